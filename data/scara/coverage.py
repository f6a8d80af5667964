#!/usr/bin/env python3
"""How often the 95 % intervals of rivid_identify hold the truth; standard library only.

    python3 coverage.py RIVID_IDENTIFY EXPERIMENT.toml [runs]

Makes S2 again with other seeds (5000, 5002, ...), identifies each with the settings of the experiment file, and prints
for each parameter the share of intervals that hold the truth and the mean error in standard deviations.
"""

import json
import os
import subprocess
import sys
import tempfile

import generate


def main(program, experiment, runs):
    reference, seconds, encoder, _ = generate.LOGS["scara_s2.csv"]
    truth = {name: p["value"] for name, p in generate.truth()["parameters"].items()}
    inside, bias, all_inside = {}, {}, 0
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "s2.csv")
        for run in range(runs):
            generate.write(log, generate.simulate(reference, seconds, encoder, 5000 + 2 * run)[0])
            command = [program, experiment, "--log", log, "--json", "--output", folder]
            result = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
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
