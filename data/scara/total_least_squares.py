#!/usr/bin/env python3
"""Total least squares beside weighted least squares on the same rows of S1: bias, RMSE, coverage. Needs NumPy and SciPy.

    python3 total_least_squares.py FOLDER [runs] [rad]

FOLDER holds rivid_simulate and rivid_identify; the encoder noise is 2e-5 rad unless another is given. S1 is simulated with seeds 5000,
5001, ...; rivid_identify makes exact rows and their weights. Total least squares takes the right singular vector of the smallest singular
value of the weighted [W Y], as it is or with columns of unit length. Intervals of all are from the jackknife that leaves out each of ten
blocks of time. The RMSE is relative to that of weighted least squares.
"""

import os
import subprocess
import sys
import tempfile

import numpy as np
from scipy import stats

HERE = os.path.dirname(os.path.abspath(__file__))
BLOCKS = 10


def least_squares(W, Y):
    return np.linalg.lstsq(W, Y, rcond=None)[0]


def total_least_squares(W, Y):
    v = np.linalg.svd(np.column_stack([W, Y]), full_matrices=False)[2][-1]
    return -v[:-1] / v[-1]


def with_columns_of_unit_length(W, Y):
    scale, length = np.linalg.norm(W, axis=0), np.linalg.norm(Y)
    return total_least_squares(W / scale, Y / length) * length / scale


METHODS = {"WLS": least_squares, "TLS": total_least_squares, "TLS, columns of unit length": with_columns_of_unit_length}


def estimate(method, W, Y, block):
    """Values, and deviations by the jackknife."""
    left_out = np.array([method(W[block != k], Y[block != k]) for k in range(BLOCKS)])
    spread = left_out - left_out.mean(axis=0)
    return method(W, Y), np.sqrt((BLOCKS - 1) / BLOCKS * np.sum(spread**2, axis=0))


def rows(programs, seed, noise, folder):
    def run(program, *arguments):
        subprocess.run([os.path.join(programs, program), *arguments, "--quiet", "--output", folder], check=True)

    log, file = os.path.join(folder, "log.csv"), os.path.join(folder, "rows.npz")
    run("rivid_simulate", os.path.join(HERE, "simulate_s1.toml"), "--seed", str(seed), "--set", f"simulation.position_noise={noise}")
    run("rivid_identify", os.path.join(HERE, "scara.toml"), "--log", log, "--validate", log, "--set", 'signal.cutoff_hz="off"',
        "--set", "signal.trim=0", "--write-rows", file)
    return np.load(file)


def main(programs, runs, noise):
    truth = dict(ZZ1R=3.44, Fv1=0.03, Fc1=0.82, off1=0.0, ZZ2=0.062, MX2=0.242, MY2=0.014, Fv2=0.013, Fc2=0.137, off2=0.0)
    errors, ratios = {name: [] for name in METHODS}, {name: [] for name in METHODS}
    with tempfile.TemporaryDirectory() as folder:
        for run in range(runs):
            made = rows(programs, 5000 + run, noise, folder)
            true = np.array([truth[name] for name in made["parameters"]])
            block = np.minimum((made["t"] / made["t"].max() * BLOCKS).astype(int), BLOCKS - 1)
            for name, method in METHODS.items():
                value, sigma = estimate(method, made["weight"][:, None] * made["W"], made["weight"] * made["Y"], block)
                errors[name].append(value - true)
                ratios[name].append((value - true) / sigma)
    best = np.sqrt(np.mean(np.square(errors["WLS"]), axis=0))
    reach = stats.t.ppf(0.975, BLOCKS - 1)
    for name in METHODS:
        error = np.array(errors[name])
        bias = np.abs(error.mean(axis=0)) / error.std(axis=0)
        rmse = np.sqrt(np.mean(error**2, axis=0)) / best
        held = 100 * np.mean(np.abs(ratios[name]) <= reach, axis=0)
        print(f"{name}: largest bias {bias.max():.2f} of the spread, RMSE {rmse.min():.2f} ... {rmse.max():.2f} of that of WLS, "
              f"coverage {held.min():.1f} ... {held.max():.1f}, mean {held.mean():.1f} %")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 200, float(sys.argv[3]) if len(sys.argv) > 3 else 2e-5)
