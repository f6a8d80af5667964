"""Filters, derivatives and decimation of series, one column a signal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rivid import _rivid

if TYPE_CHECKING:
    from rivid.types import ArrayLike, Convention, Floats


def zero_phase(
    x: ArrayLike, f_m: float, cutoff_hz: float, *, order: int = 4, convention: Convention = "standard"
) -> Floats:
    """Each column through a Butterworth low-pass forwards, then backwards: gain |H|², no phase."""
    return _rivid.zero_phase(np.asarray(x, dtype=float), f_m, cutoff_hz, order, convention)


def differentiate(q: ArrayLike, f_m: float) -> tuple[Floats, Floats, Floats]:
    """q, q̇ and q̈ by central differences."""
    return _rivid.differentiate(np.asarray(q, dtype=float), f_m)


def decimate(x: ArrayLike, n_d: int | Sequence[int], *, convention: Convention = "standard") -> Floats:
    """Parallel decimation of each column (13, 14), in several stages where n_d lists their factors."""
    stages = [n_d] if isinstance(n_d, int) else list(n_d)
    return _rivid.decimate(np.asarray(x, dtype=float), stages, convention)


def deviation_factor(n_d: int | Sequence[int]) -> float:
    """By how much decimation makes classical standard deviations too small."""
    return _rivid.deviation_factor([n_d] if isinstance(n_d, int) else list(n_d))
