#!/usr/bin/env python3
"""Coverage of the intervals of parameters and drive gains, with gains that are estimated, on arms simulated by Pinocchio.

    venv/bin/python benchmarks/gain_coverage.py build/test/apps/rivid [ARM ...] [--logs 4] [--draws 3]

Arms and logs are those of arms_pinocchio.py; each run draws drive gains, 10 % (standard deviation) off the nominal ones, and estimates
them with the parameters, by the rows and the method that rivid chooses:

  known   from one gain that is known to 1 % (and is 1 % off)
  mass    from a second log with a payload of a tenth of the arm's mass, which is known
  ratios  of one log alone: parameters are compared up to the common scale, which that can not show
  none    from a payload too light to show a scale: nominal gains are kept

and counts the intervals of 95 % that hold the truth: of all parameters, and of the gains that are identified.
"""

import argparse
import collections
import csv
import json
import pathlib
import subprocess
import tempfile

import numpy as np
import pinocchio as pin

from arms_pinocchio import Arm, truth

ARMS = ("ur5", "xarm7", "kinova", "panda", "tiago")
KINDS = ("known", "mass", "ratios", "none")
HEAVY, LIGHT = 0.1, 1e-5  # payloads, of the mass of the arm
OFF = 0.1  # of the gains
KNOWN = 0.01


def loaded(name, part):
    """The arm with a body on its last link, under the control that it had without, and the mass of that body."""
    arm = Arm(name)
    mass = part * sum(body.mass for body in arm.model.inertias[1:])
    body = pin.Inertia(mass, np.array([0.02, -0.01, 0.08]), mass * 0.05**2 * np.eye(3))
    arm.model.appendBodyToJoint(arm.model.njoints - 1, body, pin.SE3.Identity())
    arm.data = arm.model.createData()
    return arm, mass


def as_currents(log, gains, to):
    """The log with currents, by the gains, in place of the torques."""
    with log.open() as file:
        head, *rows = list(csv.reader(file))
    table = np.array(rows, dtype=float)
    for j, gain in enumerate(gains):
        table[:, head.index(f"tau{j + 1}")] /= gain
    np.savetxt(to, table, delimiter=",", header=",".join(head).replace("tau", "i"), comments="", fmt="%.9g")


def experiment(arm, joints, kind, folder, masses):
    lines = ["[robot]", f'urdf = "{arm.urdf}"', "gravity = [0, 0, -9.81]", "drive_gain = 1.0"]
    lines += [f'base = "{arm.base}"', f'tip = "{arm.tip}"'] if arm.tip else []
    for j, name in enumerate(joints):
        lines.append(f'joints."{name}" = {{ Ia = {arm.Ia[j]}, Fv = {arm.Fv[j]}, Fc = {arm.Fc[j]} }}')
    lines += ["[log]", f'files = ["{folder}/alone.csv"]']
    lines += [f"{what} = " + json.dumps([f"{column}{j + 1}" for j in range(arm.n)]) for what, column in (("position", "q"), ("control", "i"))]
    lines += ["[signal]", "torque_held = true", "[method]"]
    lines.append("gains = " + {"known": f'{{ known = {{ "{(*joints, "")[0]}" = {KNOWN} }} }}', "ratios": '"estimate"',
                               "mass": f'{{ loaded = "{folder}/mass.csv", mass = {masses[0]} }}',
                               "none": f'{{ loaded = "{folder}/none.csv", mass = {masses[1]} }}'}[kind])
    return "\n".join(lines) + "\n"


def names_of_joints(program, arm, folder):
    """In the order of the parameters."""
    text = experiment(arm, [], "ratios", folder, (0.0, 0.0)).replace('gains = "estimate"', "")
    return [joint["name"] for joint in identified(program, folder, text)["fit"]["joints"]]


def identified(program, folder, text):
    file = folder / "experiment.toml"
    file.write_text(text)
    run = subprocess.run([program, "identify", "--json", str(file), "--output", str(folder / "result"), "--force"], capture_output=True, text=True, check=False)
    if run.returncode > 1:
        raise SystemExit(run.stderr)
    return json.loads(run.stdout)


def exact(found):
    """The joint whose gain counted as exact, where ratios alone are known."""
    return min(range(len(found["joints"])), key=lambda j: found["joints"][j]["sigma"])


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("program")
    asked.add_argument("arms", nargs="*", metavar="ARM")
    asked.add_argument("--logs", type=int, default=4)
    asked.add_argument("--draws", type=int, default=3, help="of the gains, for each log")
    asked.add_argument("--only", choices=KINDS)
    given = asked.parse_args()
    for name in given.arms or ARMS:
        held = collections.defaultdict(list)
        of_gains = collections.defaultdict(list)
        seen = collections.defaultdict(list)
        statuses = {kind: collections.Counter() for kind in KINDS}
        alone, (heavy, *masses), (light, lightest) = Arm(name), loaded(name, HEAVY), loaded(name, LIGHT)
        masses.append(lightest)
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            joints = None
            for seed in range(1, given.logs + 1):
                alone.log(seed, folder / "a.csv")
                heavy.log(100 + seed, folder / "m.csv")
                light.log(200 + seed, folder / "n.csv")
                for draw in range(given.draws):
                    for kind in [given.only] if given.only else KINDS:
                        random = np.random.default_rng([seed, draw, KINDS.index(kind)])
                        gains = 1 + OFF * random.normal(size=alone.n)
                        if kind == "known":
                            gains[0] = 1 + KNOWN * random.normal()
                        for log, to in (("a", "alone"), ("m", "mass"), ("n", "none")):
                            as_currents(folder / f"{log}.csv", gains, folder / f"{to}.csv")
                        joints = joints or names_of_joints(given.program, alone, folder)
                        result = identified(given.program, folder, experiment(alone, joints, kind, folder, masses))
                        of_ratios = exact(result["gains"]) if kind == "ratios" else None
                        factor = 1.0 if of_ratios is None else 1.0 / gains[of_ratios]
                        statuses[kind][result["status"]] += 1
                        statuses[kind].update(warning["code"] for warning in result["warnings"])
                        for p in result["parameters"]:
                            low, high = p["interval_95"]
                            held[kind].append(low <= factor * truth(p, alone) <= high)
                        for j, (gain, true) in enumerate(zip(result["gains"]["joints"], gains)):
                            seen[kind].append(gain["identifiable"])
                            if gain["identifiable"] and j != of_ratios:
                                low, high = gain["interval_95"]
                                of_gains[kind].append(low <= factor * true <= high)
        for kind, inside in held.items():
            gains = of_gains[kind]
            print(f"{name:10} {kind:7} parameters {100 * np.mean(inside):5.1f} % of {len(inside)}, gains identified {100 * np.mean(seen[kind]):5.1f} %, " +
                  (f"{100 * np.mean(gains):5.1f} % of {len(gains)} hold" if gains else "") + "; " +
                  ", ".join(f"{count} {word}" for word, count in statuses[kind].most_common()), flush=True)


if __name__ == "__main__":
    main()
