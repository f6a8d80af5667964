"""ROS 2: a controller of trajectories plays, its joint states are recorded."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from rivid._rivid import InputError
from rivid.play.motion import Path, State

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rivid.types import Floats

_POINTS_HZ = 50.0  # the controller's own polynomials lie between
_PATIENCE = 10.0  # s, for a server to answer
_SILENCE = 0.1  # s, without a state
_LEAD = 0.5  # s from the goal to its first point


class RosArm:
    """Any robot under a ``joint_trajectory_controller``, whose states hold efforts."""

    effort = "tau"

    def __init__(
        self, joints: Sequence[str], *, controller: str = "joint_trajectory_controller", states: str = "joint_states", node: Any = None
    ) -> None:
        import rclpy
        from control_msgs.action import FollowJointTrajectory
        from rclpy.action import ActionClient
        from sensor_msgs.msg import JointState

        if node is None and not rclpy.ok():
            rclpy.init()
        self._rclpy, self._action = rclpy, FollowJointTrajectory
        self._node = node if node is not None else rclpy.create_node("rivid_play")
        self._joints = list(joints)
        self._client = ActionClient(self._node, FollowJointTrajectory, f"{controller}/follow_joint_trajectory")
        self._newest: Any = None
        self._node.create_subscription(JointState, states, self._take, 100)

    def position(self) -> Floats:
        """Where it stands."""
        return self._measured()[1]

    def begin(self, path: Path, speed: float) -> None:
        """Sends the trajectory, at so many times the speed."""
        from rclpy.duration import Duration
        from trajectory_msgs.msg import JointTrajectoryPoint

        if not self._client.wait_for_server(timeout_sec=_PATIENCE):
            raise TimeoutError(f"no controller serves {self._client._action_name}")
        self._path, self._speed = path, speed
        goal = self._action.Goal()
        goal.trajectory.joint_names = self._joints
        count = math.ceil(path.duration / speed * _POINTS_HZ)
        for k in range(count + 1):
            q, qd, qdd = path.at(path.duration * k / count)
            point = JointTrajectoryPoint()
            point.positions, point.velocities = q.tolist(), (speed * qd).tolist()
            point.accelerations = (speed**2 * qdd).tolist()
            point.time_from_start = Duration(seconds=path.duration / speed * k / count).to_msg()
            goal.trajectory.points.append(point)
        begin = self._node.get_clock().now() + Duration(seconds=_LEAD)
        goal.trajectory.header.stamp = begin.to_msg()
        self._begin = begin.nanoseconds * 1e-9
        sent = self._client.send_goal_async(goal)
        self._rclpy.spin_until_future_complete(self._node, sent, timeout_sec=_PATIENCE)
        self._goal = sent.result()
        if self._goal is None or not self._goal.accepted:
            raise OSError("the controller does not accept the trajectory; its log says why")
        self._result = self._goal.get_result_async()

    def step(self) -> State | None:
        """Waits for the next joint states; None once the controller has ended."""
        t, q, qd, effort = self._measured()
        if self._result.done():
            return None
        s = min(max((t - self._begin) * self._speed, 0.0), self._path.duration)
        told, told_v, told_a = self._path.at(s)
        moving = 0.0 < s < self._path.duration
        return State(t, q, qd, effort, s, (told, moving * self._speed * told_v, moving * self._speed**2 * told_a))

    def stop(self) -> None:
        """Cancels the goal: the controller then stops as it is configured to."""
        self._goal.cancel_goal_async()

    def _take(self, message: Any) -> None:
        self._newest = message

    def _measured(self) -> tuple[float, Floats, Floats, Floats]:
        self._newest = None
        begin, patience = time.monotonic(), _SILENCE if hasattr(self, "_goal") else _PATIENCE
        while self._newest is None:
            if time.monotonic() - begin > patience:
                if hasattr(self, "_goal"):
                    self.stop()
                raise TimeoutError(f"no joint states for {patience:g} s")
            self._rclpy.spin_once(self._node, timeout_sec=0.01)
        message = self._newest
        missing = [name for name in self._joints if name not in message.name]
        if missing:
            raise InputError(f"joint states have no {missing[0]!r}, but {', '.join(message.name)}")
        at = [message.name.index(name) for name in self._joints]
        for what in ("velocity", "effort"):
            if len(getattr(message, what)) != len(message.name):
                raise InputError(f"joint states have {len(getattr(message, what))} values of {what}, must have {len(message.name)}")
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        return (stamp, *(np.array(values)[at] for values in (message.position, message.velocity, message.effort)))
