"""The closed loops of closed_loop.cpp as they are usually simulated in Python: SciPy's LSODA by odeint, whose right-hand
side is called without SciPy's Python layers in between, and by solve_ivp; tanh(velocity / v_s) is the sign of friction.

    python3 closed_loop_python.py FOLDER

FOLDER/problem.json describes robot, gains and reference. Writes FOLDER/results.json: for each width v_s of the tanh the
median of the milliseconds of the processor, the calls of the right-hand side, and the name of the file with the
positions at the samples.
"""

import json
import math
import pathlib
import statistics
import sys
import time

import numpy as np
from scipy.integrate import odeint, solve_ivp

WIDTHS = [1e-2, 1e-3, 1e-4]
RTOL = 1e-6
ATOL = 1e-8
REPEATS = 5


def scara(problem):
    """Two joints by the closed form, in plain numbers: faster than arrays of two."""
    p = problem["parameters"]
    zz1, zz2, mx, my = p["ZZ1R"], p["ZZ2"], p["MX2"], p["MY2"]
    fv1, fc1, fv2, fc2 = p["Fv1"], p["Fc1"], p["Fv2"], p["Fc2"]
    length = problem["length"]
    (s1, s2), (d1, d2) = problem["stiffness"], problem["damping"]
    via, move = problem["via"], problem["move"]
    last = len(via) - 2
    cos, sin, tanh = math.cos, math.sin, math.tanh

    def right_hand_side(y, t, v_s):
        q1, q2, v1, v2 = y.tolist()
        i = min(int(t / move), last)
        u = min(t / move - i, 1.0)
        s = u * u * u * (10.0 + u * (6.0 * u - 15.0))
        (a1, a2), (b1, b2) = via[i], via[i + 1]
        c2, n2 = cos(q2), sin(q2)
        coupling = length * (mx * c2 - my * n2)
        bend = length * (mx * n2 + my * c2)
        m12 = zz2 + coupling
        m11 = zz1 + zz2 + 2.0 * coupling
        f1 = s1 * (a1 + s * (b1 - a1) - q1) - d1 * v1 + bend * v2 * (2.0 * v1 + v2) - fv1 * v1 - fc1 * tanh(v1 / v_s)
        f2 = s2 * (a2 + s * (b2 - a2) - q2) - d2 * v2 - bend * v1 * v1 - fv2 * v2 - fc2 * tanh(v2 / v_s)
        inverse = 1.0 / (m11 * zz2 - m12 * m12)
        return v1, v2, (zz2 * f1 - m12 * f2) * inverse, (m11 * f2 - m12 * f1) * inverse

    return right_hand_side, np.array([*via[0], 0.0, 0.0])


def chain(problem):
    """Any chain of revolute joints by Pinocchio's articulated bodies."""
    import pinocchio as pin

    model = pin.Model()
    parent = 0
    for j, link in enumerate(problem["links"]):
        placement = pin.SE3(np.array(link["R"]), np.array(link["p"]))
        parent = model.addJoint(parent, pin.JointModelRZ(), placement, f"joint_{j + 1}")
        xx, xy, xz, yy, yz, zz, mx, my, mz, m = link["inertial"]
        model.appendBodyToJoint(
            parent, pin.Inertia.FromDynamicParameters(np.array([m, mx, my, mz, xx, xy, yy, xz, yz, zz])), pin.SE3.Identity()
        )
    model.armature = np.array([link["Ia"] for link in problem["links"]])
    model.gravity.linear = np.array(problem["gravity"])
    data = model.createData()
    n = model.nv
    Fv, Fc = (np.array([link[name] for link in problem["links"]]) for name in ("Fv", "Fc"))
    stiffness, damping = np.array(problem["stiffness"]), np.array(problem["damping"]) + Fv
    A, B = np.array(problem["A"]), np.array(problem["B"])
    omega = problem["omega_f"] * np.arange(1, A.shape[1] + 1)
    position = np.hstack([A / omega, -B / omega])
    sines = np.empty(2 * len(omega))
    rate = np.empty(2 * n)
    aba, sin, cos, tanh = pin.aba, np.sin, np.cos, np.tanh

    def reference(t):
        angle = omega * t
        sin(angle, out=sines[: len(omega)])
        cos(angle, out=sines[len(omega) :])
        return position @ sines

    def right_hand_side(y, t, v_s):
        q, v = y[:n], y[n:]
        rate[:n] = v
        rate[n:] = aba(model, data, q, v, stiffness * (reference(t) - q) - damping * v - Fc * tanh(v / v_s))
        return rate

    start = np.hstack([reference(0.0), A.sum(axis=1)])
    return right_hand_side, start


def by_odeint(right_hand_side, start, t, v_s):
    y, info = odeint(right_hand_side, start, t, args=(v_s,), rtol=RTOL, atol=ATOL, mxstep=100000, full_output=True)
    return y, info["nfe"][-1]


def by_solve_ivp(right_hand_side, start, t, v_s):
    # It keeps what it is given.
    rate = lambda instant, y: np.array(right_hand_side(y, instant, v_s))
    found = solve_ivp(rate, (t[0], t[-1]), start, method="LSODA", t_eval=t, rtol=RTOL, atol=ATOL)
    return found.y.T, found.nfev


def main():
    folder = pathlib.Path(sys.argv[1])
    problem = json.loads((folder / "problem.json").read_text())
    right_hand_side, start = {"scara": scara, "chain": chain}[problem["robot"]](problem)
    n = len(start) // 2
    t = np.arange(problem["samples"]) / problem["rate"]
    results = []
    for integrated in (by_odeint, by_solve_ivp):
        for v_s in WIDTHS:
            times = []
            for _ in range(REPEATS):
                begin = time.process_time()
                y, calls = integrated(right_hand_side, start, t, v_s)
                times.append(time.process_time() - begin)
            name = f"positions_{len(results)}"
            np.ascontiguousarray(y[:, :n]).tofile(folder / name)
            results.append(
                {
                    "how": integrated.__name__.removeprefix("by_"),
                    "v_s": v_s,
                    "ms": 1e3 * statistics.median(times),
                    "right_hand_sides": int(calls),
                    "positions": name,
                }
            )
    (folder / "results.json").write_text(json.dumps(results))


if __name__ == "__main__":
    main()
