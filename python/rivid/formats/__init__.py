"""Logs as robots write them: tables from names to columns, by the libraries that own the formats.

Damaged files, and files made to do so, let these libraries crash, loop and take all memory. Each file is therefore read by a process of
its own, rivid.formats.reader, within limits of memory and time: the answer is a table or an InputError, whatever becomes of it.
"""

from __future__ import annotations

import json
import os
import signal
import stat
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rivid import _rivid
from rivid._rivid import InputError
from rivid.formats.columns import has_more_than_numbers, printable

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
_TEXT = Format("text", "rivid.formats.text", "")
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


def format_of(path: Path) -> Format:
    """The format of a file by its first bytes, or of the folder of a bag; text where nothing else is known."""
    try:
        kind = path.stat().st_mode
        if stat.S_ISDIR(kind):
            if (path / "metadata.yaml").exists():
                return Format("rosbag2", BAG, "ros")
            raise InputError(printable(f"{path}: is a folder without metadata.yaml, a log or the folder of a bag is required"))
        if not stat.S_ISREG(kind):
            raise InputError(printable(f"{path}: is a pipe or a device, a file is required"))
        with path.open("rb") as file:
            first = file.read(max(map(len, _BEGINNINGS)))
    except OSError as error:
        raise InputError(printable(f"{path}: the log can not be read: {error.strerror}")) from None
    return next((known for beginning, known in _BEGINNINGS.items() if first.startswith(beginning)), _TEXT)


def is_text(path: Path) -> bool:
    """Whether the C++ reader of CSV files reads a file."""
    return format_of(path) is _TEXT


_most_mebibytes = 2048


def limit_inputs(mebibytes: int) -> None:
    """The largest text that is read from now on, and the most memory that a log of another format takes while it is read [MiB].

    Without it they are 16384 and 2048, with which a bag or a .npz of some hours is read. It holds for this process.
    """
    global _most_mebibytes
    if not isinstance(mebibytes, int) or not 1 <= mebibytes < 2**42:
        raise InputError(f"limit_inputs: mebibytes is {mebibytes!r}, must be a whole number from 1 to 2⁴²")
    _rivid.limit_inputs(mebibytes << 20)
    _most_mebibytes = mebibytes


def read(path: Path) -> Table:
    """The columns of a file: vectors of one length, of numbers, times or words.

    Raises InputError for what can not be read.
    """
    head, body = _answer("read", path)
    table, offset = {}, 0
    for name, kind, count in head:
        table[name] = np.frombuffer(body, kind, count, offset)
        offset += table[name].nbytes
    return table


def contents(path: Path) -> list[str]:
    """What a file holds, one line each."""
    return _answer("contents", path)[0]


def beyond_numbers(path: Path) -> Table:
    """The columns of a text with dates, seconds with nanoseconds, or empty cells, which C++ does not read; nothing of another."""
    try:
        table = read(path)
    except InputError:
        return {}
    return table if has_more_than_numbers(table) else {}


# With this sys.path, so that it imports what this process would.
_PROGRAM = "import sys; sys.path[:] = sys.argv.pop(1).split('\\n'); from rivid.formats.reader import main; main()"
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1", "ARROW_DEFAULT_MEMORY_POOL": "system"}
_SECONDS = (60, 10)  # of a processor: for a file, and more for each MiB of it
_PATIENCE = 20  # times as long on the clock, for what waits and does not work


def _answer(function: str, path: Path) -> tuple[Any, memoryview]:
    """What a function of the module of its format says of a file: the head of the answer, and the bytes of the columns."""
    import subprocess
    import tempfile

    found = format_of(path)
    seconds = _SECONDS[0] + _SECONDS[1] * (path.stat().st_size >> 20)
    with tempfile.TemporaryDirectory(prefix="rivid_") as scratch:
        program = [sys.executable, "-I", "-B", "-c", _PROGRAM, "\n".join(map(str, sys.path))]
        command = [*program, function, *found, str(path), str(_most_mebibytes), str(seconds)]
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        try:
            done = subprocess.run(command, env=os.environ | _ONE_THREAD | {"TMPDIR": scratch}, timeout=_PATIENCE * seconds, check=False, **quiet)
        except subprocess.TimeoutExpired:
            done = subprocess.CompletedProcess(command, -signal.SIGXCPU, b"")
    end = done.stdout.find(b"\n") + 1
    if done.returncode == 0 and end:
        head = json.loads(done.stdout[:end])
        if isinstance(head, str):
            raise InputError(head)
        return head, memoryview(done.stdout)[end:]
    why = f"the library that reads {found.name} ended by itself"
    if done.returncode == -signal.SIGXCPU:
        why = f"it takes more than {seconds} s of a processor, or waits for ever"
    elif done.returncode < 0:
        why = f"the library that reads {found.name} crashed ({signal.Signals(-done.returncode).name})"
    raise InputError(printable(f"{path}: can not be read: {why}; the file is damaged, or made to do so"))
