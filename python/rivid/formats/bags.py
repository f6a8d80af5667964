"""Bags of ROS, by rosbags: MCAP, rosbag2 and ROS 1."""

from __future__ import annotations

from array import array
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from rivid._rivid import InputError

_STATE = "sensor_msgs/msg/JointState"
_CONTROLLER = ("control_msgs/msg/JointTrajectoryControllerState",)
_REFERENCES = (("reference", "desired"), ("feedback", "actual"))


class _Series:
    """Columns of one topic: stamps, and a row of values by the joints that a message names."""

    def __init__(self) -> None:
        self.stamps: list[int] = []
        self.columns: dict[str, int] = {}
        self.rows: list[tuple[tuple[int, ...], array[float]]] = []
        self._places: dict[tuple[Any, ...], tuple[int, ...]] = {}

    def add(self, stamp: int, names: tuple[str, ...], fields: list[tuple[str, Any]]) -> None:
        key = (names, tuple(field for field, _ in fields))
        if key not in self._places:
            wanted = [f"{name}/{field}" for field, _ in fields for name in names]
            self._places[key] = tuple(self.columns.setdefault(name, len(self.columns)) for name in wanted)
        self.stamps.append(stamp)
        self.rows.append((self._places[key], array("d", [x for _, values in fields for x in values])))

    def matrix(self) -> Any:
        out = np.full((len(self.rows), len(self.columns)), np.nan)
        for k, (places, values) in enumerate(self.rows):
            out[k, places] = values
        return out


def _opened(path: Path) -> AnyReader:
    return AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))


def _stamp(message: Any, recorded: int) -> int:
    stamp = message.header.stamp
    at = stamp.sec * 1_000_000_000 + stamp.nanosec
    return at or recorded


def _of_state(message: Any) -> list[tuple[str, Any]]:
    n = len(message.name)
    fields = (("position", message.position), ("velocity", message.velocity), ("effort", message.effort))
    return [(name, values) for name, values in fields if len(values) == n]


def _of_controller(message: Any) -> list[tuple[str, Any]]:
    n = len(message.joint_names)
    out = []
    for prefix, names in zip(("reference_", ""), _REFERENCES):
        point = next((getattr(message, name) for name in names if hasattr(message, name)), None)
        if point is not None:
            fields = (("position", point.positions), ("velocity", point.velocities))
            out += [(prefix + field, values) for field, values in fields if len(values) == n]
            if not prefix and len(point.effort) == n:
                out.append(("effort", point.effort))
    return out


def _series(reader: AnyReader, path: Path) -> dict[str, _Series]:
    wanted = [c for c in reader.connections if c.msgtype in (_STATE, *_CONTROLLER)]
    if not wanted:
        topics = ", ".join(f"{c.topic} ({c.msgtype})" for c in reader.connections) or "nothing"
        raise InputError(f"{path}: holds neither JointState nor JointTrajectoryControllerState, only {topics}")
    out: dict[str, _Series] = {c.topic: _Series() for c in wanted}
    for connection, recorded, raw in reader.messages(connections=wanted):
        message: Any = reader.deserialize(raw, connection.msgtype)
        series = out[connection.topic]
        if connection.msgtype == _STATE:
            series.add(_stamp(message, recorded), tuple(message.name), _of_state(message))
        else:
            series.add(_stamp(message, recorded), tuple(message.joint_names), _of_controller(message))
    return {topic: series for topic, series in out.items() if series.rows}


def read(path: Path) -> dict[str, Any]:
    """Columns "t" [s], "<joint>/position", "/velocity", "/effort", "/reference_position", "/reference_velocity".

    One row for each stamp of a header, with empty cells where a topic has no message of that stamp. What several topics say of a
    joint is taken from JointState, else from the topic with the most messages.
    """
    with _opened(path) as reader:
        series = _series(reader, path)
        states = {c.topic for c in reader.connections if c.msgtype == _STATE}
    if not series:
        raise InputError(f"{path}: the topics of joints hold no message")
    order = sorted(series, key=lambda topic: (topic not in states, -len(series[topic].rows)))
    stamps = np.unique(np.concatenate([np.array(s.stamps, dtype=np.int64) for s in series.values()]))
    out: dict[str, Any] = {"t": (stamps - stamps[0]) * 1e-9}
    for topic in order:
        found = series[topic]
        values = found.matrix()
        at = np.searchsorted(stamps, np.array(found.stamps, dtype=np.int64))
        for name, column in found.columns.items():
            if name not in out:
                known = ~np.isnan(values[:, column])
                out[name] = np.full(len(stamps), np.nan)
                out[name][at[known]] = values[known, column]
    return out


def contents(path: Path) -> list[str]:
    """Topics with their types, numbers of messages, and the joints of those that have any."""
    with _opened(path) as reader:
        lines = []
        for c in sorted(reader.connections, key=lambda c: c.topic):
            joints = ""
            if c.msgtype in (_STATE, *_CONTROLLER):
                for connection, _, raw in reader.messages(connections=[c]):
                    message: Any = reader.deserialize(raw, connection.msgtype)
                    joints = ": " + ", ".join(message.name if c.msgtype == _STATE else message.joint_names)
                    break
            lines.append(f"{c.topic}  {c.msgtype}, {c.msgcount} messages{joints}")
        return lines

