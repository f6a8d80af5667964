#!/usr/bin/env python3
"""Writes scara_oracle.csv beside this file: the SCARA of data/scara in its closed loop, by an integrator of its own.

    python3 scara_oracle.py             standard library only, under a second
    python3 scara_oracle.py --check     measures the integration error, a few seconds

One row a tenth of a second: time, true positions and velocities of both joints, for the via points of S2. No noise; a
disturbance that is a formula, held for each control period, acts beside the drives. Runge-Kutta of fourth order, five steps
in each period, with fixed friction modes between events; reversals and break-aways are located by bisection to 1e-13 s.
Halving the step changes the motion by at most 6.5e-14 rad and 2.2e-12 rad/s.
"""

import math
import os
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


def disturbance(k):
    """Torques on the joints in control period k, N m."""
    return 0.06 * math.sin(1.7 * k), 0.015 * math.cos(2.3 * k)


SUBSTEPS = 5  # RK4 steps in each control period
EVENT_TOLERANCE = 1e-13  # s: width at which the bisection of a reversal or a break-away stops

VIA = [(0, 0), (3, 4), (-2, -2), (2, 3), (-3, -4), (2, -1), (-1, 4), (2.4, -3), (0, 0)]
MOVE = 2.5  # s
ROW = 20  # control periods


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


def simulate(substeps=SUBSTEPS):
    """True (q1, q2, qd1, qd2) at each control instant, and counts."""
    reference = quintic(VIA, MOVE)
    h = 1.0 / F_M / substeps
    state, mode = (*reference(0.0), 0.0, 0.0), (0, 0)
    tally = {"events": 0}
    motion, previous = [], state[:2]
    for k in range(round(MOVE * (len(VIA) - 1) * F_M) + 1):
        q_r = reference(k / F_M)
        velocity = tuple((a - b) * F_M for a, b in zip(state[:2], previous))
        previous = state[:2]
        v = tuple(K_P[j] * K_V[j] * (q_r[j] - state[j]) - K_V[j] * velocity[j] for j in (0, 1))
        motion.append(state)
        tau = tuple(a + b for a, b in zip(v, disturbance(k)))
        for _ in range(substeps):
            state, mode = advance(state, tau, mode, h, tally)
    return motion, tally


def check():
    """Largest change of the motion when the integration step is halved, twice."""
    motions = []
    for factor in (1, 2, 4):
        motion, tally = simulate(SUBSTEPS * factor)
        motions.append(motion)
        print(f"{tally['events']} friction events")
    for factor, coarse, fine in ((2, *motions[0:2]), (4, *motions[1:3])):
        change = [max(abs(x[i] - y[i]) for x, y in zip(coarse, fine)) for i in range(4)]
        print(f"step 1/{factor}: changes by {max(change[:2]):.1e} rad, {max(change[2:]):.1e} rad/s")


def main(arguments):
    if arguments == ["--check"]:
        return check()
    motion, _ = simulate()
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, "scara_oracle.csv"), "w", newline="\n") as out:
        out.write("t,q1,q2,qd1,qd2\n")
        for k in range(0, len(motion), ROW):
            out.write(",".join(repr(x + 0.0) for x in (k / F_M, *motion[k])) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
