"""A control loop at 1 kHz on the simulated six-axis robot of data/six_axis, as examples/07_in_the_loop.cpp: computed torque, the payload
estimated while the robot moves, and contacts seen by the momentum."""

import sys
from pathlib import Path

import numpy as np

import rivid
from rivid.online import ContactObserver, OnlineModel, PayloadEstimator

RATE = 1000.0
MASS = 3.0  # kg
PICK_UP, PUSH, END = 22.0, 29.0, 30.0  # s

data = Path(sys.argv[1] if len(sys.argv) > 1 else "data/scara").parent / "six_axis"
robot = rivid.Robot.from_urdf(data / "six_axis.urdf", friction="symmetric", rotor_inertia=True)
n = len(robot)
drives = {f"{name}{joint + 1}": value for joint in range(n) for name, value in (("Ia", 0.1), ("Fv", 2.0), ("Fc", 3.0))}
empty = {**robot.standard_parameters, **drives}

# The load is a body on the last link, whose moments are about the origin of the link.
com, inertia = 0.08, 0.004
loaded = dict(empty)
loaded[f"M{n}"] += MASS
loaded[f"MZ{n}"] += MASS * com
for name, moment in (("XX", inertia + MASS * com**2), ("YY", inertia + MASS * com**2), ("ZZ", inertia)):
    loaded[f"{name}{n}"] += moment


class Controller:
    """Computed torque with poles at 20 rad/s; the estimators hear of the torque that acted until now."""

    def __init__(self, model):
        self.dynamics = rivid.InverseDynamics(model.model, smoothing_speed=0.05)
        self.payload = PayloadEstimator(model, rate_hz=RATE)
        self.contact = ContactObserver(model, rate_hz=RATE, smoothing_speed=0.05)
        self.last_tau = np.zeros(n)
        self.expects_payload = False

    def update(self, q, qd, q_r, qd_r, qdd_r, learn):
        touched = self.contact.update(q, qd, self.last_tau, learn=learn)
        tau = self.dynamics.torque(q, qd, qdd_r + 40.0 * (qd_r - qd) + 400.0 * (q_r - q))
        if touched and not self.expects_payload:
            self.payload.pause()  # what touches the robot is no payload
        else:
            self.payload.update(q, tau)
        if self.expects_payload:
            found = self.payload.payload
            if found.held and found.good:
                self.contact.set_payload(self.payload.inertial)
                self.expects_payload = False
        self.last_tau = tau
        return tau


class Plant:
    """The robot that is controlled, a step of semi-implicit Euler a tick."""

    def __init__(self, parameters):
        self.dynamics = rivid.InverseDynamics(robot.model(parameters), smoothing_speed=0.05)

    def step(self, q, qd, tau):
        qdd = np.linalg.solve(self.dynamics.mass_matrix(q), tau - self.dynamics.bias(q, qd) - self.dynamics.friction(qd))
        qd = qd + qdd / RATE
        return q + qd / RATE, qd


# What an identification would say, each parameter to 1 %; OnlineModel.from_result("result.json") takes it
# from a file.
chi = robot.base_parameters().from_standard(list(empty.values()))
covariance = np.diag(np.maximum(1e-4 * chi**2, 1e-6))
controller = Controller(OnlineModel(robot, chi, covariance, sigma_rho=0.1, velocity_threshold=0.2))
before, after = Plant(empty), Plant(loaded)

omega = 1.0 + 0.3 * np.arange(n)
q, qd = np.zeros(n), np.zeros(n)
seen = touched = None
for k in range(int(END * RATE)):
    t = k / RATE
    reference = 0.5 * (1.0 - np.cos(omega * t)), 0.5 * omega * np.sin(omega * t), 0.5 * omega**2 * np.cos(omega * t)
    if t == PICK_UP:
        controller.expects_payload = True  # the gripper has closed
    learn = t < PICK_UP - 1.0 or PICK_UP + 2.0 < t < PUSH - 1.0  # nothing touches it then
    tau = controller.update(q, qd, *reference, learn)
    if seen is None and controller.payload.change_tick > 0:
        seen = t
    if touched is None and t > PUSH - 1.0 and controller.contact.link >= 0:
        touched = t
    push = np.where(np.arange(n) == 2, 20.0 if t > PUSH else 0.0, 0.0)  # N·m on joint 3
    q, qd = (before if t < PICK_UP else after).step(q, qd, tau + push)

found = controller.payload.payload
print(f"pick-up at {PICK_UP} s seen at {seen} s, mass {found.mass:.3f} ± {found.mass_half_width:.3f} kg of {MASS}")
print(f"push at {PUSH} s seen at {touched} s")
assert seen is not None and PICK_UP < seen < PICK_UP + 0.5
assert touched is not None and PUSH < touched < PUSH + 0.3
assert abs(found.mass - MASS) < 0.15
