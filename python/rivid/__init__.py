"""rivid identifies the dynamic parameters of robot arms from logs of their motion.

    robot = rivid.Robot.from_urdf("ur10e.urdf", tip="tool0", friction="symmetric")
    fit = rivid.identify(robot, rivid.Log(t=t, q=q, tau=tau), rivid.Wls())
    print(fit.parameters)

Options have the words, defaults and checks of experiment files: docs/experiment.md lists them. Numbers in parentheses, as (13), are
equations of the paper, [RIV] in docs/references.md.
"""

from rivid import online, signal
from rivid._options import (
    Auto,
    Cascade,
    ComputedTorque,
    Didim,
    Essential,
    Fourier,
    Iv,
    Logged,
    Ols,
    OutputError,
    Pd,
    Physical,
    Pid,
    PointToPoint,
    Wls,
)
from rivid._rivid import Error, InputError, NumericsError
from rivid._rivid import version as __version__
from rivid.commands import compare, explain, export
from rivid.experiment import Excitation, Experiment, Simulation, draft, excite, simulate
from rivid.findings import Finding
from rivid.fit import Fit, Prediction, RividWarning, check, identify
from rivid.formats import limit_inputs
from rivid.log import Log, read_log, read_logs
from rivid.montecarlo import MonteCarloResults, Study, montecarlo
from rivid.payload import Payload, Payloads, identify_payloads
from rivid.robot import BaseParameters, DynamicModel, InverseDynamics, Robot
from rivid.table import Table

for _error in (Error, InputError, NumericsError):
    _error.__module__ = "rivid"

__all__ = [
    "Auto",
    "BaseParameters",
    "Cascade",
    "ComputedTorque",
    "Didim",
    "DynamicModel",
    "Error",
    "Essential",
    "Excitation",
    "Experiment",
    "Finding",
    "Fit",
    "Fourier",
    "InputError",
    "InverseDynamics",
    "Iv",
    "Log",
    "Logged",
    "MonteCarloResults",
    "NumericsError",
    "Ols",
    "OutputError",
    "Payload",
    "Payloads",
    "Pd",
    "Physical",
    "Pid",
    "PointToPoint",
    "Prediction",
    "RividWarning",
    "Robot",
    "Simulation",
    "Study",
    "Table",
    "Wls",
    "__version__",
    "check",
    "compare",
    "draft",
    "excite",
    "explain",
    "export",
    "identify",
    "identify_payloads",
    "limit_inputs",
    "montecarlo",
    "online",
    "read_log",
    "read_logs",
    "signal",
    "simulate",
]
