"""Payloads, and drive gains from a known one."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rivid import _rivid
from rivid._arrays import each, instance_of, path_of, shaped
from rivid._keys import text_of
from rivid._options import Wls
from rivid.fit import Fit
from rivid.log import read_logs
from rivid.robot import Robot
from rivid.table import Table

if TYPE_CHECKING:
    from rivid.types import ArrayLike, Floats, LogSource

_INERTIA = (("Ixx", "Ixy", "Ixz"), ("Ixy", "Iyy", "Iyz"), ("Ixz", "Iyz", "Izz"))


class Payload:
    """A payload in the flange frame, or what one has more than another.

    ``values`` has name, value, unit, sigma and interval_95 of ``mass``, ``com_x`` … and of a body ``Ixx`` …; ``reason`` says why some are missing.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document = document
        self.name: str = document["name"]
        self.model: Literal["point", "body"] = document["model"]
        self.reason: str = document["reason"]
        self.values = Table([{"name": name, **value} for name, value in document["values"].items()])
        self.urscript: str | None = document.get("urscript")
        self.libfranka: str | None = document.get("libfranka")

    def _value(self, name: str) -> float:
        return self._document["values"].get(name, {}).get("value", math.nan)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self._value("mass")

    @property
    def com(self) -> Floats:
        """Centre of mass, (3) [m]; not a number where it is not determined."""
        return np.array([self._value(f"com_{axis}") for axis in "xyz"])

    @property
    def inertia(self) -> Floats:
        """About the centre of mass, axes of the flange, (3, 3) [kg·m²]; not a number where it is not determined."""
        return np.array([[self._value(name) for name in row] for row in _INERTIA])

    def __repr__(self) -> str:
        return f"<Payload {self.name}: {self.mass:.5g} kg>"


class Payloads:
    """Payloads from one fit. ``document`` is all of it, the content of payload.json; a ``Payload`` is found by its name."""

    def __init__(self, document: str, text: str) -> None:
        self._text = text
        self.document: dict[str, Any] = json.loads(document)
        self.payloads = [Payload(one) for one in self.document["payloads"]]
        self.differences = [Payload(one) for one in self.document["differences"]]
        self.gains = Table(self.document["gains"])

    @property
    def identified(self) -> bool:
        """Whether the logs determine arm and payloads; ``document["reason"]`` says why not."""
        return self.document["status"] == "identified"

    def __getitem__(self, name: str) -> Payload:
        for one in (*self.payloads, *self.differences):
            if one.name == name:
                return one
        raise KeyError(name)

    def __str__(self) -> str:
        return self._text


def identify_payloads(
    robot: Robot,
    loaded: LogSource | Iterable[LogSource] | Mapping[str, LogSource | Iterable[LogSource]],
    method: Wls | None = None,
    *,
    without: LogSource | Iterable[LogSource] | None = None,
    arm: Fit | str | PathLike[str] | None = None,
    gains: ArrayLike | Literal["estimate"] | None = None,
    mass: float | Mapping[str, float] | None = None,
    link: str = "",
    flange: tuple[ArrayLike, ArrayLike] | None = None,
    model: Literal["automatic", "point", "body"] = "automatic",
    load_friction: bool = False,
    threads: int = 1,
) -> Payloads:
    """Identifies payloads, and their differences, from logs with them beside logs of the arm alone or on top of its identification.

    ``loaded`` is what ``read_logs`` takes, or a dict of that by the names of several payloads. The arm is known from the logs ``without`` or as ``arm``, a
    ``Fit`` or the path of a result.json. ``gains`` are standard deviations of the drive gains in percent, one or one a joint (1, or what the arm says); ``"estimate"`` (or infinity):
    unknown, then ``mass`` [kg] sets their scale. ``link`` is the moving link that it is on, the last of an arm without it, and
    ``flange`` the flange's pose in the frame of that link: rotation matrix (3, 3) and origin (3) [m].

    Raises InputError where robot, logs and options do not fit together.
    """
    if (without is None) == (arm is None):
        raise TypeError("identify_payloads: the arm is known from logs `without` payload or as `arm`: give one of them")
    instance_of("identify_payloads: robot", robot, Robot)
    known = None
    if arm is not None:
        of = _rivid.IdentifiedArm
        known = of.of_fit(arm.robot._robot, arm._found) if isinstance(arm, Fit) else of.of_result(path_of("identify_payloads: arm", arm), robot._robot)
        robot = Robot._of(known.robot)
    named = loaded if isinstance(loaded, Mapping) and not _is_table(loaded) else {"payload": loaded}
    masses = mass if isinstance(mass, Mapping) else {} if mass is None else {next(iter(named)): mass}
    if unknown := set(masses) - set(named):
        raise KeyError(f"identify_payloads: no logs are those of {sorted(unknown)}")
    loads = [(name, [log._log for log in read_logs(logs, robot)], masses.get(name)) for name, logs in named.items()]
    axes, origin = (np.eye(3), np.zeros(3)) if flange is None else flange
    R, p = shaped("identify_payloads: flange axes", axes, (3, 3)), shaped("identify_payloads: flange origin", origin, (3,))
    options = _rivid.PayloadOptions(model, link, R, p, _gain_sigma(gains, len(robot)), load_friction)
    sections = text_of(Wls() if method is None else method, "identify_payloads")
    alone = [] if without is None else [log._log for log in read_logs(without, robot)]
    return Payloads(*_rivid.identify_payloads(robot._robot, loads, alone, known, sections, options, threads))


def _is_table(loaded: Mapping[str, Any]) -> bool:
    """Whether a mapping is one log, from names to columns of numbers, and no dict of logs by name."""
    return all(not isinstance(one, (str, PathLike)) and np.ndim(one) == 1 and np.asarray(one).dtype.kind in "fiu" for one in loaded.values())


def _gain_sigma(gains: ArrayLike | str | None, joints: int) -> Floats:
    if gains is None:
        return np.empty(0)
    percent = math.inf if isinstance(gains, str) and gains == "estimate" else gains
    return 0.01 * each("identify_payloads: gains", percent, joints)
