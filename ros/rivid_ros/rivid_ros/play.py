"""ros2 run rivid_ros play --ros-args -p plan:=PLAN: plays the motion of a plan at a tenth of its speed, at half, at its own."""

from __future__ import annotations

import rclpy
from rivid import Experiment
from rivid.play import play
from rivid.play.ros import RosArm


def main() -> int:
    """Runs the node until the motion is played or stopped; the exit code is 1 where it was stopped."""
    rclpy.init()
    node = rclpy.create_node("rivid_play")
    try:
        value = lambda name, default: node.declare_parameter(name, default).value
        plan = value("plan", "plan")
        robot = Experiment(f"{plan}/experiment.toml").robot
        controller, states = value("controller", "joint_trajectory_controller"), value("joint_states", "joint_states")
        arm = RosArm(robot.joints, controller=controller, states=states, node=node)
        runs = play(plan, arm, speeds=value("speeds", [0.1, 0.5, 1.0]), tracking=value("tracking", 0.1), force=value("force", False))
        for run in runs:
            node.get_logger().info(str(run))
        return int(runs[-1].stopped is not None)
    finally:
        node.destroy_node()
        rclpy.shutdown()
