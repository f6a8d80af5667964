"""Text that the reader of the library, one number a cell, does not take: empty cells of merged topics, dates of other forms."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rivid._rivid import InputError
from rivid.formats.columns import with_seconds


def parsed(path: Path) -> dict[str, Any]:
    """The columns of a text as `read` gives them, nothing where it can not be read so."""
    try:
        return read(path)
    except (InputError, OSError, UnicodeDecodeError, StopIteration):
        return {}


def has_more_than_numbers(table: Mapping[str, Any]) -> bool:
    """Whether there are dates, seconds with nanoseconds, or columns of numbers some of whose cells are empty."""
    with_time = with_seconds(table)
    return ("t" in with_time and "t" not in table) or any(
        column.dtype.kind == "f" and 0 < np.count_nonzero(np.isnan(column)) < len(column) for column in table.values()
    )


def read(path: Path) -> dict[str, Any]:
    """The columns of a text with a header: numbers, with NaN where a cell is empty, or words."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        first = file.readline()
        separator = max(",;\t", key=first.count)
        file.seek(0)
        lines = csv.reader((line for line in file if line.strip() and line[0] not in "#%"), delimiter=separator)
        names = [name.strip().removeprefix("\ufeff") for name in next(lines)]
        cells = list(lines)
    for number, row in enumerate(cells, start=2):
        if len(row) != len(names):
            raise InputError(f"{path}: row {number} has {len(row)} fields, {len(names)} are required")
    return {name: _column([row[j] for row in cells]) for j, name in enumerate(names)}


def _column(cells: list[str]) -> Any:
    try:
        return np.array([float(cell) if cell.strip() else np.nan for cell in cells])
    except ValueError:
        return np.array([cell.strip() for cell in cells], dtype=object)
