"""Values of SciPy that tests/identify/diagnostics_test.cpp compares with.

    python3 residual_oracle.py > residual_oracle.csv      # SciPy 1.10 or later

Rows: name of a series, skewness, excess kurtosis, statistic and p of Jarque and Bera, statistic and p of Ljung and Box
over 20 rows. The series are made of sines, so that both sides have the same numbers, and have mean zero.
"""

import numpy as np
import scipy.stats

t = np.arange(500.0)
series = {
    "whitish": np.sin(1.7 * t + 3.0 * np.sin(t) + 0.1 * t * t),
    "coloured": np.sin(0.05 * t) + 0.4 * np.sin(1.7 * t + np.sin(t)),
    "skewed": np.exp(1.5 * np.sin(2.3 * t + 0.07 * t * t)),
}

for name, x in series.items():
    x = x - x.mean()
    n = len(x)
    jarque_bera = scipy.stats.jarque_bera(x)
    r = np.array([x[l:] @ x[:-l] for l in range(1, 21)]) / (x @ x)
    ljung_box = n * (n + 2) * np.sum(r**2 / (n - np.arange(1, 21)))
    cells = [
        scipy.stats.skew(x),
        scipy.stats.kurtosis(x),
        jarque_bera.statistic,
        jarque_bera.pvalue,
        ljung_box,
        scipy.stats.chi2.sf(ljung_box, 20),
    ]
    print(",".join([name] + [repr(float(c)) for c in cells]))
