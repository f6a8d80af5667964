#!/usr/bin/env python3
"""Standard deviations over the spread of estimates, for motions that were designed and for others.

    python3 benchmarks/sigma_over_spread.py build/test/apps/rivid [--runs 200]

Three designed motions and three through random points for each of the arms of data/: each is simulated `runs` times with
encoder noise of 5e-5 rad and identified as drafted. Prints the mean of σ over spread, its range, and the coverage.
"""

import argparse
import json
import pathlib
import random
import re
import subprocess
import tempfile

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
# Folder, URDF, reach of the random points, seconds between two, [excitation] of the designs.
ARMS = [
    ("six_axis", "six_axis.urdf", [1.5, 1.0, 1.0, 1.5, 1.2, 2.0], 1.25,
     "duration = 10\nrate_hz = 1000\nnoise = [0.4, 0.5, 0.2, 0.1, 0.1, 0.05]\n"
     "limits = { acceleration = [10, 10, 10, 20, 20, 20] }\n"),
    ("scara", "scara.urdf", [1.5, 2.0], 2.5,
     "duration = 20\nrate_hz = 200\nnoise = [0.06, 0.015]\n"
     "limits = { lower = [-3, -3], upper = [3, 3], velocity = [2, 3], acceleration = [3, 8] }\n"),
]


def table(text, name):
    """A table of an experiment file, up to the next one."""
    return re.search(rf"(?ms)^\[{name}\][^\n]*\n.*?(?=^\[[a-z]|\Z)", text).group(0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--runs", type=int, default=200)
    asked = parser.parse_args()
    drawn = random.Random(20261128)
    print("| arm | motion | mean | least | largest | coverage % |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def run(*words):
            subprocess.run([asked.program, *map(str, words), "-q", "--force"], check=True)

        for arm, urdf, reach, seconds, excitation in ARMS:
            (folder / urdf).write_bytes((DATA / arm / urdf).read_bytes())
            first = (DATA / arm / "montecarlo_first.toml").read_text()
            robot, control = table(first, "robot"), table(first, "control")
            (folder / "excite.toml").write_text(f"{robot}\n{control}\n\n[excitation]\n{excitation}")
            references = []
            for seed in (1, 2, 3):
                run("excite", folder / "excite.toml", "--seed", seed, "--starts", 1, "-o", folder / "design")
                references.append((f"design {seed}", table((folder / "design/experiment.toml").read_text(), "reference")))
            for k in range(1, 4):
                via = [[round(drawn.uniform(-r, r), 3) for r in reach] for _ in range(9)]
                references.append((f"points {k}", f'[reference]\ntype = "point_to_point"\nvia = {via}\ndurations = {seconds}\n'))
            for motion, reference in references:
                simulation = re.sub(r"position_noise = \S+", "position_noise = 5e-5", table(first, "simulation"))
                study = folder / "study.toml"
                study.write_text(f"{robot}\n{control}\n\n{reference}\n{simulation}\n\n[montecarlo]\nruns = {asked.runs}\n"
                                 'seed = 1\n\n[[montecarlo.trial]]\nlabel = "WLS"\nname = "wls"\n')
                run("study", study, "--restart", "-o", folder / "out")
                trial = json.loads((folder / "out/summary.json").read_text())["trials"][0]
                over = [p["sigma_over_spread"] for p in trial["parameters"]]
                print(f"| {arm} | {motion} | {sum(over) / len(over):.2f} | {min(over):.2f} | {max(over):.2f} "
                      f"| {100 * trial['mean_coverage']:.1f} |", flush=True)


if __name__ == "__main__":
    main()
