"""NumPy's .npz and .npy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rivid._rivid import InputError
from rivid.formats.columns import flattened


def _arrays(path: Path) -> dict[str, Any]:
    loaded = np.load(path, allow_pickle=False)
    if isinstance(loaded, np.ndarray):
        return _named(path, loaded)
    with loaded:
        return {name: loaded[name] for name in loaded.files}


def _named(path: Path, array: Any) -> dict[str, Any]:
    if not array.dtype.names:
        raise InputError(f"{path}: is one array of shape {array.shape} without names of columns; save a structured array, or .npz")
    return {name: array[name] for name in array.dtype.names}


def read(path: Path) -> dict[str, Any]:
    """The columns of a file."""
    return flattened(_arrays(path), str(path))


def contents(path: Path) -> list[str]:
    """Names and shapes of the arrays."""
    return [f"{name}  {array.dtype} {array.shape}" for name, array in _arrays(path).items()]
