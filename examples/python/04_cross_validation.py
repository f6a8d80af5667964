"""Trained on one log, validated on another: ordinary and weighted least squares side by side."""

import sys
from pathlib import Path

import rivid

data = Path(sys.argv[1] if len(sys.argv) > 1 else "data/scara")
robot = rivid.Robot.from_urdf(data / "scara.urdf", friction="coulomb", rotor_inertia=False)

options = {"torque_held": True, "cutoff_hz": 20.0, "decimation": 20}
ols = rivid.identify(robot, data / "scara_s2.csv", rivid.Ols(**options))
wls = rivid.identify(robot, data / "scara_s2.csv", rivid.Wls(**options))

print("parameter: OLS (sigma), WLS (sigma)")
for o, w in zip(ols.parameters, wls.parameters):
    print(f"{o['name']}: {o['value']:.6g} ({o['sigma']:.2g}), {w['value']:.6g} ({w['sigma']:.2g}) {o['unit']}")

for name, fit in (("OLS", ols), ("WLS", wls)):
    unseen = fit.validate(data / "scara_validation.csv")
    print(f"{name}: relative error {fit.relative_error:.4f} on its own log, {unseen['relative_error']:.4f} on the other")
    for own, other in zip(fit.fit, unseen["joints"]):
        # A model that only fits its own log would err several times as much on another.
        assert other["relative_error"] < 2.0 * own["relative_error"]
