"""Filters, derivatives and decimation of series, one column a signal."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rivid import _rivid
from rivid._arrays import floats

if TYPE_CHECKING:
    from rivid.types import ArrayLike, Convention, Floats


def zero_phase(
    x: ArrayLike, f_m: float, cutoff_hz: float, *, order: int = 4, convention: Convention = "standard"
) -> Floats:
    """Each column through a Butterworth low-pass forwards, then backwards: gain |H|², no phase."""
    return _rivid.zero_phase(floats("signal.zero_phase: x", x, 2), f_m, cutoff_hz, order, convention)


def differentiate(q: ArrayLike, f_m: float) -> tuple[Floats, Floats, Floats]:
    """q, q̇ and q̈ by central differences."""
    return _rivid.differentiate(floats("signal.differentiate: q", q, 2), f_m)


def decimate(x: ArrayLike, n_d: int | Sequence[int], *, convention: Convention = "standard") -> Floats:
    """Parallel decimation of each column (13, 14), in several stages where n_d lists their factors."""
    return _rivid.decimate(floats("signal.decimate: x", x, 2), _stages("signal.decimate", n_d), convention)


def deviation_factor(n_d: int | Sequence[int]) -> float:
    """By how much decimation makes classical standard deviations too small."""
    return _rivid.deviation_factor(_stages("signal.deviation_factor", n_d))


_MOST = 2**31  # an int of the library


def _stages(who: str, n_d: int | Sequence[int]) -> list[int]:
    try:
        stages = [operator.index(factor) for factor in ([n_d] if np.ndim(n_d) == 0 else n_d)]  # type: ignore[list-item, union-attr]
    except (TypeError, ValueError):
        raise _rivid.InputError(f"{who}: n_d is {n_d!r}, must be a whole number or a list of such") from None
    if any(not -_MOST <= factor < _MOST for factor in stages):
        raise _rivid.InputError(f"{who}: n_d is {n_d!r}, must be below 2³¹")
    return stages
