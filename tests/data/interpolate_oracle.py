#!/usr/bin/env python3
"""Writes interpolate_oracle.csv: splines and polygons by SciPy, for interpolate_test.cpp.

One row a value: case, kind (knot, spline or linear), t, first signal, second signal.
"""

import pathlib

import numpy as np
import scipy
from scipy.interpolate import CubicSpline

rng = np.random.default_rng(20260731)


def signals(t):
    return np.column_stack([np.sin(3.0 * t) + 0.2 * t**2, np.cos(5.0 * t) - t])


cases = {
    "uniform": np.linspace(0.0, 2.0, 41),
    "jittered": np.cumsum(rng.uniform(0.008, 0.016, 200)),
    "steep": np.concatenate([np.linspace(0.0, 0.1, 6), np.linspace(0.101, 0.102, 5), np.linspace(1.0, 2.0, 8)]),
    "four": np.array([0.0, 0.3, 0.4, 1.0]),
    "three": np.array([-1.0, 0.25, 1.0]),
    "two": np.array([0.5, 0.75]),
}

here = pathlib.Path(__file__).parent
with open(here / "interpolate_oracle.csv", "w", encoding="utf-8") as out:
    out.write(f"# written by interpolate_oracle.py with numpy {np.__version__}, scipy {scipy.__version__}\n")
    out.write("# kind: 0 knot, 1 spline, 2 linear\n")
    out.write("case,kind,t,y1,y2\n")
    for number, t in enumerate(cases.values()):
        y = signals(t)
        at = np.sort(rng.uniform(t[0], t[-1], 25))
        at[0], at[-1] = t[0], t[-1]
        polygon = np.column_stack([np.interp(at, t, y[:, c]) for c in range(2)])
        for kind, x, values in ((0, t, y), (1, at, CubicSpline(t, y)(at)), (2, at, polygon)):
            for row, value in zip(x, values):
                out.write(f"{number},{kind},{row:.17g},{value[0]:.17g},{value[1]:.17g}\n")
