"""Values of SciPy and statsmodels that tests/solve/distributions_test.cpp and long_run_test.cpp compare with.

    python3 statistics_oracle.py > statistics_oracle.csv      # SciPy 1.11 or later, statsmodels 0.14 or later

Rows: name, arguments …, value. The regression behind "hac" is made of sines, so that both sides have the same numbers.
"""

import numpy as np
import scipy.stats
import statsmodels.api as sm


def row(*cells):
    print(",".join(c if isinstance(c, str) else repr(float(c)) for c in cells))


for x in (0.01, 0.5, 3.84, 20.0, 150.0):
    for k in (1.0, 2.0, 7.5, 20.0, 120.0):
        row("chi_square", x, k, scipy.stats.chi2.sf(x, k))
for x in (0.02, 0.8, 1.5, 4.0, 30.0):
    for k in (1.0, 8.0, 43.0):
        for l in (1.0, 17.0, 350.0):
            row("f", x, k, l, scipy.stats.f.sf(x, k, l))

t = np.arange(200.0)
X = np.column_stack([np.ones(200), np.sin(0.13 * t), np.cos(0.31 * t)])
y = X @ [1.0, -2.0, 0.5] + 0.3 * np.sin(0.05 * t) + 0.2 * np.sin(1.7 * t + 0.2 * np.sin(t))
fit = sm.OLS(y, X).fit()
for lag in (0, 3, 17):
    S = np.linalg.inv(fit.normalized_cov_params) @ fit.get_robustcov_results(
        "HAC", maxlags=lag, use_correction=False
    ).cov_params() @ np.linalg.inv(fit.normalized_cov_params)
    for i in range(3):
        for j in range(3):
            row("hac", lag, i, j, S[i, j])
