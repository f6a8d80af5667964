"""Many robots and long studies on many machines, by Dask: pip install 'rivid[dask]'.

Each task is one experiment or a few runs of a study. What goes through the scheduler are paths, settings and results; logs are read where
the work is done, so that paths must mean the same on all machines. No result depends on the number of workers, and what a worker
leaves undone is done by another.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from distributed import Client, as_completed

from rivid import _rivid
from rivid.experiment import Experiment
from rivid.fit import identify
from rivid.montecarlo import MonteCarloResults, Study
from rivid.table import Table

if TYPE_CHECKING:
    from rivid.types import Progress, Settings


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
    futures = client.map(_run, pieces, path=Path(path), settings=settings, pure=False)
    rows: list[_rivid.MonteCarloRow] = []
    for done, (_, found) in enumerate(as_completed(futures, with_results=True), start=1):
        rows += found
        if progress is not None:
            progress("runs", done / len(pieces))
    return study.results(rows)


def identify_fleet(
    experiments: Iterable[str | PathLike[str]],
    *,
    client: Client,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Fleet:
    """Identifies one robot for each experiment file. An experiment that can not be read or used is part of the answer."""
    paths = [Path(path) for path in experiments]
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
    known = sorted(value for value in values if value is not None)
    if not known:
        return float("nan")
    middle = len(known) // 2
    return known[middle] if len(known) % 2 else 0.5 * (known[middle - 1] + known[middle])


def _run(runs: list[int], path: Path, settings: Settings | None) -> list[_rivid.MonteCarloRow]:
    return Study(path, settings).run(runs)


def _identified(path: Path, settings: Settings | None) -> dict[str, Any]:
    try:
        return identify(Experiment(path, settings)).document
    except _rivid.Error as error:
        return {"error": str(error)}
