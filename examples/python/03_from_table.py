"""A robot that is made in memory, from modified Denavit-Hartenberg parameters: its base parameters and torques."""

import numpy as np

import rivid

quarter = np.pi / 2
robot = rivid.Robot.from_mdh(
    [
        {"joint": "waist", "type": "R", "alpha": 0.0, "a": 0.0, "d": 0.4},
        {"joint": "shoulder", "type": "R", "alpha": quarter, "a": 0.0, "d": 0.0},
        {"joint": "elbow", "type": "R", "alpha": 0.0, "a": 0.5, "d": 0.0},
    ],
    friction="none",
    rotor_inertia=False,
)
base = robot.base_parameters()
print(f"{len(base)} base parameters of {len(robot.standard_parameters)} standard ones")
print(base)

chi = np.linspace(1.0, 2.0, len(base))
q, qd, qdd = np.array([0.3, -0.8, 1.1]), np.array([0.5, -1.2, 0.7]), np.array([2.0, 1.0, -3.0])
tau = robot.regressor(q[None], qd[None], qdd[None])[0] @ chi
other = robot.model(chi).inverse_dynamics(q, qd, qdd)  # recursive Newton-Euler
for name, by_regressor, by_recursion in zip(robot.joints, tau, other):
    print(f"{name}: {by_regressor:.6g} N·m, recursive Newton-Euler {by_recursion:.6g} N·m")

# The same torques by another algorithm.
assert np.abs(tau - other).max() <= 1e-12 * np.abs(tau).max()
