"""A hobby servo without torque or current, goal and position alone: rivid beside SciPy over MuJoCo's rollouts.

    PYTHONPATH=build/test/python venv/bin/python benchmarks/methods/servo.py FOLDER

FOLDER has pendulum.urdf and feetech_1.csv … feetech_4.csv, one motion each (bench of Rhoban BAM; columns t, q, goal). The law is
u = sat(goal - q), in units of the drive's gain, which no such log shows. Each motion is fitted by rivid's weighted least squares on
torques that are those of the law, by its output error, and by scipy.optimize.least_squares over the simulated loop, the best of three
starts; the models are simulated by MuJoCo on the three other motions. Packages and exit code 77: as methods.py.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")

try:
    import mujoco
    import numpy as np
    import rivid
    from scipy.optimize import least_squares
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

LIMIT = 0.27  # rad between goal and position at which the duty ends
STEP = 0.002  # s, of MuJoCo
ARM = 0.12  # m, of the weight
MOTIONS = (1, 3, 4)  # with the torque on all the time
NAMES = ("inertia", "m l", "viscous", "Coulomb")  # over the gain: rad s², rad s²/m, s, rad
START = np.array([0.005, 0.05, 0.02, 0.01])
STARTS = (0.5, 1, 2)  # times START: from each SciPy goes to another minimum, of which the lowest counts
GRAVITY = 9.81


@dataclass
class Motion:
    """A log at even instants."""

    t: np.ndarray
    q: np.ndarray
    goal: np.ndarray

    @classmethod
    def read(cls, path: Path) -> Motion:
        table = np.genfromtxt(path, delimiter=",", names=True)
        t = np.arange(table["t"][0], table["t"][-1], STEP)
        return cls(t - t[0], np.interp(t, table["t"], table["q"]), np.interp(t, table["t"], table["goal"]))


class Loop:
    """The servo in MuJoCo, in units of its gain: one joint, a position actuator whose force ends at LIMIT."""

    XML = f"""<mujoco><option timestep="{STEP}" integrator="implicitfast" gravity="0 0 -{GRAVITY}"/>
<worldbody><body><joint name="servo" axis="0 1 0"/><inertial pos="0 0 -{ARM}" mass="1" diaginertia="1e-6 1e-6 1e-6"/></body></worldbody>
<actuator><position joint="servo" kp="1" forcerange="-{LIMIT} {LIMIT}"/></actuator></mujoco>"""

    def __init__(self) -> None:
        self.model = mujoco.MjModel.from_xml_string(self.XML)

    def motion(self, x: np.ndarray, of: Motion) -> np.ndarray:
        """Positions that a goal gives, from the first measured position at rest."""
        inertia, moment, viscous, coulomb = x
        m = self.model
        m.body_mass[1] = max(moment, 1e-6) / ARM
        m.dof_armature[0] = max(inertia - moment * ARM, 1e-5)  # the rotor has what the weight does not
        m.dof_damping.reshape(-1)[0] = max(viscous, 0.0)
        m.dof_frictionloss[0] = max(coulomb, 0.0)
        mujoco.mj_setConst(m, mujoco.MjData(m))
        data = mujoco.MjData(m)
        data.qpos[0] = of.q[0]
        out = np.empty(len(of.t))
        for k, goal in enumerate(of.goal):
            out[k] = data.qpos[0]
            data.ctrl[0] = goal
            mujoco.mj_step(m, data)
        return out


def by_scipy(loop: Loop, folder: Path, number: int) -> np.ndarray:
    motion = Motion.read(log_of(folder, number))
    ends = [least_squares(lambda x: loop.motion(x, motion) - motion.q, k * START, x_scale=START, diff_step=1e-3) for k in STARTS]
    return min(ends, key=lambda end: end.cost).x


def by_rivid(method: str) -> Callable[[Loop, Path, int], np.ndarray]:
    def fit(_: Loop, folder: Path, number: int) -> np.ndarray:
        with TemporaryDirectory() as work:
            file = Path(work) / "servo.toml"
            file.write_text(EXPERIMENT.format(folder=folder.resolve(), log=log_of(folder, number).resolve(), method=method))
            found = rivid.identify(file)
            if not np.isfinite(found.chi).all():
                raise rivid.NumericsError(f"{found.status}: {'; '.join(found.reasons)}")
            names = dict(zip(found.parameters["name"], found.chi))
        return np.array([names["YY1R"], -names["MZ1"], names["Fv1"], names["Fc1"]])

    return fit


EXPERIMENT = f"""
[robot]
urdf = "{{folder}}/pendulum.urdf"
gravity = [0, 0, -{GRAVITY}]
friction = "coulomb"
[log]
files = ["{{log}}"]
time = "t"
position = ["q"]
reference = ["goal"]
irregular = "resample"
[control]
law = "pid"
K_p = 1
K_d = 0
v_tau_max = {LIMIT}
[method]
name = "{{method}}"
"""


def log_of(folder: Path, number: int) -> Path:
    return folder / f"feetech_{number}.csv"


def main() -> int:
    folder, loop = Path(sys.argv[1]), Loop()
    fits = {"rivid WLS": by_rivid("wls"), "rivid output error": by_rivid("output_error"), "SciPy over MuJoCo": by_scipy}
    motions = {k: Motion.read(log_of(folder, k)) for k in MOTIONS}
    print(f"{'fitted on':9} {'by':20} {'time':>7}  rms error of the position [rad] on motion " + " ".join(f"{k:7}" for k in MOTIONS))
    held_out: dict[str, list[float]] = {name: [] for name in fits}
    for number in MOTIONS:
        for name, fit in fits.items():
            begin = time.process_time()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", rivid.RividWarning)
                try:
                    x = fit(loop, folder, number)
                except rivid.Error as error:
                    print(f"{number:9} {name:20} {error}")
                    continue
            seconds = time.process_time() - begin
            errors = {k: float(np.sqrt(np.mean((loop.motion(x, m) - m.q) ** 2))) for k, m in motions.items()}
            held_out[name] += [e for k, e in errors.items() if k != number]
            values = ", ".join(f"{what} {value:.4g}" for what, value in zip(NAMES, x))
            print(f"{number:9} {name:20} {seconds:6.2f} s {'':42}" + " ".join(f"{e:7.4f}" for e in errors.values()) + f"   {values}", flush=True)
    for name, errors in held_out.items():
        print(f"{name}: held-out errors {np.median(errors):.4f} rad (median of {len(errors)})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
