"""Designs for twenty arms with the meshes of their links, a tool, floor, wall and table: distances by two other libraries.

Descriptions are those of the package example-robot-data, each with a cylinder as tool behind its tip. The finished motion is sampled
2000 times; frames are Pinocchio's, distances those of Coal (the further FCL) and of MuJoCo, of convex hulls, of all pairs that
the design says it keeps. Printed of each arm: joints, pairs, seeds that gave a motion, the smallest distance by either beyond the clearance
that is asked for, the largest difference of the plan's distances from theirs, the worst loss of log det that was reported behind
the search, and the most processor seconds of a seed, beside those without bodies.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data mujoco
    venv/bin/python benchmarks/excite_meshes.py build/test/apps/rivid [--seeds N] [--clearance M] [ARM ...]
"""

import argparse
import json
import pathlib
import re
import resource
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree

import coal
import mujoco
import numpy as np
import pinocchio as pin

from excite_arms import LIMITS, NAMES, Arm
from robot_data_arms import ROBOTS

SAMPLES = 2000
SHARE = ROBOTS.parents[1]


def with_tool(arm, folder):
    """The description with a tool behind its last link and meshes by their paths."""
    tree = ElementTree.parse(arm.urdf)
    root = tree.getroot()
    for mesh in root.iter("mesh"):
        mesh.set("filename", mesh.get("filename").replace("package:/", str(SHARE)))
    last = next(joint for joint in root.findall("joint") if joint.get("name") == arm.joints[-1])
    # Along the last axis, away from the link before.
    frame = pin.buildModelFromUrdf(str(arm.urdf))
    place = frame.jointPlacements[frame.getJointId(arm.joints[-1])]
    axis = np.array(list(map(float, last.find("axis").get("xyz").split())))
    axis *= -1.0 if axis @ place.rotation.T @ place.translation < -1e-6 else 1.0
    w = np.linalg.norm(axis)
    roll, pitch, yaw = pin.rpy.matrixToRpy(pin.Quaternion.FromTwoVectors(np.array([0, 0, 1.0]), axis / w).matrix())
    tool = f"""<robot><link name="a_tool"><collision><origin xyz="0 0 0.05"/><geometry><cylinder radius="0.02" length="0.1"/></geometry>
        </collision></link><joint name="a_flange" type="fixed"><origin rpy="{roll} {pitch} {yaw}"/>
        <parent link="{arm.tip or last.find("child").get("link")}"/><child link="a_tool"/></joint></robot>"""
    root.extend(ElementTree.fromstring(tool))
    arm.urdf = folder / "arm.urdf"
    tree.write(arm.urdf)


def owners(arm):
    """Of each link of the description the link of the chain that it is fixed to; other joints stand at 0."""
    joints = {j.find("child").get("link"): j for j in ElementTree.parse(arm.urdf).getroot().findall("joint")}
    of_chain = {name: joint for joint in joints.values() for name in [joint.get("name")] if name in arm.joints}
    links = [link.get("name") for link in ElementTree.parse(arm.urdf).getroot().findall("link")]
    base = arm.base or next(link for link in links if link not in joints)
    out = {}
    for link in [*joints, base]:
        at = link
        while at != base and at in joints and joints[at].get("name") not in of_chain:
            at = joints[at].find("parent").get("link")
        if at == base or at in joints and joints[at].get("name") in of_chain:
            out[link] = at
    return base, out


class Solids:
    """Shapes for both libraries, each {owner, number of the joint, pose at it}."""

    def __init__(self):
        self.spec, self.all = mujoco.MjSpec(), []

    def add(self, owner, joint, place, shape, scale=np.ones(3)):
        geom = self.spec.worldbody.add_geom()
        if isinstance(shape, coal.Box):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, shape.halfSide
        elif isinstance(shape, coal.Sphere):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [shape.radius, 0, 0]
        elif isinstance(shape, coal.Cylinder):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, [shape.radius, shape.halfLength, 0]
        else:
            shape.buildConvexHull(True, "Qt")
            mesh = self.spec.add_mesh(name=f"m{len(self.all)}")
            mesh.uservert = np.array(shape.vertices()).reshape(-1).tolist()
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, mesh.name
            shape = shape.convex
        self.all.append((owner, joint, place, shape))

    def compiled(self):
        self.model = self.spec.compile()
        self.data = mujoco.MjData(self.model)
        self.inner = []
        for k in range(len(self.all)):
            mesh, inner = self.model.geom_dataid[k], pin.SE3.Identity()
            if mesh >= 0:
                w, *v = self.model.mesh_quat[mesh]
                inner = pin.SE3(pin.Quaternion(w, *v), self.model.mesh_pos[mesh])
            self.inner.append(inner)

    def nearest(self, placed, pairs):
        """Of pairs of owners the smallest distances, by Coal and by MuJoCo."""
        for k, pose in enumerate(placed):
            at = pose * self.inner[k]
            self.data.geom_xpos[k], self.data.geom_xmat[k] = at.translation, at.rotation.reshape(-1)
        request, far = coal.DistanceRequest(), 0.3
        for pair, combinations in pairs.items():
            for i, k in combinations:
                a, b = (coal.Transform3s(placed[m].rotation, placed[m].translation) for m in (i, k))
                by_coal = coal.distance(self.all[i][3], a, self.all[k][3], b, request, coal.DistanceResult())
                by_mujoco = mujoco.mj_geomDistance(self.model, self.data, i, k, far, None) if by_coal < 0.2 else by_coal
                self.least[pair] = np.minimum(self.least.get(pair, np.inf), [by_coal, by_mujoco])


class Cell:
    def __init__(self, name, folder, clearance=0.03):
        self.clearance = clearance
        self.arm = arm = Arm(name)
        # A gripper's effort is as large as its friction.
        arm.limits["torque"] = np.where(0.8 * arm.limits["torque"] > arm.friction, arm.limits["torque"], LIMITS["torque"])
        with_tool(arm, folder)
        self.base, owner = owners(arm)
        self.model = pin.buildModelFromUrdf(str(arm.urdf))
        geometry = pin.buildGeomFromUrdf(self.model, str(arm.urdf), pin.GeometryType.COLLISION)
        self.data = self.model.createData()
        frame = lambda link: self.data.oMf[self.model.getFrameId(link, pin.FrameType.BODY)]
        pin.framesForwardKinematics(self.model, self.data, pin.neutral(self.model))
        self.root = frame(self.base).copy()
        second = self.data.oMi[self.model.getJointId(arm.joints[1])].translation
        shoulder, reach, random = self.root.actInv(second), 0.0, np.random.default_rng(1)
        for _ in range(200):
            pin.framesForwardKinematics(self.model, self.data, self.full(random.uniform(-3, 3, arm.n)))
            reach = max(reach, np.linalg.norm(self.root.actInv(frame("a_tool").translation) - shoulder))
        down = arm.gravity / np.linalg.norm(arm.gravity)
        # Standing arms have a socket; others hang on a trunk.
        low = -0.1 * reach if not arm.tip or name == "panda" else float(shoulder @ -down) - 0.6 * reach
        self.half_spaces = {"floor": (-down, low)}
        side = np.eye(3)[int(np.argmin(np.abs(down)))]
        self.half_spaces["wall"] = (side, float(side @ shoulder) - 0.7 * reach)
        third = np.cross(down, side)
        middle = shoulder + 0.7 * reach * side
        middle = middle + down * (float(middle @ -down) - low - 0.1 * reach)
        half = np.abs(0.2 * reach * side) + np.abs(0.4 * reach * third) + np.abs(0.1 * reach * down)
        self.table = (middle - half, middle + half)
        self.solids = Solids()
        for item in geometry.geometryObjects:
            link = self.model.frames[item.parentFrame].name
            if link in owner:
                shape = item.geometry
                self.solids.add(owner[link], item.parentJoint, item.placement, shape)
        thick = 1.0
        for what, (normal, offset) in self.half_spaces.items():
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0, 1]), normal).matrix()
            self.solids.add(what, None, pin.SE3(turn, normal * (offset - thick)), coal.Box(8.0, 8.0, 2 * thick))
        self.solids.add("table", None, pin.SE3(np.eye(3), middle), coal.Box(*(2 * half)))
        self.solids.compiled()

    def full(self, q):
        out = pin.neutral(self.model)
        for name, x in zip(self.arm.joints, q):
            joint = self.model.joints[self.model.getJointId(name)]
            out[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(x), np.sin(x)] if joint.nq == 2 else x
        return out

    def experiment(self, bodies):
        arm = self.arm
        lists = lambda values: json.dumps([float(v) for v in values])
        text = arm.experiment()
        if not bodies:
            return text
        text += f"[excitation.space]\nclearance = {self.clearance}\nhalf_spaces = [" + ", ".join(
            f'{{ name = "{name}", normal = {lists(normal)}, offset = {float(offset)!r} }}' for name, (normal, offset) in self.half_spaces.items()
        )
        return text + f']\nboxes = [{{ name = "table", min = {lists(self.table[0])}, max = {lists(self.table[1])} }}]\n'

    def distances(self, plan):
        """{pair: by Coal, by MuJoCo} over the motion."""
        kept = [(c["first"], c["second"]) for c in plan["clearances"] if c["wanted"] is not None]
        of = lambda owner: [k for k, solid in enumerate(self.solids.all) if solid[0] == owner]
        pairs = {(a, b): [(i, k) for i in of(a) for k in of(b)] for a, b in kept}
        self.solids.least = {}
        series = {key: np.array(plan["motion"][key]) for key in ("A", "B", "q0")}
        t = np.linspace(0, plan["motion"]["duration"], SAMPLES + 1)
        w = plan["motion"]["omega_f"] * np.arange(1, series["A"].shape[1] + 1)
        q = series["q0"] + (np.sin(np.outer(t, w)) / w) @ series["A"].T - (np.cos(np.outer(t, w)) / w) @ series["B"].T
        for k in range(len(t)):
            pin.forwardKinematics(self.model, self.data, self.full(q[k]))
            placed = [
                self.root * place if joint is None else self.data.oMi[joint] * place for _, joint, place, _ in self.solids.all
            ]
            self.solids.nearest(placed, pairs)
        return self.solids.least


def design(program, cell, seed, bodies, folder):
    file, plan = folder / "arm.toml", folder / "plan"
    file.write_text(cell.experiment(bodies))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [program, "excite", file, "--threads", "1", "--seed", str(seed), "--quiet", "--output", plan]
    done = subprocess.run(command, capture_output=True, text=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return None if done.returncode else json.loads((plan / "plan.json").read_text()), done.stderr.strip(), seconds


def row_of(program, name, seeds, clearance, folder):
    cell = Cell(name, folder, clearance)
    plans, beyond, apart, lost, times, free, faults = [], [], [], [0.0], [], [], []
    for seed in range(1, seeds + 1):
        free.append(design(program, cell, seed, False, folder)[2])
        plan, fault, seconds = design(program, cell, seed, True, folder)
        times.append(seconds)
        if plan is None:
            faults.append(f"seed {seed}: {fault}")
            continue
        plans.append(plan)
        found = cell.distances(plan)
        # Links without a shape have none in other libraries: the plan says of which it assumes one.
        assumed = " ".join(said["text"] for said in plan["warnings"] if said["code"] == "body_assumed")
        shaped = {solid[0] for solid in cell.solids.all}
        bare = {(c["first"], c["second"]) for c in plan["clearances"] if not {c["first"], c["second"]} <= shaped}
        assert all(link in shaped or link in assumed for pair in bare for link in pair), bare
        for use in plan["clearances"]:
            if (use["first"], use["second"]) in bare:
                continue
            if use["wanted"] is not None:
                both = found[use["first"], use["second"]]
                beyond.append(min(both) - use["wanted"])
                if use["distance"] < 0.2:
                    apart.append(np.abs(both - use["distance"]).max())
        for said in plan["warnings"]:
            if said["code"] == "polishing_lost":
                best, kept = map(float, re.findall(r"(?:came to|instants) (-?[\d.]+)", said["text"]))
                lost.append(best - kept)
    least = f"{1e3 * min(beyond):.2f} | {1e3 * max(apart, default=0):.2f}" if beyond else " | "
    return (
        f"| {name} | {cell.arm.n} | {len(beyond) / max(len(plans), 1):.0f} | {len(plans)} of {seeds} | {least} | {max(lost):.1f} "
        f"| {max(free):.0f}, {max(times):.0f} | {'; '.join(faults)} |"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("arms", nargs="*", default=NAMES)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--clearance", type=float, default=0.03, help="[m]")
    asked = parser.parse_intermixed_args()
    print("| arm | joints | pairs | seeds | least distance beyond asked, mm | apart, mm | nats lost | CPU s without, with bodies | |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in asked.arms:
        with tempfile.TemporaryDirectory() as folder:
            print(row_of(asked.program, name, asked.seeds, asked.clearance, pathlib.Path(folder)), flush=True)


if __name__ == "__main__":
    main()
