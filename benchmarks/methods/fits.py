"""The methods: each is one function fit(log) -> (chi, C), base parameters `log.base @ standard` and their covariance.

`standard` are Pinocchio's parameters in the order of `log.columns`. Raise NotApplicable where the log lacks what the method needs.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import rivid
from mujoco import sysid
from robots import GRAVITY, Log

sys.path.append(str(Path(__file__).resolve().parents[1]))
from compare_figaroh import Arm as FigarohArm
from compare_figaroh import at_samples, decimated, derivatives, solved

Estimate = tuple[np.ndarray, np.ndarray]


class NotApplicable(Exception):
    """The log lacks what the method needs."""


def by_rivid(make: Callable[..., rivid.Auto], loop: bool = False, **options: object) -> Callable[[Log], Estimate]:
    """A method of rivid with its defaults; those that simulate the loop need its controller."""

    def fit(log: Log) -> Estimate:
        if loop and log.control is None:
            raise NotApplicable("no reference and controller")
        controller = {"control": log.control} if loop else {}
        held = {"torque_held": True} if log.torque_held else {}
        record = rivid.Log(log.rate, log.q, log.tau, q_r=log.q_r)
        found = rivid.identify(log.robot, record, make(**held, **controller, **options))
        if not np.isfinite(found.chi).all():
            raise rivid.NumericsError(f"{found.status}: {'; '.join(found.reasons)}")
        if "physical" not in options:
            return found.chi, found.covariance
        consistent = found.document["physical"]
        C = np.array(consistent["C_chi"]) if len(consistent["C_chi"]) else found.covariance
        return np.array(consistent["chi"]), C.reshape(found.covariance.shape)

    return fit


def filtered(log: Log, trim: float = 0.2) -> tuple[tuple[np.ndarray, ...], np.ndarray, int]:
    """What both of the least squares below do first: low-pass and differences of the positions; the decimation to 100 Hz."""
    keep = slice(int(trim * log.rate), -int(trim * log.rate))
    tau = at_samples(log.tau) if log.torque_held else log.tau
    return tuple(x[keep] for x in derivatives(log.q, log.rate)), tau[keep], max(round(log.rate / 100), 2)


def figaroh(log: Log) -> Estimate:
    motion, tau, factor = filtered(log)
    found = solved(FigarohArm(log.urdf), motion, tau, factor, has_actuator_inertia=log.rotor, has_joint_offset=log.offset)
    base = np.delete(log.base, found.gone, axis=1)[:, found.index]
    return base @ found.chi, base @ found.covariance @ base.T


def decimated_columns(log: Log) -> tuple[np.ndarray, np.ndarray]:
    """Regressor and torques of filtered rows, joint after joint."""
    motion, tau, factor = filtered(log)
    W = log.columns(*motion)
    joints = W.shape[1]
    return decimated(W.transpose(1, 0, 2).reshape(-1, W.shape[2]), joints, factor), decimated(tau.T.ravel(), joints, factor)


def pinocchio(log: Log) -> Estimate:
    """Weighted least squares in NumPy on Pinocchio's regressor; what the data do not show is left to the pseudo-inverse."""
    W, y = decimated_columns(log)
    joints = log.q.shape[1]
    weights = np.ones(len(y))
    for _ in range(2):
        W_w, y_w = W * weights[:, None], y * weights
        left, values, right = np.linalg.svd(W_w, full_matrices=False)
        kept = values > 1e-8 * values[0]
        inverse = right[kept].T / values[kept]
        standard = inverse @ (left[:, kept].T @ y_w)
        residual = np.split(y - W @ standard, joints)
        weights = np.repeat([1 / max(np.std(r), 1e-12) for r in residual], len(y) // joints)
    scale = np.sum((y_w - W_w @ standard) ** 2) / (len(y) - np.sum(kept))
    half = log.base @ inverse
    return log.base @ standard, scale * half @ half.T


CHUNK, STEP = 0.5, 0.002  # s: of a rollout, and of its integration, as in its own tests
STRETCH = np.array([0.05, 20.0])  # its own 0.5 to 2 would exclude the truth
ITERATIONS, LARGEST = 20, 3  # its budget: minutes a robot of so many joints


def mujoco_sysid(log: Log) -> Estimate:
    """Rollouts from measured states, driven by the torques of the log; from the description on, bodies by pseudo-inertias."""
    if log.q.shape[1] > LARGEST:
        raise NotApplicable(f"more than {LARGEST} joints take too long")
    spec = mujoco.MjSpec.from_file(str(log.urdf))
    spec.option.timestep, spec.option.gravity = STEP, GRAVITY
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
    joints = [joint.name for joint in spec.joints]
    inertia = np.diag(pin.crba(log.model, log.model.createData(), log.q[0]))
    loads = np.abs(log.tau).max(axis=0)
    params = sysid.ParameterDict()
    for j, name in enumerate(joints):
        spec.joint(name).limited = False
        spec.add_actuator(name=f"motor_{name}", target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, gainprm=[1.0] + [0.0] * 9)
        for kind, start in (("armature", 0.2 * inertia[j]), ("damping", 0.2 * inertia[j]), ("frictionloss", 0.05 * loads[j])):
            if kind != "armature" or log.rotor:
                params.add(sysid.Parameter(f"{name}_{kind}", start, 0.0, 20 * start, modifier=_setter(name, kind)))
    for kind in (mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtSensor.mjSENS_JOINTVEL):
        for name in joints:
            spec.add_sensor(name=f"{name}_{kind.name}", type=kind, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=name)
    model = spec.compile()
    moved = [model.body(model.jnt_bodyid[j]).name for j in range(model.njnt)]
    for body in moved:
        params.add(sysid.body_inertia_param(spec, model, body, inertia_type=sysid.InertiaType.Pseudo, stretch_bound_mult=STRETCH, modifier=_body_setter(body)))

    (q, qd, _), _, _ = filtered(log)
    stride = max(round(STEP * log.rate), 1)
    ends = log.tau if log.torque_held else (log.tau + np.roll(log.tau, -1, axis=0)) / 2  # means from sample to sample
    first = (len(log.q) - len(q)) // 2
    means = ends[first : first + len(q) // stride * stride].reshape(-1, stride, len(joints)).mean(axis=1)
    q, qd, tau = q[::stride][: len(means)], qd[::stride][: len(means)], means
    spec.option.timestep = stride / log.rate
    size = round(CHUNK / spec.option.timestep)
    t = spec.option.timestep * np.arange(size)
    chunks = [slice(k, k + size) for k in range(0, len(q) - size, size)]
    sequences = sysid.ModelSequences(
        "arm",
        spec,
        [f"chunk {k}" for k in range(len(chunks))],
        [sysid.create_initial_state(model, q[c.start], qd[c.start]) for c in chunks],
        [sysid.TimeSeries(t, tau[c]) for c in chunks],
        [sysid.TimeSeries.from_names(t, np.hstack([q[c], qd[c]]), model) for c in chunks],
    )
    compiled: dict[bytes, mujoco.MjModel] = {}

    def build(params: sysid.ParameterDict, spec: mujoco.MjSpec) -> mujoco.MjModel:
        """One compilation for all chunks: half of the time without it."""
        key = params.as_vector().tobytes()
        if key not in compiled:
            if len(compiled) > params.size:
                compiled.clear()
            compiled[key] = sysid.apply_param_modifiers(params, spec)
        return compiled[key]

    residual = sysid.build_residual_fn(models_sequences=[sequences], build_model=build, n_threads=1)
    found, result = sysid.optimize(params, residual, verbose=False, optimizer="scipy_parallel_fd", max_iters=ITERATIONS, ftol=1e-2, x_scale="jac")

    def base(x: np.ndarray) -> np.ndarray:
        found.update_from_vector(x)
        return log.base @ _standard(log, sysid.apply_param_modifiers(found, spec), joints, moved)

    x = np.array(result.x)
    chi = base(x)
    away = 1e-6 * np.maximum(np.abs(x), 1e-3)
    G = np.column_stack([(base(x + step) - chi) / np.sum(step) for step in np.diag(away)])
    final = np.concatenate(residual(x, found)[0])
    J = result.jac
    # Its calculate_intervals() for the parameters themselves; base parameters by the delta method.
    C = final @ final / (len(final) - len(x)) * np.linalg.pinv(J.T @ J, rcond=1e-14, hermitian=True)
    return chi, G @ C @ G.T


def _setter(name: str, kind: str) -> Callable[[mujoco.MjSpec, sysid.Parameter], None]:
    def put(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
        value = parameter.value[0]
        setattr(spec.joint(name), kind, [value, 0, 0] if kind == "damping" else value)

    return put


def _body_setter(name: str) -> Callable[[mujoco.MjSpec, sysid.Parameter], None]:
    """What apply_body_inertia() does, which in MuJoCo 4.0.0 leaves a model that does not compile: it makes `iquat` NaN."""

    def put(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
        pi = sysid.model_modifier.pi_from_theta(parameter.value)
        body, centre = spec.body(name), pi[1:4] / pi[0]
        skew = sysid.model_modifier.skew(centre)
        inertia = pi[4:].reshape(3, 3) + pi[0] * skew @ skew
        body.mass, body.ipos, body.inertia, body.iquat = pi[0], centre, np.zeros(3), [1.0, 0.0, 0.0, 0.0]
        body.fullinertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]

    return put


def _standard(log: Log, model: mujoco.MjModel, joints: list[str], moved: list[str]) -> np.ndarray:
    """The parameters of a MuJoCo model in the order of Log.columns."""
    bodies = []
    for name in moved:
        body = model.body(name)
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        turn = turn.reshape(3, 3)
        bodies.append(pin.Inertia(body.mass[0], body.ipos, turn @ np.diag(body.inertia) @ turn.T).toDynamicParameters())
    dofs = [model.joint(name).dofadr[0] for name in joints]
    drives = [model.dof_damping[dofs].reshape(len(dofs), -1)[:, 0], model.dof_frictionloss[dofs]]
    drives += [model.dof_armature[dofs]] * log.rotor + [np.zeros(len(dofs))] * log.offset
    return np.concatenate([*bodies, *drives])


METHODS: dict[str, Callable[[Log], Estimate]] = {
    "rivid OLS": by_rivid(rivid.Ols),
    "rivid WLS": by_rivid(rivid.Wls),
    "rivid robust": by_rivid(rivid.Wls, robust="huber"),
    "rivid physical": by_rivid(rivid.Wls, physical=True),
    "rivid IV": by_rivid(rivid.Iv, loop=True),
    "rivid PIV": by_rivid(rivid.Iv, loop=True, prefilter=True),
    "rivid DIDIM": by_rivid(rivid.Didim, loop=True),
    "rivid output error": by_rivid(rivid.OutputError, loop=True),
    "FIGAROH": figaroh,
    "Pinocchio + NumPy": pinocchio,
    "mujoco.sysid": mujoco_sysid,
}
