"""Designs for twenty arms that were not made for rivid, with limits checked by Pinocchio.

Descriptions are those of the package example-robot-data. Each arm gets one design with the defaults and one start; where the
description has no limit of velocities or torques, or a limit that can not be meant, ours of LIMITS is given and noted.
The Fourier series is then sampled ten times as densely as it is played, and torques are Pinocchio's, with the friction
that the description states. Printed of each: joints, parameters, seconds of one core, log det, the largest use of a
limit, and what was given; of several seeds the means, and the largest use of all.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data
    venv/bin/python benchmarks/excite_arms.py build/test/apps/rivid_excite [--seeds N] [ARM | FILE.urdf ...]
"""

import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin

from robot_data_arms import ARMS, chain, description

RATE, DURATION, DENSER = 500, 15, 10
NAMES = [name for name in ARMS if name not in ("two joints", "go2 leg")]
LIMITS = {"velocity": 2.0, "torque": 50.0, "acceleration": 10.0}  # rad/s, N m, rad/s²
NOISE = 0.01  # of the torque limit


class Arm:
    def __init__(self, name):
        _, base, tip = self.urdf, self.base, self.tip = description(name)
        root = ElementTree.parse(self.urdf).getroot()
        model = pin.buildModelFromUrdf(str(self.urdf))
        self.gravity = np.array([0.0, 0.0, -9.81])
        if tip:
            # In the axes of the base link, which need not stand upright.
            data = model.createData()
            pin.framesForwardKinematics(model, data, pin.neutral(model))
            self.gravity = data.oMf[model.getFrameId(base)].rotation.T @ self.gravity
        model = chain(model, base, tip)
        self.model, self.data, self.n = model, model.createData(), model.nv
        self.joints = list(model.names)[1:]
        xml = {joint.get("name"): joint for joint in root.findall("joint")}
        value = lambda name, tag, key: float((xml[name].find(tag) if xml[name].find(tag) is not None else {}).get(key, 0))
        self.endless = [model.joints[j].nq == 2 for j in range(1, model.njoints)]
        self.damping = np.array([value(name, "dynamics", "damping") for name in self.joints])
        self.friction = np.array([value(name, "dynamics", "friction") for name in self.joints])
        given = {
            "velocity": np.array([value(name, "limit", "velocity") for name in self.joints]),
            "torque": np.array([value(name, "limit", "effort") for name in self.joints]),
        }
        self.limits, self.notes = {}, []
        for what, most in (("velocity", 50.0), ("torque", 20000.0)):
            usable = (given[what] > 0) & (given[what] < most)
            self.limits[what] = np.where(usable, given[what], LIMITS[what])
            if not usable.all():
                self.notes.append(f"{what} of {(~usable).sum()} joints")

    def experiment(self):
        lists = lambda values: json.dumps([float(v) for v in values])
        lines = ["[robot]", f'urdf = "{self.urdf}"', f"gravity = {lists(self.gravity)}"]
        lines += [f'base = "{self.base}"', f'tip = "{self.tip}"'] if self.tip else []
        lines += ["[excitation]", f"duration = {DURATION}", f"rate_hz = {RATE}", "starts = 1"]
        lines += [f"noise = {lists(NOISE * self.limits['torque'])}", "[excitation.limits]"]
        lines += [f"{what} = {lists(values)}" for what, values in self.limits.items()]
        lines += [f"acceleration = {LIMITS['acceleration']}"]
        return "\n".join(lines) + "\n"

    def full(self, q):
        return np.concatenate([[np.cos(x), np.sin(x)] if e else [x] for e, x in zip(self.endless, q)])

    def largest_use(self, plan):
        """Of half the range of each limit, on the dense grid."""
        series = {key: np.array(plan["motion"][key]) for key in ("A", "B", "q0")}
        t = np.linspace(0, plan["motion"]["duration"], DENSER * RATE * DURATION + 1)
        w = plan["motion"]["omega_f"] * np.arange(1, series["A"].shape[1] + 1)
        sines, cosines = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        q = series["q0"] + (sines / w) @ series["A"].T - (cosines / w) @ series["B"].T
        v = cosines @ series["A"].T + sines @ series["B"].T
        a = -(sines * w) @ series["A"].T + (cosines * w) @ series["B"].T
        tau = np.array([pin.rnea(self.model, self.data, self.full(q[k]), v[k], a[k]) for k in range(len(t))])
        tau += self.damping * v + self.friction * np.sign(v)
        # The part of the range, about its middle, that is left by default.
        low = np.array([-np.pi if e else x for e, x in zip(self.endless, self.bounds(self.model.lowerPositionLimit))])
        high = np.array([np.pi if e else x for e, x in zip(self.endless, self.bounds(self.model.upperPositionLimit))])
        shares = {
            "position": np.abs(q - (low + high) / 2) / (0.95 * (high - low) / 2),
            "velocity": np.abs(v) / (0.9 * self.limits["velocity"]),
            "acceleration": np.abs(a) / LIMITS["acceleration"],
            "torque": np.abs(tau) / (0.8 * self.limits["torque"]),
        }
        quantity = max(shares, key=lambda key: shares[key].max())
        joint = self.joints[int(shares[quantity].max(axis=0).argmax())]
        return shares[quantity].max(), f"{quantity} of {joint}"

    def bounds(self, limits):
        return [0.0 if e else limits[self.model.joints[j + 1].idx_q] for j, e in enumerate(self.endless)]


def design(excite, arm, seed):
    """The plan, or why there is none, and processor seconds."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "arm.toml")
        file.write_text(arm.experiment())
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [excite, str(file), "--threads", "1", "--seed", str(seed), "--quiet", "--output", folder]
        done = subprocess.run(command, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if done.returncode:
            return None, done.stderr.strip(), seconds
        return json.loads(pathlib.Path(folder, "plan.json").read_text()), "", seconds


def row_of(excite, name, seeds):
    arm = Arm(name)
    times, log_dets, uses = [], [], []
    for seed in range(1, seeds + 1):
        plan, fault, seconds = design(excite, arm, seed)
        if plan is None:
            return f"| {name} | {arm.n} | | {seconds:.1f} | none, seed {seed}: {fault} | | |"
        times.append(seconds)
        # Not a number where some parameter is not seen.
        log_dets.append(np.nan if plan["log_det"] is None else plan["log_det"])
        uses.append(arm.largest_use(plan))
    use, where = max(uses)
    return (
        f"| {name} | {arm.n} | {len(plan['parameters'])} | {np.mean(times):.1f} | {np.mean(log_dets):.0f} | "
        f"{100 * use:.4f} %, {where} | {', '.join(arm.notes)} |"
    )


def main():
    excite, *names = sys.argv[1:]
    seeds = 1
    if names[:1] == ["--seeds"]:
        seeds = int(names[1])
        names = names[2:]
    print("| arm | joints | parameters | CPU s | log det | largest use of a limit | given besides |")
    print("|---|---|---|---|---|---|---|")
    for name in names or NAMES:
        print(row_of(excite, name, seeds), flush=True)


if __name__ == "__main__":
    main()
