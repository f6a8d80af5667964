"""Experiment files, and simulated experiments."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rivid import _rivid
from rivid._arrays import instance_of, path_of
from rivid._keys import Control, Motion, settings_of, toml
from rivid.log import Log, files_of
from rivid.robot import Robot

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from rivid._options import SimulationKeys
    from rivid.types import Floats, Progress, Settings


class Experiment:
    """What an experiment file says, docs/experiment.md. ``rivid.identify(experiment)`` and ``simulate(experiment)`` do it."""

    def __init__(
        self, path: str | PathLike[str], settings: Settings | None = None, *, simulation: bool = False
    ) -> None:
        """Reads the file; ``simulation`` asks for the sections of a simulation in place of those of an identification.

        Raises InputError with line and column for what can not be used.
        """
        self.path = path_of("Experiment: path", path)
        self._settings = settings_of(settings)
        self._experiment = _rivid.Experiment(self.path, self._settings, simulation)
        self._simulation = simulation

    @cached_property
    def robot(self) -> Robot:
        """The robot of [robot]."""
        return Robot._of(self._experiment.robot)

    @property
    def settings(self) -> dict[str, Any]:
        """All settings, defaults included."""
        return {key: json.loads(value) for key, value, _, _ in self._experiment.settings(self._simulation)}

    def logs(self, *, progress: Progress | None = None) -> list[Log]:
        """The logs of [log]."""
        return [Log._of(log, self._inputs()) for log in self._experiment.logs(False, progress)]

    def validation(self, *, progress: Progress | None = None) -> list[Log]:
        """The logs of [validation]."""
        return [Log._of(log, self._inputs()) for log in self._experiment.logs(True, progress)]

    def _inputs(self) -> list[Path]:
        """All files that it reads, itself first."""
        return self._experiment.inputs(self._simulation)

    def __repr__(self) -> str:
        return f"<Experiment {str(self.path)!r}>"


def draft(
    robot: str | PathLike[str],
    logs: str | PathLike[str] | Iterable[str | PathLike[str]],
    path: str | PathLike[str],
    *,
    tip: str = "",
) -> list[str]:
    """Writes an experiment file to begin with, as ``rivid init`` does; returns what is doubtful or missing.

    A TOML file of that name is replaced. Raises InputError where ``path`` is the robot, a log, or another file that is no TOML.
    """
    listed = logs if isinstance(logs, Iterable) and not isinstance(logs, (str, bytes)) else [logs]
    files = [path_of("draft: logs", file) for file in listed]
    description, target = path_of("draft: robot", robot), path_of("draft: path", path)
    text, _, doubts = _rivid.draft(target, description, tip, files)
    _rivid.write_file(target, text, ".toml", [description, *files])
    return doubts


class Simulation:
    """A simulated experiment: the motion, and the log that a recorder would have kept, with its noise.

    ``outcome`` is "completed", or why the simulation ended early, ``reason`` says when and at which joint. ``t`` [s], ``q``, ``qd``, ``qdd`` [rad | m, s] are the true
    motion, ``tau`` the torques of the drives [N·m | N], ``v_tau`` the control signals, ``q_r`` the reference.
    """

    def __init__(self, robot: Robot, record: _rivid.SimulationRecord, inputs: Iterable[Path] = ()) -> None:
        self.robot = robot
        self._record = record
        self.outcome: str = record.outcome
        self.reason: str = record.reason
        self.log = Log._of(record.log, inputs)
        self.t: Floats = record.t
        self.q, self.qd, self.qdd = record.q, record.qd, record.qdd
        self.tau, self.v_tau, self.q_r = record.tau, record.v_tau, record.q_r

    @property
    def document(self) -> dict[str, Any]:
        """The content of simulation.json."""
        return json.loads(self._record.document(self.robot._robot))

    def __str__(self) -> str:
        return self._record.text(self.robot._robot)

    def __repr__(self) -> str:
        return f"<Simulation: {self.outcome}, {len(self.t)} samples>"


def simulate(
    robot: Robot | Experiment | str | PathLike[str],
    control: Control | None = None,
    reference: Motion | None = None,
    *,
    progress: Progress | None = None,
    **keys: Unpack[SimulationKeys],
) -> Simulation:
    """Simulates a robot in its closed loop.

    ``simulate(robot, Pd(omega_n=10, rate_hz=200), PointToPoint(via=…, durations=2.0))`` takes the a-priori values of the robot,
    or ``parameters`` of a file; ``keys`` are those of [simulation]. ``simulate("simulate.toml")`` does what a file says.
    """
    if isinstance(robot, (str, PathLike)):
        robot = Experiment(robot, simulation=True)
    if isinstance(robot, Experiment):
        if control is not None or reference is not None or keys:
            raise TypeError("simulate: an experiment says control, reference and simulation itself")
        return Simulation(robot.robot, robot._experiment.simulate(progress), robot._inputs())
    instance_of("simulate: robot", robot, Robot)
    if control is None or reference is None:
        raise TypeError("simulate: control and reference are required beside the robot")
    instance_of("simulate: control", control, Control)
    instance_of("simulate: reference", reference, Motion)
    sections = {"control": control.section(), "reference": reference.section(), "simulation": keys}
    text = "\n".join(f"{name} = {toml(value)}" for name, value in sections.items())
    read = [Path(file) for file in (reference.keys.get("file"), keys.get("parameters")) if isinstance(file, (str, PathLike))]
    return Simulation(robot, _rivid.simulate(robot._robot, text, progress), files_of(robot) + read)


class Excitation:
    """A designed motion, and the forecast of an identification from it."""

    def __init__(self, found: tuple[str, str, Floats, Floats, Floats, Floats]) -> None:
        text, self._summary, self.t, self.q, self.qd, self.qdd = found
        self.document: dict[str, Any] = json.loads(text)

    def __str__(self) -> str:
        return self._summary

    def __repr__(self) -> str:
        return f"<Excitation: {len(self.t)} samples>"


def excite(
    path: str | PathLike[str],
    settings: Settings | None = None,
    *,
    threads: int = 1,
    progress: Progress | None = None,
) -> Excitation:
    """Designs the motion that [excitation] of an experiment file asks for."""
    return Excitation(_rivid.design(path_of("excite: path", path), settings_of(settings), threads, progress))
