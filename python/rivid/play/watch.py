"""Whether a robot does what its plan foretells."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from rivid.robot import InverseDynamics, Robot

if TYPE_CHECKING:
    from rivid.play.motion import Path, State
    from rivid.types import Floats

_MEMORY = 0.2  # s; robots answer so late, and filter so long, at most
_BUCKET = 0.02  # s; the memory is kept by ranges of so long
_HOLD = 0.02  # s; shorter ones are glitches of a sensor
_SLOW = 0.02  # of the largest velocity; below it friction may have either sign, and any size up to its own


class Watch:
    """Compares each state with all that was told, and foretold, within the last 0.2 s, so that no robot's delay needs to be known."""

    def __init__(self, robot: Robot, path: Path, limits: dict[str, Floats], tracking: Floats, torque_band: Floats) -> None:
        self._dynamics = InverseDynamics(robot.model())
        self._states = path.states()
        self._slow = _SLOW * np.max(np.abs(self._states[1]), axis=0)
        self._stiction = np.abs(self._dynamics.friction(self._slow))
        self._limits, self._names = limits, robot.joints
        self._tracking, self._band = tracking, torque_band
        self.gain = np.ones(len(robot))  # N m, N, for a unit of the readings; nan: unknown
        self.begin()

    def begin(self) -> None:
        """Forgets what was told and measured."""
        self._told: deque[tuple[float, Floats, Floats]] = deque()  # begin of the bucket, least and most of q and torques
        self._out_since: float | None = None
        self.worst_tracking = np.zeros(len(self._names))
        self.worst_torque = np.zeros(len(self._names))
        self._readings: list[tuple[Floats, Floats]] = []

    def complaint(self, state: State) -> str | None:
        """What is wrong, once it lasts."""
        said = self._fault(state)
        self._out_since = None if said is None else state.t if self._out_since is None else self._out_since
        lasts = self._out_since is not None and state.t - self._out_since >= _HOLD
        return said if lasts else None

    def _fault(self, state: State) -> str | None:
        if not np.isfinite([state.q, state.qd, state.effort]).all():
            return "a reading is no number"
        foretold = self._dynamics.torque(*state.told)
        self._remember(state, foretold)
        least = np.min([row[1] for row in self._told], axis=0)
        most = np.max([row[2] for row in self._told], axis=0)
        torque = self.gain * state.effort
        tracking, excess = np.fmax(np.fmax(least - (state.q, torque), (state.q, torque) - most), 0.0)
        self.worst_tracking = np.fmax(self.worst_tracking, tracking)
        self.worst_torque = np.fmax(self.worst_torque, excess)
        self._readings.append((state.effort, foretold))
        checks = [
            ("position", -state.q, -self._limits["lower"]),
            ("position", state.q, self._limits["upper"]),
            ("velocity", np.abs(state.qd), self._limits["velocity"]),
            ("distance from the positions told", tracking, self._tracking),
            ("torque", np.abs(torque), self._limits["torque"]),
            ("distance of the torque from the forecast", excess, self._band),
        ]
        for what, value, limit in checks:
            over = np.flatnonzero(value > limit)
            if len(over):
                j = over[0]
                return f"{self._names[j]}: {what} is {abs(value[j]):.4g}, must be at most {abs(limit[j]):.4g}"
        return None

    def _remember(self, state: State, foretold: Floats) -> None:
        q, qd, _ = state.told
        slow, friction = np.abs(qd) < self._slow, self._dynamics.friction(qd)
        least = np.array([q, foretold - slow * (friction + self._stiction)])
        most = np.array([q, foretold - slow * (friction - self._stiction)])
        if self._told and state.t - self._told[-1][0] < _BUCKET:
            begin, before_least, before_most = self._told[-1]
            self._told[-1] = (begin, np.minimum(before_least, least), np.maximum(before_most, most))
        else:
            self._told.append((state.t, least, most))
        while state.t - self._told[0][0] > _MEMORY + _BUCKET:
            self._told.popleft()

    def too_much_at(self, speed: float) -> str | None:
        """Why the motion can not be played at a speed: the torque foretold and what was missed so far pass the limit."""
        rows = [self._dynamics.torque(q, speed * qd, speed**2 * qdd) for q, qd, qdd in zip(*self._states)]
        most = np.max(np.abs(rows), axis=0)
        for j in np.flatnonzero(most + self.worst_torque > self._limits["torque"])[:1]:
            return (
                f"{self._names[j]}: the torque foretold is up to {most[j]:.4g}, and was missed by {self.worst_torque[j]:.4g};"
                f" together they must be at most {self._limits['torque'][j]:.4g}"
            )
        return None

    def unwatched(self) -> list[str]:
        """Joints whose readings have no known gain."""
        return [name for name, gain in zip(self._names, self.gain) if np.isnan(gain)]

    def learn_gains(self) -> None:
        """Gains by the readings of a run and its forecast, of the joints whose readings follow it."""
        readings, foretold = (np.array(series) for series in zip(*self._readings))
        for j in range(len(self._names)):
            r = np.corrcoef(readings[:, j], foretold[:, j])[0, 1] if np.ptp(readings[:, j]) > 0 else 0.0
            gain = (readings[:, j] @ foretold[:, j]) / max(readings[:, j] @ readings[:, j], 1e-300)
            self.gain[j] = gain if r > 0.7 else np.nan

