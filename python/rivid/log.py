"""Logs: from arrays, from tables in memory, and from files of any format."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rivid import _rivid, formats
from rivid._arrays import floats, instance_of, path_of
from rivid._keys import toml_keys
from rivid.findings import Finding, findings_of
from rivid.formats.columns import complete, flattened, printable, with_seconds
from rivid.robot import Robot

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from rivid._options import LogKeys
    from rivid.types import ArrayLike, Floats, LogSource, Progress


class Log:
    """What was recorded while a robot moved: one row a sample, one column a joint, in SI units on the joint side.

    ``t`` are instants [s]; a number instead is the rate in Hz. ``q`` are positions [rad | m]; beside them either torques ``tau``
    [N·m | N] or control signals ``v_tau`` are needed to identify a robot, and references ``q_r`` for instrumental variables.
    Series of one joint may be vectors. Raises InputError where sizes differ, a value is not finite, or the time stamps are
    irregular: ``rivid.read_logs`` resamples such.
    """

    _log: _rivid.Log
    _files: tuple[str | PathLike[str], ...]  # that it was read from

    def __init__(
        self,
        t: ArrayLike,
        q: ArrayLike,
        tau: ArrayLike | None = None,
        *,
        v_tau: ArrayLike | None = None,
        q_r: ArrayLike | None = None,
        qd_r: ArrayLike | None = None,
        qd: ArrayLike | None = None,
        source: str = "log",
    ) -> None:
        names: list[str] = []
        series: list[Floats] = []
        rate = None
        stamps = floats("Log: t", t)
        if stamps.ndim == 0:
            rate = float(stamps)
        else:
            names.append("t")
            series.append(_columns("t", stamps))
            if series[0].shape[1] != 1:
                raise _rivid.InputError(f"Log: t has {series[0].shape[1]} columns, must have one")
        given = {"q": ("q", q), "qd": ("qd", qd), "tau": ("tau", tau), "v": ("v_tau", v_tau)}
        for prefix, (name, values) in {**given, "qref": ("q_r", q_r), "qdref": ("qd_r", qd_r)}.items():
            if values is not None:
                columns = _columns(name, values)
                names += [f"{prefix}{j + 1}" for j in range(columns.shape[1])]
                series.append(columns)
        rows = {len(columns) for columns in series}
        if len(rows) > 1:
            raise _rivid.InputError(f"{source}: the series have {', '.join(map(str, sorted(rows)))} rows, must have as many each")
        if rows == {0}:
            raise _rivid.InputError(f"{source}: the series have no rows, must have at least 2")
        values = np.empty((rows.pop(), len(names)), order="F")  # as the library has it
        np.concatenate(series, axis=1, out=values)
        self._log = _rivid.Log(source, names, values, rate)
        self._files = ()

    @classmethod
    def _of(cls, log: _rivid.Log, files: Iterable[str | PathLike[str]] = ()) -> Log:
        out = cls.__new__(cls)
        out._log = log
        out._files = tuple(files)
        return out

    @property
    def source(self) -> str:
        """What messages name it by."""
        return self._log.source

    @property
    def rate_hz(self) -> float:
        """Sampling rate [Hz]."""
        return self._log.f_m

    @property
    def t(self) -> Floats:
        """Instants [s]."""
        return self._log.t

    @property
    def q(self) -> Floats:
        """Measured positions [rad | m]."""
        return self._log.q

    @property
    def qd(self) -> Floats | None:
        """Measured velocities, where they were recorded [rad/s | m/s]."""
        return _recorded(self._log.qd)

    @property
    def tau(self) -> Floats | None:
        """Joint-side torques, where they were recorded [N·m | N]."""
        return _recorded(self._log.tau)

    @property
    def v_tau(self) -> Floats | None:
        """Control signals, where they were recorded."""
        return _recorded(self._log.v_tau)

    @property
    def q_r(self) -> Floats | None:
        """Reference positions, where they were recorded [rad | m]."""
        return _recorded(self._log.q_r)

    @property
    def qd_r(self) -> Floats | None:
        """Reference velocities, where they were recorded [rad/s | m/s]."""
        return _recorded(self._log.qd_r)

    @property
    def notes(self) -> list[str]:
        """What was found or done on the way in."""
        return self._log.notes

    @property
    def findings(self) -> list[Finding]:
        """What may make a result wrong."""
        return findings_of(self._log.findings)

    def shifted(self, lag: float) -> Log:
        """The log with torques and control signals ``lag`` samples earlier; −0.5 for a signal that is held to the next sample."""
        return Log._of(_rivid.shift_torque(self._log, lag), self._files)

    def digest(self) -> str:
        """SHA-256 of the numbers, by which a result names its input."""
        import hashlib

        digest = hashlib.sha256()
        for series in (self._log.t, self._log.q, self._log.tau, self._log.v_tau, self._log.q_r):
            digest.update(repr(series.shape).encode())
            digest.update(np.ascontiguousarray(series.T).tobytes())
        return digest.hexdigest()

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Writes the log so that the command line tools read it without further options.

        Raises InputError where that would replace a file that the log was read from, or one that is no CSV.
        """
        _rivid.write_file(path_of("Log.to_csv: path", path), self._log.to_csv(), ".csv", files_of(self))

    def __len__(self) -> int:
        return self._log.samples

    def __repr__(self) -> str:
        return f"<Log {self.source!r}: {len(self)} samples of {self._log.joints} joints at {self.rate_hz:g} Hz>"

    def __reduce__(self) -> Any:
        return Log._of, (self._log, self._files)


def read_logs(
    source: LogSource | Iterable[LogSource],
    robot: Robot,
    *,
    progress: Progress | None = None,
    **keys: Unpack[LogKeys],
) -> list[Log]:
    """Logs of a robot from files or tables.

    ``source`` is a file in one of the formats of docs/python.md, a pandas or polars DataFrame, an Arrow table, a mapping from
    names to columns, or a list of such. ``keys`` are those of [log] in an experiment file, as ``position=["q1", "q2"]``,
    ``units={"position": "deg"}``, ``irregular="resample"``. Where no column is named, those of the default names are taken, else
    those that ``rivid init`` would recognise; the notes of the log say which.

    A log with long gaps becomes several. Raises InputError for what can not be read or used.
    """
    instance_of("read_logs: robot", robot, Robot)
    if isinstance(source, (list, tuple)):
        return [log for item in source for log in read_logs(item, robot, progress=progress, **keys)]
    if isinstance(source, Log):
        if source._log.joints != len(robot):
            raise _rivid.InputError(
                f"{source.source}: {source._log.joints} position columns, robot {robot.name!r} has {len(robot)} joints"
            )
        return [source]
    if isinstance(source, (str, PathLike)):
        source = path_of("read_logs: source", source)
        name = printable(str(source))
        if formats.is_text(source):
            try:
                return _of_text(source, robot, keys, progress)
            except _rivid.InputError:
                # What has empty cells is completed below; what is wrong otherwise has been said best.
                if not (table := formats.beyond_numbers(source)):
                    raise
        else:
            table = formats.read(source)
    else:
        name, table = "table", _table(source)
    table = with_seconds(table)
    chosen, doubts = _chosen(list(table), robot, keys)
    wanted = _wanted(name, chosen, table)
    values = np.column_stack([np.asarray(table[column], dtype=float) for column in wanted])
    values, notes = _complete(name, chosen, wanted, values)
    text = toml_keys({**chosen, "files": [name]})
    logs = _rivid.logs_of(robot._robot, text, name, wanted, values)
    files = [source] if isinstance(source, Path) else []
    return [_noted(log, notes + doubts, files) for log in logs]


def _of_text(
    source: Path, robot: Robot, keys: Mapping[str, Any], progress: Progress | None
) -> list[Log]:
    chosen, doubts = _chosen(_rivid.column_names(source), robot, keys)
    text = toml_keys({**chosen, "files": [str(source)]})
    return [_noted(log, doubts, [source]) for log in _rivid.read_logs(robot._robot, text, str(source), progress)]


def read_log(source: LogSource, robot: Robot, *, progress: Progress | None = None, **keys: Unpack[LogKeys]) -> Log:
    """One log, as ``read_logs`` reads it. Raises InputError where gaps make several of it."""
    logs = read_logs(source, robot, progress=progress, **keys)
    if len(logs) != 1:
        raise _rivid.InputError(f"{logs[0].source}: long gaps split the log into {len(logs)}; rivid.read_logs returns them")
    return logs[0]


def files_of(*read: Log | Robot) -> list[Path]:
    """The files that logs and robots were read from, which nothing is written over."""
    return [Path(file) for one in read for file in one._files]


def _columns(name: str, values: ArrayLike) -> Floats:
    array = floats(f"Log: {name}", values)
    if array.ndim not in (1, 2):
        raise _rivid.InputError(f"Log: {name} has {array.ndim} dimensions, must have one row a sample and one column a joint")
    return array[:, np.newaxis] if array.ndim == 1 else array


def _recorded(values: Floats) -> Floats | None:
    return values if values.size else None


def _noted(log: _rivid.Log, notes: list[str], files: list[str | PathLike[str]]) -> Log:
    for note in notes:
        log.note(printable(note))
    return Log._of(log, files)


def _table(source: Any) -> Mapping[str, Any]:
    if hasattr(source, "column_names") and hasattr(source, "schema"):  # Arrow
        from rivid.formats.arrow import columns_of

        return columns_of(source)
    if isinstance(source, Mapping):
        return flattened(source, "the mapping")
    if hasattr(source, "columns") and hasattr(source, "__getitem__"):  # pandas, polars
        if getattr(getattr(source, "index", None), "name", None) is not None:
            source = source.reset_index()
        return {str(name): np.asarray(source[name]) for name in source.columns}
    raise TypeError(f"read_logs: source is {type(source).__name__}, must be a log, a file, a DataFrame or a mapping of columns")


_COLUMN_KEYS = ("position", "velocity", "torque", "control", "reference", "reference_velocity", "time")


def _chosen(names: list[str], robot: Robot, keys: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Keys of [log] that name the columns: those that were given, nothing where default names are there, else recognised ones."""
    default = _rivid.default_columns(names)
    if any(key in keys for key in _COLUMN_KEYS) or ("time" in default and len(default.get("position", [])) == len(robot)):
        return dict(keys), []
    found, doubts = _rivid.recognised(names, robot._robot)
    out = dict(keys)
    units = dict(keys.get("units") or {})
    notes = []
    for key, (columns, unit) in found.items():
        if key == "time" and "rate_hz" in keys:
            continue
        out[key] = columns[0] if key == "time" else columns
        if unit and key not in units:
            units[key] = unit
        notes.append(f"{key} taken from {columns[0]}" + (f" to {columns[-1]}" if len(columns) > 1 else "")
                     + (f" in {unit}" if unit else ""))
    if units:
        out["units"] = units
    return out, notes + doubts


def _wanted(source: str, keys: Mapping[str, Any], table: Mapping[str, Any]) -> list[str]:
    """Columns that are numbers; of those that were named all, so that a message can say what is wrong with them."""
    def is_number(name: str) -> bool:
        return np.asarray(table[name]).dtype.kind in "fiub"

    named: list[str] = []
    for key in _COLUMN_KEYS:
        value = keys.get(key)
        for item in [value] if isinstance(value, (str, int, Mapping)) else value or []:
            name = item["column"] if isinstance(item, Mapping) else item
            named.append(list(table)[name - 1] if isinstance(name, int) else name)
    if not named:
        return [name for name in table if is_number(name)]
    missing = [name for name in named if name not in table]
    if missing:
        raise _rivid.InputError(f"{source}: there is no column {missing[0]!r}; the columns are {', '.join(map(repr, table))}")
    words = [name for name in named if not is_number(name)]
    if words:
        raise _rivid.InputError(f"{source}: column {words[0]!r} holds {np.asarray(table[words[0]]).dtype}, must hold numbers")
    by_default = [name for columns in _rivid.default_columns(list(table)).values() for name in columns]
    return list(dict.fromkeys([*named, *filter(is_number, by_default)]))


def _complete(source: str, keys: Mapping[str, Any], names: list[str], values: Floats) -> tuple[Floats, list[str]]:
    """Rows without empty cells."""
    time = keys.get("time")
    clock = time["column"] if isinstance(time, Mapping) else time or ("t" if "t" in names else "time")
    if clock in names:
        return complete(names, values, clock, _positions(keys, names))
    if np.isnan(values).any():
        raise _rivid.InputError(f"{source}: there are empty cells, and no time column to interpolate over; name it by time=…")
    return values, []


def _positions(keys: Mapping[str, Any], names: list[str]) -> list[str]:
    listed = keys.get("position")
    if listed is None:
        return _rivid.default_columns(names).get("position", [])
    items = [listed] if isinstance(listed, (str, Mapping)) else listed
    return [item["column"] if isinstance(item, Mapping) else item for item in items]
