"""Torques of robots that differ from their description along designed motions: how many of 200 keep their limits.

Each robot is designed for with the defaults, without and with `prior_spread = 0.5`. Links, with all their inertia, and friction of the
robots that are drawn are each off by up to a half; the torques are Pinocchio's. Printed: how many keep the whole torque limits of
the description, and the largest torque over its limit.

    python3 -m venv venv && venv/bin/pip install pin
    venv/bin/python benchmarks/excite_prior.py build/test/apps/rivid FILE.urdf ...
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin

SPREAD, ROBOTS, ACCELERATION = 0.5, 200, 10.0
EXPERIMENT = """[robot]
urdf = "{urdf}"
friction = "coulomb"
gravity = [0, 0, -9.81]
[excitation]
starts = 1
noise = {noise}
[excitation.limits]
torque = {torque}
acceleration = {acceleration}
prior_spread = {spread}
"""


def motion(program, urdf, torque, spread):
    with tempfile.TemporaryDirectory() as folder:
        file, plan = pathlib.Path(folder, "arm.toml"), pathlib.Path(folder, "plan")
        noise = json.dumps((0.01 * torque).tolist())
        values = {"noise": noise, "torque": json.dumps(torque.tolist()), "acceleration": ACCELERATION, "spread": spread}
        file.write_text(EXPERIMENT.format(urdf=urdf, **values))
        subprocess.run([program, "excite", file, "--quiet", "--output", plan], check=True)
        data = np.genfromtxt(plan / "motion.csv", delimiter=",", names=True)
    return [np.column_stack([data[f"{what}{j + 1}"] for j in range(len(torque))]) for what in ("q", "qd", "qdd")]


def shares(model, torque, friction, states):
    """Of each robot the largest torque over its limit."""
    random = np.random.default_rng(5)
    out = []
    for _ in range(ROBOTS):
        drawn = model.copy()
        for j in range(1, drawn.njoints):
            body, s = drawn.inertias[j], random.uniform(1 - SPREAD, 1 + SPREAD)
            drawn.inertias[j] = pin.Inertia(s * body.mass, body.lever, s * body.inertia)
        damping, dry = (f * random.uniform(1 - SPREAD, 1 + SPREAD, len(f)) for f in friction)
        data = drawn.createData()
        tau = np.array([pin.rnea(drawn, data, *state) for state in zip(*(x[::5] for x in states))])
        tau += damping * states[1][::5] + dry * np.sign(states[1][::5])
        out.append((np.abs(tau) / torque).max())
    return np.array(out)


def main():
    program, *files = sys.argv[1:]
    print("| robot | prior_spread | robots within torque | largest |\n|---|---|---|---|")
    for file in map(pathlib.Path, files):
        model = pin.buildModelFromUrdf(str(file))
        xml = {joint.get("name"): joint for joint in ElementTree.parse(file).getroot().findall("joint")}
        read = lambda name, tag, key: float((xml[name].find(tag) if xml[name].find(tag) is not None else {}).get(key, 0))
        names = list(model.names)[1:]
        friction = [np.array([read(name, "dynamics", key) for name in names]) for key in ("damping", "friction")]
        torque = np.array([read(name, "limit", "effort") for name in names])
        for spread in (0.0, SPREAD):
            found = shares(model, torque, friction, motion(program, file.resolve(), torque, spread))
            print(f"| {file.stem} | {spread} | {(found <= 1).sum()} of {ROBOTS} | {100 * found.max():.0f} % |", flush=True)


if __name__ == "__main__":
    main()
