"""Players' files of rivid_excite, read by other programs than ours.

joint_trajectory.yaml by PyYAML, interpolated as joint_trajectory_controller does; motion.script by an interpreter of the part of
URScript that it may use; libfranka.csv against the checks of libfranka. All must be the motion of motion.csv.

    python players.py RIVID_EXCITE SOURCE_DIR OUTPUT

Exit code 77: PyYAML is missing, all else was checked.
"""

import csv
import math
import re
import subprocess
import sys
from pathlib import Path

try:
    import yaml
except ImportError:
    yaml = None

SKIPPED = 77
# Polynomials of fifth degree between points, and twelve decimals.
POSITION_TOLERANCE = 1e-6  # rad
REST_TOLERANCE = 1e-9


def design(excite, experiment, folder, *options):
    command = [excite, experiment, "--output", folder, "--quiet", "--starts", "1", "--set", "excitation.evaluations=40", *options]
    subprocess.run([str(word) for word in command], check=True)


class Table:
    """The columns of a CSV file, and those of all joints together, one list a row."""

    def __init__(self, file):
        with file.open(newline="") as text:
            header, *rows = csv.reader(text)
        self.columns = {name: [float(row[i]) for row in rows] for i, name in enumerate(header)}

    def __getitem__(self, name):
        return self.columns[name]

    def of_joints(self, name, joints):
        return [list(row) for row in zip(*(self.columns[f"{name}{j + 1}"] for j in range(joints)))]


def largest(values):
    return max((abs(value) for value in values), default=0.0)


def difference(a, b):
    return largest(x - y for x, y in zip(a, b, strict=True))


def quintic(t, T, a, b):
    """Position at t of 0 … T from and to (q, q̇, q̈): the polynomial of fifth degree that ROS 2's controller takes."""
    u = t / T
    s = u**3 * (10 - 15 * u + 6 * u**2)
    before = t * (1 - u) ** 3 * (1 + 3 * u)
    after = (t - T) * u**3 * (1 + 3 * (1 - u))
    return ((1 - s) * a[0] + before * a[1] + 0.5 * t**2 * (1 - u) ** 3 * a[2]
            + s * b[0] + after * b[1] + 0.5 * (t - T) ** 2 * u**3 * b[2])


def check_trajectory(file, motion, joints, names):
    message = yaml.safe_load(file.read_text())
    assert set(message) == {"joint_names", "points"}, set(message)
    assert message["joint_names"] == names, message["joint_names"]
    keys = ("positions", "velocities", "accelerations")
    points = message["points"]
    for point in points:
        assert set(point) == {*keys, "time_from_start"}, set(point)
        assert set(point["time_from_start"]) == {"sec", "nanosec"}
        assert 0 <= point["time_from_start"]["nanosec"] < 10**9
        assert all(len(point[key]) == joints for key in keys)
    at = [point["time_from_start"]["sec"] + 1e-9 * point["time_from_start"]["nanosec"] for point in points]
    assert at[0] == 0 and all(a < b for a, b in zip(at, at[1:])) and abs(at[-1] - motion["t"][-1]) < 1e-9
    for end in (points[0], points[-1]):
        assert largest(end["velocities"] + end["accelerations"]) < REST_TOLERANCE, "no rest"
    q = motion.of_joints("q", joints)
    worst = 0.0
    k = 0
    for t, expected in zip(motion["t"], q):
        while k + 2 < len(at) and t > at[k + 1]:
            k += 1
        made = [quintic(t - at[k], at[k + 1] - at[k], [points[k][key][j] for key in keys], [points[k + 1][key][j] for key in keys])
                for j in range(joints)]
        worst = max(worst, difference(made, expected))
    assert worst < POSITION_TOLERANCE, worst
    print(f"{file.name}: {len(points)} points, {worst:.1e} rad from the motion between them")


NUMBER = r"-?\d+(?:\.\d+)?"
EXPRESSION = r"[\w\s.+\-*/()\[\],]+"
GRAMMAR = [
    (r"def (\w+)\(\):$", "open"),
    (r"while (\w+) < (\w+):$", "open"),
    (r"if (\w+) > (\w+):$", "open"),
    (r"end$", "close"),
    (rf"(\w+) = \[{NUMBER}(?:, {NUMBER})*\]$", "line"),
    (rf"(\w+(?:\[\w+\])?) = {EXPRESSION}$", "line"),
    (rf"(movej|servoj|stopj)\({EXPRESSION}(?:, \w+={NUMBER}|, \w+=\w+)*\)$", "line"),
]


def run_urscript(text, functions):
    """Runs a program of one function: its grammar is checked line by line, then it is one of Python."""
    out = []
    depth = 0
    name = None
    for line in text.splitlines():
        code = line.strip()
        if not code or code.startswith("#"):
            continue
        assert code.isascii(), code
        kind = next((kind for pattern, kind in GRAMMAR if re.match(pattern, code)), None)
        assert kind is not None, f"no URScript: {code}"
        depth -= kind == "close"
        assert depth >= (0 if kind != "line" else 1), code
        assert line.startswith("  " * depth) and not line.startswith("  " * depth + " "), f"indentation: {line}"
        if kind != "close":
            out.append(line)
        if code.startswith("def "):
            assert name is None, "one function"
            name = re.match(r"def (\w+)", code)[1]
        depth += kind == "open"
    assert depth == 0, "an end is missing"
    scope = dict(functions)
    exec("\n".join(out), scope)  # noqa: S102 - the grammar above leaves nothing but arithmetic
    scope[name]()


def check_urscript(file, motion, joints):
    step = 0.002
    rows = round(step / (motion["t"][1] - motion["t"][0]))  # of the motion for each call
    served = []
    moved = []
    stopped = []

    def servoj(q, t, lookahead_time, gain):
        assert t == step and 0.03 <= lookahead_time <= 0.2 and 100 <= gain <= 2000
        served.append(list(q))

    def movej(q, a, v):
        assert not served and a > 0 and v > 0
        moved.append(q)

    run_urscript(file.read_text(), {"servoj": servoj, "movej": movej, "stopj": stopped.append, "sin": math.sin,
                                    "cos": math.cos, "get_steptime": lambda: step})
    q = motion.of_joints("q", joints)
    assert len(moved) == len(stopped) == 1
    assert difference(moved[0], q[0]) < REST_TOLERANCE
    assert abs(len(served) * step - motion["t"][-1]) < step
    worst = max(difference(sent, expected) for sent, expected in zip(served, q[rows::rows]))
    assert worst < POSITION_TOLERANCE, worst
    print(f"{file.name}: {len(served)} calls of servoj, {worst:.1e} rad from the motion")


def check_libfranka(file, limits):
    """@param limits  velocities, accelerations and jerks, one a joint"""
    table = Table(file)
    assert difference(table["t"], [k / 1000 for k in range(len(table["t"]))]) < 1e-12
    q, qd, qdd = (table.of_joints(name, 7) for name in ("q", "qd", "qdd"))
    for end in (0, -1):
        assert largest(qd[end] + qdd[end]) < REST_TOLERANCE, "no rest"
    # libfranka differentiates the positions that it is sent, the rest before and after included. Twelve
    # decimals make errors of up to 8 · 5e-13 · 1e9 in the third difference.
    sent = [q[0]] * 4 + q + [q[-1]] * 4
    for order, limit in enumerate(limits):
        sent = [[1000 * (b - a) for a, b in zip(*rows)] for rows in zip(sent, sent[1:])]
        for j in range(7):
            worst = largest(row[j] for row in sent)
            assert worst <= limit[j] + 0.005, f"derivative {order + 1} of joint {j + 1} is {worst} of {limit[j]}"
    for k in range(1, len(q) - 1):
        assert difference([500 * (b - a) for a, b in zip(q[k - 1], q[k + 1])], qd[k]) < 1e-3, "q and qd do not belong together"
    jerks = max(largest(row) for row in sent)
    print(f"{file.name}: {len(q)} rows, largest jerk {jerks:.1f} rad/s³")


ACCELERATION = [12, 6, 8, 10, 12, 16, 16]  # rad/s²
JERK = [12, 10, 12, 15, 18, 20, 20]  # rad/s³, which the design reaches
SEVEN = """<robot name="seven"><link name="base"/>{}</robot>"""
JOINT = """<link name="l{n}"><inertial><origin xyz="0.01 0.02 0.1"/><mass value="{m}"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="j{n}" type="revolute"><parent link="{parent}"/><child link="l{n}"/><origin xyz="0 {y} 0.15" rpy="{turn} 0 0"/>
<axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" velocity="2" effort="{effort}"/></joint>"""


def seven_joints(folder):
    joints = [JOINT.format(n=n, m=3.0 - 0.3 * n, parent=f"l{n - 1}" if n > 1 else "base", y=0.1 * (n % 2),
                           turn=(-1) ** n * 1.57, effort=90 if n < 5 else 15) for n in range(1, 8)]
    (folder / "seven.urdf").write_text(SEVEN.format("".join(joints)))
    (folder / "seven.toml").write_text('[robot]\nurdf = "seven.urdf"\ngravity = [0, 0, -9.81]\nfriction = "symmetric"\n'
                                       "[excitation]\nduration = 8\nrate_hz = 1000\n[excitation.limits]\n"
                                       f"acceleration = {ACCELERATION}\njerk = {JERK}\n")


def main():
    excite, source, work = Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])
    work.mkdir(parents=True, exist_ok=True)
    design(excite, source / "data/six_axis/excite.toml", work / "six", "--player", "ros", "--player", "urscript")
    motion = Table(work / "six/motion.csv")
    check_urscript(work / "six/motion.script", motion, 6)
    design(excite, source / "data/six_axis/excite.toml", work / "led", "--player", "ros", "--player", "urscript",
           "--set", "excitation.rate_hz=500", "--set", "excitation.lead_from=[1.0, -0.5, 0.8, 0.0, 1.0, -2.0]")
    led = Table(work / "led/motion.csv")
    assert led["t"][-1] > motion["t"][-1] + 1 and led.of_joints("q", 6)[0] == [1.0, -0.5, 0.8, 0.0, 1.0, -2.0]
    check_urscript(work / "led/motion.script", led, 6)
    seven_joints(work)
    for folder, options in (("seven", []), ("seven_led", ["--set", "excitation.lead_from=[1, -1, 0.5, 0, 0, 1, 2]"])):
        design(excite, work / "seven.toml", work / folder, "--player", "libfranka", *options)
        check_libfranka(work / folder / "libfranka.csv", [[2] * 7, ACCELERATION, JERK])
    if yaml is None:
        print("skipped: joint_trajectory.yaml was not read; pip install pyyaml")
        sys.exit(SKIPPED)
    for folder, table in (("six", motion), ("led", led)):
        check_trajectory(work / folder / "joint_trajectory.yaml", table, 6, [f"joint_{j}" for j in range(1, 7)])


if __name__ == "__main__":
    main()
