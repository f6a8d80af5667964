#!/usr/bin/env python3
"""What one log of the KUKA says of load friction, and how well it predicts the other log, for docs/friction.md. Needs NumPy.

    python3 tests/real/kuka_one_log.py FOLDER LOGS [draws]

FOLDER holds rivid_identify, LOGS the logs and the URDF. Takes the rows of each log (tests/real/kuka_kr300.toml without its [signal], but for
the window). Prints what load gains at each joint by cross-validation over eight stretches of one log. Then fits friction that follows the
load (Fl >= 0) to both logs, and draws logs of that model: its torques and blocks of 0.6 s of a residual. Fits each log of a draw, and
prints the relative errors on the other.
"""

import copy
import os
import subprocess
import sys
import tempfile

import numpy as np

EXPERIMENT = """
[robot]
urdf = "{logs}/kr300.urdf"
friction = "symmetric"
[log]
files = ["{logs}/kr300_{name}.csv"]
position = ["q1", "q2", "q3", "q4", "q5", "q6"]
torque = ["tau1", "tau2", "tau3", "tau4", "tau5", "tau6"]
rate_hz = 250
subtract = [{{ joint = "joint_2", table = "{logs}/counterbalance_joint2.csv" }}]
[signal]
window = [2.0, 8.2]
[method]
name = "wls"
"""
PASSES = 12
BLOCK = 0.6  # s
STRETCHES = 8


class Rows:
    def __init__(self, programs, logs, name, folder):
        experiment, file = os.path.join(folder, name + ".toml"), os.path.join(folder, name + ".npz")
        with open(experiment, "w", encoding="utf-8") as out:
            out.write(EXPERIMENT.format(logs=os.path.abspath(logs), name=name))
        program = os.path.join(programs, "rivid_identify")
        subprocess.run([program, experiment, "--output", folder, "--write-rows", file, "--quiet"], check=False)  # doubtful is 1
        made = np.load(file)
        names = [str(p) for p in made["parameters"]]
        self.t, self.joint, self.Y, self.W = made["t"], made["joint"].astype(int), made["Y"], made["W"]
        self.joints = range(len(made["joints"]))
        self.rigid = np.array([not p.startswith(("Fv", "Fc", "off")) for p in names])
        self.sign = np.sum([np.where(self.joint == j, self.W[:, names.index(f"Fc{j + 1}")], 0.0) for j in self.joints], axis=0)

    def part(self, mask):
        out = copy.copy(self)
        for name in ("t", "joint", "Y", "W", "sign"):
            setattr(out, name, getattr(self, name)[mask])
        return out

    def load_columns(self, chi):
        """sign(q') |load| of each joint."""
        column = self.sign * np.abs(self.W[:, self.rigid] @ chi[self.rigid])
        return np.column_stack([np.where(self.joint == j, column, 0.0) for j in self.joints])

    def torques(self, chi, Fl):
        return self.W @ chi + self.load_columns(chi) @ Fl


def weighted(W, Y, joint, joints):
    """Least squares, each joint's rows by the deviation that they are left with."""
    weight = np.ones(len(Y))
    for _ in range(3):
        scale = np.linalg.norm(W * weight[:, None], axis=0)
        scale[scale == 0] = 1
        theta = np.linalg.lstsq(W * weight[:, None] / scale, Y * weight, rcond=None)[0] / scale
        for j in joints:
            weight[joint == j] = 1 / np.sqrt(np.mean((Y - W @ theta)[joint == j] ** 2))
    return theta


def fit(logs, torques, kept):
    """Parameters and Fl of the joints kept: the load is that of the last pass, and joints whose Fl is negative have none."""
    W, Y = np.vstack([log.W for log in logs]), np.concatenate(torques)
    joint, joints, b = np.concatenate([log.joint for log in logs]), logs[0].joints, W.shape[1]
    chi, Fl = weighted(W, Y, joint, joints), np.zeros(len(joints))
    for _ in range(PASSES if kept else 0):
        theta = weighted(np.hstack([W, np.vstack([log.load_columns(chi) for log in logs])[:, kept]]), Y, joint, joints)
        chi, Fl = theta[:b], np.zeros(len(joints))
        Fl[kept] = theta[b:]
        kept = [j for j in kept if Fl[j] > 0]
    return chi, np.maximum(Fl, 0)


def error(log, torques, model):
    return 100 * np.linalg.norm(torques - log.torques(*model)) / np.linalg.norm(torques)


def own_residual(log, kept):
    """Of a fit to this log alone, as large as that of the true parameters would be."""
    chi, Fl = fit([log], [log.Y], kept)
    return (log.Y - log.torques(chi, Fl)) / np.sqrt(1 - (len(chi) + np.count_nonzero(Fl)) / len(log.Y))


def both_ways(logs, torques, kept):
    """Fit to A, error on B; fit to B, error on A; their mean."""
    out = [error(logs[1 - k], torques[1 - k], fit(logs[k : k + 1], torques[k : k + 1], kept)) for k in (0, 1)]
    return [*out, np.mean(out)]


def gains_in_standard_errors(log):
    """Of load at one joint alone, in the squared error of that joint on stretches of time that were left out of the fit."""
    stretch = ((log.t - log.t.min()) / (np.ptp(log.t) + 1e-9) * STRETCHES).astype(int)
    squares = {}
    for joint in [None, *log.joints]:
        left = np.zeros((STRETCHES, len(log.joints)))
        for k in range(STRETCHES):
            model = fit([log.part(stretch != k)], [log.Y[stretch != k]], [] if joint is None else [joint])
            unseen = log.part(stretch == k)
            for j in log.joints:
                left[k, j] = np.sum((unseen.Y - unseen.torques(*model))[unseen.joint == j] ** 2)
        squares[joint] = left
    gains = [squares[None][:, j] - squares[j][:, j] for j in log.joints]
    return np.array([g.mean() / (g.std(ddof=1) / np.sqrt(STRETCHES)) if g.any() else 0 for g in gains])


def drawn(log, residual, random):
    out = np.empty_like(residual)
    for j in log.joints:
        at = np.flatnonzero(log.joint == j)
        length = max(1, round(BLOCK / np.median(np.diff(log.t[at]))))
        for first in range(0, len(at), length):
            part = at[first : first + length]
            begin = random.integers(0, len(at) - len(part) + 1)
            out[part] = random.choice([-1, 1]) * residual[at[begin : begin + len(part)]]
    return out


def main(programs, folder, draws):
    with tempfile.TemporaryDirectory() as made:
        logs = [Rows(programs, folder, name, made) for name in "AB"]
    torques = [log.Y for log in logs]
    laws = {"symmetric": [], "load": list(logs[0].joints)}
    for log, name in zip(logs, "AB"):
        print(f"{name} alone, gain by load at joints 1 ... in standard errors:", np.round(gains_in_standard_errors(log), 1))
    truth = fit(logs, torques, laws["load"])
    print("both logs: Fl", np.round(truth[1], 3), "errors [%]", np.round([error(log, log.Y, truth) for log in logs], 2))
    for law, kept in laws.items():
        print(law, "A -> B, B -> A, mean [%]:", np.round(both_ways(logs, torques, kept), 1))
    of_both = [log.Y - log.torques(*truth) for log in logs]
    for name, residuals in ("the fit to both logs", of_both), ("their own fits", [own_residual(log, laws["load"]) for log in logs]):
        random = np.random.default_rng(1)
        found = {law: [] for law in laws}
        for _ in range(draws):
            made = [log.torques(*truth) + drawn(log, residual, random) for log, residual in zip(logs, residuals)]
            for law, kept in laws.items():
                found[law].append(both_ways(logs, made, kept)[2])
        for law, means in found.items():
            low, middle, high = np.percentile(means, [5, 50, 95])
            print(f"{law}, mean of {draws} draws with the residual of {name}: 5 % below {low:.1f}, half below {middle:.1f}, "
                  f"95 % below {high:.1f} %; {100 * np.mean(np.array(means) <= 8):.0f} % of them at most 8 %", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 150)
