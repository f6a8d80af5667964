"""Every robot description of the package example-robot-data, whole, beside Pinocchio.

Prints for each its joints, the links that carry more than one, and the largest differences relative to the largest value: torques, mass
matrix, torques of the accelerations that direct dynamics finds (where M can be inverted), and W χ of the base parameters; or why rivid
refuses it. Mimic joints move by themselves in both.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data
    PYTHONPATH=build/test/python venv/bin/python benchmarks/trees_pinocchio.py

Exit code: 1 if a difference exceeds those of LARGEST, else 0.
"""

import re
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

import rivid
from robot_data_arms import ROBOTS

SAMPLES = 20
LARGEST = {"torques": 1e-13, "M": 1e-13, "accelerations": 1e-13, "regressor": 1e-5}  # the last one: base_tolerance
WELL_CONDITIONED = 1e8


def held(path, joints):
    """Pinocchio's model of the joints that rivid has, and the place of each of them."""
    model = pin.buildModelFromUrdf(str(path))
    others = [j for j in range(1, model.njoints) if model.names[j] not in joints]
    if others:
        model = pin.buildReducedModel(model, others, pin.neutral(model))
    return model, [model.joints[model.getJointId(joint)] for joint in joints]


def position(model, places, q):
    out = pin.neutral(model)
    for place, value in zip(places, q):
        out[place.idx_q : place.idx_q + place.nq] = [np.cos(value), np.sin(value)] if place.nq == 2 else [value]
    return out


def largest_difference(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


def compare(original):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / original.name
        path.write_text(re.sub("<mimic[^>]*>", "", original.read_text()))
        return differences(path)


def differences(path):
    robot = rivid.Robot.from_urdf(path, friction="none", rotor_inertia=False, gravity=[0, 0, -9.81])
    model, places = held(path, robot.joints)
    data = model.createData()
    order = [place.idx_v for place in places]
    dynamics = robot.model()
    random = np.random.default_rng(1)
    q, qd, qdd = (scale * random.normal(size=(SAMPLES, len(robot))) for scale in (1.0, 2.0, 5.0))
    found = dict.fromkeys(LARGEST, 0.0)
    torques = []
    for k in range(SAMPLES):
        at = position(model, places, q[k])
        v, a = np.zeros((2, model.nv))
        v[order], a[order] = qd[k], qdd[k]
        torques.append(pin.rnea(model, data, at, v, a)[order])
        M = pin.crba(model, data, at)
        M = (np.triu(M) + np.triu(M, 1).T)[np.ix_(order, order)]
        found["torques"] = max(found["torques"], largest_difference(dynamics.inverse_dynamics(q[k], qd[k], qdd[k]), torques[k]))
        found["M"] = max(found["M"], largest_difference(dynamics.mass_matrix(q[k]), M))
        if np.linalg.cond(M) < WELL_CONDITIONED:
            moved = M @ (dynamics.direct_dynamics(q[k], qd[k], torques[k]) - qdd[k])
            found["accelerations"] = max(found["accelerations"], np.abs(moved).max() / np.abs(torques[k]).max())
    base = robot.base_parameters()
    chi = base.from_standard(np.array(list(robot.standard_parameters.values())))
    found["regressor"] = largest_difference(robot.regressor(q, qd, qdd) @ chi, np.array(torques))
    return robot, found


def main():
    worst = 0
    compared = refused = 0
    print(f"{'description':34} {'joints':>6}  " + "  ".join(f"{name:>13}" for name in LARGEST))
    for path in sorted(ROBOTS.rglob("*.urdf")):
        try:
            robot, found = compare(path)
        except rivid.InputError as error:
            refused += 1
            print(f"{path.stem:34} refused: {str(error).split(': ', 1)[1][:110]}")
            continue
        compared += 1
        worst |= any(found[name] > LARGEST[name] for name in LARGEST)
        print(f"{path.stem:34} {len(robot):6}  " + "  ".join(f"{found[name]:13.1e}" for name in LARGEST))
    print(f"{compared} compared, {refused} refused")
    return worst


if __name__ == "__main__":
    sys.exit(main())
