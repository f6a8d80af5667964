"""Arguments that can not be used are refused by name; files that were read are not written over."""

import shutil

import numpy as np
import pytest

import rivid
from rivid import online, signal

T = np.arange(50) * 0.01
Q = np.random.default_rng(1).normal(size=(50, 2))
MASKED = np.ma.array(Q, mask=Q > 0)


@pytest.fixture(scope="module")
def fit(robot, scara):
    return rivid.identify(robot, scara / "scara_s2.csv", rivid.Ols(cutoff_hz=20, decimation=20))


@pytest.mark.parametrize(
    ("x", "words"),
    [
        (Q[:, 0], r"x has shape \(50,\), must be a matrix with one row a sample"),
        (MASKED, "x has masked samples, must have none"),
        (Q + 1j, "x is complex128, must hold real numbers"),
        (T.astype("timedelta64[s]"), "x is timedelta64.*, must hold real numbers"),
        ([[1.0, 2.0], [3.0]], "x must hold real numbers: .*inhomogeneous"),
        ([["a", "b"]], "x must hold real numbers: .*'a'"),
    ],
)
def test_what_is_no_matrix_of_real_numbers_is_refused(x, words):
    for function, *more in ((signal.zero_phase, 100.0, 10.0), (signal.decimate, 5)):
        with pytest.raises(rivid.InputError, match=f"signal.{function.__name__}: {words}"):
            function(x, *more)


def test_series_of_another_kind_are_refused(robot):
    model = robot.model()
    for call, words in (
        (lambda: robot.regressor(Q[:, 0], Q, Q), r"Robot\.regressor: q has shape \(50,\)"),
        (lambda: robot.regressor(Q, MASKED, Q), r"Robot\.regressor: qd has masked samples"),
        (lambda: robot.model(1.0), r"Robot\.model: parameters has shape \(\)"),
        (lambda: robot.base_parameters().to_standard(Q), r"BaseParameters\.to_standard: chi has shape \(50, 2\)"),
        (lambda: model.mass_matrix(Q), r"DynamicModel\.mass_matrix: q has shape \(50, 2\), must be a vector"),
        (lambda: model.inverse_dynamics(Q[0], Q, Q), r"DynamicModel\.inverse_dynamics: qd has shape \(50, 2\)"),
        (lambda: model.direct_dynamics(Q, Q[0], Q), r"DynamicModel\.direct_dynamics: qd has shape \(2,\)"),
        (lambda: rivid.Log(T, MASKED), "Log: q has masked samples"),
        (lambda: rivid.Log(T, Q, v_tau=Q * 1j), "Log: v_tau is complex128"),
        (lambda: rivid.Log(Q, Q), "Log: t has 2 columns, must have one"),
        (lambda: rivid.Log([], []), "log: the series have no rows"),
    ):
        with pytest.raises(rivid.InputError, match=words):
            call()


def test_whole_numbers_of_numpy_are_stages():
    x = np.arange(20.0)[:, np.newaxis]
    assert np.array_equal(signal.decimate(x, np.int64(4)), signal.decimate(x, 4))
    assert np.array_equal(signal.decimate(x, np.array([2, 2])), signal.decimate(x, [2, 2]))
    assert signal.deviation_factor(np.int64(5)) == signal.deviation_factor(5)
    for n_d in (2.5, "4", None, [2.0], 2**40):
        with pytest.raises(rivid.InputError, match="signal.decimate: n_d is "):
            signal.decimate(x, n_d)


def test_a_value_for_all_joints_is_one_number(robot, scara, fit):
    log = scara / "scara_s2.csv"
    for call, what in (
        (lambda x: rivid.InverseDynamics(robot.model(), x), "InverseDynamics: smoothing_speed"),
        (lambda x: online.ContactObserver(robot.model(), rate_hz=1e3, smoothing_speed=x), "ContactObserver: smoothing_speed"),
        (lambda x: online.OnlineModel(robot, fit.chi, fit.covariance, x, 0.1), "OnlineModel: sigma_rho"),
        (lambda x: rivid.identify_payloads(robot, log, without=log, gains=x), "identify_payloads: gains"),
    ):
        for wrong in ([1.0], [1.0, 1.0, 1.0], [[1.0, 1.0]]):
            with pytest.raises(rivid.InputError, match=rf"{what} has shape .*, must be one number or 2, one a joint"):
                call(wrong)


def test_a_loop_refuses_another_number_of_joints(robot, fit):
    loop = rivid.InverseDynamics(robot.model())
    two, three = np.zeros(2), np.zeros(3)
    for call in (
        lambda x: loop.torque(two, x, two),
        loop.gravity,
        lambda x: loop.bias(two, x),
        lambda x: loop.coriolis(x, two),
        loop.friction,
        loop.mass_matrix,
    ):
        for wrong in (three, two[:1], np.zeros((1, 2)), 0.0):
            with pytest.raises(rivid.InputError, match=r"InverseDynamics: qd? has shape .*, must have \(2,\)"):
                call(wrong)
    model = online.OnlineModel.from_fit(fit)
    observer = online.ContactObserver(model, rate_hz=1000.0)
    estimators = [
        made(model, rate_hz=1000.0) for made in (online.PayloadEstimator, online.FrictionMonitor, online.RecursiveIdentifier)
    ]
    state = online.RobotState(model, rate_hz=1000.0)
    updates = [each.update for each in estimators] + [lambda q, tau: observer.update(q, two, tau), lambda q, tau: state.update(0.0, q, tau)]
    for update in updates:
        update(two, two)
        for q, tau, name in ((three, two, "q"), (two, three, "tau"), (np.zeros((1, 2)), two, "q")):
            with pytest.raises(rivid.InputError, match=rf"\.update: {name} has shape .*, must have \(2,\)"):
                update(q, tau)
    with pytest.raises(rivid.InputError, match=r"point has shape \(2,\), must have \(3,\)"):
        observer.force(0, two)
    with pytest.raises(rivid.InputError, match=r"OnlineModel: covariance has shape \(2, 2\), must have \(8, 8\)"):
        online.OnlineModel(robot, fit.chi, np.eye(2), 1.0, 0.1)
    with pytest.raises(rivid.InputError, match=r"PayloadEstimator: R has shape \(2, 2\), must have \(3, 3\)"):
        online.PayloadEstimator(model, rate_hz=1000.0, R=np.eye(2))


def test_a_method_and_rows_of_a_table_are_refused_by_name(robot, scara):
    for function in (rivid.identify, rivid.check):
        with pytest.raises(TypeError, match=f"{function.__name__}: the method is 'ols', must be one such as"):
            function(robot, scara / "scara_s2.csv", "ols")
    with pytest.raises(rivid.InputError, match=r"from_mdh: row 2 has no 'type'"):
        rivid.Robot.from_mdh([{"type": "R", "alpha": 0, "a": 0, "d": 0}, {"alpha": 0, "a": 0, "d": 0}])


def test_masked_samples_of_a_table_are_empty_cells(robot, columns):
    v1 = np.ma.array(columns["v1"], mask=np.arange(len(columns["v1"])) % 100 == 50)
    log = rivid.read_log({**columns, "v1": v1}, robot)
    empty = np.where(v1.mask, np.nan, columns["v1"])
    assert np.array_equal(log.v_tau, rivid.read_log({**columns, "v1": empty}, robot).v_tau)
    assert any(f"{v1.mask.sum()} of {len(v1)} rows have empty cells" in note for note in log.notes)


@pytest.fixture
def files(scara, tmp_path):
    """A robot, a log and an experiment that may be written to."""
    for name in ("scara.urdf", "scara_s2.csv"):
        shutil.copy(scara / name, tmp_path)
    rivid.draft(tmp_path / "scara.urdf", tmp_path / "scara_s2.csv", tmp_path / "scara.toml")
    return tmp_path


def test_what_was_read_is_not_written_over(files):
    robot = rivid.Robot.from_urdf(files / "scara.urdf", friction="coulomb")
    log = rivid.read_log(files / "scara_s2.csv", robot)
    fit = rivid.identify(robot, log, rivid.Wls(decimation=20))
    of_file = rivid.identify(rivid.Experiment(files / "scara.toml", {"signal.decimation": 20}))
    read = ("scara.urdf", "scara_s2.csv", "scara.toml")
    before = [(files / name).read_bytes() for name in read]
    for write, names in (
        (lambda path: rivid.draft(files / "scara.urdf", [files / "scara_s2.csv"], path), read[:2]),
        (log.shifted(-0.5).to_csv, read[1:2]),
        (fit.save, read[:2]),
        (fit.to_html, read[:2]),
        (of_file.save, read),
        (of_file.to_html, read),
    ):
        for name in names:
            with pytest.raises(rivid.InputError, match=rf"{name}: is an input of this run|{name} must end in"):
                write(files / name)
    (files / "reference.csv").write_text("t,qref1,qref2\n" + "".join(f"{0.005 * k},0,0\n" for k in range(20)))
    rest = rivid.simulate(robot, rivid.Pd(omega_n=10, zeta=1, rate_hz=200), rivid.Logged(file=files / "reference.csv"))
    with pytest.raises(rivid.InputError, match=r"reference\.csv: is an input of this run"):
        rest.log.to_csv(files / "reference.csv")
    # Nor files of another kind, though it was not read.
    with pytest.raises(rivid.InputError, match=r"scara\.toml must end in \.json"):
        fit.save(files / "scara.toml")
    assert [(files / name).read_bytes() for name in read] == before
    for _ in range(2):  # what was written before is
        fit.save(files / "result.json")
        rivid.Log(T, Q, source=str(files / "made.csv")).to_csv(files / "made.csv")
