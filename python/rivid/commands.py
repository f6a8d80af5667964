"""What the program does with results, from Python: exported models, and models compared."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from rivid import _rivid
from rivid._arrays import path_of
from rivid._tools import program
from rivid.fit import Fit
from rivid.log import read_logs

if TYPE_CHECKING:
    from rivid.types import LogSource


def _run(*words: object) -> str:
    done = subprocess.run([program(), *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode > 1 or not done.stdout and done.returncode:
        raise _rivid.InputError(done.stderr.strip().removeprefix(f"rivid {words[0]}: error: "))
    return done.stdout


def export(
    fit: Fit | str | PathLike[str],
    to: str,
    output: str | PathLike[str],
    *,
    urdf: str | PathLike[str] | None = None,
    samples: int | None = None,
    seed: int = 1,
    force: bool = False,
) -> Path:
    """Writes a fit, or a result.json, as a model for another program; returns the path of its main file.

    ``to`` is "mjcf", "sdf", "drake", "pinocchio", "urdf" or "header", as of ``rivid export``. All but the last need physically consistent parameters and the
    URDF of the robot, which ``urdf`` names where the result does not know it.

    With ``samples``, so many robots drawn from the distribution of the fit, or with "npz" their parameters as arrays; returns the path of the manifest, which
    names the files.

    Raises InputError where ``rivid export`` writes nothing.
    """
    path = path_of("export: output", output)
    with TemporaryDirectory() as folder:
        options = ["--urdf", path_of("export: urdf", urdf)] if urdf is not None else []
        options += ["--samples", str(samples), "--seed", str(seed)] if samples is not None else []
        options += ["--force"] if force else []
        _run("export", _result(fit, Path(folder) / "result.json"), "--to", to, "--output", path, *options)
    return path if samples is None else path.with_name(f"{path.stem}_samples.json")


def compare(
    models: Iterable[Fit | str | PathLike[str]] | Mapping[str, Fit | str | PathLike[str]],
    log: LogSource | Iterable[LogSource],
    *,
    threads: int = 1,
    rollout: bool = False,
) -> dict[str, Any]:
    """Judges models by the torques that they predict on logs: the content of comparison.json, see docs/compare.md.

    ``models`` are fits, paths of result.json, URDFs or parameter files, perhaps by names; the first one is a fit or a result, by whose signal chain the rows are
    made. ``log`` is whatever ``read_logs`` takes. ``rollout`` simulates windows of the logs, driven by their torques, as well.
    """
    named = models if isinstance(models, Mapping) else {_name(model, k): model for k, model in enumerate(models, start=1)}
    opened = {name: Fit.load(m) if not isinstance(m, Fit) and Path(m).suffix == ".json" else m for name, m in named.items()}
    first = next(iter(opened.values()), None)
    if not isinstance(first, Fit):
        raise TypeError("compare: the first model must be a fit or a result.json, which says how rows are made of the logs")
    with TemporaryDirectory() as folder:
        files, logs = [], []
        for k, model in enumerate(opened.values()):
            files.append(Path(folder) / f"{k}.json" if isinstance(model, Fit) else path_of("compare: model", model))
            if isinstance(model, Fit):
                # Logs are written by the usual names below, whatever an experiment file calls the columns.
                document = dict(model.document)
                document["provenance"] = {**document["provenance"], "inputs": []}
                files[-1].write_text(json.dumps(document), encoding="utf-8")
        for k, one in enumerate(read_logs(log, first.robot)):
            logs.append(Path(folder) / f"log_{k}.csv")
            one.to_csv(logs[-1])
        out = json.loads(_run("compare", *files, "--log", *logs, "--threads", threads, "--json", *["--rollout"] * rollout))
    for rows in (out["models"], *(one["models"] for one in out.get("rollouts", {}).get("found", []))):
        for row, name in zip(rows, opened):
            row["name"] = name
    return out


def explain(code: str) -> str:
    """Cause and cure of a finding or a status. Raises KeyError for an unknown code."""
    text = _rivid.explanation(code)
    if text is None:
        raise KeyError(code)
    return text


def _result(fit: Fit | str | PathLike[str], file: Path) -> Path:
    if not isinstance(fit, Fit):
        return path_of("export: fit", fit)
    fit.save(file)
    return file


def _name(model: Fit | str | PathLike[str], number: int) -> str:
    return f"model {number}" if isinstance(model, Fit) else str(model)
