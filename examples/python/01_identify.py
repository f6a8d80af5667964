"""The SCARA robot of data/scara by ordinary least squares."""

import sys
from pathlib import Path

import rivid

data = Path(sys.argv[1] if len(sys.argv) > 1 else "data/scara")

# Fv q̇ + Fc sign q̇; direct drive
robot = rivid.Robot.from_urdf(data / "scara.urdf", friction="coulomb", rotor_inertia=False)

log = data / "scara_s2.csv"  # columns t, q1, q2, v1, v2

# v acts from t_k to t_{k+1}
fit = rivid.identify(robot, log, rivid.Ols(torque_held=True, cutoff_hz=20.0, decimation=20))
print(fit)
