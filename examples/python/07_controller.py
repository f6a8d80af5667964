"""A controller that reads no file, as examples/06_headers_only.cpp: the numbers of its robot, the SCARA of data/scara, are written out here
as an identification found them."""

import numpy as np

import rivid

robot = rivid.Robot.from_mdh(
    [
        {"joint": "joint_1", "type": "R", "alpha": 0.0, "a": 0.0, "d": 0.0},
        {"joint": "joint_2", "type": "R", "alpha": 0.0, "a": 0.5, "d": 0.0},
    ],
    gravity=[0, 0, -9.81],
    friction="coulomb",
    rotor_inertia=False,
)
model = robot.model(
    {"ZZ1R": 3.38, "Fv1": 0.03, "Fc1": 0.82, "ZZ2": 0.063, "MX2": 0.242, "MY2": 0.001, "Fv2": 0.013, "Fc2": 0.137}
)


class ComputedTorque:
    """Poles at omega_n, with the damping of 1."""

    def __init__(self, model, omega_n):
        self.dynamics = rivid.InverseDynamics(model, smoothing_speed=0.01)  # rad/s
        self.k_p, self.k_v = omega_n**2, 2.0 * omega_n

    def torque(self, q, qd, q_r, qd_r, qdd_r):
        return self.dynamics.torque(q, qd, qdd_r + self.k_v * (qd_r - qd) + self.k_p * (q_r - q))


controller = ComputedTorque(model, 10.0)
omega = np.array([3.0, 5.0])
torques = []
for k in range(1000):
    phase = omega * 1e-3 * k
    q_r, qd_r, qdd_r = 0.5 * (1.0 - np.cos(phase)), 0.5 * omega * np.sin(phase), 0.5 * omega**2 * np.cos(phase)
    q, qd = q_r - 1e-3 * np.sin(7.0 * phase), qd_r - 7e-3 * omega * np.cos(7.0 * phase)  # as if measured
    torques.append(controller.torque(q, qd, q_r, qd_r, qdd_r))
print(f"largest torques: {np.abs(torques).max(axis=0).round(3)} N m")
assert np.isfinite(torques).all()
