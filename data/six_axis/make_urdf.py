#!/usr/bin/env python3
"""Makes six_axis.urdf; standard library only.

    python3 make_urdf.py

The numbers of the robot are those of the TX40 in BIRDy (README.md), which has them about the origins of modified
Denavit-Hartenberg frames. A URDF has fixed angles instead of alpha and theta, and inertias about the centre of mass.
"""

import math
import os

HERE = os.path.dirname(os.path.abspath(__file__))

# Frame j in frame j-1 is RotX(alpha) TransX(a) RotZ(theta) TransZ(d) at q = 0: alpha, theta [rad], a, d [m].
QUARTER = math.pi / 2
FRAMES = [
    (0, 0, 0, 0.32),
    (-QUARTER, -QUARTER, 0, 0),
    (0, QUARTER, 0.225, 0.035),
    (QUARTER, 0, 0, 0.225),
    (-QUARTER, 0, 0, 0),
    (QUARTER, math.pi, 0, 0),
]
# M, MX, MY, MZ, XX, XY, XZ, YY, YZ, ZZ about the origin of the link's frame.
BODIES = [
    (8.61, 0, 0, -0.4305, 0.424, 0, 0, 0.424, 0, 0.352),
    (4.85, 0.392, -7.2e-3, 0.162, 1.63e-2, 7.85e-4, -1.57e-2, 8.81e-2, 3.24e-4, 8.28e-2),
    (4.07, 3.26e-2, 2.44e-2, 0.265, 2.23e-2, -1.95e-4, -1.16e-3, 2.24e-2, -2.22e-3, 4.41e-3),
    (3.62, 1.45e-2, -7.24e-3, -0.586, 0.109, 2.9e-5, 1.35e-3, 0.108, -1.17e-3, 4.07e-3),
    (1.02, 0, -3.06e-3, -1.02e-3, 1.01e-3, 0, 0, 1.00e-3, -3.06e-6, 1.01e-3),
    (0.20, 0, 0, 8.4e-3, 3.53e-3, 0, 0, 3.53e-3, 0, 3.53e-4),
]
FV = (7.9379, 5.6948, 1.9804, 1.1141, 1.60, 0.6894)
FC = (6.9822, 7.8301, 6.1939, 2.4063, 3.4092, 1.8313)
LIMITS = ((-180, 180), (-125, 125), (-138, 138), (-270, 270), (-120, 133.5), (-270, 270))  # deg
SPEEDS = (287, 287, 430, 410, 320, 700)  # deg/s
LINKS = ("shoulder", "arm", "elbow", "forearm", "wrist", "flange")


def text(x, digits=12):
    """Without a negative zero."""
    return f"{x:.{digits}g}" if abs(x) > 1e-15 else "0"


def triple(x, y, z, digits=12):
    return " ".join(text(value, digits) for value in (x, y, z))


def joint(j):
    alpha, theta, a, d = FRAMES[j]
    ca, sa, ct, st = math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta)
    # RotX(alpha) RotZ(theta), row by row, as roll, pitch and yaw.
    rotation = ((ct, -st, 0.0), (ca * st, ca * ct, -sa), (sa * st, sa * ct, ca))
    pitch = math.atan2(-rotation[2][0], math.hypot(rotation[0][0], rotation[1][0]))
    if math.hypot(rotation[0][0], rotation[1][0]) < 1e-9:  # at the pole of the angles roll is free
        roll, yaw = 0.0, math.atan2(-rotation[0][1], rotation[1][1])
    else:
        roll = math.atan2(rotation[2][1], rotation[2][2])
        yaw = math.atan2(rotation[1][0], rotation[0][0])
    low, high = (math.radians(x) for x in LIMITS[j])
    parent = "base" if j == 0 else LINKS[j - 1]
    return f"""  <joint name="joint_{j + 1}" type="revolute">
    <parent link="{parent}"/>
    <child link="{LINKS[j]}"/>
    <origin xyz="{triple(a, -sa * d, ca * d)}" rpy="{triple(roll, pitch, yaw, 17)}"/>
    <axis xyz="0 0 1"/>
    <limit lower="{low:.4f}" upper="{high:.4f}" effort="{(100, 100, 60, 30, 30, 15)[j]}" velocity="{math.radians(SPEEDS[j]):.4f}"/>
    <dynamics damping="{text(FV[j])}" friction="{text(FC[j])}"/>
  </joint>
"""


def link(j):
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = BODIES[j]
    x, y, z = mx / m, my / m, mz / m
    moments = {"ixx": xx - m * (y * y + z * z), "ixy": xy + m * x * y, "ixz": xz + m * x * z,
               "iyy": yy - m * (x * x + z * z), "iyz": yz + m * y * z, "izz": zz - m * (x * x + y * y)}
    inertia = " ".join(f'{name}="{text(value)}"' for name, value in moments.items())
    return f"""  <link name="{LINKS[j]}">
    <inertial>
      <origin xyz="{triple(x, y, z)}" rpy="0 0 0"/>
      <mass value="{text(m)}"/>
      <inertia {inertia}/>
    </inertial>
  </link>
"""


def urdf():
    body = "".join(joint(j) + link(j) for j in range(6))
    return ('<?xml version="1.0"?>\n<!-- Made by make_urdf.py; README.md says where the numbers are from. -->\n'
            f'<robot name="six_axis">\n  <link name="base"/>\n{body}</robot>\n')


def main():
    with open(os.path.join(HERE, "six_axis.urdf"), "w", encoding="ascii") as out:
        out.write(urdf())


if __name__ == "__main__":
    main()
