"""Parquet and Feather, by pyarrow."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.feather
import pyarrow.parquet

from rivid.formats.columns import flattened


def _table(path: Path) -> pyarrow.Table:
    with path.open("rb") as file:
        parquet = file.read(4) == b"PAR1"
    # Without threads, which wait for each other for ever where one finds no memory.
    if parquet:
        with pyarrow.parquet.ParquetFile(path, pre_buffer=False) as opened:
            return opened.read(use_threads=False)
    return pyarrow.feather.read_table(path, use_threads=False, memory_map=False)


def _column(column: pyarrow.ChunkedArray) -> Any:
    kind = column.type
    if pyarrow.types.is_list(kind) or pyarrow.types.is_fixed_size_list(kind) or pyarrow.types.is_large_list(kind):
        rows = column.to_pylist()
        widths = {len(row) for row in rows if row is not None}
        if len(widths) != 1:
            return np.array([str(row) for row in rows])
        width = widths.pop()
        return np.array([[np.nan] * width if row is None else row for row in rows])
    return column.to_numpy()


def columns_of(table: pyarrow.Table) -> dict[str, Any]:
    """The columns of an Arrow table as arrays; a column of lists is a matrix, a struct is several columns."""
    table = table.combine_chunks()
    while any(pyarrow.types.is_struct(kind) for kind in table.schema.types):
        table = table.flatten()
    return {name: _column(table[name]) for name in table.column_names}


def read(path: Path) -> dict[str, Any]:
    """The columns of a file."""
    return flattened(columns_of(_table(path)), str(path))


def contents(path: Path) -> list[str]:
    """Names and types of the columns."""
    table = _table(path)
    return [f"{field.name}  {field.type}, {table.num_rows} rows" for field in table.schema]
