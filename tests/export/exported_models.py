"""Torques of exported models in Pinocchio, MuJoCo and Drake, beside those of the exported C header.

    python exported_models.py RIVID_IDENTIFY RIVID_SIMULATE SOURCE_DIR REAL_DATA C_COMPILER OUTPUT

The oracle of the models is the C header, which tests/export/c_header_test.cpp compares with the library. Torques are compared
at 200 random states, dry friction and offsets aside, which these programs treat each in its own way. Exit code 77: skipped.
"""

import ctypes
import importlib.util
import subprocess
import sys
from pathlib import Path

SKIPPED = 77
STATES = 200
SEED = 20261122
# Of the largest torque of a joint: both sides sum the same terms in another order, from numbers with all
# digits.
TOLERANCE = 1e-9

try:
    import mujoco
    import numpy as np
    import pinocchio
    import pydrake.multibody.parsing  # noqa: F401
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import MultibodyForces
except ImportError as absent:
    print(f"skipped: {absent}; pip install pin mujoco drake numpy")
    sys.exit(SKIPPED)


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode not in options.pop("allowed", (0,)):
        sys.exit(f"{command}: exit code {done.returncode}\n{done.stderr}")
    return done.stderr


class CHeader:
    """The torques of the exported header, compiled as a shared library."""

    def __init__(self, header, compiler, joints):
        name = header.stem
        source = header.with_suffix(".c")
        arguments = "const double* q, const double* qd, const double* qdd, double* tau"
        source.write_text(
            f'#include "{header.name}"\n'
            f"void rigid({arguments}) {{ {name}_rigid_body(q, qd, qdd, tau); }}\n"
            f"void whole({arguments}) {{ {name}_inverse_dynamics(q, qd, qdd, tau); }}\n"
        )
        library = header.with_suffix(".so")
        run(compiler, "-std=c99", "-O1", "-shared", "-fPIC", "-o", library, source, "-lm")
        self.library = ctypes.CDLL(str(library))
        self.joints = joints

    def __call__(self, function, q, qd, qdd):
        array = ctypes.c_double * self.joints
        tau = array()
        getattr(self.library, function)(array(*q), array(*qd), array(*qdd), tau)
        return np.array(tau)


def module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    out = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(out)
    return out


def drake_torques(plant, joints, states):
    context = plant.CreateDefaultContext()
    places = [plant.GetJointByName(name).velocity_start() for name in joints]
    out = []
    for q, qd, qdd in states:
        plant.SetPositions(context, q)
        plant.SetVelocities(context, qd)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        acceleration = np.zeros(plant.num_velocities())
        acceleration[places] = qdd
        out.append(plant.CalcInverseDynamics(context, acceleration, forces)[places])
    return out


def mujoco_torques(file, joints, states, dry_friction):
    model = mujoco.MjModel.from_xml_path(str(file))
    if not dry_friction:
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    data = mujoco.MjData(model)
    # They are named as in the URDF, and in its order.
    assert [model.joint(j).name for j in range(model.njnt)] == joints
    assert [model.actuator(j).name for j in range(model.nu)] == joints
    out = []
    for q, qd, qdd in states:
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        out.append(data.qfrc_inverse.copy())
    return out


class Comparison:
    def __init__(self):
        self.failed = False

    def expect(self, what, torques, expected, tolerance=TOLERANCE):
        expected = np.array(expected)
        error = np.abs(np.array(torques) - expected).max() / np.abs(expected).max()
        good = bool(error <= tolerance)
        self.failed |= not good
        print(f"{'ok  ' if good else 'FAIL'} {what}: {error:.1e} of the largest torque")


def compare(identify, compiler, result, robot, comparison):
    for target in ("urdf", "mjcf", "sdf", "drake", "pinocchio", "header"):
        run(identify, "export", result, "--to", target)
    at = result / f"{robot}_identified"
    pin = module(at.with_name(at.name + "_pinocchio.py"))
    joints = pin.JOINTS
    count = len(joints)
    header = CHeader(at.with_suffix(".h"), compiler, count)

    model = pin.load()
    random = np.random.default_rng(SEED)
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    states = [
        (random.uniform(lower, upper), random.uniform(-2, 2, count), random.uniform(-5, 5, count))
        for _ in range(STATES)
    ]
    rigid = [header("rigid", *state) for state in states]
    whole = [header("whole", *state) for state in states]
    damping = module(at.with_name(at.name + "_drake.py")).DAMPING
    viscous = [tau + np.multiply(damping, qd) for tau, (_, qd, _) in zip(rigid, states)]

    data = model.createData()
    comparison.expect(f"{robot} pinocchio.rnea", [pinocchio.rnea(model, data, *s) for s in states], rigid)
    comparison.expect(
        f"{robot} pinocchio with friction", [pin.inverse_dynamics(model, data, *s) for s in states], whole
    )

    mjcf = at.with_suffix(".xml")
    comparison.expect(f"{robot} MuJoCo without dry friction", mujoco_torques(mjcf, joints, states, False), viscous)
    # Away from reversals MuJoCo's dry friction is that of the law.
    fast = [(q, np.where(np.abs(qd) < 0.1, 0.1, qd), qdd) for q, qd, qdd in states]
    dry = module(at.with_name(at.name + "_pinocchio.py"))
    offset = dry.friction(np.full(count, 1e-300))  # what is left of friction as the speed vanishes: Fc and offset
    reverse = dry.friction(np.full(count, -1e-300))
    asymmetry = 0.5 * (offset + reverse)
    expected = [header("whole", *state) - asymmetry for state in fast]
    comparison.expect(f"{robot} MuJoCo with dry friction", mujoco_torques(mjcf, joints, fast, True), expected, 1e-6)

    drake = module(at.with_name(at.name + "_drake.py"))
    plant = MultibodyPlant(0.0)
    drake.load(plant)
    plant.Finalize()
    torques = drake_torques(plant, joints, states)
    comparison.expect(f"{robot} Drake without dry friction", torques, viscous)
    added = [tau + drake.friction_left_out(s[1], load) for tau, s, load in zip(torques, states, rigid)]
    comparison.expect(f"{robot} Drake with friction", added, whole)

    plant = MultibodyPlant(0.0)
    pydrake.multibody.parsing.Parser(plant).AddModels(str(at.with_suffix(".sdf")))
    plant.mutable_gravity_field().set_gravity_vector(drake.GRAVITY)  # Drake does not read that of a world
    plant.Finalize()
    comparison.expect(f"{robot} SDF in Drake", drake_torques(plant, joints, states), viscous)

    plain = pinocchio.buildModelFromUrdf(str(at.with_suffix(".urdf")))
    plain.gravity.linear = np.array(drake.GRAVITY)
    plain.armature = model.armature
    data = plain.createData()
    comparison.expect(f"{robot} URDF", [pinocchio.rnea(plain, data, *s) for s in states], rigid)


def main(identify, simulate, source, real, compiler, output):
    identify, simulate, source, output = (Path(p).resolve() for p in (identify, simulate, source, output))
    output.mkdir(parents=True, exist_ok=True)
    comparison = Comparison()
    robots = {"six_axis": source / "data/six_axis/six_axis.toml"}
    for robot in ("ur10e", "panda"):
        if real and (Path(real) / robot).is_dir():
            robots[robot] = source / f"tests/real/{robot}.toml"
        else:
            print(f"skipped: no logs of the {robot} in RIVID_REAL_DATA")
    for robot, experiment in robots.items():
        result = output / f"{robot}_result"
        options = ["--physical", "--quiet", "--output", result]
        if robot == "six_axis":
            run(simulate, source / "data/six_axis/simulate.toml", "--quiet", "--output", output / "made")
            options += ["--method", "wls", "--set", "signal.cutoff_hz=20", "--log", output / "made/log.csv"]
        else:
            # Their experiment files name logs relative to the folder of the data.
            (output / robot).unlink(missing_ok=True)
            (output / robot).symlink_to((Path(real) / robot).resolve())
            (output / experiment.name).write_text(experiment.read_text())
            experiment = output / experiment.name
        run(identify, experiment, *options, cwd=output)
        compare(identify, compiler, result, robot, comparison)
    return 1 if comparison.failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
