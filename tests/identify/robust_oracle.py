"""Values of statsmodels' RLM that tests/identify/robust_test.cpp compares with.

    python3 robust_oracle.py > robust_oracle.csv      # statsmodels 0.14 or later

The log is made of sines, so that both sides have the same numbers: positions of a slider, torques of its model with errors
and some gross outliers. Rows are those of [RIV] without any filter: central differences, two samples lost at each end.
Scale is the median of |residual| / 0.6745, estimated anew in each iteration; the bisquare begins from Huber's estimate;
covariance is Huber's "H1". Rows of the output: loss, quantity, index, value.
"""

import numpy as np
import statsmodels.api as sm

F_M = 100.0
CHI = np.array([12.0, 3.0, 1.5])  # mass, viscous and Coulomb friction
k = np.arange(200.0)
q = 0.3 * np.sin(0.11 * k) + 0.1 * np.sin(0.37 * k + 0.4)
qd = np.gradient(q) * F_M
qdd = np.gradient(qd) * F_M
X = np.column_stack([qdd, qd, np.sign(qd)])[2:-2]
error = 0.4 * np.sin(1.7 * k + 3.0 * np.sin(0.9 * k)) + 0.3 * np.sin(2.9 * k * (1.0 + 0.01 * k))
error[::13] += 25.0
error[5::31] -= 40.0
y = X @ CHI + error[2:-2]


def row(*cells):
    print(",".join(c if isinstance(c, str) else repr(float(c)) for c in cells))


huber = sm.robust.norms.HuberT(1.345)
bisquare = sm.robust.norms.TukeyBiweight(4.685)
for name, norm in (("huber", huber), ("bisquare", bisquare)):
    for u in (0.0, 0.3, 1.2, -1.4, 2.0, 3.7, -4.6, 6.0):
        row(name, "weight", u, norm.weights(np.array([u]))[0])
        row(name, "slope", u, norm.psi_deriv(np.array([u]))[0])
start = None
for name, norm in (("huber", huber), ("bisquare", bisquare)):
    fit = sm.RLM(y, X, M=norm).fit(maxiter=500, tol=1e-13, conv="coefs", cov="H1", start_params=start)
    start = fit.params
    for i in range(3):
        row(name, "chi", i, fit.params[i])
        row(name, "sigma", i, fit.bse[i])
    row(name, "scale", 0, fit.scale)
    row(name, "weights", 0, fit.weights.sum())
    row(name, "below_half", 0, (fit.weights < 0.5).sum())
    row(name, "rejected", 0, (fit.weights == 0.0).sum())
