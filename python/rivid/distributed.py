"""Many logs, many robots and long studies on many machines, by Dask: pip install 'rivid[dask]'.

Each task is one log, one experiment or a few runs of a study. What goes through the scheduler are paths, settings and results; logs are read where
the work is done, so that paths must mean the same on all machines. No result depends on the number of workers, and what a worker
leaves undone is done by another.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from distributed import Client, Future, as_completed

from rivid import _rivid
from rivid import identify as identify_here
from rivid._arrays import path_of
from rivid._keys import Method, toml
from rivid._options import Auto
from rivid.experiment import Experiment
from rivid.fit import Fit
from rivid.log import Log, read_logs
from rivid.montecarlo import MonteCarloResults, Study
from rivid.robot import Robot
from rivid.table import Table

if TYPE_CHECKING:
    from rivid.types import LogSource, Progress, Settings


def montecarlo(
    path: str | PathLike[str],
    *,
    client: Client,
    runs: int | None = None,
    settings: Settings | None = None,
    runs_a_task: int = 10,
    progress: Progress | None = None,
) -> MonteCarloResults:
    """``rivid.montecarlo`` on the workers of a client: the same rows, save the seconds that identifications took."""
    study = Study(path, settings)
    count = study.runs if runs is None else runs
    pieces = [list(range(first, min(first + runs_a_task, count))) for first in range(0, count, runs_a_task)]
    futures = client.map(_run, pieces, path=path_of("montecarlo: path", path), settings=settings, pure=False)
    rows: list[_rivid.MonteCarloRow] = []
    for done, (_, found) in enumerate(as_completed(futures, with_results=True), start=1):
        rows += found
        if progress is not None:
            progress("runs", done / len(pieces))
    return study.results(rows)


def identify(
    robot: Robot,
    logs: Sequence[str | PathLike[str]],
    method: Method | None = None,
    *,
    client: Client,
    validation: LogSource | Iterable[LogSource] | None = None,
    logs_a_task: int = 1,
    progress: Progress | None = None,
) -> Fit:
    """``rivid.identify`` from many logs: a task reduces a log, or ``logs_a_task``, to factors, which are merged in a tree. ``Iv`` has
    the loops of all logs simulated where these are, iteration by iteration.

    ``logs`` are files that the workers can read; they never pass through the client. Where ``decimation`` is left open, the first log
    chooses the rows of all. The estimate is the same bit by bit whatever the number of workers, and that of one process to rounding: to the
    last bit where one task takes all logs.
    Standard deviations come from blocks of time, see docs/scale.md; residuals are not looked at.

    Raises InputError for a log that can not be used, and for what needs all samples: ``Didim``, ``OutputError``, and the options
    ``prefilter``, ``robust`` and ``essential``.
    """
    paths = [path_of("identify: logs", log) for log in logs]
    if not paths:
        raise _rivid.InputError("identify: no log is given")
    prepare = client.submit(_Plan.made, robot, method or Auto(), paths[0], len(paths), pure=False)
    parts = [paths[k : k + logs_a_task] for k in range(0, len(paths), logs_a_task)]
    level = client.map(_factored, parts, plan=prepare, pure=False)
    if progress is not None:
        for done, _ in enumerate(as_completed(level), start=1):
            progress("logs", done / len(level))
    plan, content = client.gather([prepare, _tree(client, _merged, level)])

    def loops(request: bytes) -> bytes:
        if progress is not None:
            progress("loops", 0.0)
        level = client.map(_looped, parts, plan=prepare, request=request, pure=False)
        return client.gather(_tree(client, _merged_loops, level))

    found, inputs = _rivid.identify_factors(robot._robot, content, plan.sections, _SOURCE, loops)
    fit = _FitOfFactors(robot, found, paths, inputs)
    for one in [] if validation is None else read_logs(validation, robot):
        fit.validate(one)
    return fit


def identify_fleet(
    experiments: Iterable[str | PathLike[str]],
    *,
    client: Client,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Fleet:
    """Identifies one robot for each experiment file. An experiment that can not be read or used is part of the answer."""
    paths = [path_of("identify_fleet: experiments", path) for path in experiments]
    if len(set(paths)) < len(paths):
        raise _rivid.InputError("identify_fleet: an experiment is named twice")
    futures = {client.submit(_identified, path, settings, pure=False): path for path in paths}
    found: dict[Path, dict[str, Any]] = {}
    for future, document in as_completed(futures, with_results=True):
        found[futures[future]] = document
        if progress is not None:
            progress("robots", len(found) / len(paths))
    return Fleet({path: found[path] for path in paths})


class Fleet:
    """What the identifications of many robots found, in the order of their experiments."""

    def __init__(self, documents: Mapping[Path, Mapping[str, Any]]) -> None:
        self.documents = dict(documents)
        """result.json of each experiment, or ``{"error": message}``."""

    @property
    def robots(self) -> Table:
        """Status of each experiment."""
        return Table(
            [
                {
                    "experiment": str(path),
                    "status": document.get("status", "error"),
                    "relative_error": document["fit"]["relative_error"] if "fit" in document else None,
                    "warnings": len(document.get("warnings", [])),
                    "why": document.get("error") or "; ".join(document.get("reasons", [])),
                }
                for path, document in self.documents.items()
            ]
        )

    @property
    def parameters(self) -> Table:
        """One row for each experiment and parameter, with how far its value is from the median of the robots that have a parameter of
        that name, in standard deviations of the value."""
        rows = [
            {"experiment": str(path), **{key: p[key] for key in ("name", "value", "unit", "sigma", "verdict")}}
            for path, document in self.documents.items()
            for p in document.get("parameters", [])
        ]
        medians = {name: _median([r["value"] for r in rows if r["name"] == name]) for name in {r["name"] for r in rows}}
        for row in rows:
            known = row["value"] is not None and row["sigma"]
            row["from_median"] = (row["value"] - medians[row["name"]]) / row["sigma"] if known else None
        return Table(rows)

    def to_parquet(self, path: str | PathLike[str]) -> None:
        """Writes ``parameters`` by pyarrow."""
        import pyarrow
        import pyarrow.parquet

        pyarrow.parquet.write_table(pyarrow.Table.from_pylist(list(map(dict, self.parameters))), path)

    def __repr__(self) -> str:
        return repr(self.robots)


def _median(values: list[float | None]) -> float:
    known = [value for value in values if value is not None]
    return median(known) if known else float("nan")


_MERGED_AT_ONCE = 8
_BLOCKS = 10  # of all logs together at least
_SOURCE = "rivid.distributed.identify"


class _Plan:
    """What all tasks of one identification share."""

    def __init__(self, robot: Robot, sections: str, blocks: int) -> None:
        self.robot = robot
        self.sections = sections
        self.blocks = blocks

    @staticmethod
    def made(robot: Robot, method: Method, first: Path, logs: int) -> _Plan:
        sections = method.sections()
        pilot = [log._log for log in read_logs(first, robot)]
        signal = json.loads(_rivid.chosen_signal(robot._robot, pilot, _text(sections), _SOURCE))
        return _Plan(robot, _text({**sections, "signal": {**sections["signal"], **signal}}), max(1, round(_BLOCKS / logs)))


class _FitOfFactors(Fit):
    """A fit whose logs are read again where somebody asks for what needs them."""

    def __init__(self, robot: Robot, found: _rivid.Identification, paths: list[Path], inputs: list[tuple[str, str]]) -> None:
        super().__init__(robot, found, None, [])
        self._paths = paths
        self._read = inputs

    def _files(self) -> list[Path]:
        return super()._files() + self._paths

    def _log_inputs(self) -> list[tuple[str, str]]:
        return self._read

    def _training(self) -> list[Log]:
        if self._logs is None:
            self._logs = read_logs(self._paths, self.robot)
        return self._logs


def _text(sections: Mapping[str, Mapping[str, Any]]) -> str:
    return "\n".join(f"{name} = {toml(keys)}" for name, keys in sections.items())


def _factored(paths: list[Path], plan: _Plan) -> bytes:
    def factors(path: Path) -> bytes:
        logs = [(log._log, log.digest()) for log in read_logs(path, plan.robot)]
        return _rivid.factors(plan.robot._robot, logs, plan.sections, _SOURCE, plan.blocks)

    return _merged([factors(path) for path in paths])


def _merged(parts: list[bytes]) -> bytes:
    return _rivid.merged_factors(parts)


def _looped(paths: list[Path], plan: _Plan, request: bytes) -> bytes:
    def loops(path: Path) -> bytes:
        logs = [log._log for log in read_logs(path, plan.robot)]
        return _rivid.loop_factors(plan.robot._robot, logs, plan.sections, _SOURCE, request, plan.blocks)

    return _merged_loops([loops(path) for path in paths])


def _merged_loops(parts: list[bytes]) -> bytes:
    return _rivid.merged_loop_factors(parts)


def _tree(client: Client, merged: Callable[[list[bytes]], bytes], level: list[Future]) -> Future:
    while len(level) > 1:
        # Of a level that is merged nobody holds a future: its memory is given back, and what a lost worker
        # held is made again.
        level = [client.submit(merged, level[k : k + _MERGED_AT_ONCE], pure=False) for k in range(0, len(level), _MERGED_AT_ONCE)]
    return level[0]


def _run(runs: list[int], path: Path, settings: Settings | None) -> list[_rivid.MonteCarloRow]:
    return Study(path, settings).run(runs)


def _identified(path: Path, settings: Settings | None) -> dict[str, Any]:
    try:
        return identify_here(Experiment(path, settings)).document
    except _rivid.Error as error:
        return {"error": str(error)}
