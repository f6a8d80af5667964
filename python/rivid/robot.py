"""Robots, their base parameters and regressors, and models with numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rivid import _rivid
from rivid._arrays import each, floats, instance_of, path_of, shaped
from rivid._keys import toml_keys
from rivid.findings import Finding, findings_of
from rivid.table import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from rivid._options import RobotKeys
    from rivid.log import Log
    from rivid.types import ArrayLike, Floats

_MDH_COLUMNS = ("joint", "type", "alpha", "a", "d", "theta")


class Robot:
    """A robot: geometry, drives, friction laws, and the a-priori values of its description.

    ``Robot.from_urdf`` and ``Robot.from_mdh`` make one. It never changes.
    """

    _robot: _rivid.Robot
    _description: tuple[Any, ...] | None
    _files: tuple[str, ...]  # that were read

    @classmethod
    def from_urdf(cls, path: str | PathLike[str], **keys: Unpack[RobotKeys]) -> Robot:
        """The robot of a URDF: the chain from ``base`` to ``tip``, the joints ``moving``, or all that moves.

        ``keys`` are those of [robot] in an experiment file: ``friction="symmetric"``, ``rotor_inertia=False``,
        ``joints={"elbow": {"gear_ratio": 101}}``, … Raises InputError for what can not be used, with the line of the file.
        """
        path = path_of("Robot.from_urdf: path", path)
        return cls._made(_rivid.read_input(path), str(path), "", False, toml_keys(keys))

    @classmethod
    def from_mdh(cls, table: str | PathLike[str] | Iterable[Mapping[str, Any]], **keys: Unpack[RobotKeys]) -> Robot:
        """The robot of a modified Denavit-Hartenberg table.

        ``table`` is a CSV file, or a list of rows with ``type`` ("R" or "P"), ``alpha``, ``a``, ``d``, ``theta`` and perhaps
        ``joint``, its name, in rad and m. ``keys`` are those of [robot].
        """
        if isinstance(table, (str, PathLike)):
            path = path_of("Robot.from_mdh: table", table)
            return cls._made(_rivid.read_input(path), str(path), path.stem, True, toml_keys(keys))
        if isinstance(table, bytes) or not isinstance(table, Iterable):
            raise TypeError(f"Robot.from_mdh: table is {type(table).__name__}, must be a path or a list of rows")
        text = io.StringIO()
        writer = csv.writer(text)
        writer.writerow(_MDH_COLUMNS)
        for number, row in enumerate(table, start=1):
            values = {"joint": number, "theta": 0.0, **instance_of(f"Robot.from_mdh: row {number}", row, Mapping)}
            if missing := [column for column in _MDH_COLUMNS if column not in values]:
                raise _rivid.InputError(f"Robot.from_mdh: row {number} has no {missing[0]!r}, must have type, alpha, a and d")
            writer.writerow([values[column] for column in _MDH_COLUMNS])
        return cls._made(text.getvalue(), "Robot.from_mdh", "robot", True, toml_keys(keys))

    @classmethod
    def _made(cls, *description: Any) -> Robot:
        out = cls._of(_rivid.Robot.of_description(*description), description[1:2])
        out._description = description
        return out

    @classmethod
    def _of(cls, robot: _rivid.Robot, files: tuple[str, ...] = ()) -> Robot:
        out = cls.__new__(cls)
        out._robot = robot
        out._description = None
        out._files = files
        return out

    def __reduce__(self) -> Any:
        if self._description is None:
            raise TypeError("a robot of an experiment file can not be pickled; make it by Robot.from_urdf")
        return Robot._made, self._description

    @property
    def name(self) -> str:
        """Name in the description."""
        return self._robot.name

    @property
    def joints(self) -> list[str]:
        """Names of the joints, base to tip."""
        return self._robot.joint_names

    @property
    def findings(self) -> list[Finding]:
        """What is doubtful in the description."""
        return findings_of(self._robot.findings)

    @property
    def limits(self) -> Table:
        """Limits of the joints; infinite where the description has none."""
        columns = ("lower", "upper", "max_velocity", "max_effort")
        values = [getattr(self._robot, column) for column in columns]
        return Table([{"name": name, **dict(zip(columns, row))} for name, *row in zip(self.joints, *values)])

    @property
    def standard_parameters(self) -> dict[str, float]:
        """A-priori values of the standard parameters (2) by their names [SI, joint side]."""
        return dict(zip(self._robot.parameter_names, self._robot.chi_st().tolist()))

    def base_parameters(self) -> BaseParameters:
        """The combinations of standard parameters that the torques can show (4–6)."""
        return BaseParameters(self)

    def regressor(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, threads: int = 1) -> Floats:
        """The regressor of the base parameters along a motion (12), (samples, joints, base parameters).

        ``regressor(q, qd, qdd) @ chi`` are the torques, (samples, joints). The motion has one row a sample.
        """
        q, qd, qdd = (floats(f"Robot.regressor: {name}", x, 2) for name, x in (("q", q), ("qd", qd), ("qdd", qdd)))
        base = self.base_parameters()
        W = _rivid.observation(self._robot, base._base, q, qd, qdd, threads)
        return W.T.reshape(len(base), self._robot.size, len(q)).transpose(2, 1, 0)

    def model(self, parameters: Mapping[str, float] | ArrayLike | str | PathLike[str] | None = None) -> DynamicModel:
        """The robot with numbers.

        ``parameters`` are values of all base or all standard parameters: by name, as an array in the order of
        ``base_parameters()`` or ``standard_parameters``, or a parameter file; without them those of the description.
        """
        base = self.base_parameters()
        if parameters is None:
            return DynamicModel(_rivid.DynamicModel(self._robot, self._robot.chi_st()))
        if isinstance(parameters, (str, PathLike)):
            chi_st = _rivid.read_parameters(path_of("Robot.model: parameters", parameters), base._base)
            return DynamicModel(_rivid.DynamicModel(self._robot, chi_st))
        if isinstance(parameters, Mapping):
            names = base.names if set(parameters) == set(base.names) else self._robot.parameter_names
            if set(parameters) != set(names):
                raise _rivid.InputError("Robot.model: the names are neither those of all base nor of all standard parameters")
            parameters = [parameters[name] for name in names]
        values = floats("Robot.model: parameters", parameters, 1)
        if len(values) == len(base):
            return DynamicModel(_rivid.DynamicModel.of_base(self._robot, base._base, values))
        return DynamicModel(_rivid.DynamicModel(self._robot, values))

    def effort(self, log: Log) -> Floats:
        """Joint-side torques of a log (8): its torques, or its control signals times the gains of the drives."""
        return self._robot.effort(log._log)

    def __len__(self) -> int:
        return self._robot.size

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {', '.join(self.joints)}>"


class BaseParameters(Sequence[str]):
    """Base parameters of a robot (4–6): a sequence of their names."""

    def __init__(self, robot: Robot) -> None:
        self._base = _rivid.BaseParameters(robot._robot)

    @property
    def names(self) -> list[str]:
        """"ZZ1R", … in the order of all vectors of base parameters."""
        return self._base.names

    @property
    def table(self) -> Table:
        """Name, unit and regrouping of each."""
        rows = zip(self._base.names, self._base.units, self._base.regrouped)
        return Table([{"name": name, "unit": unit, "regrouped": text} for name, unit, text in rows])

    @property
    def rank_gap(self) -> float:
        """How clear the decision between kept and regrouped columns is; below 100 it is doubtful."""
        return self._base.rank_gap

    @property
    def doubt(self) -> str | None:
        """A warning where that decision is doubtful."""
        return self._base.doubt

    def regrouping(self, name: str) -> dict[str, float]:
        """Standard parameters that make up a base parameter, with their coefficients."""
        return dict(self._base.regrouping(self.names.index(name)))

    def from_standard(self, chi_st: ArrayLike) -> Floats:
        """Base parameters of standard ones (6)."""
        return self._base.from_standard(floats("BaseParameters.from_standard: chi_st", chi_st, 1))

    def to_standard(self, chi: ArrayLike) -> Floats:
        """Some standard parameters with these base parameters; they need not be physically consistent."""
        return self._base.to_standard(floats("BaseParameters.to_standard: chi", chi, 1))

    def null_space(self) -> Floats:
        """Directions of the standard parameters that the torques can not show, one column each."""
        return self._base.null_space()

    def __len__(self) -> int:
        return len(self._base)

    def __getitem__(self, index: Any) -> Any:
        return self.names[index]

    def __repr__(self) -> str:
        return repr(self.table)

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


class DynamicModel:
    """A robot with numbers for its parameters: its dynamics (1, 21).

    Motions have one row a sample; a single instant is one row of n numbers.
    """

    def __init__(self, model: _rivid.DynamicModel) -> None:
        self._model = model

    @classmethod
    def from_result(
        cls,
        path: str | PathLike[str],
        *,
        parameters: Literal["estimate", "physical"] | None = None,
        force: bool = False,
    ) -> DynamicModel:
        """The identified robot of a result.json: by default its physically consistent parameters, where it has them.

        ``force`` takes a result that is not identified.
        """
        return cls(_rivid.DynamicModel.of_result(path_of("DynamicModel.from_result: path", path), parameters or "", force))

    @property
    def joints(self) -> list[str]:
        """Names of the joints, base to tip."""
        return self._model.joint_names

    @property
    def clamped(self) -> list[str]:
        """Friction parameters that were taken as zero, since they would drive."""
        return self._model.clamped

    def mass_matrix(self, q: ArrayLike) -> Floats:
        """M(q), rotors included, (n, n)."""
        return self._model.mass_matrix(floats("DynamicModel.mass_matrix: q", q, 1))

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Floats:
        """Torques of a motion, in its shape [N·m | N]."""
        return _rows(self._model.inverse_dynamics, q=q, qd=qd, qdd=qdd)

    def direct_dynamics(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> Floats:
        """Accelerations that torques give, in their shape [rad/s² | m/s²].

        Raises NumericsError where the mass matrix is not positive definite.
        """
        return _rows(self._model.direct_dynamics, q=q, qd=qd, tau=tau)

    def __repr__(self) -> str:
        return f"<DynamicModel: {', '.join(self.joints)}>"


class InverseDynamics:
    """Torques for the loop of a controller: one call an instant, nothing is made anew between calls.

    ``smoothing_speed`` [rad/s | m/s], one or one a joint, smooths the sign of the velocity; without it friction flickers about
    rest with the noise of the encoder. A thread has one of its own.

    All raise InputError for a wrong size; numbers that are not finite give such torques.
    """

    def __init__(self, model: DynamicModel, smoothing_speed: ArrayLike | None = None) -> None:
        n = model._model.size
        speeds = np.zeros(0) if smoothing_speed is None else each("InverseDynamics: smoothing_speed", smoothing_speed, n)
        self._shape = (n,)
        self._dynamics = _rivid.InverseDynamics(model._model, speeds)

    def torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Floats:
        """τ = M(q) q̈ + N(q, q̇) + friction."""
        return self._dynamics.torque(self._of_joints("q", q), self._of_joints("qd", qd), self._of_joints("qdd", qdd))

    def gravity(self, q: ArrayLike) -> Floats:
        """Torques against gravity, without friction."""
        return self._dynamics.gravity(self._of_joints("q", q))

    def bias(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Coriolis, centrifugal and gravity torques, without friction."""
        return self._dynamics.bias(self._of_joints("q", q), self._of_joints("qd", qd))

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Coriolis and centrifugal torques."""
        return self._dynamics.coriolis(self._of_joints("q", q), self._of_joints("qd", qd))

    def friction(self, qd: ArrayLike) -> Floats:
        """Friction torques."""
        return self._dynamics.friction(self._of_joints("qd", qd))

    def mass_matrix(self, q: ArrayLike) -> Floats:
        """M(q), rotors included."""
        return self._dynamics.mass_matrix(self._of_joints("q", q))

    def _of_joints(self, name: str, x: ArrayLike) -> Floats:
        return shaped(f"InverseDynamics: {name}", x, self._shape)


def _rows(function: Any, **series: ArrayLike) -> Floats:
    what = f"DynamicModel.{function.__name__}"
    ndim = 1 if floats(f"{what}: q", series["q"]).ndim == 1 else 2
    arrays = [floats(f"{what}: {name}", x, ndim) for name, x in series.items()]
    return function(*(x[np.newaxis] for x in arrays))[0] if ndim == 1 else function(*arrays)
