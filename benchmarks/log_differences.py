#!/usr/bin/env python3
"""What logs of one robot, each drafted and identified by itself, say of the same parameters, beside what their intervals allow. Needs NumPy.

    build/venv/bin/python benchmarks/log_differences.py build/test/apps/rivid LOGS [--set KEY=VALUE ...]

LOGS is the folder of the real logs of docs/references.md. Logs that are alone are cut into pieces. Prints for each robot the share of the
differences within the 95 % intervals of the difference: of the parameters that both logs identify, of friction, and of all that have an
interval; and the root mean square of the differences over their standard deviations, 1 where these are right.
"""

import argparse
import itertools
import json
import pathlib
import subprocess
import tempfile

import numpy as np

COUPLED = 'robot.coupling=[{motor="joint_6",joints=["joint_5"],inertia="tied",coulomb="single"}]'
ROBOTS = {  # description, logs or a log and the number of its pieces, what a draft leaves to be filled in
    "UR10e": ("ur10e/ur10e.urdf", ["ident_30s_12harm", "ident_40s_12harm", "unload_14harm"], []),
    "KUKA": ("kuka_kr300/kr300.urdf", ["kr300_A", "kr300_B"], []),
    "Panda": ("panda/panda.urdf", ("panda_1khz", 3), ["robot.rotor_inertia=false"]),
    "EMPS": ("emps/emps.urdf", ["emps_ident", "emps_pulses"], ["robot.rotor_inertia=false"]),
    "TX40": ("tx40/tx40.urdf", ("tx40_ident", 2), [COUPLED]),
}


def pieces(log, count, folder):
    head, *rows = log.read_text().splitlines(keepends=True)
    out = []
    for k in range(count):
        out.append(folder / f"{log.stem}_{k + 1}of{count}.csv")
        out[-1].write_text("".join([head, *rows[k * len(rows) // count:(k + 1) * len(rows) // count]]))
    return out


def identified(program, urdf, log, settings, folder):
    """Parameters by name, of a draft."""
    file = folder / "draft.toml"
    subprocess.run([program, "init", urdf, log, "--output", file, "--force"], check=True, capture_output=True)
    given = [word for setting in settings for word in ("--set", setting)]
    run = subprocess.run([program, "identify", file, "--json", "--output", folder / "result", "--force", *given],
                         capture_output=True, text=True, check=False)
    if run.returncode > 1:
        raise SystemExit(run.stderr)
    return {p["name"]: p for p in json.loads(run.stdout)["parameters"]}


def differences(first, second):
    """Of each parameter its name, whether both identify it, whether the difference is within its interval, and the difference in σ."""
    for name in first.keys() & second.keys():
        a, b = first[name], second[name]
        halves = [(p["interval_95"][1] - p["interval_95"][0]) / 2 for p in (a, b) if p["interval_95"] and None not in p["interval_95"]]
        if len(halves) == 2:
            off = a["value"] - b["value"]
            yield name, a["verdict"] == b["verdict"] == "identified", abs(off) < np.hypot(*halves), off / np.hypot(a["sigma"], b["sigma"])


def share(inside):
    return f"{100 * np.mean(inside):5.1f} % of {len(inside):3}" if len(inside) else "      none    "


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("program", type=pathlib.Path)
    asked.add_argument("logs", type=pathlib.Path)
    asked.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    given = asked.parse_args()
    pool = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for robot, (urdf, logs, settings) in ROBOTS.items():
            urdf = given.logs.resolve() / urdf
            files = [urdf.parent / f"{log}.csv" for log in logs] if isinstance(logs, list) else pieces(urdf.parent / f"{logs[0]}.csv", logs[1], folder)
            results = [identified(given.program.resolve(), urdf, file, settings + given.set, folder) for file in files]
            found = [d for pair in itertools.combinations(results, 2) for d in differences(*pair)]
            pool += found
            print(f"{robot:7}{said(found)}", flush=True)
    print(f"{'all':7}{said(pool)}")


def said(found):
    some = {"identified": [inside for _, sure, inside, _ in found if sure],
            "friction": [inside for name, _, inside, _ in found if name[0] == "F" or name.startswith("off")],
            "all": [inside for *_, inside, _ in found]}
    return ", ".join(f"{what} {share(inside)}" for what, inside in some.items()) + f", rms difference {np.sqrt(np.mean([z * z for *_, z in found])):.2f} σ"


if __name__ == "__main__":
    main()
