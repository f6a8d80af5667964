"""A designed motion as a path that can be played at any speed, and what an arm says on the way."""

from __future__ import annotations

from os import PathLike
from pathlib import Path as File
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from rivid._rivid import InputError

if TYPE_CHECKING:
    from rivid.types import Floats


class Path:
    """Positions over time; polynomials of fifth degree between rows of positions, velocities and accelerations (rows, joints)."""

    def __init__(self, t: Floats, q: Floats, qd: Floats, qdd: Floats) -> None:
        self._t, self._q, self._qd, self._qdd = t, q, qd, qdd
        self.duration = float(t[-1])

    @classmethod
    def of_plan(cls, folder: str | PathLike[str]) -> Path:
        """The motion that ``rivid excite`` wrote into a folder. Raises InputError where it holds none."""
        file = File(folder) / "motion.csv"
        if not file.is_file():
            raise InputError(f"{file} is not there, must be the motion that rivid excite wrote")
        table = np.genfromtxt(file, delimiter=",", names=True)
        names = table.dtype.names or ()
        joints = sum(name[:1] == "q" and name[1:].isdigit() for name in names)
        series = [np.column_stack([table[f"{kind}{j + 1}"] for j in range(joints)]) for kind in ("q", "qd", "qdd")]
        return cls(table["t"], *series)

    def at(self, s: float) -> tuple[Floats, Floats, Floats]:
        """Positions at an instant of the motion [s], with their first and second derivative by it."""
        k = min(max(int(np.searchsorted(self._t, s, side="right")) - 1, 0), len(self._t) - 2)
        h = self._t[k + 1] - self._t[k]
        u = min(max((s - self._t[k]) / h, 0.0), 1.0)
        v, a = h * self._qd[k], 0.5 * h * h * self._qdd[k]
        d = self._q[k + 1] - self._q[k] - v - a
        dv = h * self._qd[k + 1] - v - 2 * a
        da = h * h * self._qdd[k + 1] - 2 * a
        c3, c4, c5 = 10 * d - 4 * dv + 0.5 * da, -15 * d + 7 * dv - da, 6 * d - 3 * dv + 0.5 * da
        q = self._q[k] + u * (v + u * (a + u * (c3 + u * (c4 + u * c5))))
        qd = (v + u * (2 * a + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h
        qdd = (2 * a + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (h * h)
        return q, qd, qdd

    def states(self, count: int = 2000) -> tuple[Floats, Floats, Floats]:
        """Positions, velocities and accelerations at so many instants, (count, joints) each."""
        rows = [self.at(s) for s in np.linspace(0.0, self.duration, count)]
        q, qd, qdd = (np.array(series) for series in zip(*rows))
        return q, qd, qdd


class State(NamedTuple):
    """What an arm measures at an instant of its clock, and what it is told at that instant."""

    t: float  # s
    q: Floats
    qd: Floats
    effort: Floats  # torques, or currents
    s: float  # instant of the motion, at its own speed
    told: tuple[Floats, Floats, Floats]  # positions, velocities, accelerations


class Arm(Protocol):
    """A robot that plays a path. Its methods are called from one thread."""

    effort: str  # "tau": N m, N; "v": another unit, as currents

    def position(self) -> Floats:
        """Where it stands."""

    def begin(self, path: Path, speed: float) -> None:
        """Begins to play, at so many times the speed."""

    def step(self) -> State | None:
        """Waits for the next state; None once the arm is at rest. Raises TimeoutError where none comes."""

    def stop(self) -> None:
        """Asks for rest as soon as the arm can; step() goes on until it is reached."""


class Streamed:
    """What arms share that are sent a position each period. They stop along the path, which is known to be free."""

    stop_seconds = 0.4
    begin_seconds = 1.0  # within which they come from where they stand onto the path

    def begin(self, path: Path, speed: float) -> None:
        """Begins to play, at so many times the speed."""
        self._path, self._s, self._rate, self._braking = path, 0.0, speed, 0.0
        self._played, self._beside = 0.0, self.position() - path.at(0.0)[0]

    def position(self) -> Floats:
        """Where it stands."""
        raise NotImplementedError

    def stop(self) -> None:
        """Slows down along the path."""
        self._braking = self._braking or self._rate / self.stop_seconds

    def resting(self) -> bool:
        """Whether the path is at its end, or the arm has stopped on it."""
        return self._s >= self._path.duration or self._rate <= 0.0

    def advance(self, seconds: float) -> tuple[float, tuple[Floats, Floats, Floats]]:
        """The instant of the motion a period later, and what is to be told then."""
        self._rate = max(self._rate - self._braking * seconds, 0.0)
        self._s = min(self._s + self._rate * seconds, self._path.duration)
        q, qd, qdd = self._path.at(self._s)
        self._played += seconds
        u = min(self._played / self.begin_seconds, 1.0)
        q = q + (1.0 - u**3 * (10.0 + u * (6.0 * u - 15.0))) * self._beside
        return self._s, (q, self._rate * qd, self._rate**2 * qdd - self._braking * qd)
