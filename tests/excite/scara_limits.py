"""Limits of designed motions for the SCARA of data/scara, on ten times as many instants as are played.

    python scara_limits.py RIVID_EXCITE SOURCE_DIR OUTPUT [SEEDS]

The torques come from the robot's equations in closed form, dry friction included, and those that rivid_excite predicts for the played
samples must be the same. Prints the largest share of each limit over all seeds.
"""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

LENGTH = 0.5  # m, of the first link
DENSER = 10
TOLERANCE = 1e-9  # N m, another order of the same sum
EXPERIMENT = """[robot]
urdf = "{urdf}"
friction = "symmetric"
[excitation]
duration = 8
rate_hz = 500
noise = [0.1, 0.05]
"""


def states(motion, t):
    """(q, q̇, q̈) of both joints at an instant."""
    w = motion["omega_f"]
    harmonics = range(len(motion["A"][0]))
    waves = [((l + 1) * w, math.sin((l + 1) * w * t), math.cos((l + 1) * w * t)) for l in harmonics]
    out = []
    for A, B, q0 in zip(motion["A"], motion["B"], motion["q0"]):
        terms = list(zip(A, B, waves))
        out.append((q0 + sum((a * s - b * c) / f for a, b, (f, s, c) in terms), sum(a * c + b * s for a, b, (_, s, c) in terms),
                    sum(f * (b * c - a * s) for a, b, (f, s, c) in terms)))
    return out


def torques(p, state):
    (_, v1, a1), (q2, v2, a2) = state
    c, s = math.cos(q2), math.sin(q2)
    sign = [math.copysign(1.0, v) if v else 0.0 for v in (v1, v2)]
    first = (p["ZZ1R"] * a1 + p["ZZ2"] * (a1 + a2)
             + LENGTH * p["MX2"] * ((2 * a1 + a2) * c - v2 * (2 * v1 + v2) * s)
             - LENGTH * p["MY2"] * ((2 * a1 + a2) * s + v2 * (2 * v1 + v2) * c)
             + p["Fv1"] * v1 + p["Fc1"] * sign[0] + p["off1"])
    second = (p["ZZ2"] * (a1 + a2) + p["Ia2"] * a2 + LENGTH * p["MX2"] * (a1 * c + v1 * v1 * s)
              - LENGTH * p["MY2"] * (a1 * s - v1 * v1 * c) + p["Fv2"] * v2 + p["Fc2"] * sign[1] + p["off2"])
    return first, second


def largest_shares(plan, played):
    motion = plan["motion"]
    p = {parameter["name"]: parameter["value"] for parameter in plan["parameters"]}
    for row in played:
        state = states(motion, float(row["t"]))
        if min(abs(state[0][1]), abs(state[1][1])) > 1e-6:
            for j, tau in enumerate(torques(p, state)):
                assert abs(tau - float(row[f"tau{j + 1}"])) < TOLERANCE, (row["t"], tau)
    intervals = DENSER * (len(played) - 1)
    largest = {}
    for k in range(intervals + 1):
        state = states(motion, motion["duration"] * k / intervals)
        tau = torques(p, state)
        for j, (q, v, _) in enumerate(state):
            for what, value in (("position", q), ("velocity", v), ("torque", tau[j])):
                key = (f"joint_{j + 1}", what)
                largest[key] = max(largest.get(key, 0.0), abs(value))
    # Limits of this robot are symmetric about zero.
    return {key: largest[key] / abs(limit["limit"]) for limit in plan["limits"] for key in [(limit["joint"], limit["quantity"])]}


def main():
    excite, source, output = sys.argv[1], Path(sys.argv[2]).resolve(), Path(sys.argv[3])
    seeds = int(sys.argv[4]) if len(sys.argv) > 4 else 3
    output.mkdir(parents=True, exist_ok=True)
    experiment = output / "scara.toml"
    experiment.write_text(EXPERIMENT.format(urdf=source / "data/scara/scara.urdf"))
    worst = {}
    for seed in range(1, seeds + 1):
        folder = output / f"seed_{seed}"
        subprocess.run([excite, str(experiment), "--starts", "1", "--seed", str(seed), "--quiet", "--output", str(folder)], check=True)
        plan = json.loads((folder / "plan.json").read_text())
        with (folder / "motion.csv").open(newline="") as text:
            shares = largest_shares(plan, list(csv.DictReader(text)))
        for key, share in shares.items():
            worst[key] = max(worst.get(key, 0.0), share)
            assert share <= 1.001, f"seed {seed}: {key} uses {share}"
    for (joint, quantity), share in worst.items():
        print(f"{joint} {quantity}: at most {100 * share:.4f} % used, {seeds} seeds")


if __name__ == "__main__":
    main()
