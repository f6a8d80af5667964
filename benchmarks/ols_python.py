"""Identification by least squares as it is usually written in Python: NumPy, SciPy and Pinocchio.

    python3 ols_python.py LOG.csv ROBOT.urdf CUTOFF_HZ [DECIMATION]

LOG.csv has columns t, q1 ... qn, tau1 ... taun at a constant rate. Prints the seconds of the processor from the arrays in memory to
the parameters, the number of columns, the relative error in percent and the most memory that the process held.
"""

import resource
import sys
import time

import numpy as np
import pinocchio as pin
import scipy.linalg
import scipy.signal


def base_columns(regressor):
    """Columns of a regressor over random states that do not depend on those before them."""
    triangle = np.abs(np.diag(scipy.linalg.qr(regressor, mode="r")[0]))
    return np.flatnonzero(triangle > 1e-8 * triangle.max())


def rows(model, data, q, qd, qdd):
    """Observation matrix grouped joint by joint: inertial parameters, rotor inertias, friction, offsets."""
    samples, n = q.shape
    W = np.zeros((n, samples, 14 * n))
    for k in range(samples):
        W[:, k, : 10 * n] = pin.computeJointTorqueRegressor(model, data, q[k], qd[k], qdd[k])
    for j in range(n):
        W[j, :, 10 * n + j] = qdd[:, j]
        W[j, :, 11 * n + j] = qd[:, j]
        W[j, :, 12 * n + j] = np.sign(qd[:, j])
        W[j, :, 13 * n + j] = 1.0
    return W


def identified(model, t, q, tau, cutoff_hz, decimation):
    f_m = (len(t) - 1) / (t[-1] - t[0])
    sos = scipy.signal.butter(4, cutoff_hz, fs=f_m, output="sos")
    q = scipy.signal.sosfiltfilt(sos, q, axis=0)
    qd = np.gradient(q, 1.0 / f_m, axis=0)
    qdd = np.gradient(qd, 1.0 / f_m, axis=0)
    border = int(f_m / cutoff_hz * 3.0)
    inner = slice(border, len(t) - border)
    data = model.createData()
    rng = np.random.default_rng(1)
    n = q.shape[1]
    random = rows(model, data, *(rng.uniform(-2.0, 2.0, (500, n)) for _ in range(3)))
    kept = base_columns(random.reshape(-1, 14 * n))
    W = rows(model, data, q[inner], qd[inner], qdd[inner])[:, :, kept]
    Y = tau[inner].T
    if decimation > 1:
        low_pass = scipy.signal.cheby1(8, 0.05, 0.8 / decimation, output="sos")
        W = scipy.signal.sosfiltfilt(low_pass, W, axis=1)[:, ::decimation]
        Y = scipy.signal.sosfiltfilt(low_pass, Y, axis=1)[:, ::decimation]
    W = W.reshape(-1, len(kept))
    Y = Y.reshape(-1)
    Q, R = scipy.linalg.qr(W, mode="economic", check_finite=False)
    chi = scipy.linalg.solve_triangular(R, Q.T @ Y)
    residual = Y - W @ chi
    variance = residual @ residual / (len(Y) - len(chi))
    inverse = scipy.linalg.solve_triangular(R, np.eye(len(chi)))
    sigma = np.sqrt(variance * np.sum(inverse**2, axis=1))
    return chi, sigma, np.linalg.norm(residual) / np.linalg.norm(Y)


def main():
    log_file, urdf, cutoff_hz = sys.argv[1:4]
    decimation = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    log = np.loadtxt(log_file, delimiter=",", skiprows=1)
    n = (log.shape[1] - 1) // 2
    t, q, tau = log[:, 0], np.ascontiguousarray(log[:, 1 : n + 1]), np.ascontiguousarray(log[:, n + 1 :])
    model = pin.buildModelFromUrdf(urdf)
    start = time.process_time()
    chi, _, error = identified(model, t, q, tau, float(cutoff_hz), decimation)
    seconds = time.process_time() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"{seconds:.4f} {len(chi)} {100.0 * error:.4f} {peak:.1f}")


if __name__ == "__main__":
    main()
