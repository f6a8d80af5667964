"""Writes oracle.csv beside this file: what SciPy makes of the filters in rivid/signal.

One line a case: its name, then numbers. Made with Python 3.11, NumPy 2.4 and SciPy 1.17:

    python3 oracle.py

The series is that of probe.hpp.
"""

import math
import pathlib

import numpy as np
import scipy
from scipy import signal

F_M = 200.0
CUTOFF_HZ = 20.0
LENGTH = 160
FREQUENCIES_HZ = np.array([0.0, 1.0, 5.0, 10.0, 20.0, 30.0, 50.0, 80.0, 95.0])


def probe(n_m):
    k = np.arange(n_m)
    return (
        0.4
        + 0.8 * np.sin(0.004 * k)
        + 0.5 * np.sin(0.05 * k)
        + 0.3 * np.cos(0.31 * k)
        + 0.2 * np.sin(1.7 * k)
        + 0.1 * ((k * 7919) % 101) / 101.0
    )


def settling_samples(poles, level):
    return max(len(poles), math.ceil(math.log(level) / math.log(np.abs(poles).max())))


def zero_phase(design, x, convention):
    sos = design("sos")
    _, poles, _ = design("zpk")
    order = len(poles)
    padding = 3 * order if convention == "matlab" else min(settling_samples(poles, 1e-6), len(x) - 1)
    return signal.sosfiltfilt(sos, x, padtype="odd", padlen=padding)


def butterworth(order, cutoff_hz=CUTOFF_HZ):
    return lambda output: signal.butter(order, cutoff_hz, fs=F_M, output=output)


def chebyshev1(order, ripple_db, cutoff_hz=CUTOFF_HZ):
    return lambda output: signal.cheby1(order, ripple_db, cutoff_hz, fs=F_M, output=output)


def decimate(x, n_d, convention):
    design = chebyshev1(8, 0.05, 0.8 * F_M / (2 * n_d))
    if convention == "matlab":
        n_m = len(x)
        return zero_phase(design, x, convention)[n_d - (n_d * math.ceil(n_m / n_d) - n_m) - 1 :: n_d]
    # The series goes on as a constant at both ends, far enough that the filter forgets what is behind.
    margin = 400 * n_d
    y = signal.sosfiltfilt(design("sos"), np.pad(x, margin, mode="edge"), padlen=0)
    return y[margin : margin + len(x) : n_d] * 10 ** (2 * 0.05 / 20)


def gain(design):
    _, h = signal.freqz_sos(design("sos"), FREQUENCIES_HZ, fs=F_M)
    return np.abs(h)


def cases():
    yield "frequencies_hz", FREQUENCIES_HZ
    x = probe(LENGTH)
    for order in range(1, 9):
        yield f"gain butterworth {order}", gain(butterworth(order))
        yield f"gain chebyshev1 {order}", gain(chebyshev1(order, 0.5))
        for convention in ("matlab", "standard"):
            yield f"zero_phase butterworth {order} {convention}", zero_phase(butterworth(order), x, convention)
    yield "zero_phase chebyshev1 8 matlab", zero_phase(chebyshev1(8, 0.05), x, "matlab")
    yield "zero_phase butterworth 4 at 0.2 Hz matlab", zero_phase(butterworth(4, 0.2), x, "matlab")
    for n_d in (2, 10, 20, 50, 100):
        for convention in ("matlab", "standard"):
            yield f"decimate {n_d} {convention}", decimate(probe(20 * n_d - n_d // 3), n_d, convention)


def main():
    path = pathlib.Path(__file__).with_name("oracle.csv")
    with path.open("w") as out:
        out.write(f"# oracle.py with SciPy {scipy.__version__}, NumPy {np.__version__}\n")
        for name, values in cases():
            out.write(",".join([name, *(repr(float(v)) for v in values)]) + "\n")


main()
