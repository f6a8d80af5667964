"""Text that the reader of the library, one number a cell, does not take: empty cells of merged topics, dates of other forms."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from rivid._rivid import InputError


def read(path: Path) -> dict[str, Any]:
    """The columns of a text with a header: numbers, with NaN where a cell is empty, or words."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        first = file.readline()
        separator = max(",;\t", key=first.count)
        file.seek(0)
        lines = csv.reader((line for line in file if line.strip() and line[0] not in "#%"), delimiter=separator)
        names = [name.strip().removeprefix("\ufeff") for name in next(lines, [])]
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
