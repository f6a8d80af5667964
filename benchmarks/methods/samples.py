"""64 robots drawn from a result, in MuJoCo and in rivid: torques at random states, and motions under the same torques.

    PYTHONPATH=build/test/python venv/bin/python benchmarks/methods/samples.py build/test/apps/rivid EXPERIMENT.toml      # mujoco, numpy

Dry friction, which MuJoCo has as a constraint, is left out of both. Both integrate by the same steps of Runge and Kutta; their difference is
divided by the time.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import rivid

SAMPLES, STATES, STEP, DURATION = 64, 50, 1e-3, 1.0


def ours(robot, names, chi_st):
    return robot.model({n: 0.0 if n.startswith(("Fc", "off")) else float(x) for n, x in zip(names, chi_st)})


def theirs(file):
    m = mujoco.MjModel.from_xml_path(str(file))
    m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS | mujoco.mjtDisableBit.mjDSBL_LIMIT
    m.opt.integrator, m.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, STEP
    m.actuator_ctrllimited[:] = 0
    return m, mujoco.MjData(m)


def torque_error(model, m, data, states):
    q, qd, qdd = states
    expected, found = model.inverse_dynamics(q, qd, qdd), np.empty_like(q)
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], qd[k], qdd[k]
        mujoco.mj_inverse(m, data)
        found[k] = data.qfrc_inverse
    return np.abs(found - expected).max() / np.abs(expected).max()


def rollout_error(model, m, data, torques):
    """Largest difference of a position after the torques of a slow motion, over the time that it took."""
    mujoco.mj_resetData(m, data)
    q, v, h = np.zeros(m.nv), np.zeros(m.nv), STEP
    worst = 0.0
    for k, tau in enumerate(torques, 1):
        data.ctrl[:] = tau
        mujoco.mj_step(m, data)
        a = model.direct_dynamics
        a1 = a(q, v, tau)
        a2 = a(q + h / 2 * v, v + h / 2 * a1, tau)
        a3 = a(q + h / 2 * (v + h / 2 * a1), v + h / 2 * a2, tau)
        a4 = a(q + h * (v + h / 2 * a2), v + h * a3, tau)
        q, v = q + h * v + h * h / 6 * (a1 + a2 + a3), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        worst = max(worst, np.abs(q - data.qpos).max() / (k * h))
    return worst


def main():
    program, file = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        run = lambda *words: subprocess.run([program, *words], check=True, capture_output=True)  # noqa: E731
        run("identify", file, "--physical", "--output", folder / "result", *sys.argv[3:])
        for form, name in (("mjcf", "arm.xml"), ("npz", "arm.npz")):
            run("export", folder / "result", "--to", form, "--samples", str(SAMPLES), "--seed", "1", "--output", folder / name)
        drawn = np.load(folder / "arm.npz")
        robot = rivid.Experiment(file).robot
        names, n = list(drawn["standard_parameters"]), len(robot)
        random = np.random.default_rng(1)
        states = [random.uniform(-most, most, (STATES, n)) for most in (2, 2, 5)]
        t = np.arange(0, DURATION, STEP)[:, None]
        omega = random.uniform(1, 4, n)
        motion = [0.3 * (1 - np.cos(omega * t)), 0.3 * omega * np.sin(omega * t), 0.3 * omega**2 * np.cos(omega * t)]
        torques = ours(robot, names, drawn["chi_st"].mean(axis=0)).inverse_dynamics(*motion)
        errors = []
        for k, chi_st in enumerate(drawn["chi_st"]):
            pair = ours(robot, names, chi_st), *theirs(folder / f"arm_{k:03}.xml")
            errors.append((torque_error(*pair, states), rollout_error(*pair, torques)))
    torque, rollout = np.max(errors, axis=0)
    print(f"{len(errors)} samples: torques within {torque:.1e} of the largest, positions within {rollout:.1e} rad a second")


if __name__ == "__main__":
    main()
