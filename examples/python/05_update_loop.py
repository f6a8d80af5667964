"""The loop of a computed-torque controller. It knows the SCARA of data/scara from the result.json of its identification; the robot
that it moves here has the true parameters."""

import sys
import tempfile
from pathlib import Path

import numpy as np

import rivid

data = Path(sys.argv[1] if len(sys.argv) > 1 else "data/scara")
experiment = rivid.Experiment(data / "scara.toml", {"method.physical": True})
truth = experiment.robot.model()


def largest_tracking_error(model, omega_n=10.0):
    """Of the joints' positions on a way of two seconds [rad]."""
    dynamics = rivid.InverseDynamics(model, smoothing_speed=0.01)  # rad/s
    period = 1e-3
    amplitude, omega = np.array([0.8, -0.5]), np.array([3.0, 5.0])
    q, qd = np.zeros(2), np.zeros(2)
    largest = 0.0
    for k in range(2000):
        phase = omega * k * period
        q_r = amplitude * (1.0 - np.cos(phase))  # starts at rest
        qd_r = amplitude * omega * np.sin(phase)
        qdd_r = amplitude * omega**2 * np.cos(phase)
        tau = dynamics.torque(q, qd, qdd_r + 2.0 * omega_n * (qd_r - qd) + omega_n**2 * (q_r - q))
        largest = max(largest, np.abs(q_r - q).max())
        qd = qd + period * truth.direct_dynamics(q, qd, tau)
        q = q + period * qd
    return largest


with tempfile.TemporaryDirectory() as folder:
    result = Path(folder) / "result.json"
    rivid.identify(experiment).save(result)
    identified = rivid.DynamicModel.from_result(result)
# A guess for comparison: half of everything.
standard = experiment.robot.standard_parameters
guess = experiment.robot.model({name: 0.5 * value for name, value in standard.items()})

with_model, with_guess = largest_tracking_error(identified), largest_tracking_error(guess)
print(f"largest tracking error: {1e3 * with_model:.3g} mrad with the identified model, {1e3 * with_guess:.3g} mrad with half of it")
assert with_model < 0.1 * with_guess
