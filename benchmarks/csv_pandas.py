#!/usr/bin/env python3
"""Reading speed of pandas and NumPy on a log like that of csv.cpp; pandas is optional.

Usage: csv_pandas.py [FILE]; without a file, one of 60 MB is generated and removed.
"""

import os
import sys
import tempfile
import time

import numpy as np

COLUMNS = 22
ROWS = 245_000


def generated():
    rng = np.random.default_rng(20260731)
    t = 1e-3 * np.arange(ROWS)
    scale = np.where(np.arange(1, COLUMNS) > 14, 30.0, 1.5)
    values = np.sin(np.outer(t, np.arange(1, COLUMNS))) * scale + 1e-3 * rng.standard_normal((ROWS, COLUMNS - 1))
    handle, path = tempfile.mkstemp(suffix=".csv", prefix="rivid_benchmark_")
    os.close(handle)
    header = ",".join(["t"] + [f"c{c}" for c in range(1, COLUMNS)])
    np.savetxt(path, np.column_stack([t, values]), fmt="%.9g", delimiter=",", header=header, comments="")
    return path


def report(name, read, path):
    seconds = min(timed(read, path) for _ in range(3))
    print(f"{name:8} {1e-6 * os.path.getsize(path) / seconds:8.0f} MB/s")


def timed(read, path):
    start = time.perf_counter()
    read(path)
    return time.perf_counter() - start


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else generated()
    try:
        report("numpy", lambda p: np.loadtxt(p, delimiter=",", skiprows=1), path)
        try:
            import pandas
        except ImportError:
            print("pandas   is not installed")
        else:
            report("pandas", pandas.read_csv, path)
    finally:
        if len(sys.argv) < 2:
            os.remove(path)


main()
