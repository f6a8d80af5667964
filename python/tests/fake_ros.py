"""rclpy and messages, as far as players of trajectories use them: types are those of the message definitions, time is counted."""

import sys
import types

import numpy as np
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.base import Nodetype
from scipy.interpolate import CubicHermiteSpline

STORE = get_typestore(Stores.ROS2_HUMBLE)
STRINGS = ("string",)


class Message:
    """Fields as the definition has them, and of their types, as the messages of rclpy insist."""

    kind = ""

    def __init__(self):
        for name, field in STORE.fielddefs[self.kind][1]:
            object.__setattr__(self, name, default(field))

    def __setattr__(self, name, value):
        field = dict(STORE.fielddefs[self.kind][1])[name]
        what, definition = field
        if what == Nodetype.NAME:
            assert isinstance(value, Message) and value.kind == definition
        elif what == Nodetype.BASE:
            assert isinstance(value, python_type(definition[0]))
        else:
            assert isinstance(value, list) and all(isinstance(x, python_type(definition[0][1][0])) for x in value)
        object.__setattr__(self, name, value)

    def plain(self):
        """As a bag stores it."""
        values = {}
        for name, (what, definition) in STORE.fielddefs[self.kind][1]:
            value = getattr(self, name)
            values[name] = value.plain() if what == Nodetype.NAME else value
            if what == Nodetype.SEQUENCE and definition[0][0] == Nodetype.NAME:
                values[name] = [x.plain() for x in value]
            elif what == Nodetype.SEQUENCE and definition[0][1][0] == "float64":
                values[name] = np.array(value)
        return STORE.types[self.kind](**values)


def python_type(name):
    return str if name == "string" else float if name.startswith("float") else int


def default(field):
    what, definition = field
    if what == Nodetype.NAME:
        return message(definition)()
    return [] if what == Nodetype.SEQUENCE else python_type(definition[0])()


def message(kind):
    return type(kind.rpartition("/")[2], (Message,), {"kind": kind})


class Duration:
    def __init__(self, *, seconds=0.0):
        self.nanoseconds = round(1e9 * seconds)

    def __add__(self, other):
        return Duration(seconds=1e-9 * (self.nanoseconds + other.nanoseconds))

    def to_msg(self, kind="builtin_interfaces/msg/Duration"):
        out = message(kind)()
        out.sec, out.nanosec = divmod(self.nanoseconds, 10**9)
        return out


class Instant(Duration):
    def __add__(self, other):
        return Instant(seconds=1e-9 * (self.nanoseconds + other.nanoseconds))

    def to_msg(self):
        return super().to_msg("builtin_interfaces/msg/Time")


class Future:
    def __init__(self, value=None):
        self.value = value

    def done(self):
        return self.value is not None

    def result(self):
        return self.value


class Controller:
    """A robot of a joint_trajectory_controller: follows points by cubic polynomials; its joints are not in the order of the goal."""

    def __init__(self, joints, start, torques, rate_hz=100.0, accepts=True):
        self.joints, self.q, self.torques = list(joints), np.array(start), torques
        self.time, self.period, self.accepts = 100.0, 1.0 / rate_hz, accepts
        self.goal, self.finished, self.callback, self.cancelled = None, Future(), None, False

    def send(self, goal):
        STORE.serialize_cdr(goal.trajectory.plain(), goal.trajectory.kind)
        stamp = goal.trajectory.header.stamp
        self.begin = stamp.sec + 1e-9 * stamp.nanosec
        self.goal, self.finished, self.cancelled = goal, Future(), False
        stamps = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in goal.trajectory.points]
        points = goal.trajectory.points
        self.path = CubicHermiteSpline(stamps, [p.positions for p in points], [p.velocities for p in points])
        self.end = stamps[-1]
        return Future(types.SimpleNamespace(accepted=self.accepts, get_result_async=lambda: self.finished, cancel_goal_async=self.cancel))

    def cancel(self):
        self.cancelled = True
        self.finished.value = "cancelled"

    def tick(self):
        self.time += self.period
        qd = qdd = np.zeros(len(self.q))
        if self.goal is not None and not self.finished.done():
            t = min(max(self.time - self.begin, 0.0), self.end)
            self.q, qd, qdd = self.path(t), self.path(t, 1), self.path(t, 2)
            if self.time > self.begin + self.end:
                self.finished.value = "done"
        state = message("sensor_msgs/msg/JointState")()
        state.header.stamp = Instant(seconds=self.time).to_msg()
        order = [*range(len(self.joints))][::-1]
        state.name = [self.joints[j] for j in order]
        effort = self.torques(self.q, qd, qdd)
        state.position, state.velocity, state.effort = ([float(x[j]) for j in order] for x in (self.q, qd, effort))
        self.callback(state)


def install(monkeypatch, controller):
    """Puts the modules where `import rclpy` finds them."""
    clock = types.SimpleNamespace(now=lambda: Instant(seconds=controller.time))
    log = types.SimpleNamespace(info=print)
    parameters = controller.__dict__.setdefault("parameters", {})

    def subscribe(kind, topic, callback, depth):
        assert kind.kind == "sensor_msgs/msg/JointState" and topic and depth
        controller.callback = callback

    node = types.SimpleNamespace(
        create_subscription=subscribe,
        get_clock=lambda: clock,
        get_logger=lambda: log,
        destroy_node=lambda: None,
        declare_parameter=lambda name, value: types.SimpleNamespace(value=parameters.get(name, value)),
    )

    class Client:
        def __init__(self, node, action, name):
            self._action_name = name

        def wait_for_server(self, timeout_sec):
            return True

        def send_goal_async(self, goal):
            return controller.send(goal)

    class Goal:
        __slots__ = ("trajectory",)

        def __init__(self):
            self.trajectory = message("trajectory_msgs/msg/JointTrajectory")()

    modules = {
        "rclpy": {
            "ok": lambda: False,
            "init": lambda: None,
            "shutdown": lambda: None,
            "create_node": lambda name: node,
            "spin_once": lambda node, timeout_sec: controller.tick(),
            "spin_until_future_complete": lambda node, future, timeout_sec: None,
        },
        "rclpy.action": {"ActionClient": Client},
        "rclpy.duration": {"Duration": Duration},
        "control_msgs": {},
        "control_msgs.action": {"FollowJointTrajectory": types.SimpleNamespace(Goal=Goal)},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"JointState": message("sensor_msgs/msg/JointState")},
        "trajectory_msgs": {},
        "trajectory_msgs.msg": {"JointTrajectoryPoint": message("trajectory_msgs/msg/JointTrajectoryPoint")},
    }
    for name, content in modules.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
