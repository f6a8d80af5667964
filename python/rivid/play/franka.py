"""Franka Robotics' arms, by libfranka: ``pip install pylibfranka``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rivid.play.motion import Path, State, Streamed

if TYPE_CHECKING:
    from rivid.types import Floats


class Franka(Streamed):
    """An arm of that maker, told a position each millisecond; its sensors measure torques [N m]."""

    effort = "tau"

    def __init__(self, host: str) -> None:
        import pylibfranka

        self._franka = pylibfranka
        self._robot = pylibfranka.Robot(host)

    def position(self) -> Floats:
        """Where it stands."""
        return np.array(self._robot.read_once().q)

    def begin(self, path: Path, speed: float) -> None:
        """Begins to play, at so many times the speed."""
        super().begin(path, speed)
        self._control = self._robot.start_joint_position_control(self._franka.ControllerMode.JointImpedance)

    def step(self) -> State | None:
        """Waits for a state and answers with a position; None once the arm is at rest."""
        if self.resting():
            return None
        state, elapsed = self._control.readOnce()
        s, told = self.advance(elapsed.to_sec())
        command = self._franka.JointPositions(told[0].tolist())
        command.motion_finished = self.resting()
        self._control.writeOnce(command)
        return State(state.time.to_sec(), np.array(state.q), np.array(state.dq), np.array(state.tau_J), s, told)
