#!/usr/bin/env python3
"""Writes physical_oracle.json beside this file: physically consistent parameters by a conic solver.

    python3 -m pip install numpy cvxpy clarabel     (written with numpy 2.4, cvxpy 1.9, clarabel 0.11)
    python3 physical_oracle.py

For the SCARA and for a TX40, torques at random states with a recursive Newton-Euler of its own, of a robot that is not
physical (negative second moments, friction that drives), with noise. Then for each case

    min 1/2 |(y - W x) / sigma|^2 - its least value + 1/2 |pull x|^2 + weight * prior(x)

over the standard parameters x with positive semidefinite pseudo-inertias, Ia, Fv, Fc >= 0 and bounds of masses, by
Clarabel. States, torques, descriptions, and the least costs are written; rivid must find the same cost.
"""

import json
import os

import cvxpy
import numpy as np

QUARTER = np.pi / 2
# Modified Denavit-Hartenberg: alpha, a, d, theta.
SCARA = [(0, 0, 0, 0), (0, 0.5, 0, 0)]
TX40 = [
    (0, 0, 0.32, 0),
    (-QUARTER, 0, 0, -QUARTER),
    (0, 0.225, 0.035, QUARTER),
    (QUARTER, 0, 0.225, 0),
    (-QUARTER, 0, 0, 0),
    (QUARTER, 0, 0, 0),
]
GRAVITY = np.array([0, 0, -9.80665])


def frame(row, q):
    """Orientation and origin of frame j in frame j - 1."""
    alpha, a, d, theta = row
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta + q), np.sin(theta + q)
    R = np.array([[ct, -st, 0], [st * ca, ct * ca, -sa], [st * sa, ct * sa, ca]])
    return R, np.array([a, -sa * d, ca * d])


def tensor(p):
    return np.array([[p[0], p[1], p[2]], [p[1], p[3], p[4]], [p[2], p[4], p[5]]])


def torques(table, inertials, q, qd, qdd):
    """Recursive Newton-Euler with inertial parameters about the frames' origins."""
    n = len(table)
    z = np.array([0.0, 0.0, 1.0])
    w, wd, v = np.zeros(3), np.zeros(3), -GRAVITY
    frames, wrenches = [], []
    for j in range(n):
        R, p = frame(table[j], q[j])
        v = R.T @ (v + np.cross(wd, p) + np.cross(w, np.cross(w, p)))
        w_parent = R.T @ w
        w = w_parent + qd[j] * z
        wd = R.T @ wd + np.cross(w_parent, qd[j] * z) + qdd[j] * z
        I, h, m = tensor(inertials[j]), inertials[j][6:9], inertials[j][9]
        force = m * v + np.cross(wd, h) + np.cross(w, np.cross(w, h))
        moment = I @ wd + np.cross(w, I @ w) + np.cross(h, v)
        frames.append((R, p))
        wrenches.append((force, moment))
    out = np.zeros(n)
    force, moment = np.zeros(3), np.zeros(3)
    for j in reversed(range(n)):
        force, moment = force + wrenches[j][0], moment + wrenches[j][1]
        out[j] = moment[2]
        R, p = frames[j]
        force = R @ force
        moment = R @ moment + np.cross(p, force)
    return out


class Robot:
    def __init__(self, name, table, rotors):
        self.name, self.table, self.rotors = name, table, rotors
        self.n = len(table)
        self.kinds = []  # (kind, joint), the order of rivid
        for j in range(self.n):
            self.kinds += [("inertial", j, i) for i in range(10)]
            self.kinds += [("Ia", j, 0)] if rotors[j] else []
            self.kinds += [("Fv", j, 0), ("Fc", j, 0)]

    def regressor(self, q, qd, qdd):
        W = np.zeros((self.n, len(self.kinds)))
        for c, (kind, j, i) in enumerate(self.kinds):
            if kind == "inertial":
                inertials = np.zeros((self.n, 10))
                inertials[j, i] = 1.0
                W[:, c] = torques(self.table, inertials, q, qd, qdd)
            else:
                W[j, c] = {"Ia": qdd[j], "Fv": qd[j], "Fc": np.sign(qd[j])}[kind]
        return W

    def columns(self, kind, j):
        return [c for c, (k, joint, _) in enumerate(self.kinds) if k == kind and joint == j]


def pseudo_inertia(p):
    I = tensor(p)
    P = np.zeros((4, 4))
    P[:3, :3] = 0.5 * np.trace(I) * np.eye(3) - I
    P[:3, 3] = P[3, :3] = p[6:9]
    P[3, 3] = p[9]
    return P


def random_body(random, size):
    m = random.uniform(0.5, 3.0) * size
    Q, _ = np.linalg.qr(random.normal(size=(3, 3)))
    spread = Q @ np.diag(random.uniform(0.02, 0.1, 3) ** 2) @ Q.T
    com = random.uniform(-0.15, 0.15, 3)
    S = m * (spread + np.outer(com, com))
    I = np.trace(S) * np.eye(3) - S
    return np.array([I[0, 0], I[0, 1], I[0, 2], I[1, 1], I[1, 2], I[2, 2], *(m * com), m])


def experiment(robot, samples, noise, seed):
    """States, torques of a robot that is not physical, and its description."""
    random = np.random.default_rng(seed)
    description = np.array([random_body(random, 4.0 / (j + 1)) for j in range(robot.n)])
    truth = description * random.uniform(0.8, 1.2, description.shape)
    truth[-1, :6] *= -0.3  # no body
    x = np.zeros(len(robot.kinds))
    for j in range(robot.n):
        x[robot.columns("inertial", j)] = truth[j]
        x[robot.columns("Ia", j)] = random.uniform(0.05, 0.3)
        x[robot.columns("Fv", j)] = random.uniform(1.0, 5.0)
        x[robot.columns("Fc", j)] = random.uniform(1.0, 5.0)
    x[robot.columns("Fv", robot.n - 1)] = -0.4
    q = random.uniform(-2.0, 2.0, (samples, robot.n)).round(3)
    qd = random.uniform(-2.0, 2.0, (samples, robot.n)).round(3)
    qdd = random.uniform(-8.0, 8.0, (samples, robot.n)).round(3)
    W = np.vstack([robot.regressor(*state) for state in zip(q, qd, qdd)])
    tau = (W @ x + noise * random.normal(size=W.shape[0])).round(6)
    return {
        "robot": robot.name,
        "sigma": noise,
        "inertials": description.round(6).tolist(),
        "q": q.tolist(),
        "qd": qd.tolist(),
        "qdd": qdd.tolist(),
        "tau": tau.reshape(samples, robot.n).tolist(),
    }


def least_cost(robot, data, case):
    description = np.array(data["inertials"])
    states = zip(np.array(data["q"]), np.array(data["qd"]), np.array(data["qdd"]))
    W = np.vstack([robot.regressor(*state) for state in states]) / data["sigma"]
    y = np.array(data["tau"]).reshape(-1) / data["sigma"]
    # Only the part of y that W reaches counts; few well-scaled rows in place of W.
    U, s, Vt = np.linalg.svd(W, full_matrices=False)
    rank = int((s > 1e-10 * s[0]).sum())
    rows, target = s[:rank, None] * Vt[:rank], U[:, :rank].T @ y

    x = cvxpy.Variable(len(robot.kinds))
    constraints, pulls, prior = [], [], 0
    for j in range(robot.n):
        columns = robot.columns("inertial", j)
        P = sum(x[c] * pseudo_inertia(e) for c, e in zip(columns, np.eye(10)))
        # In units of the description, which the solver likes better.
        L = np.linalg.inv(np.linalg.cholesky(pseudo_inertia(description[j])))
        scaled = cvxpy.Variable((4, 4), PSD=True)
        constraints.append(scaled == L @ P @ L.T)
        if case["prior"] == "log_det":
            prior += cvxpy.trace(scaled) - cvxpy.log_det(scaled) - 4
        else:
            prior += 0.5 * cvxpy.sum_squares(scaled - np.eye(4))
        for kind in ("Ia", "Fv", "Fc"):
            constraints += [x[c] >= 0 for c in robot.columns(kind, j)]
            # Pulled to zero as if known to make as much torque as all parameters together.
            pulls += [np.linalg.norm(rows[:, c]) / np.linalg.norm(target) * x[c] for c in robot.columns(kind, j)]
        if str(j) in case.get("masses", {}):
            least, most = case["masses"][str(j)]
            constraints += [x[columns[9]] >= least, x[columns[9]] <= most]
    if "total_mass" in case:
        total = sum(x[robot.columns("inertial", j)[9]] for j in range(robot.n))
        constraints += [total >= case["total_mass"][0], total <= case["total_mass"][1]]
    problem = cvxpy.Problem(
        cvxpy.Minimize(
            0.5 * cvxpy.sum_squares(rows @ x - target)
            + 0.5 * cvxpy.sum_squares(cvxpy.hstack(pulls))
            + case["weight"] * prior
        ),
        constraints,
    )
    problem.solve(solver=cvxpy.CLARABEL, tol_gap_abs=1e-9, tol_gap_rel=1e-9, tol_feas=1e-9)
    assert problem.status == cvxpy.OPTIMAL, problem.status
    return problem.value, problem.solver_stats.solve_time


def main():
    robots = {
        "scara": Robot("scara", SCARA, [True, False]),
        "tx40": Robot("tx40", TX40, [True] * 6),
    }
    experiments = [experiment(robots["scara"], 40, 0.5, 1), experiment(robots["tx40"], 40, 0.3, 2)]
    cases = [
        {"prior": "log_det", "weight": 1.0},
        {"prior": "log_det", "weight": 100.0},
        {"prior": "ridge", "weight": 1.0},
    ]
    bounded = {"scara": {"masses": {"1": [1.0, 1.5]}}, "tx40": {"masses": {"0": [4.0, 5.0], "3": [2.0, 9.0]}}}
    for data in experiments:
        robot = robots[data["robot"]]
        total = sum(p[9] for p in data["inertials"])
        data["cases"] = []
        for case in cases + [
            {"prior": "log_det", "weight": 1.0, "total_mass": [0.5 * total, 0.8 * total], **bounded[robot.name]}
        ]:
            cost, seconds = least_cost(robot, data, case)
            print(f"{robot.name}, {len(robot.kinds)} columns, {case}: {cost:.9g} in {1e3 * seconds:.1f} ms")
            data["cases"].append({**case, "cost": cost})
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "physical_oracle.json")
    with open(path, "w", encoding="utf-8") as out:
        json.dump(experiments, out, separators=(",", ":"))
        out.write("\n")


if __name__ == "__main__":
    main()
