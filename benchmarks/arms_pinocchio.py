"""Arms that were not built for rivid, simulated by Pinocchio, identified by rivid_identify.

Robot descriptions are those of the package example-robot-data, dynamics those of Pinocchio's articulated-body
algorithm: nothing in the logs comes from rivid. Each arm follows a sum of sines under a sampled PD control at 1 kHz, with
dry and viscous friction, rotor inertias, encoder noise that passes through the control, and a torque disturbance that
is not recorded. Three logs, one after the other, are identified with the rows and the method that rivid chooses, by weighted
least squares with a position filter, and by instrumental variables with given rows; another log judges. What is printed of each:

    mean of the relative torque errors on the other log, by the rows of the method: unfiltered ones are rougher
    intervals of 95 % that hold the true base parameter, and how many there are
    standard deviations, as root mean squares over the logs, over the root mean square of the errors: 1 where they are right
    mean time of the program, its start and both logs included, and what it warns of

    python3 -m venv venv && venv/bin/pip install pin example-robot-data
    venv/bin/python benchmarks/arms_pinocchio.py build/test/apps/rivid_identify [ARM ...]
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
import pinocchio as pin

from robot_data_arms import chain, description

RATE = 1000.0  # Hz, of control and log
DURATION = 20.0  # s
ENCODER_NOISE = 5e-6  # rad or m
DISTURBANCE = 0.01  # of the Coulomb friction, a new value each period
BANDWIDTH = 20.0  # rad/s, of the control
FRICTION_SPEED = 2e-3  # rad/s: friction is Fc tanh(v / FRICTION_SPEED)
STEPS = 20  # of the integration in a period
SHARE_OF_RANGE = 0.6  # of the joint limits that the motion uses
JUDGE = 0  # seeds of the logs: of the one that judges,
SEEDS = (1, 2, 3)  # and of those that are identified

NAMES = ("z1", "xarm7", "so101", "kinova", "talos arm", "ur5", "tiago", "baxter arm", "two joints", "pr2 arm", "g1 arm", "go2 leg")

METHODS = {  # name, keys of [signal]
    "chosen": ("auto", []),
    "WLS, 10 Hz": ("wls", ["cutoff_hz = 10", "decimation = 20"]),
    "IV": ("iv", ['cutoff_hz = "off"', "decimation = 20"]),
}


class Arm:
    """A chain of a robot with friction and rotors that go with its inertias."""

    def __init__(self, name):
        urdf, base, tip = self.urdf, self.base, self.tip = description(name)
        model = chain(pin.buildModelFromUrdf(str(urdf)), base, tip)
        self.model, self.data, self.n = model, model.createData(), model.nv
        joints = [model.joints[j] for j in range(1, model.njoints)]
        self.endless = [joint.nq == 2 for joint in joints]
        low = [-2.5 if e else model.lowerPositionLimit[j.idx_q] for j, e in zip(joints, self.endless)]
        high = [2.5 if e else model.upperPositionLimit[j.idx_q] for j, e in zip(joints, self.endless)]
        low, high = np.maximum(low, -2.5), np.minimum(high, 2.5)
        self.middle, self.reach = (low + high) / 2, SHARE_OF_RANGE * (high - low) / 2

        random = np.random.default_rng(99)
        poses = [self.middle + self.reach * random.uniform(-1, 1, self.n) for _ in range(40)]
        inertia = np.max([np.diag(pin.crba(model, self.data, self.full(q))) for q in poses], axis=0)
        gravity = np.max(
            [np.abs(pin.computeGeneralizedGravity(model, self.data, self.full(q))) for q in poses], axis=0
        )
        self.Ia = 0.3 * inertia + 1e-4
        self.J = inertia + self.Ia
        self.Fv = 0.2 * self.J
        self.Fc = 0.1 * self.J + 0.05 * gravity
        self.off = 0.02 * self.Fc
        model.armature[:] = self.Ia

    def full(self, q):
        """Positions as Pinocchio has them: an endless joint is a cosine and a sine."""
        return np.concatenate([[np.cos(x), np.sin(x)] if e else [x] for e, x in zip(self.endless, q)])

    def acceleration(self, q, v, tau):
        friction = self.Fv * v + self.Fc * np.tanh(v / FRICTION_SPEED) + self.off
        return pin.aba(self.model, self.data, self.full(q), v, tau - friction)

    def step(self, q, v, tau, h):
        """The midpoint rule. Euler's is half a step late, which a fit detects in 20 s of data."""
        middle = v + self.acceleration(q, v, tau) * h / 2
        return q + middle * h, v + self.acceleration(q + v * h / 2, middle, tau) * h

    def reference(self, t, random):
        harmonics = 2 * np.pi / 10 * np.arange(1, 6)
        sines, cosines = random.normal(size=(2, self.n, len(harmonics)))
        out = np.sin(np.outer(t, harmonics)) @ sines.T + np.cos(np.outer(t, harmonics)) @ cosines.T
        return self.middle + self.reach * out / np.abs(out).max(axis=0)

    def log(self, seed, path):
        random = np.random.default_rng(seed)
        t = np.arange(0, DURATION, 1 / RATE)
        wanted = self.reference(t, random)
        q, v = wanted[0].copy(), np.zeros(self.n)
        noise = ENCODER_NOISE * random.normal(size=(len(t), self.n))
        before = q + ENCODER_NOISE * random.normal(size=self.n)
        rows = []
        for k in range(len(t)):
            measured = q + noise[k]
            velocity, before = (measured - before) * RATE, measured
            tau = self.J * (BANDWIDTH**2 * (wanted[k] - measured) - 2 * BANDWIDTH * velocity)
            rows.append(np.concatenate([[t[k]], measured, tau, wanted[k]]))
            disturbed = tau + DISTURBANCE * self.Fc * random.normal(size=self.n)
            for _ in range(STEPS):
                q, v = self.step(q, v, disturbed, 1 / (RATE * STEPS))
        header = ["t"] + [f"{what}{j + 1}" for what in ("q", "tau", "qref") for j in range(self.n)]
        np.savetxt(path, rows, delimiter=",", header=",".join(header), comments="", fmt="%.9g")

    def experiment(self, folder, seed, method, joints):
        """The text of an experiment file. What is known of the joints only fills a_priori, the truth to compare with."""
        lines = ["[robot]", f'urdf = "{self.urdf}"', "gravity = [0, 0, -9.81]"]
        lines += [f'base = "{self.base}"', f'tip = "{self.tip}"'] if self.tip else []
        for j, name in enumerate(joints):
            lines.append(f'joints."{name}" = {{ Ia = {self.Ia[j]}, Fv = {self.Fv[j]}, Fc = {self.Fc[j]} }}')
        lines += ["[log]", f'files = ["{folder}/{seed}.csv"]']
        lines.append("reference = " + json.dumps([f"qref{j + 1}" for j in range(self.n)]))
        name, signal = METHODS[method]
        lines += ["[signal]", "torque_held = true", *signal]
        lines += ["[control]", 'law = "pd"', f"omega_n = {BANDWIDTH}", "zeta = 1", f"rate_hz = {RATE}"]
        lines += ["[method]", f'name = "{name}"', "[validation]", f'files = ["{folder}/{JUDGE}.csv"]']
        return "\n".join(lines) + "\n"


def identified(program, folder, text):
    file = folder / "experiment.toml"
    file.write_text(text)
    begin = time.monotonic()
    run = subprocess.run([program, "--json", str(file)], capture_output=True, text=True, check=False)
    seconds = time.monotonic() - begin
    if run.returncode > 1:
        raise SystemExit(run.stderr)
    return json.loads(run.stdout), seconds


def truth(parameter, arm):
    """The description has no friction offset; for the rest a_priori is the truth."""
    offset = 0.0
    for name, coefficient in parameter["regrouping"].items():
        if name.startswith("off"):
            offset += coefficient * arm.off[int(name[3:]) - 1]
    return parameter["a_priori"] + offset


class Judgement:
    """What the results of one method, of several logs of one arm, are worth."""

    def __init__(self):
        self.validation, self.seconds, self.held, self.errors, self.sigmas, self.codes = [], [], 0, [], [], set()

    def add(self, result, seconds, arm):
        parameters = result["parameters"]
        self.validation.append(100 * result["validation"][0]["relative_error"])
        self.seconds.append(seconds)
        self.held += sum(p["interval_95"][0] <= truth(p, arm) <= p["interval_95"][1] for p in parameters)
        self.errors.append([p["value"] - truth(p, arm) for p in parameters])
        self.sigmas.append([p["sigma"] for p in parameters])
        self.codes |= {result["status"]} | {w["code"] for w in result["warnings"]}

    def scaled(self):
        """Errors in the root mean square of the logs' standard deviations: one standard deviation has few degrees of freedom."""
        return np.ravel(self.errors / np.sqrt(np.mean(np.square(self.sigmas), axis=0)))

    def line(self):
        scaled = self.scaled()
        return (
            f"{np.mean(self.validation):6.3f} %{self.held:5} of {len(scaled):3}{1 / rms(scaled):6.2f}"
            f"{np.mean(self.seconds):7.2f} s {' '.join(sorted(self.codes))}   "
        )


def rms(errors):
    return np.sqrt(np.mean(np.square(errors)))


def main():
    program, names = sys.argv[1], sys.argv[2:] or NAMES
    print(f"{'arm':12}joints" + "".join(f"   {method:31}" for method in METHODS))
    totals = {method: [] for method in METHODS}
    for name in names:
        arm = Arm(name)
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            for seed in (JUDGE, *SEEDS):
                arm.log(seed, folder / f"{seed}.csv")
            first, _ = identified(program, folder, arm.experiment(folder, SEEDS[0], "chosen", []))
            joints = [joint["name"] for joint in first["fit"]["joints"]]
            line = f"{name:12}{arm.n:6}   "
            for method in totals:
                judgement = Judgement()
                for seed in SEEDS:
                    judgement.add(*identified(program, folder, arm.experiment(folder, seed, method, joints)), arm)
                totals[method].append(judgement)
                line += judgement.line()
            print(line, flush=True)
    for method, judgements in totals.items():
        scaled = np.concatenate([judgement.scaled() for judgement in judgements])
        held = sum(judgement.held for judgement in judgements)
        print(
            f"{method}: {held} of {len(scaled)} intervals hold the truth, {100 * held / len(scaled):.1f} %,"
            f" σ over spread {1 / rms(scaled):.2f}"
        )


if __name__ == "__main__":
    main()
