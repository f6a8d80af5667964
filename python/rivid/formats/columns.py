"""Tables of columns: nested variables flattened, time stamps in seconds, and empty cells filled."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from rivid._rivid import InputError, nanoseconds_of

_UNPRINTABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff]")


def printable(text: str) -> str:
    """A text of a file with control characters, and bytes that are no UTF-8, as '?'."""
    return _UNPRINTABLE.sub("?", text)


def flattened(variables: Mapping[str, Any], source: str) -> dict[str, Any]:
    """Columns of variables that are vectors, matrices with one row or one column a sample, or such in structs.

    A matrix "q" becomes "q1", "q2", …; one with one column a sample is turned. The number of samples is that of most series.
    """
    series: dict[str, Any] = {}

    def add(name: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for key, item in value.items():
                add(f"{name}.{key}" if name else str(key), item)
        elif not isinstance(value, str):
            # Masked samples are empty cells.
            masked = np.ma.is_masked(value) and value.dtype.kind in "fiub"
            array = value.astype(float).filled(np.nan) if masked else np.asarray(value)
            array = array.squeeze() if array.ndim > 1 else array
            if array.ndim in (1, 2) and array.size > 1 and (array.ndim == 1 or array.dtype.kind in "fiub"):
                series[name] = array

    add("", variables)
    if not series:
        raise InputError(f"{source}: holds no series; there is {', '.join(map(repr, variables)) or 'nothing'}")
    lengths = [n for array in series.values() for n in ({len(array)} if array.ndim == 1 else set(array.shape))]
    rows = max(set(lengths), key=lambda n: (lengths.count(n), n))
    out: dict[str, Any] = {}
    for name, array in series.items():
        if array.ndim == 2 and len(array) != rows and array.shape[1] == rows:
            array = array.T
        if len(array) != rows:
            continue
        if array.ndim == 1:
            out[name] = array
        else:
            out |= {f"{name}{j + 1}": array[:, j] for j in range(array.shape[1])}
    return out


_EPOCHS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
_OFFSET = re.compile(r"(.*:\d.*?) ?(Z|[+-]\d\d(?::?\d\d)?)$")


def _instant(text: str) -> np.datetime64:
    """A date and time as ISO 8601 writes it, in UTC; no time where the cell is empty."""
    text = text.strip().replace(",", ".")
    shift = np.timedelta64(0, "s")
    if found := _OFFSET.fullmatch(text):
        text = found[1]
        if found[2] != "Z":
            sign, digits = found[2][0], found[2][1:].replace(":", "").ljust(4, "0")
            shift = np.timedelta64(int(sign + "1") * (60 * int(digits[:2]) + int(digits[2:])), "m")
    return np.datetime64(text or "NaT", "ns") - shift


def _seconds(array: Any) -> Any | None:
    """Time stamps in seconds from the first on, where they are dates, ISO texts or whole numbers since 1970."""
    if array.dtype.kind in "OUST":
        try:
            array = np.array([_instant(str(value)) for value in array], dtype="datetime64[ns]")
        except ValueError:
            return None
    if array.dtype.kind == "M":
        known = array[~np.isnat(array)]
        return (array - known[0]) / np.timedelta64(1, "s") if known.size else None
    if array.dtype.kind in "iu":
        for least, scale in _EPOCHS:
            if array[0] >= least:
                return (array - array[0]) * scale
    return None


def with_seconds(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table with a column "t" in seconds in place of seconds and nanoseconds, dates, ISO texts or stamps since 1970."""
    out = dict(table)
    names = list(table)
    if "t" in out and np.asarray(out["t"]).dtype.kind == "f":
        return out
    for name in table:
        nanoseconds = nanoseconds_of(name, names)
        if nanoseconds and all(np.asarray(table[one]).dtype.kind in "fiub" for one in (name, nanoseconds)):
            whole = np.asarray(table[name], dtype=float)  # exact up to 2^53
            known = whole[np.isfinite(whole)]
            out["t"] = (whole - (known[0] if known.size else 0.0)) + np.asarray(table[nanoseconds], dtype=float) * 1e-9
            return out
    for name in table:
        if re.search(r"time|stamp|^t$", name, re.IGNORECASE) and len(table[name]):
            stamps = _seconds(np.asarray(table[name]))
            if stamps is not None:
                del out[name]
                out["t"] = stamps
                return out
    return out


def has_more_than_numbers(table: Mapping[str, Any]) -> bool:
    """Whether there are dates, seconds with nanoseconds, or columns of numbers some of whose cells are empty."""
    with_time = with_seconds(table)
    return ("t" in with_time and "t" not in table) or any(
        column.dtype.kind == "f" and 0 < np.count_nonzero(np.isnan(column)) < len(column) for column in table.values()
    )


_MOST_PERIODS = 10.0


def complete(names: list[str], values: Any, clock: str, leading: Iterable[str]) -> tuple[Any, list[str]]:
    """Rows without empty cells, which merged topics have.

    The rows are those where `clock` and the `leading` columns have a value. What came at other times is interpolated linearly
    between its own samples, over no more than ten of its periods; a row that still lacks a value is left out.
    """
    empty = np.isnan(values)
    if not empty.any():
        return values, []
    at = names.index(clock)
    kept = ~empty[:, [at, *map(names.index, leading)]].any(axis=1)
    out = values[kept]
    t = out[:, at]
    for j in range(values.shape[1]):
        known = ~empty[:, j] & ~empty[:, at]
        gaps = np.isnan(out[:, j])
        if not gaps.any() or np.count_nonzero(known) < 2:
            continue
        stamps, column = values[known, at], values[known, j]
        after = np.searchsorted(stamps, t[gaps]).clip(1, len(stamps) - 1)
        near = stamps[after] - stamps[after - 1] <= _MOST_PERIODS * np.median(np.diff(stamps))
        inside = (t[gaps] >= stamps[0]) & (t[gaps] <= stamps[-1]) & near
        out[gaps, j] = np.where(inside, np.interp(t[gaps], stamps, column), np.nan)
    out = out[~np.isnan(out).any(axis=1)]
    return out, [
        f"{np.count_nonzero(empty.any(axis=1))} of {len(values)} rows have empty cells; {len(out)} rows were made of them, "
        "with linear interpolation of what has no value at the instants of the positions"
    ]
