#!/usr/bin/env python3
"""How often the 95 % intervals of rivid_identify hold the truth; standard library only.

    python3 coverage.py FOLDER EXPERIMENT.toml [runs]

FOLDER holds rivid_simulate and rivid_identify. Simulates S2 with other seeds (5000, 5001, ...), identifies each log with the
settings of the experiment file, and prints for each parameter the share of intervals that hold the truth and the mean
error in standard deviations.
"""

import json
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))


def printed(*command):
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


def main(programs, experiment, runs):
    simulate, identify = (os.path.join(programs, name) for name in ("rivid_simulate", "rivid_identify"))
    plan = os.path.join(HERE, "simulate_s2.toml")
    inside, bias, all_inside = {}, {}, 0
    with tempfile.TemporaryDirectory() as folder:
        for run in range(runs):
            simulated = printed(simulate, plan, "--seed", str(5000 + run), "--json", "--output", folder)
            truth = {p["name"]: p["value"] for p in simulated["parameters"]}
            log = os.path.join(folder, "log.csv")
            result = printed(identify, experiment, "--log", log, "--json", "--output", folder)
            hits = []
            for p in result["parameters"]:
                low, high = p["interval_95"]
                name = p["name"]
                hits.append(low <= truth[name] <= high)
                inside[name] = inside.get(name, 0) + hits[-1]
                bias[name] = bias.get(name, 0.0) + (p["value"] - truth[name]) / p["sigma"]
            all_inside += all(hits)
    for name in inside:
        print(f"{name:6}{100 * inside[name] / runs:6.1f} % inside, mean error {bias[name] / runs:+.2f} sigma")
    print(f"all   {100 * all_inside / runs:6.1f} % of {runs} runs")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 200)
