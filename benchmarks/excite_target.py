"""Stated standard deviations on eight arms: what identification reports of motions that a target chose.

For each arm `rivid excite` is given a target and a spread of the prior alone. Its motion is played without a controller: torques are
Pinocchio's, with friction of 2 % of the torque limit each (at rest and at the velocity limit), and noise of 1 %, drawn `--draws` times.
`rivid identify` gets each log with its own settings. Printed: joints, harmonics, repetitions and period that were chosen; of the parameter
that is worst by the forecast the forecast, reported and true deviation over the target, root mean squares of all draws; medians over the
parameters of forecast over true and of reported over forecast (10 and 90 % of single ones); how many of 200 robots whose links and
friction are off by up to 30 % keep their whole torques along the motion; processor seconds of the design.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data
    venv/bin/python benchmarks/excite_target.py build/test/apps/rivid [--draws 40] [ARM ...]
"""

import argparse
import json
import pathlib
import resource
import subprocess
import tempfile

import numpy as np
import pinocchio as pin

from excite_arms import DURATION, NOISE, RATE, Arm

NAMES = ["z1", "xarm7", "kinova", "panda", "ur3", "ur5", "ur10", "talos arm"]
MASS, FV = 2.0, 5.0  # %
FRICTION = 0.02  # of the torque limit
SPREAD, ROBOTS = 0.3, 200


def percent(name):
    return MASS if not name.startswith("F") else FV if name[1] == "v" else None


def per_sigma(parameters):
    """One over what the target allows each parameter; 0 where it asks for nothing."""
    units, out = {}, np.zeros(len(parameters))
    for p in parameters:
        key = (p["unit"], p["name"].startswith("F"))
        units[key] = max(units.get(key, 0.0), abs(p["value"]))
    for k, p in enumerate(parameters):
        if percent(p["name"]):
            scale = max(abs(p["value"]), 0.1 * units[p["unit"], p["name"].startswith("F")])
            out[k] = 100 / scale / percent(p["name"])
    return out


def torques(arm, model, q, v, a, friction):
    data = model.createData()
    tau = np.array([pin.rnea(model, data, arm.full(q[k]), v[k], a[k]) for k in range(len(q))])
    return tau + friction * (arm.damping * v + arm.friction * np.sign(v))


def within_torque(arm, q, v, a):
    """Of robots drawn about the description, how many keep their torque limits."""
    random = np.random.default_rng(2)
    factor = lambda size=None: random.uniform(1 - SPREAD, 1 + SPREAD, size)
    out = 0
    for _ in range(ROBOTS):
        drawn = arm.model.copy()
        for j in range(1, drawn.njoints):
            body, s = drawn.inertias[j], factor()
            drawn.inertias[j] = pin.Inertia(s * body.mass, body.lever, s * body.inertia)
        tau = torques(arm, drawn, q, v, a, factor(arm.n))
        out += bool((np.abs(tau) <= arm.limits["torque"]).all())
    return out


def row_of(program, name, draws, folder):
    arm = Arm(name)
    torque, velocity = arm.limits["torque"], arm.limits["velocity"]
    arm.friction, arm.damping = FRICTION * torque, FRICTION * torque / velocity
    joints = "".join(
        f'[robot.joints."{joint}"]\nFv = {fv!r}\nFc = {fc!r}\n'
        for joint, fv, fc in zip(arm.joints, arm.damping.tolist(), arm.friction.tolist())
    )
    text = arm.experiment().replace("gravity =", 'friction = "coulomb"\ngravity =', 1).replace("starts = 1\n", "")
    text += f"prior_spread = {SPREAD}\n[excitation.target]\nmass_percent = {MASS}\nFv_percent = {FV}\nseconds = 3000\n"
    file, plan_folder, result = folder / "arm.toml", folder / "plan", folder / "id"
    file.write_text(text + joints)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([program, "excite", file, "--quiet", "--output", plan_folder], capture_output=True, text=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode:
        return f"| {name} | {arm.n} | {done.stderr.strip()} | | | | | | {seconds:.0f} |"
    plan = json.loads((plan_folder / "plan.json").read_text())
    data = np.genfromtxt(plan_folder / "motion.csv", delimiter=",", names=True)
    q, v, a = (np.column_stack([data[f"{what}{j + 1}"] for j in range(arm.n)]) for what in ("q", "qd", "qdd"))
    tau = torques(arm, arm.model, q, v, a, 1.0)
    names = ["t"] + [f"q{j + 1}" for j in range(arm.n)] + [f"tau{j + 1}" for j in range(arm.n)]
    errors, sigmas = [], []
    for seed in range(1, draws + 1):
        noise = NOISE * torque * np.random.default_rng(seed).standard_normal(tau.shape)
        rows = np.column_stack([data["t"], q, tau + noise])
        np.savetxt(plan_folder / "log.csv", rows, fmt="%.17g", delimiter=",", header=",".join(names), comments="")
        run = [program, "identify", plan_folder / "experiment.toml", "--quiet", "--force", "--output", result]
        done = subprocess.run(run, capture_output=True, text=True)
        if not (result / "result.json").exists():
            return f"| {name} | {arm.n} | {done.stderr.strip()} | | | | | | {seconds:.0f} |"
        parameters = json.loads((result / "result.json").read_text())["parameters"]
        assert [p["name"] for p in parameters] == [p["name"] for p in plan["parameters"]]
        errors.append([p["value"] - p["a_priori"] for p in parameters])
        sigmas.append([p["sigma"] for p in parameters])
    forecast = np.array([p["sigma"] for p in plan["parameters"]])
    rms = lambda values: np.sqrt(np.mean(np.square(values), axis=0))
    error, ratio = rms(errors), np.array(sigmas) / forecast
    per = per_sigma(plan["parameters"])
    worst = np.argmax(per * forecast)
    period = 2 * np.pi / plan["motion"]["omega_f"]
    times = round(plan["motion"]["duration"] / period)
    once = slice(0, round(RATE * period) + 1, 5)
    return (
        f"| {name} | {arm.n} | {len(plan['motion']['A'][0])} | {times} × {period:.1f} s "
        f"| {(per * forecast)[worst]:.2f}, {(per * rms(sigmas))[worst]:.2f}, {(per * error)[worst]:.2f} "
        f"| {np.median(forecast / error):.2f} "
        f"| {np.median(rms(ratio)):.2f} ({np.quantile(ratio, 0.1):.2f} to {np.quantile(ratio, 0.9):.2f}) "
        f"| {within_torque(arm, q[once], v[once], a[once])} of {ROBOTS} | {seconds:.0f} |"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("arms", nargs="*", default=NAMES)
    parser.add_argument("--draws", type=int, default=40)
    asked = parser.parse_intermixed_args()
    print("| arm | joints | harmonics | motion | forecast, reported, true σ / target | forecast / true | reported / forecast | torques kept | CPU s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in asked.arms:
        with tempfile.TemporaryDirectory() as folder:
            print(row_of(asked.program, name, asked.draws, pathlib.Path(folder)), flush=True)


if __name__ == "__main__":
    main()
