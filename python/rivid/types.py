"""Types of arguments and results, for annotations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rivid.log import Log

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Booleans = NDArray[np.bool_]

Progress = Callable[[str, float], Any]
"""Called on the way through long work with a name and the fraction done."""

LogSource = Union[Log, str, "PathLike[str]", Mapping[str, ArrayLike], Any]
"""A log, a file of one, a mapping from names to columns, or a pandas, polars or Arrow table."""

Settings = Mapping[str, Any]
"""Laid over an experiment file: ``{"signal.decimation": 5}``."""

Convention = Literal["standard", "matlab"]

__all__ = ["ArrayLike", "Booleans", "Convention", "Floats", "Indices", "LogSource", "Progress", "Settings"]
