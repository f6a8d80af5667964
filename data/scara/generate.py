#!/usr/bin/env python3
"""Simulated experiments of the two-joint planar SCARA; standard library only.

    python3 generate.py [folder]     write the logs and truth.json into folder (default: this one)
    python3 generate.py --check      measure the integration error and print it

What is simulated, and every convention of the columns: README.md beside this file.
"""

import json
import math
import os
import random
import sys

# The robot: tau = IDM(q, qd, qdd) chi, vertical axes, so no gravity. SI units, joint side.
LENGTH = 0.5
ZZ1R, ZZ2 = 3.44, 0.062
MX2, MY2 = 0.242, 0.014
LMX2, LMY2 = LENGTH * MX2, LENGTH * MY2
FV = (0.03, 0.013)
FC = (0.82, 0.137)

# The controller, sampled with a zero-order hold: v = k_p k_v (q_r - q) - k_v qd, tau = v.
F_M = 200
ZETA = 1.0
OMEGA_N = (1.0, 10.0)
DESIGN_INERTIA = (ZZ1R + ZZ2 + 2.0 * LMX2, ZZ2)
K_P = tuple(w / (2.0 * ZETA) for w in OMEGA_N)
K_V = tuple(2.0 * ZETA * w * j for w, j in zip(OMEGA_N, DESIGN_INERTIA))

# Torque that acts on the joints, held for one control period, and is not recorded: standard deviation, N m.
DISTURBANCE = (0.06, 0.015)

SUBSTEPS = 5  # RK4 steps in each control period
EVENT_TOLERANCE = 1e-13  # s: width at which the bisection of a reversal or a break-away stops

VIA_S1 = [(0, 0), (1.5, 2), (-1, -1), (1, 1.5), (-1.5, -2), (1, -0.5), (-0.5, 2), (1.2, -1.5), (0, 0)]
VIA_S2 = [(2 * a, 2 * b) for a, b in VIA_S1]
VIA_VALIDATION = [(0, 0), (-2.2, 3), (1.6, 0.8), (2.8, -2.6), (-0.8, -3.2), (-2.6, 1.4), (1.4, 3.6),
                  (0.2, -1.2), (0, 0)]


class Gaussian:
    """Normal deviates by Box and Muller from random(), whose sequence Python guarantees for a given seed."""

    def __init__(self, seed):
        self.uniform = random.Random(seed).random

    def __call__(self, sigma):
        radius = math.sqrt(-2.0 * math.log(1.0 - self.uniform()))
        return sigma * radius * math.cos(2.0 * math.pi * self.uniform())


def quintic(via, duration):
    """Rest-to-rest moves of the given duration from each via point to the next; at rest afterwards."""

    def reference(t):
        move = int(t / duration + 1e-9)
        if move >= len(via) - 1:
            return tuple(float(x) for x in via[-1])
        s = min(max(t / duration - move, 0.0), 1.0)
        blend = s * s * s * (10.0 + s * (-15.0 + 6.0 * s))
        return tuple(a + (b - a) * blend for a, b in zip(via[move], via[move + 1]))

    return reference


def accelerations(q2, qd1, qd2, tau1, tau2, mode1, mode2):
    """Accelerations, and the friction that holds each sticking joint (0 for one that slips).

    A mode is the sign of the sliding velocity, or 0 for a joint that sticks.
    """
    s, c = math.sin(q2), math.cos(q2)
    coupling = LMX2 * c - LMY2 * s
    centrifugal = LMX2 * s + LMY2 * c
    m11 = ZZ1R + ZZ2 + 2.0 * coupling
    m12 = ZZ2 + coupling
    net1 = tau1 + centrifugal * qd2 * (2.0 * qd1 + qd2) - FV[0] * qd1 - FC[0] * mode1
    net2 = tau2 - centrifugal * qd1 * qd1 - FV[1] * qd2 - FC[1] * mode2
    if mode1 and mode2:
        det = m11 * ZZ2 - m12 * m12
        return (ZZ2 * net1 - m12 * net2) / det, (m11 * net2 - m12 * net1) / det, 0.0, 0.0
    if mode1:
        qdd1 = net1 / m11
        return qdd1, 0.0, 0.0, net2 - m12 * qdd1
    if mode2:
        qdd2 = net2 / ZZ2
        return 0.0, qdd2, net1 - m12 * qdd2, 0.0
    return 0.0, 0.0, net1, net2


def rk4(state, tau, mode, h):
    """One Runge-Kutta step of (q1, q2, qd1, qd2) in fixed modes; a sticking joint stays where it is."""
    q1, q2, v1, v2 = state
    a1, a2, _, _ = accelerations(q2, v1, v2, *tau, *mode)
    g = 0.5 * h
    u1, u2 = v1 + g * a1, v2 + g * a2
    b1, b2, _, _ = accelerations(q2 + g * v2, u1, u2, *tau, *mode)
    w1, w2 = v1 + g * b1, v2 + g * b2
    c1, c2, _, _ = accelerations(q2 + g * u2, w1, w2, *tau, *mode)
    x1, x2 = v1 + h * c1, v2 + h * c2
    d1, d2, _, _ = accelerations(q2 + h * w2, x1, x2, *tau, *mode)
    k = h / 6.0
    return (q1 + k * (v1 + 2.0 * (u1 + w1) + x1), q2 + k * (v2 + 2.0 * (u2 + w2) + x2),
            v1 + k * (a1 + 2.0 * (b1 + c1) + d1), v2 + k * (a2 + 2.0 * (b2 + c2) + d2))


def choose_mode(state, tau, mode):
    """Modes of the joints at zero velocity: the combination that Coulomb's law admits."""
    at_rest = [state[2] == 0.0, state[3] == 0.0]
    choices = [(0, 1, -1) if at_rest[j] else (mode[j],) for j in (0, 1)]
    candidates = [(m1, m2) for m1 in choices[0] for m2 in choices[1]]
    for candidate in sorted(candidates, key=lambda m: abs(m[0]) + abs(m[1])):
        outcome = accelerations(state[1], state[2], state[3], *tau, *candidate)
        qdd, hold = outcome[:2], outcome[2:]
        if all(not at_rest[j] or (candidate[j] * qdd[j] > 0.0 if candidate[j] else abs(hold[j]) <= FC[j])
               for j in (0, 1)):
            return candidate
    raise ArithmeticError(f"no admissible friction mode at {state}, torque {tau}")


def events(state, tau, mode):
    """For each joint: has it passed its reversal (slipping) or its break-away (sticking)?"""
    hold = accelerations(state[1], state[2], state[3], *tau, *mode)[2:]
    return [state[2 + j] * mode[j] < 0.0 if mode[j] else abs(hold[j]) > FC[j] for j in (0, 1)]


def advance(state, tau, mode, h, tally):
    """Integrate over h under a constant torque, locating every reversal and break-away by bisection."""
    mode = choose_mode(state, tau, mode)
    left = h
    for _ in range(100):
        trial = rk4(state, tau, mode, left)
        if not any(events(trial, tau, mode)):
            return trial, mode
        low, high = 0.0, left
        while high - low > EVENT_TOLERANCE:
            middle = 0.5 * (low + high)
            if any(events(rk4(state, tau, mode, middle), tau, mode)):
                high = middle
            else:
                low = middle
        passed = rk4(state, tau, mode, high)
        which = events(passed, tau, mode)
        state = passed[:2] + tuple(passed[2 + j] if mode[j] and not which[j] else 0.0 for j in (0, 1))
        mode = choose_mode(state, tau, mode)
        tally["events"] += 1
        left -= high
        if left <= 0.0:
            return state, mode
    raise ArithmeticError("more than 100 friction events in one integration step")


def simulate(reference, duration, encoder, seed, disturbance=DISTURBANCE, substeps=SUBSTEPS):
    """Rows (t, q1, q2, v1, v2, qref1, qref2), the true (q1, q2, qd1, qd2) of each row, and counts.

    The encoder draws from Random(seed), the disturbance from Random(seed + 1).
    """
    noise, shove = Gaussian(seed), Gaussian(seed + 1)
    h = 1.0 / F_M / substeps
    start = reference(0.0)
    state, mode = (start[0], start[1], 0.0, 0.0), (0, 0)
    tally = {"events": 0, "stuck": [0, 0]}
    rows, truth, previous = [], [], None
    for k in range(round(duration * F_M) + 1):
        t = k / F_M
        measured = (state[0] + noise(encoder), state[1] + noise(encoder))
        q_r = reference(t)
        velocity = tuple((a - b) * F_M for a, b in zip(measured, previous)) if previous else (0.0, 0.0)
        previous = measured
        v = tuple(K_P[j] * K_V[j] * (q_r[j] - measured[j]) - K_V[j] * velocity[j] for j in (0, 1))
        rows.append((t, *measured, *v, *q_r))
        truth.append(state)
        tau = tuple(v[j] + shove(disturbance[j]) for j in (0, 1))
        for _ in range(substeps):
            state, mode = advance(state, tau, mode, h, tally)
        for j in (0, 1):
            tally["stuck"][j] += mode[j] == 0
    return rows, truth, tally


LOGS = {
    # file: (reference, seconds, encoder noise in rad, seed)
    "scara_s1.csv": (quintic(VIA_S1, 2.5), 20.0, 2.0e-5, 1001),
    "scara_s2.csv": (quintic(VIA_S2, 2.5), 20.0, 4.5e-5, 2001),
    "scara_validation.csv": (quintic(VIA_VALIDATION, 2.5), 20.0, 4.5e-5, 3001),
}


def write(path, rows):
    with open(path, "w", newline="\n") as out:
        out.write("t,q1,q2,v1,v2,qref1,qref2\n")
        for row in rows:
            out.write(",".join("%.9g" % (x + 0.0) for x in row) + "\n")


def truth():
    """The base parameters that identification should find, as IDM columns are named in the literature."""
    inertia, first_moment, viscous, torque = "kg m^2", "kg m", "N m s/rad", "N m"
    values = [("ZZ1R", ZZ1R, inertia), ("Fv1", FV[0], viscous), ("Fc1", FC[0], torque), ("off1", 0.0, torque),
              ("ZZ2", ZZ2, inertia), ("MX2", MX2, first_moment), ("MY2", MY2, first_moment),
              ("Fv2", FV[1], viscous), ("Fc2", FC[1], torque), ("off2", 0.0, torque)]
    return {
        "robot": "scara",
        "regrouping": {"ZZ1R": "ZZ1 + 0.25 M2"},
        "parameters": {name: {"value": value, "unit": unit} for name, value, unit in values},
    }


def check():
    """Largest change of the true motion when the integration step is halved, twice."""
    for name, settings in LOGS.items():
        motions = []
        for factor in (1, 2, 4):
            rows, motion, tally = simulate(*settings, substeps=SUBSTEPS * factor)
            motions.append(motion)
            if factor == 1:
                stuck = "{} and {}".format(*tally["stuck"])
                print(f"{name}: {tally['events']} friction events; joints stick at {stuck} of {len(rows)} samples")
        for factor, coarse, fine in ((2, *motions[0:2]), (4, *motions[1:3])):
            change = [max(abs(x[i] - y[i]) for x, y in zip(coarse, fine)) for i in range(4)]
            print(f"{name}: step 1/{factor}: changes by {max(change[:2]):.1e} rad, {max(change[2:]):.1e} rad/s")


def main(arguments):
    if arguments == ["--check"]:
        return check()
    folder = arguments[0] if arguments else os.path.dirname(os.path.abspath(__file__))
    for name, settings in LOGS.items():
        rows, _, _ = simulate(*settings)
        write(os.path.join(folder, name), rows)
        print(f"{name}: {len(rows)} rows")
    with open(os.path.join(folder, "truth.json"), "w", newline="\n") as out:
        json.dump(truth(), out, indent=2)
        out.write("\n")


if __name__ == "__main__":
    main(sys.argv[1:])
