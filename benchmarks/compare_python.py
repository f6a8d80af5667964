#!/usr/bin/env python3
"""rivid identify against ols_python.py, from the start of the process to the printed result.

    python3 compare_python.py RIVID [--samples N] [--decimation N] [--drafted] [--repeat N] [--python PYTHON]

Both get the same robot of seven joints and the same log of N samples at 1 kHz (default 2000: a cold start), in turns.
rivid's experiment has the settings of the Python program or, with --drafted, those of `rivid init`.
Prints medians and ratios of the whole commands and of the most memory that the processes held, and the median of the
part of the Python program between arrays and parameters. Both this program and PYTHON need numpy, scipy and pin.
"""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
import pinocchio

# Parent-to-child origins and angles about x of an arm like the Franka Emika Panda.
JOINTS = [
    ("0 0 0.333", 0.0),
    ("0 0 0", -np.pi / 2),
    ("0 -0.316 0", np.pi / 2),
    ("0.0825 0 0", np.pi / 2),
    ("-0.0825 0.384 0", -np.pi / 2),
    ("0 0 0", np.pi / 2),
    ("0.088 0 0", np.pi / 2),
]
CUTOFF_HZ = 20.0


def write_robot(file):
    lines = ['<robot name="arm"><link name="base"/>']
    for j, (xyz, roll) in enumerate(JOINTS, 1):
        parent = "base" if j == 1 else f"link{j - 1}"
        lines.append(
            f'<link name="link{j}"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
            f'</inertial></link><joint name="j{j}" type="revolute"><parent link="{parent}"/><child link="link{j}"/>'
            f'<origin xyz="{xyz}" rpy="{roll} 0 0"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" velocity="99" effort="999"/></joint>'
        )
    file.write_text("\n".join(lines) + "\n</robot>\n")


def write_log(file, robot, samples):
    """A motion of five sines a joint, with the torques of the robot and noise of 0.1 N·m."""
    rng = np.random.default_rng(7)
    n = len(JOINTS)
    t = np.arange(samples) / 1000.0
    omega = rng.uniform(1.0, 20.0, (5, 1, n))
    angle = omega * t[None, :, None] + rng.uniform(0.0, 6.0, (5, 1, n))
    q = np.sum(np.sin(angle), axis=0) * 0.4
    qd = np.sum(omega * np.cos(angle), axis=0) * 0.4
    qdd = np.sum(-(omega**2) * np.sin(angle), axis=0) * 0.4
    model = pinocchio.buildModelFromUrdf(str(robot))
    data = model.createData()
    tau = np.array([pinocchio.rnea(model, data, *state) for state in zip(q, qd, qdd)])
    tau += np.sign(qd) + 0.1 * rng.standard_normal(q.shape)
    header = ",".join(["t"] + [f"q{j}" for j in range(1, n + 1)] + [f"tau{j}" for j in range(1, n + 1)])
    np.savetxt(file, np.column_stack([t, q, tau]), delimiter=",", header=header, comments="", fmt="%.9g")


def write_experiment(file, decimation):
    names = lambda stem: ", ".join(f'"{stem}{j}"' for j in range(1, len(JOINTS) + 1))
    decimated = f"decimation = {decimation}\n" if decimation > 1 else ""
    file.write_text(
        f'[robot]\nurdf = "arm.urdf"\n[log]\nfiles = ["log.csv"]\ntime = "t"\nposition = [{names("q")}]\n'
        f"torque = [{names('tau')}]\n[signal]\nrows = \"paper\"\ncutoff_hz = {CUTOFF_HZ}\n{decimated}[method]\nname = \"ols\"\ncovariance = \"classical\"\n"
    )


def run(command, folder):
    """Seconds on the wall and of the processor, MiB at the worst moment and output of a command, on one thread."""
    start = time.perf_counter()
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, env=environment)
    output = process.stdout.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    if status != 0:
        sys.exit(f"{command} failed")
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0, output


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--samples", type=int, default=2000)
    parser.add_argument("--decimation", type=int, default=1)
    parser.add_argument("--drafted", action="store_true")
    parser.add_argument("--repeat", type=int, default=11)
    parser.add_argument("--python", default=sys.executable)
    arguments = parser.parse_args()
    pipeline = pathlib.Path(__file__).resolve().parent / "ols_python.py"
    program = str(pathlib.Path(arguments.program).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_robot(folder / "arm.urdf")
        write_log(folder / "log.csv", folder / "arm.urdf", arguments.samples)
        if arguments.drafted:
            run([program, "init", "arm.urdf", "log.csv", "-o", "arm.toml"], folder)
        else:
            write_experiment(folder / "arm.toml", arguments.decimation)
        ours, theirs = [], []
        for _ in range(arguments.repeat):
            ours.append(run([program, "identify", "arm.toml", "--quiet"], folder))
            theirs.append(
                run(
                    [arguments.python, str(pipeline), "log.csv", "arm.urdf", str(CUTOFF_HZ), str(arguments.decimation)],
                    folder,
                )
            )
    middle = lambda runs, column: statistics.median(run[column] for run in runs)
    inner = statistics.median(float(run[3].split()[0]) for run in theirs)
    print(f"{arguments.samples} samples, decimation {arguments.decimation}, {theirs[0][3].split()[1]} columns: medians")
    print("                  wall [ms]  processor [ms]  memory [MiB]")
    for name, runs in (("rivid_identify", ours), ("Python", theirs)):
        print(f"{name:15s} {1e3 * middle(runs, 0):11.1f} {1e3 * middle(runs, 1):15.1f} {middle(runs, 2):13.1f}")
    print(f"from arrays to parameters, Python {1e3 * inner:9.1f}")
    print("ratio           " + " ".join(f"{middle(theirs, k) / middle(ours, k):{11 + 2 * k}.1f}" for k in range(3)))


if __name__ == "__main__":
    main()
