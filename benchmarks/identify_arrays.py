"""`rivid.identify` from NumPy arrays against the library in C++, in turns: seven joints, weighted least squares, one thread.

    PYTHONPATH=build/test/python python benchmarks/identify_arrays.py build/test/benchmarks/benchmark_identify_arrays [SAMPLES] [ROUNDS]

Prints medians of the processor's time, their ratio, and whether the bits of the estimates are the same.
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
from compare_python import JOINTS, write_log, write_robot

import rivid

RUNS = 5  # a process; the first warms up
THIS = pathlib.Path(__file__).resolve()


def from_arrays(folder):
    """A line a run: milliseconds and the estimate, as the program in C++ prints them."""
    n = len(JOINTS)
    values = np.loadtxt(folder / "log.csv", delimiter=",", skiprows=1)
    t, q, tau = values[:, 0], values[:, 1 : 1 + n], values[:, 1 + n :]
    robot = rivid.Robot.from_urdf(folder / "arm.urdf")
    for _ in range(RUNS):
        begin = time.process_time()
        fit = rivid.identify(robot, rivid.Log(t=t, q=q, tau=tau), rivid.Wls(decimation=20))
        print(1e3 * (time.process_time() - begin), *(x.hex() for x in fit.chi.tolist()))
        del fit


def main():
    program, samples, rounds = sys.argv[1], int((sys.argv[2:] or [100_000])[0]), int((sys.argv[3:] or [7])[0])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_robot(folder / "arm.urdf")
        write_log(folder / "log.csv", samples)
        names = {stem: [f"{stem}{j}" for j in range(1, len(JOINTS) + 1)] for stem in ("q", "tau")}
        (folder / "arm.toml").write_text(
            f'[robot]\nurdf = "arm.urdf"\n[log]\nfiles = ["log.csv"]\nposition = {names["q"]}\ntorque = {names["tau"]}\n'
            '[signal]\ndecimation = 20\n[method]\nname = "wls"\n'
        )
        commands = {"C++": [program, folder / "arm.toml", str(RUNS)], "NumPy": [sys.executable, THIS, "--arrays", folder]}
        times, estimates = {name: [] for name in commands}, set()
        for _ in range(rounds):
            for name, command in commands.items():
                done = subprocess.run(command, capture_output=True, text=True, check=True)
                lines = [line.split() for line in done.stdout.splitlines()]
                times[name].append(statistics.median(float(line[0]) for line in lines[1:]))
                estimates.update(tuple(float.fromhex(x) for x in line[1:]) for line in lines)
    for name, found in times.items():
        print(f"{name:6s} {statistics.median(found):8.1f} ms")
    ratio = statistics.median(theirs / ours for ours, theirs in zip(times["C++"], times["NumPy"]))
    print(f"ratio  {ratio:8.3f}; estimates {'are the same' if len(estimates) == 1 else 'DIFFER'} bit by bit")


if __name__ == "__main__":
    if sys.argv[1] == "--arrays":
        from_arrays(pathlib.Path(sys.argv[2]))
    else:
        main()
