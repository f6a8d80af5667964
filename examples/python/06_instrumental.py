"""From a simulated closed loop to its parameters by instrumental variables: nothing is filtered, nothing is known at the start."""

import sys
from pathlib import Path

import numpy as np

import rivid

data = Path(sys.argv[1] if len(sys.argv) > 1 else "data/scara")
robot = rivid.Robot.from_urdf(data / "scara.urdf", gravity=[0, 0, -9.81], friction="coulomb", rotor_inertia=False)

control = rivid.Pd(omega_n=[1, 10], zeta=1, rate_hz=200)
via = [[0, 0], [1.5, 2], [-1, -1], [1, 1.5], [-1.5, -2], [1, -0.5], [-0.5, 2], [1.2, -1.5], [0, 0]]
simulation = rivid.simulate(
    robot,
    control,
    rivid.PointToPoint(via=via, durations=2.5),
    position_noise=2e-5,  # rad
    disturbance=[0.06, 0.015],  # N·m
    seed=7,
)
fit = rivid.identify(robot, simulation.log, rivid.Iv(control=control, decimation=20, torque_held=True))
print(fit)

base = robot.base_parameters()
truth = base.from_standard(list(robot.standard_parameters.values()))
errors = (fit.chi - truth) / fit.sigma
print("errors in standard deviations:", np.round(errors, 2))
assert fit.identified
# Of eight parameters one in three thousand such logs has an error beyond 4 σ.
assert np.abs(errors).max() < 4.0
