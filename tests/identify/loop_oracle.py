"""Writes loop_oracle.csv and prints what DIDIM and closed-loop output error make of it, for loop_methods_test.cpp.

A planar arm of two joints with friction Fv q' + Fc tanh(q'/speed) under sampled PD control, by NumPy and SciPy: Lagrange's equations in
closed form, Runge-Kutta steps, SciPy's least squares. Nothing is shared with rivid.

    python3 tests/identify/loop_oracle.py
"""

from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

RATE = 200.0  # Hz
SAMPLES = 1200
STEPS = 4  # of the integration in a period
LENGTH = 0.5  # m
SPEED = 0.05  # rad/s, of tanh
K_P = np.array([4.0, 6.0])  # 1/s
K_V = np.array([14.0, 1.2])  # N m s/rad
TRUTH = np.array([3.44, 0.03, 0.82, 0.062, 0.242, 0.014, 0.013, 0.137])  # ZZ1R Fv1 Fc1 ZZ2 MX2 MY2 Fv2 Fc2
COLUMNS = np.array([8, 5])  # of each joint's rows
NOISE = 2e-5  # rad
DISTURBANCE = np.array([0.06, 0.015])  # N m, a new value each period


def reference():
    t = np.arange(SAMPLES) / RATE
    q1 = 1.2 * (1 - np.cos(2.1 * t)) + 0.4 * (1 - np.cos(5.3 * t))
    q2 = 0.9 * (1 - np.cos(2.9 * t)) - 0.5 * (1 - np.cos(4.1 * t))
    return np.column_stack([q1, q2])


def regressor(q, v, a):
    """(2 x 8) of one sample."""
    c, s = np.cos(q[1]), np.sin(q[1])
    both = a[0] + a[1]
    friction = np.tanh(v / SPEED)
    mx = LENGTH * (c * (2 * a[0] + a[1]) - s * v[1] * (2 * v[0] + v[1]))
    my = -LENGTH * (s * (2 * a[0] + a[1]) + c * v[1] * (2 * v[0] + v[1]))
    first = [a[0], v[0], friction[0], both, mx, my, 0, 0]
    second = [0, 0, 0, both, LENGTH * (c * a[0] + s * v[0] ** 2), LENGTH * (c * v[0] ** 2 - s * a[0]), v[1], friction[1]]
    return np.array([first, second])


def acceleration(chi, q, v, tau):
    rest = regressor(q, v, np.zeros(2)) @ chi
    columns = [regressor(q, v, e) @ chi - rest for e in np.eye(2)]
    return np.linalg.solve(np.column_stack(columns), tau - rest)


def simulate(chi, wanted, noise=None, disturbance=None):
    """Positions, velocities, accelerations and torques at the samples; torques hold until the next one."""
    noise = np.zeros_like(wanted) if noise is None else noise
    disturbance = np.zeros_like(wanted) if disturbance is None else disturbance
    q, v, h = wanted[0].copy(), CubicSpline(np.arange(len(wanted)) / RATE, wanted)(0, 1), 1 / RATE / STEPS
    before = q + noise[0]
    out = []
    for k in range(len(wanted)):
        measured = q + noise[k]
        tau = K_P * K_V * (wanted[k] - measured) - K_V * (measured - before) * RATE
        before = measured
        u = tau + disturbance[k]
        out.append([q.copy(), v.copy(), acceleration(chi, q, v, u), tau])
        for _ in range(STEPS):
            k1 = acceleration(chi, q, v, u)
            k2 = acceleration(chi, q + h / 2 * v, v + h / 2 * k1, u)
            k3 = acceleration(chi, q + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2, u)
            k4 = acceleration(chi, q + h * v + h * h / 2 * k2, v + h * k3, u)
            q = q + h * v + h * h / 6 * (k1 + k2 + k3)
            v = v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return [np.array(part) for part in zip(*out)]


def didim(chi, wanted, tau):
    """Least squares of the torques on the regressor of the simulated loop, each joint's rows by their deviation, until it stands still."""
    for _ in range(200):
        q, v, a, _ = simulate(chi, wanted)
        V = np.array([regressor(*state) for state in zip(q, v, a)])
        sigma = np.sqrt(np.sum((tau - V @ chi) ** 2, axis=0) / (len(V) - COLUMNS))
        weighted = (V / sigma[None, :, None]).reshape(-1, 8)
        after = np.linalg.lstsq(weighted, (tau / sigma).reshape(-1), rcond=None)[0]
        if np.max(np.abs(after - chi) / np.abs(chi)) < 1e-9:
            return after
        chi = after
    raise SystemExit("no fixed point")


def output_error(chi, wanted, measured):
    """Weights by joint and parameters in turn."""
    for _ in range(20):
        sigma = np.sqrt(np.mean((measured - simulate(chi, wanted)[0]) ** 2, axis=0))
        found = least_squares(
            lambda x, s=sigma: ((measured - simulate(x, wanted)[0]) / s).reshape(-1),
            chi, x_scale=np.abs(TRUTH), xtol=1e-12, ftol=1e-14, gtol=1e-14, jac="3-point",
        )
        if np.max(np.abs(found.x - chi) / np.abs(chi)) < 1e-7:
            return found.x
        chi = found.x
    raise SystemExit("weights and parameters do not settle")


def main():
    random = np.random.default_rng(7)
    wanted = reference()
    noise = NOISE * random.normal(size=wanted.shape)
    disturbance = DISTURBANCE * random.normal(size=wanted.shape)
    q, _, _, tau = simulate(TRUTH, wanted, noise, disturbance)
    log = np.round(np.column_stack([q + noise, tau, wanted]), 9)
    file = Path(__file__).with_suffix(".csv")
    np.savetxt(file, log, delimiter=",", header="q1,q2,tau1,tau2,qref1,qref2", comments="", fmt="%.9g")
    log = np.loadtxt(file, delimiter=",", skiprows=1)
    for name, found in (
        ("DIDIM", didim(TRUTH, log[:, 4:], log[:, 2:4])),
        ("output error", output_error(TRUTH, log[:, 4:], log[:, :2])),
    ):
        print(name, ", ".join(f"{x:.9g}" for x in found), flush=True)


main()
