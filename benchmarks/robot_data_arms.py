"""Arms of the package example-robot-data, for the benchmarks that use them: description, base link, tip link."""

import pathlib

import pinocchio as pin

# Both packages share one prefix.
ROBOTS = pathlib.Path(pin.__file__).parents[4] / "share/example-robot-data/robots"
ARMS = {  # no links where the robot is a single chain
    "z1": ("z1_description/urdf/z1.urdf", None, None),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", None, None),
    "so100": ("so_arm_description/urdf/so100.urdf", None, None),
    "so101": ("so_arm_description/urdf/so101.urdf", None, None),
    "kinova": ("kinova_description/robots/kinova.urdf", None, None),
    "panda": ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand"),
    "ur3": ("ur_description/urdf/ur3_robot.urdf", None, None),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", None, None),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", None, None),
    "talos arm": ("talos_data/robots/talos_left_arm.urdf", None, None),
    "tiago": ("tiago_description/robots/tiago.urdf", "torso_fixed_link", "arm_7_link"),
    "tiago right": ("tiago_description/robots/tiago_dual.urdf", "torso_fixed_link", "arm_right_7_link"),
    "tiago pro": ("tiago_pro_description/robots/tiago_pro.urdf", "torso_lift_link", "arm_right_7_link"),
    "baxter arm": ("baxter_description/urdf/baxter.urdf", "torso", "left_wrist"),
    "pr2 arm": ("pr2_description/urdf/pr2.urdf", "torso_lift_link", "r_gripper_palm_link"),
    "g1 arm": ("g1_description/urdf/g1_29dof_rev_1_0.urdf", "torso_link", "left_wrist_yaw_link"),
    "romeo": ("romeo_description/urdf/romeo.urdf", "torso", "l_wrist"),
    "icub": ("icub_description/robots/icub.urdf", "chest", "l_hand"),
    "centauro": ("centauro_description/urdf/centauro.urdf", "torso_2", "arm1_6"),
    "alex": ("alex_description/urdf/alex_nub_hands.urdf", "Torso", "LeftWristRollLink"),
    "two joints": ("asr_twodof_description/urdf/TwoDofs.urdf", None, None),
    "go2 leg": ("go2_description/urdf/go2.urdf", "base", "FL_foot"),
}


def description(name):
    """The URDF of an arm by name or path, and the links that the chain is between."""
    if name.endswith(".urdf"):
        return pathlib.Path(name).resolve(), None, None
    file, base, tip = ARMS[name]
    return ROBOTS / file, base, tip


def chain(model, base, tip):
    """Of a robot's model the joints between two links; all where no link is named."""
    if not tip:
        return model
    joint = model.frames[model.getFrameId(tip)].parentJoint
    stop = model.frames[model.getFrameId(base)].parentJoint
    kept = []
    while joint not in (stop, 0):
        kept.append(joint)
        joint = model.parents[joint]
    others = [j for j in range(1, model.njoints) if j not in kept]
    return pin.buildReducedModel(model, others, pin.neutral(model))
