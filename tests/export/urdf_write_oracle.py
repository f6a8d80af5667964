"""Torques of urdf_write_oracle.urdf by Pinocchio, for RewrittenUrdf.GivesTheTorquesThatPinocchioReadsFromIt.

    pip install pin numpy && python3 urdf_write_oracle.py

The URDF is what rewritten_urdf() made of the tree in urdf_write_test.cpp; the test checks that it still does.
Pinocchio 4.1.0, NumPy 2.4.6.
"""

import pathlib

import numpy as np
import pinocchio as pin

here = pathlib.Path(__file__).parent
model = pin.buildModelFromUrdf(str(here / "urdf_write_oracle.urdf"))
# The branch stands still.
model = pin.buildReducedModel(model, [model.getJointId("finger_joint")], pin.neutral(model))
model.gravity.linear = np.array([0.0, 0.0, -9.80665])
data = model.createData()
random = np.random.default_rng(2024)
with open(here / "urdf_write_oracle.csv", "w") as file:
    file.write("q1,q2,q3,qd1,qd2,qd3,qdd1,qdd2,qdd3,tau1,tau2,tau3\n")
    for _ in range(12):
        q, qd, qdd = random.uniform(-2, 2, 3), random.uniform(-2, 2, 3), random.uniform(-5, 5, 3)
        # Joint c is continuous: Pinocchio takes its cosine and sine.
        tau = pin.rnea(model, data, np.array([q[0], q[1], np.cos(q[2]), np.sin(q[2])]), qd, qdd)
        file.write(",".join(repr(float(x)) for x in [*q, *qd, *qdd, *tau]) + "\n")
