"""Plays the motion of a plan on a robot, slowly first, watches it, and records the log that ``rivid init`` reads."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path as File
from typing import NamedTuple

import numpy as np

from rivid._arrays import each, path_of
from rivid._rivid import InputError, write_file
from rivid.experiment import Experiment
from rivid.log import Log
from rivid.play.motion import Arm, Path, State, Streamed
from rivid.play.simulated import Simulated
from rivid.play.watch import Watch
from rivid.robot import Robot
from rivid.types import ArrayLike, Floats

__all__ = ["Arm", "Path", "Recording", "Simulated", "State", "Streamed", "play"]


_NEAR = 0.02  # rad, m; what is left of the way to the beginning is gone within a second


class Recording(NamedTuple):
    """One run of the motion."""

    speed: float
    file: File
    stopped: str | None  # why, where the robot was stopped
    tracking: Floats  # largest distance of each joint from what it was told within 0.2 s [rad, m]
    torque: Floats  # of its torque from the forecast [N m, N]
    unwatched: list[str]  # joints whose torque is not known, so that only their positions were watched

    def __str__(self) -> str:
        worst = int(np.argmax(self.tracking))
        end = "was stopped: " + self.stopped if self.stopped is not None else "done"
        blind = f"; torques not watched: {', '.join(self.unwatched)}" if self.unwatched else ""
        far = ", ".join(f"{value:.3g}" for value in self.torque)
        return (
            f"{100 * self.speed:g} %: {end}; {self.file}\n"
            f"  up to {self.tracking[worst]:.2g} from the positions told (joint {worst + 1}), torques up to {far} from the forecast{blind}"
        )


def play(
    plan: str | PathLike[str],
    arm: Arm,
    *,
    speeds: Sequence[float] = (0.1, 0.5, 1.0),
    tracking: ArrayLike = 0.1,
    torque_band: ArrayLike | None = None,
    go: Callable[[float, Recording | None], bool] | None = None,
    force: bool = False,
) -> list[Recording]:
    """Plays the motion that ``rivid excite`` wrote into the folder ``plan``, at one speed after the other, each a share of its own.

    The robot is stopped where a joint is beyond its limits, further than ``tracking`` [rad, m] from the positions it was told, or its
    torque further than ``torque_band`` [N m, N; a quarter of the largest] from the forecast by the description, for 0.02 s, and where no state
    comes. A faster run begins only where its forecast and what the slower ones were missed by stay within the torque limits, and ``go``, which is
    asked before each with its speed and the last recording, agrees.

    Every run is a CSV file in ``plan``: ``log.csv`` at full speed, ``log_10.csv`` at a tenth; its first line holds the motion, the speed and
    why it ended. Currents have no forecast before the first run, which then finds the gains of those joints whose current follows the
    forecast; the others are not watched.

    Returns the runs; the last is ``stopped`` where one was. Raises InputError where the robot is not at the beginning of the motion, and OSError
    of what speaks to it.
    """
    folder = path_of("play: plan", plan)
    path, robot = Path.of_plan(folder), Experiment(folder / "experiment.toml").robot
    if not speeds or any(not 0.0 < speed <= 1.0 for speed in speeds) or list(speeds) != sorted(speeds):
        raise InputError(f"play: speeds are {list(speeds)}, must be rising numbers above 0, at most 1")
    begin, end = path.at(0.0)[0], path.at(path.duration)[0]
    if len(speeds) > 1 and np.max(np.abs(end - begin)) > 1e-6:
        raise InputError(f"{folder}: the motion ends elsewhere than it begins, so it can be played once; give one speed")
    limits = _limits(folder, robot)
    band = 0.25 * limits["torque"] if torque_band is None else each("play: torque_band", torque_band, len(robot))
    if not np.isfinite(band).all():
        j = int(np.flatnonzero(~np.isfinite(band))[0])
        raise InputError(f"play: {robot.joints[j]} has no torque limit, so torque_band must say how far its torque may be from the forecast")
    files = [folder / ("log.csv" if speed == 1.0 else f"log_{100 * speed:g}.csv") for speed in speeds]
    for file in files:
        if file.exists() and not force:
            raise InputError(f"{file}: is there already; move it away, or force replaces it")
    near = each("play: tracking", tracking, len(robot))
    watch = Watch(robot, path, limits, near, band)
    if arm.effort != "tau":
        watch.gain = _gains(robot)
    runs: list[Recording] = []
    for speed, file in zip(speeds, files):
        _must_stand_at(begin, arm, robot.joints)
        if (why := watch.too_much_at(speed)) is not None:
            raise InputError(f"play: at {100 * speed:g} % {why}")
        if go is not None and not go(speed, runs[-1] if runs else None):
            break
        runs.append(_run(file, path, arm, watch, speed))
        if runs[-1].stopped is not None:
            break
        if np.isnan(watch.gain).all():
            watch.learn_gains()
    return runs


def _run(file: File, path: Path, arm: Arm, watch: Watch, speed: float) -> Recording:
    watch.begin()
    states: list[State] = []
    stopped: str | None = None
    try:
        arm.begin(path, speed)
        while True:
            try:
                if (state := arm.step()) is None:
                    break
                states.append(state)
                said = watch.complaint(state)
            except KeyboardInterrupt:
                said = "interrupted"
            if stopped is None and said is not None:
                stopped = said
                arm.stop()
        # A controller that gives up by itself is at rest early.
        if stopped is None and states and np.max(np.abs(states[-1].told[0] - path.at(path.duration)[0])) > 1e-3:
            stopped = "the robot's controller ended the motion"
    except Exception as error:
        stopped = str(error)
        with contextlib.suppress(Exception):
            arm.stop()
            while arm.step() is not None:
                pass
        raise
    finally:
        if states:
            _write(file, arm, states, speed, stopped)
    return Recording(speed, file, stopped, watch.worst_tracking, watch.worst_torque, watch.unwatched())


def _write(file: File, arm: Arm, states: list[State], speed: float, stopped: str | None) -> None:
    plan = json.loads((file.parent / "plan.json").read_text(encoding="utf-8"))
    inside = {"speed": speed, "stopped": stopped, "date": time.strftime("%Y-%m-%dT%H:%M:%S%z")}
    inside |= {key: plan.get(key) for key in ("motion", "duration", "lead_in", "lead_out", "provenance")}
    joints = range(1, len(states[0].q) + 1)
    names = [f"{name}{j}" for name in ("q", "qd", arm.effort, "qref") for j in joints]
    moving = next((x for x in states if x.s > 0.0), states[0])
    begin = moving.t - moving.s / speed
    rows = [np.concatenate([[x.t - begin], x.q, x.qd, x.effort, x.told[0]]) for x in states]
    text = [f"# rivid play: {json.dumps(inside)}", ",".join(["t", *names]), *(",".join(map(repr, row.tolist())) for row in rows), ""]
    write_file(file, "\n".join(text), ".csv", [file.parent / "plan.json"])


def _must_stand_at(begin: Floats, arm: Arm, names: list[str]) -> None:
    q = arm.position()
    far = np.flatnonzero(np.abs(q - begin) > _NEAR)
    if len(far):
        j = far[0]
        raise InputError(
            f"{names[j]} is at {q[j]:.4g}, must be within {_NEAR:g} of {begin[j]:.4g}, where the motion begins;"
            " lead_from in [excitation] plans a way from where the robot stands"
        )


def _limits(folder: File, robot: Robot) -> dict[str, Floats]:
    """The whole of those that the design kept shares of."""
    given = json.loads((folder / "plan.json").read_text(encoding="utf-8"))["provenance"]["options"]["excitation"]["limits"]
    described = {"lower": "lower", "upper": "upper", "velocity": "max_velocity", "torque": "max_effort"}
    values = {name: given[name] or robot.limits[column] for name, column in described.items()}
    return {name: np.broadcast_to(np.array(value, dtype=float), len(robot)) for name, value in values.items()}


def _gains(robot: Robot) -> Floats:
    """Torques of one unit of the readings; nan where the experiment says nothing."""
    n = len(robot)
    gains = np.asarray(robot.effort(Log(1.0, np.zeros((2, n)), v_tau=np.ones((2, n)))))[0]
    return gains if np.any(gains != 1.0) else np.full(n, np.nan)
