"""Arrays of real numbers, paths and objects from what callers give. Messages name it by ``what``: the function and its argument."""

from __future__ import annotations

import re
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rivid import _rivid

if TYPE_CHECKING:
    from rivid.types import ArrayLike, Floats

_DOUBLE = np.dtype(float)  # one object
_KINDS = ("one number", "a vector", "a matrix with one row a sample")


def floats(what: str, x: ArrayLike, ndim: int | None = None) -> Floats:
    """An array, of so many dimensions.

    Raises InputError for masked samples, which would come in with the values below the mask, for complex numbers, and for what holds no
    numbers.
    """
    array = x if type(x) is np.ndarray and x.dtype is _DOUBLE else _converted(what, x)
    if ndim is not None and array.ndim != ndim:
        raise _rivid.InputError(f"{what} has shape {array.shape}, must be {_KINDS[ndim]}")
    return array


def shaped(what: str, x: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """An array of a shape. Raises InputError as floats() does, and for another shape."""
    array = floats(what, x)
    if array.shape != shape:
        raise _rivid.InputError(f"{what} has shape {array.shape}, must have {shape}")
    return array


def each(what: str, x: ArrayLike, joints: int) -> Floats:
    """A value for each joint from one for all or one a joint. Raises InputError as floats() does, and for another size."""
    array = floats(what, x)
    if array.shape not in ((), (joints,)):
        raise _rivid.InputError(f"{what} has shape {array.shape}, must be one number or {joints}, one a joint")
    return np.broadcast_to(array, (joints,)).copy()


def path_of(what: str, x: str | PathLike[str]) -> Path:
    """A path. Raises TypeError for what is none, and InputError for one that messages and documents can not show."""
    if not isinstance(x, (str, PathLike)) or not isinstance(text := fspath(x), str):
        raise TypeError(f"{what} is {type(x).__name__}, must be a path: str or pathlib.Path")
    if re.search("[\0\ud800-\udfff]", text):
        raise _rivid.InputError(f"{what} is {text!r}, must be UTF-8 without null characters")
    return Path(text)


def instance_of(what: str, x: Any, kind: type) -> Any:
    """An object of a class. Raises TypeError for another."""
    if not isinstance(x, kind):
        raise TypeError(f"{what} is {type(x).__name__}, must be {kind.__name__}")
    return x


def _converted(what: str, x: Any) -> Floats:
    if np.ma.is_masked(x):
        raise _rivid.InputError(f"{what} has masked samples, must have none; leave them out or fill them")
    try:
        array = np.asarray(x)
        if array.dtype.kind not in "cmM":
            return array.astype(float, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise _rivid.InputError(f"{what} must hold real numbers: {error}") from None
    raise _rivid.InputError(f"{what} is {array.dtype}, must hold real numbers")
