"""Tables of results."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_text(item) for item in value) + "]"
    return str(value)


class Table(Sequence[Mapping[str, Any]]):
    """Rows with named columns, as a document of rivid lists them.

    ``table["value"]`` is a column: an array where it holds numbers (not a number where the document has null), else a list.
    ``table[3]`` is a row, ``table.row("ZZ1R")`` that of a name. ``pandas()`` makes a DataFrame, with the names as index.
    """

    def __init__(self, rows: Sequence[Mapping[str, Any]], shown: Sequence[str] = ()) -> None:
        self._rows = [dict(row) for row in rows]
        self._shown = list(shown)

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self._rows[0]) if self._rows else []

    def row(self, name: str) -> Mapping[str, Any]:
        """The row of a name.

        Raises KeyError where there is none.
        """
        for row in self._rows:
            if row.get("name") == name:
                return row
        raise KeyError(f"there is no {name!r}, only {', '.join(str(row.get('name')) for row in self._rows)}")

    def pandas(self) -> Any:
        """A pandas.DataFrame of the table."""
        import pandas

        frame = pandas.DataFrame({name: list(self[name]) for name in self.columns})
        return frame.set_index("name") if "name" in frame else frame

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[Mapping[str, Any]]:
        return iter(self._rows)

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return self._rows[key]
        if key not in self.columns:
            raise KeyError(f"there is no column {key!r}, only {', '.join(self.columns)}")
        values = [row.get(key) for row in self._rows]
        if any(map(_is_number, values)) and all(value is None or _is_number(value) for value in values):
            return np.array([np.nan if value is None else value for value in values], dtype=float)
        return values

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        names = [name for name in self._shown if name in self.columns] or [
            name for name in self.columns if not isinstance(self._rows[0][name], Mapping)
        ]
        return names, [[_text(row.get(name)) for name in names] for row in self._rows]

    def __repr__(self) -> str:
        names, rows = self._cells()
        widths = [max(map(len, column)) for column in zip(names, *rows)]
        return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in (names, *rows))

    def _repr_html_(self) -> str:
        names, rows = self._cells()

        def line(cells: Sequence[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        body = "\n".join(line(row, "td") for row in rows)
        return f"<table>\n<thead>{line(names, 'th')}</thead>\n<tbody>\n{body}\n</tbody>\n</table>"
