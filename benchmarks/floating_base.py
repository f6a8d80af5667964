"""A quadruped that drops, stands and hangs: base parameters and mass from its motion, its torques and the forces on it.

Solo12 is integrated by Pinocchio's direct dynamics with a free flyer: eight drops of 0.8 s with swinging legs, a stance of 12 s on four
springs that hold the feet, 12 s on a hoist, a spring at the trunk. Motors have rotors and friction. Measured at 1 kHz, with noise: pose of
the trunk (0.1 mm, 0.2 mrad) or an accelerometer (0.02 m/s²) and its orientation, joint angles (20 µrad), motor torques (0.01 N·m), forces at
feet and hoist (0.1 N). Printed for each seed: base parameters, those within their 95 % intervals, largest error in standard deviations,
error of the total mass, the interval's half-width. The last line sums the seeds.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data
    venv/bin/python benchmarks/floating_base.py build/test/apps/rivid [SEED ...] [--imu] [--only drops|stance|hoist ...]
                                                [--mass]

With --mass no torque or force is logged, and the total mass is given: drops alone.

Exit code: 1 where the mass of a seed is off by 0.5 % or fewer than 90 % of all parameters are within their intervals.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np
import pinocchio as pin

from robot_data_arms import ROBOTS

URDF = ROBOTS / "solo_description/robots/solo12.urdf"
LEGS = ["FL", "FR", "HL", "HR"]
RATE, STEPS = 1000, 4  # Hz, steps of integration a sample
ROTOR, VISCOUS, COULOMB, SMOOTH = 2e-4, 0.01, 0.03, 0.2
STIFF, DAMPED = 3000.0, 6.0  # of what holds a foot [N/m, N s/m]
HOIST_STIFF, HOIST_DAMPED = 150.0, 2.0
HOIST_AT = np.array([0.05, 0.02, 0.08])
IMU_AT = np.array([0.06, -0.03, 0.02])
NOISE = dict(place=1e-4, turn=2e-4, angle=2e-5, torque=0.01, force=0.1, acceleration=0.02)


class Solo:
    def __init__(self):
        self.model = pin.buildModelFromUrdf(str(URDF), pin.JointModelFreeFlyer())
        self.model.armature[6:] = ROTOR
        self.data = self.model.createData()
        self.n = self.model.nv - 6
        self.feet = [self.model.getFrameId(f"{leg}_FOOT") for leg in LEGS]
        self.mass = sum(inertia.mass for inertia in self.model.inertias)

    def stand(self):
        q = pin.neutral(self.model)
        for k in range(4):
            q[7 + 3 * k : 10 + 3 * k] = [0.0, 0.7, -1.4] if k < 2 else [0.0, -0.7, 1.4]
        return q

    def point(self, frame, at):
        """Place, velocity and the Jacobian of its velocity, along the axes of the world, of a point of a frame."""
        pose = self.data.oMf[frame]
        J = pin.getFrameJacobian(self.model, self.data, frame, pin.LOCAL_WORLD_ALIGNED)
        arm = pose.rotation @ at
        return pose.translation + arm, J[:3] - pin.skew(arm) @ J[3:]


class Run:
    """One log of a motion that drives follow and springs hold."""

    def __init__(self, solo, kind, seconds, random):
        self.solo, self.kind = solo, kind
        n = solo.n
        self.q = solo.stand()
        self.v = np.zeros(solo.model.nv)
        self.rest = self.q[7:].copy()
        harmonics = 6
        low, high = (0.3, 2.0) if kind == "stance" else (1.0, 4.0)
        size = 0.05 if kind == "stance" else 0.25
        self.frequencies = 2 * np.pi * random.uniform(low, high, (harmonics, n))
        self.sizes = size * random.uniform(0.3, 1.0, (harmonics, n)) / np.sqrt(harmonics)
        self.phases = random.uniform(0, 2 * np.pi, (harmonics, n))
        self.gains = (12.0, 0.2) if kind == "stance" else (8.0, 0.15)
        if kind == "drops":
            turn = pin.rpy.rpyToMatrix(*random.uniform([-0.7, -0.5, -3], [0.7, 0.5, 3]))
            self.q[3:7] = pin.Quaternion(turn).coeffs()
            self.v[:6] = random.uniform(-1, 1, 6) * [0.5, 0.5, 1.0, 2.5, 1.5, 2.5]
        pin.framesForwardKinematics(solo.model, solo.data, self.q)
        trunk = solo.model.getFrameId("base_link")
        self.holds = [(foot, np.zeros(3), STIFF, DAMPED) for foot in solo.feet] + [(trunk, HOIST_AT, HOIST_STIFF, HOIST_DAMPED)]
        self.on = [kind == "stance"] * 4 + [kind == "hoist"]
        self.anchors = [solo.data.oMf[f].act(at) for f, at, *_ in self.holds]
        for k in range(4):
            self.anchors[k] = self.anchors[k] - [0, 0, solo.mass * 9.81 / 4 / STIFF]
        self.anchors[4] = self.anchors[4] + [0, 0, solo.mass * 9.81 / HOIST_STIFF]
        self.samples = int(seconds * RATE)

    def torque(self, t, q, v):
        fade = min(1.0, t / 0.5) if self.kind != "drops" else 1.0
        a = self.frequencies * t + self.phases
        wanted = self.rest + fade * (self.sizes * np.sin(a)).sum(axis=0)
        speed = fade * (self.sizes * self.frequencies * np.cos(a)).sum(axis=0)
        return self.gains[0] * (wanted - q[7:]) + self.gains[1] * (speed - v[6:])

    def forces(self, q, v):
        """Of springs, along the axes of the world, and what they are as generalised forces."""
        solo = self.solo
        out, generalised = np.zeros((5, 3)), np.zeros(solo.model.nv)
        if any(self.on):
            pin.computeJointJacobians(solo.model, solo.data, q)
            pin.updateFramePlacements(solo.model, solo.data)
        for k, (frame, at, stiff, damped) in enumerate(self.holds):
            if self.on[k]:
                place, J = solo.point(frame, at)
                out[k] = stiff * (self.anchors[k] - place) - damped * (J @ v)
                generalised += J.T @ out[k]
        return out, generalised

    def acceleration(self, t, q, v):
        motor = self.torque(t, q, v)
        forces, generalised = self.forces(q, v)
        friction = VISCOUS * v[6:] + COULOMB * np.tanh(v[6:] / SMOOTH)
        generalised[6:] += motor - friction
        return pin.aba(self.solo.model, self.solo.data, q, v, generalised), motor, forces

    def step(self, t, h):
        model = self.solo.model
        f = lambda t, dq, v: (v, self.acceleration(t, pin.integrate(model, self.q, dq), v)[0])
        v = self.v
        k1 = f(t, np.zeros(model.nv), v)
        k2 = f(t + h / 2, h / 2 * k1[0], v + h / 2 * k1[1])
        k3 = f(t + h / 2, h / 2 * k2[0], v + h / 2 * k2[1])
        k4 = f(t + h, h * k3[0], v + h * k3[1])
        self.q = pin.integrate(model, self.q, h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0]))
        self.v = v + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])

    def log(self, random, torques=True):
        rows = []
        noisy = lambda x, sigma: x + sigma * random.standard_normal(len(x))
        for k in range(self.samples):
            t = k / RATE
            a, motor, forces = self.acceleration(t, self.q, self.v)
            R = pin.Quaternion(self.q[3:7]).matrix()
            w, wd = self.v[3:6], a[3:6]  # in the frame of the trunk, as the linear ones
            felt = a[:3] + np.cross(w, self.v[:3]) - R.T @ [0, 0, -9.81] + np.cross(wd, IMU_AT) + np.cross(w, np.cross(w, IMU_AT))
            turned = pin.Quaternion(R @ pin.exp3(NOISE["turn"] * random.standard_normal(3))).coeffs()
            rows.append(
                np.concatenate(
                    [[t], noisy(self.q[:3], NOISE["place"]), turned[[3, 0, 1, 2]], noisy(felt, NOISE["acceleration"])]
                    + [noisy(self.q[7:], NOISE["angle"])]
                    + ([noisy(motor, NOISE["torque"])] if torques else [])
                    + ([noisy(forces.ravel(), NOISE["force"]) if any(self.on) else forces.ravel()] if torques else [])
                )
            )
            for i in range(STEPS):
                self.step(t + i / RATE / STEPS, 1 / RATE / STEPS)
        return np.array(rows)


def header(n, torques=True):
    names = ["t"] + [f"base_{c}" for c in ("x", "y", "z", "qw", "qx", "qy", "qz")] + ["acc_x", "acc_y", "acc_z"]
    names += [f"q{j + 1}" for j in range(n)]
    return names + ([f"tau{j + 1}" for j in range(n)] + [f"f{k}_{c}" for k in range(5) for c in "xyz"] if torques else [])


def listed(words):
    return "[" + ", ".join(f'"{w}"' for w in words) + "]"


def experiment(solo, files, imu, mass):
    joints = list(solo.model.names)[2:]
    out = [f'[robot]\nurdf = "{URDF}"\nfloating = true\ngravity = [0, 0, -9.81]']
    if mass:
        out += [f'friction = "none"\nrotor_inertia = false\ntotal_mass = {mass}']
    else:
        out += [f'friction = "coulomb"\nsign_speed = {SMOOTH}']
        out += [f'[robot.joints."{joint}"]\nIa = {ROTOR}\nFv = {VISCOUS}\nFc = {COULOMB}' for joint in joints]
    out += [f"[log]\nfiles = {listed(files)}"]
    place = f'acceleration = ["acc_x", "acc_y", "acc_z"]\nimu = {IMU_AT.tolist()}' if imu else 'position = ["base_x", "base_y", "base_z"]'
    out += [f'[log.base]\n{place}\norientation = ["base_qw", "base_qx", "base_qy", "base_qz"]']
    for k in range(0 if mass else 5):
        frame = solo.model.frames[solo.feet[k]] if k < 4 else None
        link = f"{LEGS[k]}_LOWER_LEG" if k < 4 else "base_link"
        lower = solo.model.frames[solo.model.getFrameId(link)]
        at = lower.placement.actInv(frame.placement).translation if k < 4 else HOIST_AT
        wrench = listed(f"f{k}_{c}" for c in "xyz")
        out += [f'[[log.contact]]\nlink = "{link}"\nwrench = {wrench}\nat = {at.tolist()}\nframe = "world"']
    return "\n".join(out + ['[signal]\ntorque_held = false\n[method]\nname = "wls"\n'])


def seed_row(rivid, seed, kinds, imu, by_mass):
    solo = Solo()
    random = np.random.default_rng(seed)
    runs = [kind for kind in kinds for _ in range(8 if kind == "drops" else 1)]
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for k, kind in enumerate(runs):
            data = Run(solo, kind, 0.8 if kind == "drops" else 12.0, random).log(random, not by_mass)
            files.append(f"{kind}_{k}.csv")
            np.savetxt(pathlib.Path(folder, files[-1]), data, delimiter=",", header=",".join(header(solo.n, not by_mass)), comments="")
        file = pathlib.Path(folder, "solo.toml")
        file.write_text(experiment(solo, files, imu, solo.mass if by_mass else None))
        done = subprocess.run([rivid, "identify", file, "--output", pathlib.Path(folder, "id")], capture_output=True, text=True)
        try:
            result = json.loads(pathlib.Path(folder, "id", "result.json").read_text())
        except FileNotFoundError:
            raise SystemExit(done.stderr)
    parameters = result["parameters"]
    errors = np.array([abs(p["value"] - p["a_priori"]) / p["sigma"] for p in parameters])
    mass = next(p for p in parameters if p["name"].startswith("M6"))
    assert abs(mass["a_priori"] - solo.mass) < 1e-9
    off = mass["value"] / solo.mass - 1
    within = int((errors <= result["covariance"]["quantile_975"]).sum())
    print(
        f"seed {seed}: {result['status']}, {within} of {len(errors)} within, worst {errors.max():.1f} σ "
        f"({parameters[errors.argmax()]['name']}), mass {100 * off:+.3f} % ± {196 * mass['sigma'] / solo.mass:.3f} %",
        flush=True,
    )
    return within, len(errors), abs(off)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("rivid")
    parser.add_argument("seeds", nargs="*", type=int, default=[1, 2, 3, 4, 5])
    parser.add_argument("--imu", action="store_true")
    parser.add_argument("--only", nargs="+", choices=["drops", "stance", "hoist"], default=["drops", "stance", "hoist"])
    parser.add_argument("--mass", action="store_true")
    given = parser.parse_args()
    kinds = ["drops"] if given.mass else given.only
    rows = [seed_row(given.rivid, seed, kinds, given.imu, given.mass) for seed in given.seeds]
    within, count, off = sum(r[0] for r in rows), sum(r[1] for r in rows), max(r[2] for r in rows)
    print(f"{within} of {count} within their intervals ({100 * within / count:.1f} %), mass off by {100 * off:.3f} % at most")
    return int(off > 0.005 or within < 0.9 * count)


if __name__ == "__main__":
    raise SystemExit(main())
