"""Universal Robots, by RTDE: ``pip install ur_rtde``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rivid.play.motion import Path, State, Streamed

if TYPE_CHECKING:
    from rivid.types import Floats

_LOOK_AHEAD, _STIFFNESS = 0.03, 500.0  # of servoj: s, and its own unit


class UniversalRobot(Streamed):
    """An arm of that maker. Its readings are motor currents [A]; ``drive_gain`` of the experiment makes torques of them."""

    effort = "v"

    def __init__(self, host: str, *, rate_hz: float = 500.0) -> None:
        import rtde_control
        import rtde_receive

        self._period = 1.0 / rate_hz
        self._receive = rtde_receive.RTDEReceiveInterface(host, rate_hz)
        self._control = rtde_control.RTDEControlInterface(host, rate_hz)

    def position(self) -> Floats:
        """Where it stands."""
        return np.array(self._receive.getActualQ())

    def begin(self, path: Path, speed: float) -> None:
        """Begins to play, at so many times the speed."""
        super().begin(path, speed)
        self._stamp = self._receive.getTimestamp()
        self._missed = 0

    def step(self) -> State | None:
        """Sends a position and waits a period; None once the arm is at rest."""
        if self.resting():
            self._control.servoStop()
            return None
        started = self._control.initPeriod()
        s, told = self.advance(self._period)
        if not self._control.servoJ(told[0].tolist(), 0.0, 0.0, self._period, _LOOK_AHEAD, _STIFFNESS):
            self._control.servoStop()
            raise OSError("the robot takes no positions: is it in remote control, and not stopped?")
        self._control.waitPeriod(started)
        stamp = self._receive.getTimestamp()
        self._missed = self._missed + 1 if stamp == self._stamp else 0
        if self._missed * self._period > 0.1:
            self._control.servoStop()
            raise TimeoutError("the robot has sent no state for 0.1 s")
        self._stamp = stamp
        receive = self._receive
        q, qd, current = (np.array(x) for x in (receive.getActualQ(), receive.getActualQd(), receive.getActualCurrent()))
        return State(stamp, q, qd, current, s, told)
