"""Stated standard deviations on eight arms: what identification reports of motions that a target chose.

For each arm `rivid excite` is given a target alone. Its motion is played once without a controller: torques are Pinocchio's, with
friction of 2 % of the torque limit each (at rest and at the velocity limit), and noise of 1 %. `rivid identify` gets that log with its
own settings. Printed: joints, the target, harmonics, period and repetitions that were chosen, the forecast and the reported standard
deviation over the target (of the parameter that is worst), errors beyond 1.96 of the reported deviations, processor seconds.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data
    venv/bin/python benchmarks/excite_target.py build/test/apps/rivid_excite build/test/apps/rivid [ARM ...]
"""

import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np
import pinocchio as pin

from excite_arms import DURATION, NOISE, RATE, Arm

NAMES = ["z1", "xarm7", "kinova", "panda", "ur3", "ur5", "ur10", "talos arm"]
MASS, FV = 2.0, 5.0  # %
FRICTION = 0.02  # of the torque limit


def percent(name):
    return MASS if not name.startswith("F") else FV if name[1] == "v" else None


def shares(parameters, sigma):
    """Standard deviations over what the target allows."""
    units, out = {}, []
    for p in parameters:
        key = (p["unit"], p["name"].startswith("F"))
        units[key] = max(units.get(key, 0.0), abs(p["a_priori"]))
    for p, s in zip(parameters, sigma):
        if percent(p["name"]):
            scale = max(abs(p["a_priori"]), 0.1 * units[p["unit"], p["name"].startswith("F")])
            out.append(100 * s / scale / percent(p["name"]))
    return out


def row_of(excite, rivid, name):
    arm = Arm(name)
    torque, velocity = arm.limits["torque"], arm.limits["velocity"]
    arm.friction, arm.damping = FRICTION * torque, FRICTION * torque / velocity
    joints = "".join(
        f'[robot.joints."{joint}"]\nFv = {fv!r}\nFc = {fc!r}\n'
        for joint, fv, fc in zip(arm.joints, arm.damping.tolist(), arm.friction.tolist())
    )
    text = arm.experiment().replace("gravity =", 'friction = "coulomb"\ngravity =', 1).replace("starts = 1\n", "")
    target = f"[excitation.target]\nmass_percent = {MASS}\nFv_percent = {FV}\nseconds = 3000\n"
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "arm.toml")
        file.write_text(text + target + joints)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        plan_folder = pathlib.Path(folder, "plan")
        done = subprocess.run([excite, file, "--quiet", "--output", plan_folder], capture_output=True, text=True)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        if done.returncode:
            return f"| {name} | {arm.n} | {done.stderr.strip()} | | | | | {seconds:.0f} |"
        plan = json.loads((plan_folder / "plan.json").read_text())
        data = np.genfromtxt(plan_folder / "motion.csv", delimiter=",", names=True)
        take = lambda what: np.column_stack([data[f"{what}{j + 1}"] for j in range(arm.n)])
        q, v, a = take("q"), take("qd"), take("qdd")
        tau = np.array([pin.rnea(arm.model, arm.data, arm.full(q[k]), v[k], a[k]) for k in range(len(q))])
        tau += arm.damping * v + arm.friction * np.sign(v)
        tau += NOISE * torque * np.random.default_rng(1).standard_normal(tau.shape)
        names = ["t"] + [f"q{j + 1}" for j in range(arm.n)] + [f"tau{j + 1}" for j in range(arm.n)]
        np.savetxt(plan_folder / "log.csv", np.column_stack([data["t"], q, tau]), delimiter=",", header=",".join(names), comments="")
        run = [rivid, "identify", plan_folder / "experiment.toml", "--output", pathlib.Path(folder, "id")]
        done = subprocess.run(run, capture_output=True, text=True)
        try:
            result = json.loads(pathlib.Path(folder, "id", "result.json").read_text())
        except FileNotFoundError:
            return f"| {name} | {arm.n} | {done.stderr.strip()} | | | | | {seconds:.0f} |"
    parameters = result["parameters"]
    forecast = {p["name"]: p["sigma"] for p in plan["parameters"]}
    planned = max(shares(parameters, [forecast[p["name"]] for p in parameters]))
    reported = max(shares(parameters, [p["sigma"] for p in parameters]))
    beyond = sum(abs(p["value"] - p["a_priori"]) > 1.96 * p["sigma"] for p in parameters)
    period = 2 * np.pi / plan["motion"]["omega_f"]
    times = round(plan["motion"]["duration"] / period)
    return (
        f"| {name} | {arm.n} | {len(plan['motion']['A'][0])} | {times} × {period:.1f} s | {planned:.2f} | {reported:.2f} | "
        f"{beyond} of {len(parameters)} | {seconds:.0f} |"
    )


def main():
    excite, rivid, *names = sys.argv[1:]
    print("| arm | joints | harmonics | motion | forecast / target | reported / target | beyond 1.96 σ | CPU s |")
    print("|---|---|---|---|---|---|---|---|")
    for name in names or NAMES:
        print(row_of(excite, rivid, name), flush=True)


if __name__ == "__main__":
    main()
