"""Logs as robots write them: tables from names to columns, by the libraries that own the formats."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from rivid._rivid import InputError
from rivid.formats import text as text

Table = Mapping[str, Any]


class Format(NamedTuple):
    """A format, and the module that reads it."""

    name: str
    module: str
    extra: str
    """That `pip install rivid[extra]` gets its libraries by; empty where NumPy is enough."""


BAG = "rivid.formats.bags"
_MCAP = Format("MCAP", BAG, "ros")
_DB3 = Format("rosbag2 (SQLite)", BAG, "ros")
_BEGINNINGS = {
    b"\x89MCAP0\r\n": _MCAP,
    b"SQLite format 3\0": _DB3,
    b"#ROSBAG V2.0": Format("ROS 1 bag", BAG, "ros"),
    b"PAR1": Format("Parquet", "rivid.formats.arrow", "parquet"),
    b"ARROW1": Format("Feather", "rivid.formats.arrow", "parquet"),
    b"FEA1": Format("Feather", "rivid.formats.arrow", "parquet"),
    b"PK\x03\x04": Format("NumPy .npz", "rivid.formats.arrays", ""),
    b"\x93NUMPY": Format("NumPy .npy", "rivid.formats.arrays", ""),
    b"MATLAB 5.0 MAT-file": Format("MATLAB v5", "rivid.formats.matlab", "matlab"),
    b"MATLAB 7.3 MAT-file": Format("MATLAB v7.3", "rivid.formats.matlab", "matlab"),
    b"\x89HDF\r\n\x1a\n": Format("HDF5", "rivid.formats.matlab", "matlab"),
}


def format_of(path: str | PathLike[str]) -> Format | None:
    """The format of a file by its first bytes, or of the folder of a bag; None for text."""
    path = Path(path)
    if path.is_dir():
        if (path / "metadata.yaml").exists():
            return Format("rosbag2", BAG, "ros")
        raise InputError(f"{path}: is a folder without metadata.yaml, a log or the folder of a bag is required")
    try:
        with path.open("rb") as file:
            first = file.read(max(map(len, _BEGINNINGS)))
    except OSError as error:
        raise InputError(f"{path}: the log can not be read: {error.strerror}") from None
    return next((known for beginning, known in _BEGINNINGS.items() if first.startswith(beginning)), None)


def is_text(path: str | PathLike[str]) -> bool:
    """Whether the C++ reader of CSV files reads a file."""
    return format_of(path) is None


def _reader(path: str | PathLike[str]) -> Any:
    found = format_of(path)
    assert found is not None
    try:
        return importlib.import_module(found.module)
    except ImportError as error:
        raise InputError(
            f"{path}: is {found.name}, which needs the Python package {error.name}: pip install 'rivid[{found.extra}]'"
        ) from None


def read(path: str | PathLike[str]) -> Table:
    """The columns of a file that is no text.

    Raises InputError for what can not be read.
    """
    return _reader(path).read(Path(path))


def contents(path: str | PathLike[str]) -> list[str]:
    """What a file holds, one line each."""
    return _reader(path).contents(Path(path))
