"""Logs that say little or nothing, to everything that takes one: a result or an InputError, never a traceback of another kind, never a signal."""

import numpy as np
import pytest

import rivid
from rivid.__main__ import convert

_SIGNAL = {"torque_held": True, "cutoff_hz": "off", "decimation": 10}
_PD = rivid.Pd(omega_n=[20, 20, 25, 30, 30, 30], reference_velocity=True, rate_hz=1000)


@pytest.fixture(scope="module")
def six_axis(scara):
    """The six-axis arm, its log as arrays, and its identification."""
    folder = scara.parent / "six_axis"
    robot = rivid.Robot.from_urdf(folder / "six_axis.urdf", gravity=[0, 0, -9.81], friction="coulomb")
    log = rivid.simulate(folder / "simulate.toml").log
    return robot, log, rivid.identify(robot, log, rivid.Wls(**_SIGNAL))


def _held(x, joints):
    return np.where(np.isin(np.arange(x.shape[1]), joints), x[0], x)


_LOGS = {
    **{f"joint {j + 1} held": lambda t, q, v, q_r, j=j: (t, _held(q, [j]), v, _held(q_r, [j])) for j in range(6)},
    "standing": lambda t, q, v, q_r: (t, _held(q, range(6)), v, _held(q_r, range(6))),
    "zero": lambda t, q, v, q_r: (t, 0 * q, 0 * v, 0 * q_r),
    "equal": lambda t, q, v, q_r: (t, *(3 * [np.repeat(q[:, :1], 6, axis=1)])),
    "without torque": lambda t, q, v, q_r: (t, q, 0 * v, q_r),
    **{f"{n} rows": lambda *series, n=n: tuple(x[:n] for x in series) for n in (0, 1, 2, 5, 20, 100, 400)},
}


def _uses(robot, good, arm, log, folder):
    """Everything that takes a log, one call each."""
    wls = rivid.Wls(**_SIGNAL)
    methods = [
        rivid.Ols(**_SIGNAL),
        wls,
        rivid.Auto(torque_held=True),
        rivid.Iv(control=_PD, **_SIGNAL),
        rivid.Iv(control=_PD, prefilter=True, **_SIGNAL),
        rivid.Wls(robust="huber", physical=True, essential=True, **_SIGNAL),
        rivid.Wls(gains="estimate", **_SIGNAL),
        rivid.Didim(control=_PD, **_SIGNAL),
    ]

    def looked_at(method):
        fit = rivid.identify(robot, log, method)
        assert str(fit) and fit.document["status"]
        for name, residual in fit.residuals.items():
            assert name in robot.joints and residual.ndim == 1
        assert "<html" in fit.to_html()

    for method in methods:
        yield lambda method=method: looked_at(method)
    yield lambda: rivid.check(robot, log, wls)
    yield lambda: rivid.identify(robot, good, wls, validation=log).to_html()
    yield lambda: rivid.identify(robot, [good, log], wls).document
    yield lambda: arm.validate(log)
    yield lambda: arm.predict(log).plot()
    for gains in (None, 1.0):
        yield lambda gains=gains: str(rivid.identify_payloads(robot, log, wls, arm=arm, gains=gains))
        yield lambda gains=gains: str(rivid.identify_payloads(robot, log, wls, without=good, gains=gains))
        yield lambda gains=gains: str(rivid.identify_payloads(robot, good, wls, without=log, gains=gains))
    yield lambda: rivid.identify_payloads(robot, log, wls, without=good, gains="estimate", mass=2.0).gains
    yield lambda: rivid.read_log(_written(log, folder), robot)


def _written(log, folder):
    log.to_csv(folder / "log.csv")
    return folder / "log.csv"


@pytest.mark.parametrize("name", _LOGS)
def test_a_degenerate_log_has_a_result_or_a_reason(name, six_axis, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    robot, good, arm = six_axis
    t, q, v, q_r = _LOGS[name](*(x[:2500] for x in (good.t, good.q, good.v_tau, good.q_r)))
    np.savez(tmp_path / "log.npz", t=t, q=q, v=v, qref=q_r)
    for read in (convert, lambda source, _: rivid.read_log(source, robot)):
        try:
            read(tmp_path / "log.npz", tmp_path / "converted.csv")
        except rivid.InputError as refusal:
            assert str(refusal)
    try:
        log = rivid.Log(t, q, v_tau=v, q_r=q_r)
    except rivid.InputError as refusal:
        assert str(refusal)
        return
    for use in _uses(robot, good, arm, log, tmp_path):
        try:
            use()
        except (rivid.InputError, rivid.NumericsError) as refusal:
            assert str(refusal)
        plt.close("all")
