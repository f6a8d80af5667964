"""Judges of an estimate: held-out torque, intervals, rollouts; and ranks with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import rivid
from fits import decimated_columns, filtered
from robots import Log

HORIZONS = (0.1, 0.3, 1.0)  # s
LOST = 1.0  # rad or m: an error counts as no more, a model that can not be simulated as this much
SMOOTH = 0.01  # rad/s, m/s: friction of rollouts is Fc tanh(v / SMOOTH)


@dataclass
class HeldOut:
    """A log that no fit used; with the true base parameters where they are known."""

    log: Log
    truth: np.ndarray | None = None
    motion: np.ndarray | None = None  # true one: (samples, joints, 3)
    rows: tuple[np.ndarray, np.ndarray] = field(init=False)  # of the base parameters, and torques

    def __post_init__(self) -> None:
        inverse = np.linalg.pinv(self.log.base)
        if self.truth is None or self.motion is None:
            W, y = decimated_columns(self.log)
            self.rows = W @ inverse, y
        else:  # along the true motion, where the only error is that of the parameters
            W = self.log.columns(*np.moveaxis(self.motion[::20], 2, 0))
            W = W.transpose(1, 0, 2).reshape(-1, W.shape[2]) @ inverse
            self.rows = W, W @ self.truth

    def torque_error(self, chi: np.ndarray) -> float:
        """‖Y − W χ‖ / ‖Y‖."""
        W, y = self.rows
        return float(np.linalg.norm(y - W @ chi) / np.linalg.norm(y))

    def rollout_errors(self, chi: np.ndarray) -> list[float]:
        """Root mean squares of the position after each of HORIZONS [rad | m]: from measured states, driven by the log's torques."""
        log, n = self.log, self.log.q.shape[1]
        (q, qd, _), tau, _ = filtered(log)
        h = 1 / log.rate
        length = round(HORIZONS[-1] * log.rate)
        starts = np.arange(0, len(q) - length - 1, length)
        friction, plain = self._split(chi)
        x, v = q[starts], qd[starts]
        errors = []
        try:
            model = log.robot.model(plain)
            for k in range(length):
                x, v = _step(model, friction, x, v, tau[starts + k], h)
                if k + 1 in {round(horizon * log.rate) for horizon in HORIZONS}:
                    off = np.nan_to_num(np.abs(x - q[starts + k + 1]), nan=LOST, posinf=LOST)
                    errors.append(float(np.sqrt(np.mean(np.minimum(off, LOST) ** 2))))
        except rivid.NumericsError:  # a mass matrix that is not positive definite
            pass
        return errors + [LOST] * (len(HORIZONS) - len(errors))

    def _split(self, chi: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
        plain = np.array(chi)
        friction = {}
        for kind in ("Fv", "Fc", "off"):
            at = [self.log.names.index(name) for j in range(self.log.q.shape[1]) if (name := f"{kind}{j + 1}") in self.log.names]
            friction[kind] = plain[at] if at else np.zeros(self.log.q.shape[1])
            plain[at] = 0.0
        return friction, plain


def _step(model: rivid.DynamicModel, friction: dict, x: np.ndarray, v: np.ndarray, tau: np.ndarray, h: float) -> tuple:
    """The midpoint rule with two halves."""

    def acceleration(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        lost = friction["Fv"] * v + friction["Fc"] * np.tanh(v / SMOOTH) + friction["off"]
        return model.direct_dynamics(x, v, tau - lost)

    for _ in range(2):
        middle = v + acceleration(x, v) * h / 4
        x, v = x + middle * h / 2, v + acceleration(x + v * h / 4, middle) * h / 2
        x, v = np.clip(x, -1e3, 1e3), np.clip(v, -1e3, 1e3)
    return x, v


def interval(values: np.ndarray, statistic=np.mean, draws: int = 2000) -> tuple[float, float, float]:
    """A statistic over the robots, the rows of `values`, with the 95 % interval of a bootstrap over them."""
    drawn = np.random.default_rng(1).integers(len(values), size=(draws, len(values)))
    low, high = np.percentile([statistic(values[d], axis=0) for d in drawn], [2.5, 97.5])
    return float(statistic(values, axis=0)), float(low), float(high)


def ranks(table: dict[str, list[float]]) -> dict[str, np.ndarray]:
    """Rank of each method on each robot: 1 has the least error."""
    order = np.argsort(np.argsort(np.array(list(table.values())), axis=0), axis=0) + 1.0
    return dict(zip(table, order))
