"""Writes a log, six_joints_oracle.csv, and what DIDIM and closed-loop output error make of it, six_joints_oracle_found.csv, for
loop_methods_test.cpp.

The arm of data/six_axis, from the tables of its make_urdf.py, with friction Fv q' + Fc tanh(q'/speed) under sampled PD control, by
NumPy and SciPy: Newton and Euler's recursion in modified Denavit-Hartenberg frames for many parameters at once, Runge-Kutta steps,
Newton's and Gauss-Newton steps with differences of whole simulations. Nothing is shared with rivid but the names of the base parameters.

    python3 tests/identify/six_joints_oracle.py    # seven minutes of a processor
"""

import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

HERE = Path(__file__).resolve().parent
DATA = HERE.parents[1] / "data" / "six_axis"
sys.path.insert(0, str(DATA))
import make_urdf  # noqa: E402

RATE = 200.0  # Hz
SAMPLES = 800
STEPS = 4  # of the integration in a period
SPEED = 0.2  # rad/s, of tanh
GRAVITY = 9.81  # m/s^2
IA = (0.362, 0.507, 0.0829, 0.0341, 0.0361, 0.0114)  # kg m^2
K_P = np.array([10.0, 10.0, 12.5, 15.0, 15.0, 15.0])  # 1/s
K_V = np.array([80.0, 80.0, 20.0, 6.0, 6.0, 1.5])  # N m s/rad
NOISE = 2e-6  # rad
DISTURBANCE = np.array([0.4, 0.5, 0.2, 0.1, 0.1, 0.05])  # N m, a new value each period
KINDS = "XX XY XZ YY YZ ZZ MX MY MZ M Ia Fv Fc".split()
# What torques determine, in the order of rivid: standard parameters that keep their columns while all others
# are zero.
BASE = """
ZZ1R Fv1 Fc1 XX2R XY2 XZ2R YZ2 ZZ2R MX2R MY2 Fv2 Fc2 XX3R XY3 XZ3 YZ3 ZZ3R MX3 MY3R Ia3 Fv3 Fc3 XX4R XY4 XZ4
YZ4 ZZ4R MX4 MY4R Ia4 Fv4 Fc4 XX5R XY5 XZ5 YZ5 ZZ5R MX5 MY5R Ia5 Fv5 Fc5 XX6R XY6 XZ6 YZ6 ZZ6 MX6 MY6 Ia6 Fv6
Fc6
""".split()
JOINT, KIND = np.array([(int(name.rstrip("R")[-1]) - 1, KINDS.index(name.rstrip("R")[:-1])) for name in BASE]).T


def standard(chi):
    """(..., 6, 13) of (..., 52)."""
    out = np.zeros((*np.shape(chi)[:-1], 6, len(KINDS)))
    out[..., JOINT, KIND] = chi
    return out


def arm():
    """(6, 13)"""
    out = np.empty((6, len(KINDS)))
    for j, (m, mx, my, mz, xx, xy, xz, yy, yz, zz) in enumerate(make_urdf.BODIES):
        out[j] = [xx, xy, xz, yy, yz, zz, mx, my, mz, m, IA[j], make_urdf.FV[j], make_urdf.FC[j]]
    return out


def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def turned(rotation, x):
    return np.array([row[0] * x[0] + row[1] * x[1] + row[2] * x[2] for row in rotation])


def inverse_dynamics(p, q, v, a, gravity):
    """Torques (6, B) of parameters (6, 13, B or 1), states (6, B) and gravity (B)."""
    omega, alpha = np.zeros((2, 3, q.shape[1]))
    acc = np.zeros((3, q.shape[1]))
    acc[2] = gravity
    forces, moments, frames = [], [], []
    for j, (twist, theta, length, d) in enumerate(make_urdf.FRAMES):
        ca, sa = np.cos(twist), np.sin(twist)
        c, s = np.cos(q[j] + theta), np.sin(q[j] + theta)
        rotation = ((c, -s, 0.0), (ca * s, ca * c, -sa), (sa * s, sa * c, ca))  # of frame j in frame j - 1
        back = tuple(zip(*rotation))
        origin = (length, -sa * d, ca * d)
        frames.append((rotation, origin))
        acc = turned(back, acc + cross(alpha, origin) + cross(omega, cross(omega, origin)))
        omega, alpha = turned(back, omega), turned(back, alpha)
        alpha += np.array([omega[1] * v[j], -omega[0] * v[j], a[j]])
        omega[2] += v[j]
        xx, xy, xz, yy, yz, zz, mx, my, mz, m = p[j, :10]
        h = (mx, my, mz)
        inertia = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        forces.append(m * acc + cross(alpha, h) + cross(omega, cross(omega, h)))
        moments.append(turned(inertia, alpha) + cross(omega, turned(inertia, omega)) + cross(h, acc))
    force = moment = 0.0
    out = np.empty_like(q)
    for j in reversed(range(6)):
        force, moment = forces[j] + force, moments[j] + moment
        Ia, Fv, Fc = p[j, 10:]
        out[j] = moment[2] + Ia * a[j] + Fv * v[j] + Fc * np.tanh(v[j] / SPEED)
        rotation, origin = frames[j]
        force = turned(rotation, force)
        moment = turned(rotation, moment) + cross(origin, force)
    return out


def acceleration(p, q, v, tau):
    """(B, 6) of parameters (6, 13, 7 B) and (B, 6) each: M and the rest by seven inverse dynamics."""
    count = len(q)
    all_v, all_a = np.zeros((2, 6, 7 * count))
    all_v[:, 6 * count :] = v.T
    all_a[:, : 6 * count] = np.repeat(np.eye(6), count, axis=1)
    gravity = np.repeat([0.0] * 6 + [GRAVITY], count)
    torques = inverse_dynamics(p, np.tile(q.T, (1, 7)), all_v, all_a, gravity).reshape(6, 7, count)
    return np.linalg.solve(torques[:, :6].transpose(2, 0, 1), (tau.T - torques[:, 6]).T[..., None])[..., 0]


def simulate(chi, wanted, noise=None, disturbance=None):
    """Positions, velocities, accelerations and torques (B, N, 6) at the samples for parameters (B, 52); torques hold until the next one."""
    p = np.tile(standard(chi).transpose(1, 2, 0), (1, 1, 7))
    noise = np.zeros_like(wanted) if noise is None else noise
    disturbance = np.zeros_like(wanted) if disturbance is None else disturbance
    h = 1 / RATE / STEPS
    q = np.tile(wanted[0], (len(chi), 1))
    v = np.tile(CubicSpline(np.arange(len(wanted)) / RATE, wanted)(0, 1), (len(chi), 1))
    before = q + noise[0]
    out = []
    for target, error, push in zip(wanted, noise, disturbance):
        measured = q + error
        tau = K_P * K_V * (target - measured) - K_V * (measured - before) * RATE
        before = measured
        u = tau + push
        for step in range(STEPS):
            k1 = acceleration(p, q, v, u)
            if step == 0:
                out.append([q, v, k1, tau])
            k2 = acceleration(p, q + h / 2 * v, v + h / 2 * k1, u)
            k3 = acceleration(p, q + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2, u)
            k4 = acceleration(p, q + h * v + h * h / 2 * k2, v + h * k3, u)
            q = q + h * v + h * h / 6 * (k1 + k2 + k3)
            v = v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return [np.stack(part, axis=1) for part in zip(*out)]


def regressor(q, v, a):
    """(N, 6, 52) of states (N, 6): the torques of unit parameters."""
    gravity = np.full(len(q), GRAVITY)
    columns = [inverse_dynamics(standard(unit)[..., None], q.T, v.T, a.T, gravity).T for unit in np.eye(len(BASE))]
    return np.stack(columns, axis=-1)


def base_of(parameters):
    """The base parameters (52) of (6, 13), as the torques of random states have it."""
    q, v, a = np.random.default_rng(1).uniform(-3, 3, (3, 400, 6))
    W = regressor(q, v, a).reshape(-1, len(BASE))
    tau = inverse_dynamics(parameters[..., None], q.T, v.T, a.T, np.full(len(q), GRAVITY)).T.reshape(-1)
    scale = np.linalg.norm(W, axis=0)
    chi, _, rank, _ = np.linalg.lstsq(W / scale, tau, rcond=1e-10)
    if rank != len(BASE) or np.linalg.norm(W @ (chi / scale) - tau) > 1e-9 * np.linalg.norm(tau):
        raise SystemExit("these are no base parameters")
    return chi / scale


def least_squares(V, tau, chi):
    """The parameters with each joint's rows weighted by what chi leaves of them, and their deviations."""
    columns = np.count_nonzero(np.any(V != 0, axis=0), axis=-1)
    sigma = np.sqrt(np.sum((tau - V @ chi) ** 2, axis=0) / (len(V) - columns))
    weighted = (V / sigma[None, :, None]).reshape(-1, len(BASE))
    scale = np.linalg.norm(weighted, axis=0)
    after = np.linalg.lstsq(weighted / scale, (tau / sigma).reshape(-1), rcond=None)[0] / scale
    half = np.linalg.inv(np.linalg.qr(weighted / scale, "r"))
    return after, np.linalg.norm(half, axis=1) / scale


def didim(chi, wanted, tau, steps):
    """The parameters that least squares on the regressor of their own simulation gives back, by Newton's steps."""
    for _ in range(30):
        points = np.vstack([chi, chi + np.diag(steps)])
        q, v, a, _ = simulate(points, wanted)
        found = [least_squares(regressor(*states), tau, point) for *states, point in zip(q, v, a, points)]
        sigma = found[0][1]
        change = np.array([after for after, _ in found]) - points
        slopes = (change[1:] - change[0]).T / steps
        step = np.linalg.solve(slopes * sigma / sigma[:, None], -change[0] / sigma)
        chi = chi + step * sigma
        print("DIDIM moves by", np.max(np.abs(step)), "sigma", flush=True)
        if np.max(np.abs(step)) < 1e-4:
            return chi
    raise SystemExit("no fixed point")


def output_error(chi, wanted, measured, steps):
    """Weights by joint and parameters in turn, by Gauss-Newton steps with central differences."""
    for _ in range(30):
        q = simulate(np.vstack([chi, chi + np.diag(steps), chi - np.diag(steps)]), wanted)[0]
        error = measured - q[0]
        weight = 1 / np.sqrt(np.mean(error**2, axis=0))
        J = ((q[1 : 1 + len(chi)] - q[1 + len(chi) :]) / 2 * weight).reshape(len(chi), -1).T
        step = np.linalg.lstsq(J, (error * weight).reshape(-1), rcond=None)[0]
        sigma = np.linalg.norm(np.linalg.inv(np.linalg.qr(J, "r")), axis=1)
        chi = chi + step * steps
        print("output error moves by", np.max(np.abs(step / sigma)), "sigma", flush=True)
        if np.max(np.abs(step / sigma)) < 1e-4:
            return chi
    raise SystemExit("no rest")


def reference():
    A, B = np.split(np.loadtxt(DATA / "six_axis_reference.csv", delimiter=",", skiprows=1), 2, axis=1)
    frequency = 0.2 * np.pi * np.arange(1, len(A) + 1)
    phase = np.outer(np.arange(SAMPLES) / RATE, frequency)
    return (np.sin(phase) / frequency) @ A - (np.cos(phase) / frequency) @ B


def main():
    random = np.random.default_rng(11)
    truth = base_of(arm())
    wanted = reference()
    noise = NOISE * random.normal(size=wanted.shape)
    disturbance = DISTURBANCE * random.normal(size=wanted.shape)
    q, _, _, tau = (x[0] for x in simulate(truth[None], wanted, noise, disturbance))
    file = HERE / "six_joints_oracle.csv"
    names = [f"{what}{j}" for what in ("q", "tau", "qref") for j in range(1, 7)]
    log = np.column_stack([q + noise, tau, wanted])
    np.savetxt(file, log, delimiter=",", header=",".join(names), comments="", fmt=["%.7f"] * 6 + ["%.4f"] * 6 + ["%.7f"] * 6)
    measured, tau, wanted = np.split(np.loadtxt(file, delimiter=",", skiprows=1), 3, axis=1)
    states = (x[0] for x in simulate(truth[None], wanted)[:3])
    steps = 0.01 * least_squares(regressor(*states), tau, truth)[1]
    found = [didim(truth, wanted, tau, steps), output_error(truth, wanted, measured, steps)]
    np.savetxt(HERE / "six_joints_oracle_found.csv", found, delimiter=",", header=",".join(BASE), comments="", fmt="%.9g")


if __name__ == "__main__":
    main()
