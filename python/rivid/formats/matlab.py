"""MATLAB's .mat, v5 by SciPy and v7.3 by h5py, and other HDF5."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.io

from rivid._rivid import InputError
from rivid.formats.columns import flattened

_MOST_VARIABLES = 10_000


def _of_v5(value: Any) -> Any:
    """Structs as dictionaries."""
    if isinstance(value, scipy.io.matlab.mat_struct):
        return {name: _of_v5(getattr(value, name)) for name in value._fieldnames}
    return value


def _of_hdf5(node: Any, matlab: bool, left: Iterator[int]) -> Any:
    """What lies in the file itself: links to other files are not followed, nor soft ones, whose path may lead over such."""
    if next(left, None) is None:
        raise InputError(f"{node.file.filename}: has more than {_MOST_VARIABLES} variables and groups, links to the same ones counted again")
    if isinstance(node, h5py.Group):
        own = [name for name in node if not name.startswith("#") and isinstance(node.get(name, getlink=True), h5py.HardLink)]
        return {name: _of_hdf5(node[name], matlab, left) for name in own}
    if not isinstance(node, h5py.Dataset):
        return {}
    if node.external or node.is_virtual:
        raise InputError(f"{node.file.filename}: the numbers of {node.name} are in other files, which are not opened")
    array = node[()]
    if matlab and np.ndim(array) == 2:  # MATLAB stores by columns, HDF5 by rows
        array = array.T
    if node.attrs.get("MATLAB_class") == b"char":
        return "".join(map(chr, np.ravel(array)))
    return array


def _variables(path: Path) -> dict[str, Any]:
    if h5py.is_hdf5(path):
        with path.open("rb") as file:
            matlab = file.read(6) == b"MATLAB"
        with h5py.File(path, "r") as file:
            return _of_hdf5(file, matlab, iter(range(_MOST_VARIABLES)))
    loaded = scipy.io.loadmat(path, struct_as_record=False, squeeze_me=True)
    return {name: _of_v5(value) for name, value in loaded.items() if not name.startswith("__")}


def read(path: Path) -> dict[str, Any]:
    """The columns of a file: variables, and fields of structs as "log.q"."""
    return flattened(_variables(path), str(path))


def _lines(name: str, value: Any) -> list[str]:
    if isinstance(value, dict):
        return [line for key, item in value.items() for line in _lines(f"{name}.{key}" if name else key, item)]
    return [f"{name}  {np.asarray(value).dtype} {np.shape(value)}"]


def contents(path: Path) -> list[str]:
    """Names and shapes of the variables."""
    return _lines("", _variables(path))
