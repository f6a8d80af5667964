"""Prints what DIDIM and closed-loop output error make of the log of EMPS, for emps_loop_methods_test.cpp.

The slide with friction Fv q' + Fc tanh(q'/speed) + off under its sampled controller, by NumPy and SciPy: Runge-Kutta steps, SciPy's
solvers. Nothing is shared with rivid.

    python3 tests/real/emps_loop_oracle.py emps_ident.csv
"""

import math
import sys

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares, root

RATE = 1000.0  # Hz
FIRST = 3104  # where the reference turns
SAMPLES = 8000
STEPS = 4  # of the integration in a period
SPEED = 0.005  # m/s, of tanh
K_P = 160.18  # 1/s
K_V = 243.45  # V s/m
V_MAX = 10.0  # V
G_TAU = 35.15065188  # N/V
START = np.array([95.1089, 203.5034, 20.3935, -3.1648])  # M Fv Fc off, as published


def simulate(chi, wanted):
    """Position, velocity, acceleration at the samples; the control signal holds until the next one."""
    M, Fv, Fc, off = chi
    h = 1 / RATE / STEPS

    def acceleration(v, force):
        return (force - Fv * v - Fc * math.tanh(v / SPEED) - off) / M

    q, v = wanted[0], float(CubicSpline(np.arange(len(wanted)) / RATE, wanted)(0, 1))
    before = [q, q]
    out = np.empty((len(wanted), 3))
    for k, target in enumerate(wanted):
        rate = 0.5 * (q - before[1]) * RATE
        before = [q, before[0]]
        signal = K_P * K_V * (target - q) - K_V * rate
        force = G_TAU * min(max(signal, -V_MAX), V_MAX)
        out[k] = q, v, acceleration(v, force)
        for _ in range(STEPS):
            k1 = acceleration(v, force)
            k2 = acceleration(v + h / 2 * k1, force)
            k3 = acceleration(v + h / 2 * k2, force)
            k4 = acceleration(v + h * k3, force)
            q += h * v + h * h / 6 * (k1 + k2 + k3)
            v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return out


def didim(wanted, force):
    """The parameters that least squares on the regressor of their own simulation gives back."""

    def change(x):
        chi = START * x
        _, v, a = simulate(chi, wanted).T
        V = np.column_stack([a, v, np.tanh(v / SPEED), np.ones_like(v)])
        return np.linalg.lstsq(V * START, force, rcond=None)[0] - x

    found = root(change, np.ones(4), tol=1e-11, options={"eps": 1e-7})
    if np.max(np.abs(change(found.x))) > 1e-8:
        raise SystemExit("no fixed point")
    return START * found.x


def output_error(wanted, measured):
    found = least_squares(
        lambda x: 1e4 * (measured - simulate(START * x, wanted)[:, 0]),
        np.ones(4), xtol=1e-12, ftol=1e-14, gtol=1e-14, jac="3-point",
    )
    return START * found.x


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    log = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1 + FIRST, max_rows=SAMPLES)
    column = {name: log[:, i] for i, name in enumerate(names)}
    print("DIDIM", ", ".join(f"{x:.9g}" for x in didim(column["qref1"], G_TAU * column["v1"])), flush=True)
    print("output error", ", ".join(f"{x:.9g}" for x in output_error(column["qref1"], column["q1"])), flush=True)


main()
