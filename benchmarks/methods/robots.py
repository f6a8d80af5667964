"""Random arms, and logs of them by MuJoCo: nothing of a log comes from rivid."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import rivid

GRAVITY = [0.0, 0.0, -9.81]
RATE, STEPS = 1000.0, 5  # Hz, of control and log; steps of the integration in a period
DURATION, HARMONICS = 12.0, 5  # s; of the motion, of 0.1 Hz
BANDWIDTH = 20.0  # rad/s, of the control


@dataclass
class Log:
    """What a method gets: a recorded motion, and what is known of its robot. One row a sample, one column a joint, SI units."""

    urdf: Path  # the description: its geometry is right, its inertias are a guess
    rate: float  # [Hz]
    q: np.ndarray
    tau: np.ndarray  # torque of the drives
    torque_held: bool = False  # from its sample to the next one
    q_r: np.ndarray | None = None  # what the controller followed,
    control: rivid.Pd | None = None  # and the controller
    keys: dict = field(default_factory=dict)  # of rivid.Robot.from_urdf
    name: str = "log"

    def __post_init__(self) -> None:
        self.robot = rivid.Robot.from_urdf(self.urdf, gravity=GRAVITY, **self.keys)
        self.model = pin.buildModelFromUrdf(str(self.urdf))
        self.model.gravity.linear = np.array(GRAVITY)
        self.names = self.robot.base_parameters().names
        self.rotor = self.keys.get("rotor_inertia", True)
        self.offset = self.keys["friction"] == "symmetric"
        self.base = self._base()

    def columns(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Pinocchio's regressor with the drives, (samples, joints, parameters): ten of each link; Fv, Fc, Ia, offsets of the joints."""
        data = self.model.createData()
        bodies = np.array([pin.computeJointTorqueRegressor(self.model, data, *row).copy() for row in zip(q, qd, qdd)])
        bodies = bodies.reshape(*q.shape, -1)  # one joint is a vector
        eye = np.eye(q.shape[1])
        drives = [qd, np.sign(qd)] + [qdd] * self.rotor + [np.ones_like(q)] * self.offset
        return np.concatenate([bodies] + [x[:, :, None] * eye for x in drives], axis=2)

    def _base(self) -> np.ndarray:
        """Base parameters of Pinocchio's standard ones: one matrix, of motions that are drawn."""
        q, qd, qdd = np.random.default_rng(0).uniform(-2, 2, size=(3, 200, self.q.shape[1]))
        W = self.robot.regressor(q, qd, qdd).reshape(-1, len(self.names))
        standard = self.columns(q, qd, qdd).reshape(len(W), -1)
        base, *_ = np.linalg.lstsq(W, standard, rcond=None)
        if np.abs(W @ base - standard).max() > 1e-7 * np.abs(standard).max():
            raise RuntimeError(f"{self.name}: the regressors of Pinocchio and rivid differ")
        return base


@dataclass
class Arm:
    """A random arm of 3 to 7 joints with its drives, sensors and controller."""

    seed: int
    folder: Path

    def __post_init__(self) -> None:
        self.random = np.random.default_rng([2026, self.seed])
        draw = self.random
        self.n = n = 3 + self.seed % 5
        lengths = draw.uniform(0.15, 0.4, n)
        turns = [np.array([draw.choice([-1, 1]) * np.pi / 2, 0, draw.uniform(-np.pi, np.pi)]) for _ in range(n)]
        turns[0][0] = 0.0
        offsets = [np.append(draw.uniform(-0.1, 0.1, 2), length) for length in lengths]
        masses = 8 * 0.65 ** np.arange(n) * draw.uniform(0.7, 1.4, n)
        inertials = [self._inertial(mass, length) for mass, length in zip(masses, lengths)]
        self.true = self._write("true", turns, offsets, inertials)
        self.urdf = self._write("guess", turns, offsets, [self._guessed(i) for i in inertials])
        self._drives()

    def _inertial(self, mass: float, length: float) -> pin.Inertia:
        size = np.array([0.06, 0.06, length]) * self.random.uniform(0.7, 1.3, 3)
        turn = pin.exp3(self.random.normal(0, 0.2, 3))
        inertia = turn @ np.diag(mass / 12 * (np.sum(size**2) - size**2)) @ turn.T
        return pin.Inertia(mass, np.array([0, 0, length / 2]) + self.random.normal(0, 0.03, 3), inertia)

    def _guessed(self, inertial: pin.Inertia) -> pin.Inertia:
        """Another body, some 20 % away: its mass distribution stretched, sheared and shifted."""
        pseudo = inertial.toPseudoInertia().toMatrix()
        away = np.eye(4) + 0.15 * self.random.normal(size=(4, 4)) * np.outer([1, 1, 1, 0.2], [1, 1, 1, 0.2])
        return pin.Inertia.FromPseudoInertia(pin.PseudoInertia.FromMatrix(away @ pseudo @ away.T))

    def _write(self, name: str, turns: list, offsets: list, inertials: list[pin.Inertia]) -> Path:
        lines = [f'<robot name="arm_{self.seed}">', '<link name="base"/>']
        for j, inertial in enumerate(inertials):
            i = inertial.inertia
            lines += [
                f'<link name="link{j + 1}"><inertial><origin xyz="{_text(inertial.lever)}"/><mass value="{inertial.mass!r}"/>'
                f'<inertia ixx="{i[0, 0]:.17g}" iyy="{i[1, 1]:.17g}" izz="{i[2, 2]:.17g}" ixy="{i[0, 1]:.17g}" ixz="{i[0, 2]:.17g}" '
                f'iyz="{i[1, 2]:.17g}"/></inertial></link>',
                f'<joint name="joint{j + 1}" type="revolute"><parent link="{f"link{j}" if j else "base"}"/><child link="link{j + 1}"/>'
                f'<origin xyz="{_text(offsets[j])}" rpy="{_text(turns[j])}"/><axis xyz="0 0 1"/>'
                '<limit lower="-3" upper="3" velocity="10" effort="10000"/></joint>',
            ]
        path = self.folder / f"{name}.urdf"
        path.write_text("\n".join([*lines, "</robot>"]), encoding="utf-8")
        return path

    def _drives(self) -> None:
        """Rotors, friction and gains that go with the inertias; noise of the sensors."""
        model = pin.buildModelFromUrdf(str(self.true))
        data = model.createData()
        poses = np.random.default_rng(99).uniform(-1.5, 1.5, size=(40, self.n))
        inertia = np.max([np.diag(pin.crba(model, data, q)) for q in poses], axis=0)
        gravity = np.max([np.abs(pin.computeGeneralizedGravity(model, data, q)) for q in poses], axis=0)
        draw = self.random
        self.Ia = draw.uniform(0.1, 0.5, self.n) * inertia
        self.Fv = draw.uniform(0.1, 0.4, self.n) * (inertia + self.Ia)
        self.Fc = draw.uniform(0.5, 1.5, self.n) * (0.1 * (inertia + self.Ia) + 0.05 * gravity)
        self.k_v = 2 * BANDWIDTH * (inertia + self.Ia)
        self.encoder = 10 ** draw.uniform(-5.7, -4.3)  # rad
        self.disturbance = draw.uniform(0.02, 0.1)  # of the Coulomb friction,
        self.memory = draw.choice([0.0, 0.02, 0.1])  # s: time constant
        spec = mujoco.MjSpec.from_file(str(self.true))
        spec.option.timestep = 1 / (RATE * STEPS)
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        spec.option.gravity = GRAVITY
        for j, joint in enumerate(spec.joints):
            joint.armature = self.Ia[j]
            joint.damping = [self.Fv[j], 0, 0]
            joint.frictionloss = self.Fc[j]
            joint.limited = False
            joint.solref_friction = [0.004, 1.0]  # as stiff as the steps allow: a joint at rest creeps little
        self.simulated = spec.compile()

    def log(self, number: int) -> Log:
        """A motion of its own under a sampled PD law; noise of the encoders and unrecorded torques go through the loop."""
        draw = np.random.default_rng([2026, self.seed, number])
        t = np.arange(0, DURATION, 1 / RATE)
        harmonics = 2 * np.pi * 0.1 * np.arange(1, HARMONICS + 1)
        sines, cosines = draw.normal(size=(2, self.n, HARMONICS))
        wanted = np.sin(np.outer(t, harmonics)) @ sines.T + np.cos(np.outer(t, harmonics)) @ cosines.T
        wanted *= draw.uniform(0.8, 1.6, self.n) / np.abs(wanted).max(axis=0)
        data = mujoco.MjData(self.simulated)
        data.qpos[:] = wanted[0]
        keep = np.exp(-1 / (RATE * self.memory)) if self.memory else 0.0
        disturbance = np.zeros(self.n)
        before = data.qpos + self.encoder * draw.normal(size=self.n)
        measured, torque = np.empty((2, len(t), self.n))
        self.motion = np.empty((len(t), self.n, 3))
        for k, goal in enumerate(wanted):
            measured[k] = data.qpos + self.encoder * draw.normal(size=self.n)
            velocity, before = (measured[k] - before) * RATE, measured[k]
            torque[k] = self.k_v * (BANDWIDTH / 2 * (goal - measured[k]) - velocity)
            disturbance = keep * disturbance + np.sqrt(1 - keep**2) * self.disturbance * self.Fc * draw.normal(size=self.n)
            data.qfrc_applied[:] = torque[k] + disturbance
            mujoco.mj_step(self.simulated, data, STEPS)
            self.motion[k] = np.column_stack([data.qpos, data.qvel, data.qacc])
        control = rivid.Pd(k_p=[BANDWIDTH / 2] * self.n, k_v=list(self.k_v), rate_hz=RATE)
        return Log(self.urdf, RATE, measured, torque, True, wanted, control, {"friction": "coulomb"}, f"arm {self.seed}, log {number}")

    def truth(self, log: Log) -> np.ndarray:
        """True base parameters."""
        model = pin.buildModelFromUrdf(str(self.true))
        bodies = [inertia.toDynamicParameters() for inertia in model.inertias[1:]]
        return log.base @ np.concatenate([*bodies, self.Fv, self.Fc, self.Ia])


def _text(values: np.ndarray) -> str:
    return " ".join(f"{x:.17g}" for x in values)
