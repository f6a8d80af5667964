"""Identification, and its result."""

from __future__ import annotations

import base64
import csv
import io
import json
import warnings
from collections.abc import Iterable, Mapping
from functools import cached_property
from hashlib import sha256
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rivid import _rivid, plots
from rivid._arrays import instance_of, path_of
from rivid._keys import Method, text_of
from rivid._options import Auto
from rivid.experiment import Experiment
from rivid.findings import Finding, findings_of
from rivid.log import Log, files_of, read_logs
from rivid.robot import DynamicModel, Robot
from rivid.table import Table

if TYPE_CHECKING:
    from rivid.types import Booleans, Floats, Indices, LogSource, Progress

_SHOWN = ("name", "value", "unit", "sigma", "relative_sigma_percent", "interval_95", "verdict", "regrouped")
_WRITTEN = ("name", "value", "unit", "sigma", "low_95", "high_95", "verdict", "regrouped")


class RividWarning(UserWarning):
    """A fit that is not identified: an estimate that there are reasons not to trust, or none."""


def identify(
    robot: Robot | Experiment | str | PathLike[str],
    log: LogSource | Iterable[LogSource] | None = None,
    method: Method | None = None,
    *,
    validation: LogSource | Iterable[LogSource] | None = None,
    threads: int = 1,
    progress: Progress | None = None,
) -> Fit:
    """Identifies the base parameters of a robot from logs of its motion, whose rows are stacked.

    ``identify(robot, log, Wls(...))``: ``log`` is whatever ``read_logs`` takes; ``method`` is ``Ols``, ``Wls``, ``Iv``, ``Didim``, ``OutputError`` or
    ``Auto``, the default. ``identify("my_robot.toml")`` does what an experiment file says.

    ``validation`` takes no part in the fit: its errors are part of the result and of its judgement. No result depends on ``threads``. ``progress(stage, fraction)`` is called now and
    then. Data that do not determine all parameters, and reasons not to trust an estimate, are no exception but a ``status`` and a RividWarning.

    Raises InputError where robot, logs and options do not fit together.
    """
    if isinstance(robot, (str, PathLike, Experiment)):
        if log is not None or method is not None:
            raise TypeError("identify: an experiment says log and method itself; see Experiment.logs and Robot.from_urdf")
        return _told(_of_experiment(robot if isinstance(robot, Experiment) else Experiment(robot), threads, progress))
    instance_of("identify: robot", robot, Robot)
    if log is None:
        raise TypeError("identify: a log is required beside the robot")
    method = Auto() if method is None else method
    sections = text_of(method, "identify")
    logs = read_logs(log, robot, progress=progress)
    others = [] if validation is None else read_logs(validation, robot, progress=progress)
    found, chosen = _rivid.identify(
        robot._robot,
        [log._log for log in logs],
        [log._log for log in others],
        sections,
        f"rivid.{type(method).__name__}",
        threads,
        progress,
    )
    return _told(Fit(Robot._of(chosen, robot._files) if chosen else robot, found, logs, others))


def _told(fit: Fit) -> Fit:
    if fit._found.status != "identified":
        reasons = "; ".join(fit._found.reasons)
        warnings.warn(f"the result is {fit._found.status}: {reasons}", RividWarning, stacklevel=3)
    return fit


def _of_experiment(experiment: Experiment, threads: int, progress: Progress | None) -> Fit:
    found = experiment._experiment.run(threads, progress)
    return Fit(experiment.robot, found, None, [], experiment)


def check(
    robot: Robot,
    log: LogSource | Iterable[LogSource],
    method: Method | None = None,
    *,
    validation: LogSource | Iterable[LogSource] = (),
    threads: int = 1,
) -> list[Finding]:
    """What would make an identification from these logs fail or mislead, the gravest first."""
    sections = text_of(Auto() if method is None else method, "check")
    instance_of("check: robot", robot, Robot)
    logs = [log._log for log in read_logs(log, robot)]
    others = [log._log for log in read_logs(validation, robot)]
    return findings_of(_rivid.check(robot._robot, logs, others, sections, threads))


class Prediction:
    """Torques of a log, measured and predicted, at the samples that the signal chain leaves."""

    def __init__(self, prediction: _rivid.Prediction, joints: list[str]) -> None:
        self._prediction = prediction
        self.joints = joints

    @property
    def source(self) -> str:
        """The log's name."""
        return self._prediction.source

    @property
    def t(self) -> Floats:
        """Instants [s]."""
        return self._prediction.start + np.arange(self._prediction.samples) / self._prediction.f_m

    @cached_property
    def measured(self) -> Floats:
        """Measured torques, one column a joint [N·m | N]."""
        return self._prediction.measured

    @cached_property
    def predicted(self) -> Floats:
        """W χ at the same samples [N·m | N]."""
        return self._prediction.predicted

    @property
    def residual(self) -> Floats:
        """Measured less predicted torques [N·m | N]."""
        return self.measured - self.predicted

    @cached_property
    def kept(self) -> Booleans:
        """Samples that the fit takes: elsewhere a joint is too slow, or reverses nearby."""
        return self._prediction.kept

    def rows(self, joint: str) -> tuple[Indices, Floats]:
        """Samples that the rows of a joint stand for, and Y − W χ of these rows, after decimation [N·m | N]."""
        j = self.joints.index(joint)
        return np.array(self._prediction.rows(j), dtype=np.int64), self._prediction.residual(j)

    def plot(self, axes: Any = None) -> Any:
        """Draws measured and predicted torques joint by joint by matplotlib, averaged as the rows of the fit are; returns the axes.

        Sample by sample the noise of differentiated positions would hide both.
        """
        window = self._row_window()
        border = len(window) // 2
        t = self.t[border : len(self.t) - border]
        axes = plots.panels(axes, len(self.joints), sharex=True)
        for j, (axis, joint) in enumerate(zip(axes, self.joints)):
            axis.plot(t, np.convolve(self.measured[:, j], window, mode="valid"), label="measured")
            axis.plot(t, np.convolve(self.predicted[:, j], window, mode="valid"), "--", label="predicted")
            axis.set_ylabel(f"{joint} torque")
        axes[-1].set_xlabel("t [s]")
        axes[0].legend(loc="upper right")
        return axes

    def _row_window(self) -> Floats:
        """The Hann window that averages samples into rows, docs/rows.md; one sample where nothing is averaged."""
        steps = [np.diff(self._prediction.rows(j)) for j in range(len(self.joints))]
        stride = min((int(step.min()) for step in steps if len(step)), default=1)
        if 2 * stride >= len(self.t):
            stride = 1
        window = np.hanning(2 * stride + 1)[1:-1]
        return window / window.sum()

    def __repr__(self) -> str:
        return f"<Prediction of {self.source!r}: {self._prediction.samples} samples>"


class Fit:
    """What an identification found.

    ``document`` is all of it, the content of result.json, which docs/result.md describes; the members below are views of it. ``fit["ZZ1R"]`` is the row of a
    parameter. A fit can be pickled: like one of ``load()`` it then has no logs of its own, and no a-priori values.
    """

    plot_torques = plots.torques
    plot_residuals = plots.residuals
    plot_friction = plots.friction
    plot_intervals = plots.intervals
    plot_correlation = plots.correlation
    plot_rollout = plots.rollout

    def __init__(
        self,
        robot: Robot,
        found: _rivid.Identification,
        logs: list[Log] | None,
        validation: list[Log],
        experiment: Experiment | None = None,
    ) -> None:
        self._found = found
        self._logs = logs
        self._experiment = experiment
        self._others = validation
        self._text: str | None = None
        self.robot = robot

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Fit:
        """The fit of a result.json, whoever wrote it.

        It predicts and validates as it did; what needs the logs of the fit, its predictions and residuals, asks for ``predict(log)``.
        """
        path = path_of("Fit.load: path", path)
        return _loaded(_rivid.read_input(path / "result.json" if path.is_dir() else path), str(path))

    def __reduce__(self) -> Any:
        return _loaded, (self._json(), "a pickled fit")

    def __getitem__(self, name: str) -> Mapping[str, Any]:
        return self.parameters.row(name)

    def _json(self) -> str:
        if self._text is not None:
            return self._text
        if self._experiment is not None:
            return self._experiment._experiment.document(self._found, self._experiment._settings)
        return self._found.document(self.robot._robot, self._inputs)

    @cached_property
    def _inputs(self) -> list[tuple[str, str]]:
        """Sources of the logs and SHA-256 of their numbers; the file of the robot and its own."""
        robot = [(str(file), sha256(file.read_bytes()).hexdigest()) for file in files_of(self.robot) if file.is_file()]
        if self._text is not None:
            return [(file["path"], file["sha256"]) for file in self.document["provenance"]["inputs"]]
        return self._log_inputs() + robot

    def _log_inputs(self) -> list[tuple[str, str]]:
        return [(log.source, log.digest()) for log in self._training()]

    @cached_property
    def document(self) -> dict[str, Any]:
        """The content of result.json."""
        return json.loads(self._json())

    @property
    def status(self) -> str:
        """"identified", or what stands against it."""
        return self.document["status"]

    @property
    def identified(self) -> bool:
        """Whether there is an answer."""
        return self.status == "identified"

    @property
    def reasons(self) -> list[str]:
        """Why the status is not "identified"."""
        return self.document["reasons"]

    @property
    def warnings(self) -> list[Finding]:
        """What may make the result wrong."""
        return findings_of(self.document["warnings"])

    @property
    def notes(self) -> list[str]:
        """What was done to the data."""
        return self.document["notes"]

    @property
    def parameters(self) -> Table:
        """The base parameters with their statistics, one row each; ``low_95`` and ``high_95`` are the ends of ``interval_95``."""
        ends = ("low_95", "high_95")
        return Table([{**p, **dict(zip(ends, p["interval_95"]))} for p in self.document["parameters"]], _SHOWN)

    @property
    def chi(self) -> Floats:
        """The estimate, in the order of ``parameters`` [SI, joint side]."""
        return self._found.chi

    @property
    def covariance(self) -> Floats:
        """Its covariance."""
        return self._found.covariance

    @property
    def sigma(self) -> Floats:
        """Its standard deviations."""
        return self.parameters["sigma"]

    @property
    def fit(self) -> Table:
        """How well each joint's torques are explained."""
        return Table(self.document["fit"]["joints"])

    @property
    def relative_error(self) -> float:
        """‖Y − W χ‖ / ‖Y‖ on the rows of the fit."""
        return self.document["fit"]["relative_error"]

    @property
    def physical(self) -> dict[str, dict[str, float]] | None:
        """Physically consistent standard parameters by link and name, where they were asked for."""
        model = self.document.get("physical")
        if model is None:
            return None
        return {link["link"]: {p["name"]: p["value"] for p in link["parameters"]} for link in model["links"]}

    @property
    def friction_curves(self) -> Table:
        """Friction over velocity by joint, as ``--write-friction`` writes it: docs/result.md. NaN where there is no row."""
        text = self._found.friction(self.robot._robot, [p._prediction for p in self.predictions])
        rows = csv.DictReader(text.splitlines())
        return Table([{key: value if key == "joint" else float(value or "nan") for key, value in row.items()} for row in rows])

    @cached_property
    def predictions(self) -> list[Prediction]:
        """Predictions of the logs of the fit. Raises InputError for a fit that was loaded."""
        if not self._training():
            raise _rivid.InputError("Fit: this one was loaded and has no logs; predict(log) takes them again")
        return [self.predict(log) for log in self._training()]

    @property
    def residuals(self) -> dict[str, Floats]:
        """Y − W χ of the rows of the fit by joint, log after log [N·m | N]."""
        return {j: np.concatenate([p.rows(j)[1] for p in self.predictions]) for j in self.robot.joints}

    def predict(self, log: LogSource) -> Prediction:
        """Measured and predicted torques of a log, by the signal chain of the fit."""
        logs = read_logs(log, self.robot)
        if len(logs) != 1:
            raise _rivid.InputError(f"predict: {logs[0].source} is {len(logs)} logs; predict them one by one")
        return Prediction(self._found.predict(self.robot._robot, logs[0]._log), self.robot.joints)

    def score(self, log: LogSource | Iterable[LogSource]) -> float:
        """R² of the torques of the rows of logs, the mean of the joints: 1 is perfect, 0 no better than each joint's mean torque."""
        predictions = [self.predict(one)._prediction for one in read_logs(log, self.robot)]
        found = []
        for j in range(len(self.robot)):
            error = np.concatenate([p.residual(j) for p in predictions])
            torque = np.concatenate([p.row_torques(j) for p in predictions])
            if len(torque) and np.ptp(torque) > 0.0:
                found.append(1.0 - error @ error / np.sum((torque - torque.mean()) ** 2))
        return float(np.mean(found)) if found else float("nan")

    def get_params(self) -> dict[str, Any]:
        """Settings of the fit, defaults included, by the keys that ``Experiment`` takes: "signal.decimation"."""
        sections = self.document["provenance"]["options"]
        return {f"{name}.{key}": value for name, keys in sections.items() for key, value in keys.items()}

    def validate(self, log: LogSource, *, threads: int = 1) -> dict[str, Any]:
        """The fit on a log that took no part in it: members of ``validation`` in docs/result.md. It becomes part of the document."""
        logs = read_logs(log, self.robot)
        out: dict[str, Any] = {}
        for one in logs:
            out = json.loads(self._found.validate(self.robot._robot, one._log, threads))
            self._others.append(one)
            if self._text is not None:
                self.document["validation"].append({"file": one.source, **out})
                self._text = json.dumps(self.document, indent=2, ensure_ascii=False) + "\n"
        self.__dict__.pop("document", None)
        return out

    def model(self, *, parameters: Literal["estimate", "physical"] | None = None, force: bool = False) -> DynamicModel:
        """The identified robot for a controller or a simulation: by default its physically consistent parameters, where they
        were asked for.

        Raises InputError where the robot is not identified, unless ``force``.
        """
        return DynamicModel(self._found.model(self.robot._robot, parameters or "", force))

    def save(self, path: str | PathLike[str]) -> None:
        """Writes result.json, or where ``path`` ends in .csv the table of the parameters, which ``Robot.model`` reads.

        Raises InputError for another ending, and where ``path`` is a file that the fit was made from, or is there and of another kind.
        """
        path = path_of("Fit.save: path", path)
        if path.suffix not in (".json", ".csv"):
            raise _rivid.InputError(f"Fit.save: {path} must end in .json, or in .csv for the parameters alone; to_html() writes the report")
        _rivid.write_file(path, self._json() if path.suffix == ".json" else self._csv(), path.suffix, self._files())

    def _csv(self) -> str:
        out = io.StringIO()
        writer = csv.DictWriter(out, _WRITTEN, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.parameters)
        return out.getvalue()

    def to_html(self, path: str | PathLike[str] | None = None) -> str:
        """The report as one page: written to ``path`` where there is one, and returned.

        Raises InputError where ``path`` is a file that the fit was made from, or is there and no HTML.
        """
        if self._experiment is not None:
            page = self._experiment._experiment.html(self._found, self._experiment._settings)
        else:
            shown = [self.predict(log)._prediction for log in self._training()]
            for log in self._others:
                shown.append(self.predict(log)._prediction)
                shown[-1].validation = True
            page = self._found.html(self.robot._robot, shown, self._inputs)
        if path is not None:
            _rivid.write_file(path_of("Fit.to_html: path", path), page, ".html", self._files())
        return page

    def _files(self) -> list[Path]:
        """Files that the fit was made from."""
        own = [] if self._experiment is None else self._experiment._inputs()
        return own + files_of(self.robot, *(self._logs or ()), *self._others)

    def _training(self) -> list[Log]:
        if self._logs is None:
            assert self._experiment is not None
            self._logs = self._experiment.logs()
        return self._logs

    def __str__(self) -> str:
        return self._found.text()

    def __repr__(self) -> str:
        return f"<Fit {self._found.title}: {self.status}, {len(self.chi)} base parameters>"

    def _repr_html_(self) -> str:
        drawing = ""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            pass
        else:
            figure = Figure(figsize=(6.0, 1.0 + 0.2 * len(self.chi)), dpi=72, layout="constrained")
            self.plot_intervals(figure.subplots())
            picture = io.BytesIO()
            figure.savefig(picture, format="png")
            drawing = f'<img alt="confidence intervals" src="data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()}">'
        return f"<p><b>{self._found.title}: {self.status}</b></p>{drawing}{self.parameters._repr_html_()}"


def _loaded(text: str, source: str) -> Fit:
    robot, found = _rivid.Identification.of_result(text, source)
    out = Fit(Robot._of(robot), found, [], [])
    out._text = text
    return out
