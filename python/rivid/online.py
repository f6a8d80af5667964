"""Estimators for the control loop: payload, contact, friction, and all parameters; see docs/online.md.

Each takes a tick at a time, with positions ``q``, velocities ``qd`` and torques ``tau`` of the joints, and its constructor does all that takes
long. An object belongs to one thread. ``update`` raises InputError for a wrong size; a tick that is not finite is a gap, after which
filters begin anew.
"""

from __future__ import annotations

import math
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from rivid import _rivid
from rivid._arrays import each, floats, path_of, shaped
from rivid._rivid import OnlinePayload, TickQuality
from rivid.robot import DynamicModel, Robot

if TYPE_CHECKING:
    from rivid.fit import Fit
    from rivid.types import ArrayLike, Floats

__all__ = [
    "ContactObserver",
    "FrictionMonitor",
    "OnlineModel",
    "OnlinePayload",
    "PayloadEstimator",
    "RecursiveIdentifier",
    "RobotState",
    "TickQuality",
]


class OnlineModel:
    """An identified robot with its uncertainty, as the estimators take it: ``OnlineModel.from_result("result.json")``,
    ``OnlineModel.from_fit(fit)``, or from numbers.

    ``chi`` and ``covariance`` are those of the base parameters, ``sigma_rho`` the standard deviation of the residual of each joint, and
    ``velocity_threshold`` the speed below which a joint says nothing.
    """

    _online: _rivid.OnlineModel

    def __init__(
        self, robot: Robot, chi: ArrayLike, covariance: ArrayLike, sigma_rho: ArrayLike, velocity_threshold: ArrayLike
    ) -> None:
        n = len(robot)
        values = floats("OnlineModel: chi", chi, 1)
        self._online = _rivid.OnlineModel(
            robot._robot,
            values,
            shaped("OnlineModel: covariance", covariance, (len(values), len(values))),
            each("OnlineModel: sigma_rho", sigma_rho, n),
            each("OnlineModel: velocity_threshold", velocity_threshold, n),
        )

    @classmethod
    def from_result(cls, path: str | PathLike[str], *, force: bool = False) -> OnlineModel:
        """From a result.json; ``force`` takes one that is not identified."""
        return cls._of(_rivid.OnlineModel.of_result(path_of("OnlineModel.from_result: path", path), force))

    @classmethod
    def from_fit(cls, fit: Fit) -> OnlineModel:
        """From what ``identify`` found. Raises InputError where the robot is not identified."""
        return cls._of(_rivid.OnlineModel.of_fit(fit.robot._robot, fit._found))

    @classmethod
    def _of(cls, online: _rivid.OnlineModel) -> OnlineModel:
        out = cls.__new__(cls)
        out._online = online
        return out

    @property
    def model(self) -> DynamicModel:
        """The robot with these parameters."""
        return DynamicModel(self._online.model())

    def __len__(self) -> int:
        return self._online.size


class PayloadEstimator(_rivid.PayloadEstimator):
    """Mass, centre of mass and inertia of what hangs on the flange, with intervals, and when that changes.

    ``rate_hz`` are ticks a second; ``torque_held`` says whether the torque of a tick acts until the next one, as a command does. ``R`` and ``p``
    are the pose of the flange in the frame of the last link; ``gain_sigma`` is the relative standard deviation of the drive gains.
    """

    def __init__(
        self,
        model: OnlineModel,
        *,
        rate_hz: float,
        torque_held: bool = True,
        R: ArrayLike | None = None,
        p: ArrayLike = (0.0, 0.0, 0.0),
        gain_sigma: float = 0.0,
    ) -> None:
        axes = np.eye(3) if R is None else shaped("PayloadEstimator: R", R, (3, 3))
        origin = shaped("PayloadEstimator: p", p, (3,))
        self._shape = (len(model),)
        super().__init__(model._online, rate_hz, torque_held, axes, origin, gain_sigma)

    def update(self, q: ArrayLike, tau: ArrayLike) -> bool:
        """Takes a tick; whether a change of the payload was found."""
        return super().update(shaped("PayloadEstimator.update: q", q, self._shape), shaped("PayloadEstimator.update: tau", tau, self._shape))


class ContactObserver(_rivid.ContactObserver):
    """External torques by the generalised momentum, and thresholds that it learns from its own residual.

    ``bandwidth`` [rad/s] is that of the residual, ``alarms_per_hour`` the false alarms of all joints together, ``smoothing_speed`` that of
    the sign of the velocity, one or one a joint (0.02 where it is None).
    """

    def __init__(
        self,
        model: DynamicModel | OnlineModel,
        *,
        rate_hz: float,
        bandwidth: float = 30.0,
        alarms_per_hour: float = 1.0,
        smoothing_speed: ArrayLike | None = None,
    ) -> None:
        dynamics = model.model if isinstance(model, OnlineModel) else model
        n = dynamics._model.size
        speeds = np.zeros(0) if smoothing_speed is None else each("ContactObserver: smoothing_speed", smoothing_speed, n)
        self._shape = (n,)
        super().__init__(dynamics._model, rate_hz, bandwidth, alarms_per_hour, speeds)

    def update(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, *, learn: bool = False) -> bool:
        """Takes a tick; whether there is a contact. ``tau`` acted from the last tick to this one. ``learn`` where nothing touches the robot:
        thresholds follow the residual."""
        series = (shaped(f"ContactObserver.update: {name}", x, self._shape) for name, x in (("q", q), ("qd", qd), ("tau", tau)))
        return super().update(*series, learn)

    def force(self, link: int, point: ArrayLike) -> Floats:
        """The smallest force on a point of a link, in its frame, that explains the residual, in the axes of the base [N]."""
        return super().force(link, shaped("ContactObserver.force: point", point, (3,)))

    def set_payload(self, body: ArrayLike) -> None:
        """A body on the last link that the model does not have: ``PayloadEstimator.inertial``."""
        super().set_payload(shaped("ContactObserver.set_payload: body", body, (10,)))


class FrictionMonitor(_rivid.FrictionMonitor):
    """Friction coefficients now, how far they have drifted since the identification, and what torque error that means.

    ``forgetting`` is the time constant of what is known of friction [s].
    """

    def __init__(self, model: OnlineModel, *, rate_hz: float, torque_held: bool = True, forgetting: float = 30.0) -> None:
        self._shape = (len(model),)
        super().__init__(model._online, rate_hz, torque_held, forgetting)

    def update(self, q: ArrayLike, tau: ArrayLike) -> None:
        """Takes a tick."""
        super().update(shaped("FrictionMonitor.update: q", q, self._shape), shaped("FrictionMonitor.update: tau", tau, self._shape))

    def set_payload(self, body: ArrayLike) -> None:
        """A body on the last link that the model does not have: ``PayloadEstimator.inertial``."""
        super().set_payload(shaped("FrictionMonitor.set_payload: body", body, (10,)))


class RecursiveIdentifier(_rivid.RecursiveIdentifier):
    """All base parameters by recursive least squares.

    ``forgetting`` is a time constant [s]; ``prior`` says whether the estimate begins with the model's parameters, else with nothing.
    """

    def __init__(
        self,
        model: OnlineModel,
        *,
        rate_hz: float,
        torque_held: bool = True,
        forgetting: float = math.inf,
        prior: bool = True,
    ) -> None:
        self._shape = (len(model),)
        super().__init__(model._online, rate_hz, torque_held, forgetting, prior)

    def update(self, q: ArrayLike, tau: ArrayLike) -> None:
        """Takes a tick."""
        super().update(shaped("RecursiveIdentifier.update: q", q, self._shape), shaped("RecursiveIdentifier.update: tau", tau, self._shape))


class RobotState(_rivid.RobotState):
    """Payload, friction and contacts together, for a whole shift: each uses what the others have learned, and ticks may be lost, late,
    repeated or wrong.

    ``learn`` is the time from the begin in which thresholds of contacts are learned and nothing may touch the robot [s]; the others as
    for ``PayloadEstimator``.
    """

    def __init__(
        self,
        model: OnlineModel,
        *,
        rate_hz: float,
        torque_held: bool = True,
        R: ArrayLike | None = None,
        p: ArrayLike = (0.0, 0.0, 0.0),
        gain_sigma: float = 0.0,
        learn: float = 120.0,
    ) -> None:
        axes = np.eye(3) if R is None else shaped("RobotState: R", R, (3, 3))
        origin = shaped("RobotState: p", p, (3,))
        self._shape = (len(model),)
        super().__init__(model._online, rate_hz, torque_held, axes, origin, gain_sigma, learn)

    def update(self, t: float, q: ArrayLike, tau: ArrayLike) -> TickQuality:
        """Takes a tick that was measured at ``t`` [s]; what was wrong with it."""
        return super().update(t, shaped("RobotState.update: q", q, self._shape), shaped("RobotState.update: tau", tau, self._shape))

    def payload_known(self, mass: float, com: ArrayLike, *, mass_sigma: float, com_sigma: float) -> bool:
        """The controller says: it is this point in the flange frame [kg], [m]. False where a number can not be used."""
        return super().payload_known(mass, shaped("RobotState.payload_known: com", com, (3,)), mass_sigma, com_sigma)

    def feedforward(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Floats:
        """Torques for a motion, with the friction and the payload of the state; once a tick."""
        series = (shaped(f"RobotState.feedforward: {name}", x, self._shape) for name, x in (("q", q), ("qd", qd), ("qdd", qdd)))
        return super().feedforward(*series)
