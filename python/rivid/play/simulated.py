"""An arm that exists nowhere: to rehearse how a motion is played, and for tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rivid.play.motion import Path, State, Streamed
from rivid.robot import InverseDynamics, Robot

if TYPE_CHECKING:
    from rivid.types import ArrayLike, Floats


class Simulated(Streamed):
    """Follows what it is told ``delay`` periods later, without the time that it takes; ``robot`` gives its torques."""

    effort = "tau"

    def __init__(self, robot: Robot, start: ArrayLike, *, rate_hz: float = 500.0, noise: ArrayLike = 0.0, delay: int = 0, seed: int = 1) -> None:
        self._dynamics = InverseDynamics(robot.model())
        self._q, self._period = np.asarray(start, dtype=float), 1.0 / rate_hz
        self._noise, self._delay, self._random = noise, delay, np.random.default_rng(seed)
        self._clock = 0.0

    def position(self) -> Floats:
        """Where it stands."""
        return self._q

    def begin(self, path: Path, speed: float) -> None:
        """Begins to play, at so many times the speed."""
        super().begin(path, speed)
        self._late = [(self._q, 0.0 * self._q, 0.0 * self._q)] * self._delay

    def step(self) -> State | None:
        """The next state; None once the motion is at rest."""
        if self.resting():
            return None
        s, told = self.advance(self._period)
        self._late.append(told)
        self._q, qd, qdd = self._late.pop(0)
        self._clock += self._period
        noise = self._noise * self._random.standard_normal(len(self._q))
        return State(self._clock, self._q, qd, self._dynamics.torque(self._q, qd, qdd) + noise, s, told)
