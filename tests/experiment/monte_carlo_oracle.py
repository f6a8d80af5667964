#!/usr/bin/env python3
"""Intervals for shares of runs, Wilson 1927, by SciPy: the values in monte_carlo_test.cpp.

    python3 monte_carlo_oracle.py
"""

from scipy.stats import binomtest

for held, runs in ((19, 20), (20, 20), (0, 20), (285, 300), (229, 300)):
    low, high = binomtest(held, runs).proportion_ci(method="wilson")
    print(f"{{{held}, {runs}, {float(low)!r}, {float(high)!r}}},")
