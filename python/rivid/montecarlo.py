"""Monte Carlo studies."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

from rivid import _rivid
from rivid._arrays import path_of
from rivid._keys import settings_of
from rivid.robot import Robot
from rivid.table import Table

if TYPE_CHECKING:
    from rivid.types import Progress, Settings


class Study:
    """Many simulated experiments, each identified in several ways: [montecarlo] of an experiment file.

    Run k, counted from 0, has the seed of the file plus k: ``study.run(range(100, 200))`` gives the same rows on any machine and
    in any order. ``results(rows)`` sums up.
    """

    def __init__(self, path: str | PathLike[str], settings: Settings | None = None) -> None:
        self._arguments = (path_of("Study: path", path), settings)
        self._study = _rivid.MonteCarlo(self._arguments[0], settings_of(settings))

    def __reduce__(self) -> Any:
        return Study, self._arguments

    @property
    def runs(self) -> int:
        """Runs that the file asks for."""
        return self._study.runs

    @cached_property
    def robot(self) -> Robot:
        """That is simulated."""
        return Robot._of(self._study.robot)

    def run(
        self, runs: Iterable[int], *, threads: int = 1, progress: Progress | None = None
    ) -> list[_rivid.MonteCarloRow]:
        """Rows of these runs, one a trial each."""
        return self._study.run(list(runs), threads, progress)

    def results(self, rows: Iterable[_rivid.MonteCarloRow]) -> MonteCarloResults:
        """What rows amount to, in whatever order they come."""
        return MonteCarloResults(self, sorted(rows, key=lambda row: row.run))


class MonteCarloResults:
    """What a study found: for each trial bias, spread, and coverage of the intervals of each parameter."""

    def __init__(self, study: Study, rows: list[_rivid.MonteCarloRow]) -> None:
        self.study = study
        self.rows = rows

    @cached_property
    def document(self) -> Any:
        """The content of summary.json."""
        return json.loads(self.study._study.summary(self.rows))

    @property
    def trials(self) -> dict[str, Table]:
        """The parameters of each trial by its label."""
        return {trial["label"]: Table(trial["parameters"]) for trial in self.document["trials"]}

    def to_html(self, path: str | PathLike[str] | None = None) -> str:
        """The report as one page: written to ``path`` where there is one, and returned.

        Raises InputError where ``path`` is a file of the study, or is there and no HTML.
        """
        page = self.study._study.html(self.rows)
        if path is not None:
            _rivid.write_file(path_of("MonteCarloResults.to_html: path", path), page, ".html", self.study._study.inputs)
        return page

    def __str__(self) -> str:
        return self.study._study.text(self.rows)


def montecarlo(
    path: str | PathLike[str],
    *,
    runs: int | None = None,
    settings: Settings | None = None,
    threads: int = 1,
    progress: Progress | None = None,
) -> MonteCarloResults:
    """Simulates and identifies an experiment many times, and reports bias, coverage and precision."""
    study = Study(path, settings)
    return study.results(study.run(range(study.runs if runs is None else runs), threads=threads, progress=progress))
