"""Every maker of a result, and every taker of one."""

import json
import pickle
import warnings

import numpy as np
import pytest
from test_formats import write_bag

import rivid

METHOD = rivid.Wls(decimation=20, torque_held=True, physical=True)
MAKERS = ["tool", "merge", "path", "arrays", "parquet", "bag", "pickle", "dask"]


@pytest.fixture(scope="module", params=MAKERS)
def saved(request, robot, scara, columns, tool, tmp_path_factory):
    """result.json of a fit that each of the makers made."""
    folder = tmp_path_factory.mktemp("saved")
    file = folder / "result.json"
    q = np.column_stack([columns["q1"], columns["q2"]])
    v = np.column_stack([columns["v1"], columns["v2"]])
    if request.param == "tool":
        tool("rivid_identify", scara / "scara.toml", "--physical", "--output", folder, "--quiet")
        return file
    if request.param == "merge":
        factors = folder / "a.factors"
        tool("rivid_identify", "factors", scara / "scara.toml", "--output", factors)
        tool("rivid_identify", "merge", factors, "--physical", "--output", folder, "--quiet")
        return file
    if request.param == "parquet":
        log = folder / "a.parquet"
        pandas = pytest.importorskip("pandas")
        pandas.DataFrame({name: columns[name] for name in ("t", "q1", "q2", "v1", "v2")}).to_parquet(log)
    elif request.param == "bag":
        log = folder / "bag"
        write_bag(log, columns["t"], q, v, mcap=True)
    elif request.param == "path":
        log = scara / "scara_s2.csv"
    else:
        log = rivid.Log(t=columns["t"], q=q, v_tau=v)
    if request.param == "dask":
        distributed = pytest.importorskip("distributed")
        from rivid import distributed as many

        with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
            fit = many.identify(robot, [scara / "scara_s2.csv"], METHOD, client=client)
    else:
        fit = rivid.identify(robot, log, METHOD)
    (pickle.loads(pickle.dumps(fit)) if request.param == "pickle" else fit).save(file)
    return file


def test_validate_and_compare_read_logs_by_the_usual_names(saved, scara, tool):
    done = tool("rivid_identify", "validate", saved, scara / "scara_validation.csv", "--json")
    assert json.loads(done.stdout)["models"][0]["relative_error"] < 0.03
    done = tool("rivid_identify", "compare", saved, scara / "scara.urdf", "--log", scara / "scara_validation.csv", "--json")
    first, second = json.loads(done.stdout)["models"]
    assert max(first["relative_error"], second["relative_error"]) < 0.03
    found = rivid.compare({"mine": saved, "urdf": scara / "scara.urdf"}, scara / "scara_validation.csv")
    assert [m["name"] for m in found["models"]] == ["mine", "urdf"]
    assert found["models"][0]["relative_error"] == pytest.approx(first["relative_error"], rel=1e-9)


@pytest.mark.parametrize("format", ["mjcf", "sdf", "drake", "pinocchio", "urdf", "header"])
def test_export_finds_the_urdf(saved, tool, tmp_path, format):
    file = tmp_path / {"mjcf": "a.xml", "sdf": "a.sdf", "header": "a.h"}.get(format, "a.urdf")
    tool("rivid_identify", "export", saved, "--to", format, "--output", file, "--force")
    other = rivid.export(rivid.Fit.load(saved), format, tmp_path / f"b{file.suffix}", force=True)
    assert other.stat().st_size > 0.9 * file.stat().st_size > 0


def test_export_draws_samples(saved, tmp_path):
    manifest = json.loads(rivid.export(saved, "npz", tmp_path / "arm.npz", samples=8, seed=3, force=True).read_text())
    assert (manifest["count"], manifest["seed"]) == (8, 3)
    arrays = np.load(tmp_path / "arm.npz")
    assert arrays["chi"].shape == (8, len(arrays["parameters"]))
    assert arrays["chi"].std(axis=0).min() > 0


def test_online_takes_it(saved, scara, tool, tmp_path):
    done = tool("rivid_online", scara / "scara_validation.csv", "--result", saved, "--output", tmp_path / "online")
    assert (tmp_path / "online/online.csv").exists(), done.stderr


def test_excite_takes_it_as_prior(saved, scara, tool, tmp_path):
    plan = tmp_path / "plan.toml"
    arm = (scara / "scara.toml").read_text().split("[log]")[0].replace("scara.urdf", str(scara / "scara.urdf"))
    plan.write_text(
        f'{arm}[excitation]\nduration = 5\nrate_hz = 200\nharmonics = 3\nstarts = 1\nevaluations = 40\nnoise = 0.02\nknown = ["{saved}"]\n'
        "[excitation.limits]\nlower = -2\nupper = 2\nvelocity = 3\nacceleration = 10\n"
    )
    tool("rivid_excite", plan, "--output", tmp_path / "plan", "--quiet")
    document = json.loads((tmp_path / "plan/plan.json").read_text())
    before = np.diag(json.loads(saved.read_text())["covariance"]["C_chi"]) ** 0.5
    after = np.array([p["sigma"] for p in document["parameters"]])
    assert np.all(after < before * (1.0 + 1e-9)) and np.any(after < 0.9 * before)
    design = rivid.excite(plan)
    assert [p["sigma"] for p in design.document["parameters"]] == pytest.approx(after.tolist(), rel=1e-9)


def test_the_state_of_a_loop_takes_it(saved):
    model = rivid.online.OnlineModel.from_result(saved)
    state = rivid.online.RobotState(model, rate_hz=1000.0, learn=1.0)
    rng = np.random.default_rng(5)

    def tick(k, tau=(0.0, 0.0)):
        phase = 0.003 * k + np.array([0.0, 1.0])
        return state.update(1e-3 * k, np.sin(phase) + 1e-6 * rng.normal(size=2), tau)

    assert all(tick(k).good for k in range(100))
    assert tick(102).lost == 2
    assert tick(103, (np.nan, 0.0)).not_finite
    assert tick(103).good
    assert tick(103).repeated
    assert tick(102).late
    assert tick(200).gap
    assert state.left_to_learn == pytest.approx(0.9, abs=0.01)
    assert not state.contact
    assert state.link == -1
    assert state.payload_known(0.5, [0.0, 0.0, 0.1], mass_sigma=0.01, com_sigma=0.005)
    assert state.payload.mass == pytest.approx(0.5, abs=0.01)
    assert not state.payload_known(-0.5, [0.0, 0.0, 0.1], mass_sigma=0.01, com_sigma=0.005)
    state.gripper(open=False)
    assert not state.payload.good
    assert state.payload_changes == 1  # what is known is no change
    two = np.zeros(2)
    plain = rivid.InverseDynamics(rivid.Fit.load(saved).model(parameters="estimate")).torque(two, two, np.ones(2))
    np.testing.assert_allclose(state.feedforward(two, two, np.ones(2)), plain, atol=1.0)
    with pytest.raises(rivid.InputError, match=r"RobotState.feedforward: qd has shape \(3,\)"):
        state.feedforward(two, np.zeros(3), two)


def test_payload_takes_it(saved, robot, scara, tool, tmp_path):
    log = scara / "scara_validation.csv"
    words = ["payload", scara / "scara.toml", "--arm", saved, "--loaded", log, "--output", tmp_path, "--json"]
    done = tool("rivid_identify", *words, code=1)  # there is none
    mass = json.loads(done.stdout)["payloads"][0]["values"]["mass"]["value"]
    found = rivid.identify_payloads(robot, log, METHOD, arm=rivid.Fit.load(saved))
    assert found["payload"].mass == pytest.approx(mass, abs=0.01)


def test_python_opens_what_was_saved(saved, scara, tmp_path):
    fit = rivid.Fit.load(saved)
    document = json.loads(saved.read_text())
    assert fit.document == document
    assert fit.identified
    assert fit.parameters["value"].tolist() == fit.chi.tolist() == [p["value"] for p in document["parameters"]]
    assert np.array_equal(fit.covariance, document["covariance"]["C_chi"])
    assert fit["ZZ1R"]["value"] == fit.chi[0]
    assert "ZZ1R" in str(fit)
    assert "ZZ1R" in fit.to_html(tmp_path / "report.html")
    assert fit.predict(scara / "scara_validation.csv").measured.shape[1] == 2
    assert fit.validate(scara / "scara_validation.csv")["relative_error"] < 0.03
    assert len(fit.document["validation"]) == len(document["validation"]) + 1
    again = pickle.loads(pickle.dumps(fit))
    assert again.document == fit.document
    with pytest.raises(rivid.InputError, match="was loaded"):
        fit.residuals


def test_a_table_of_parameters_is_written_and_read(robot, scara, tmp_path):
    fit = rivid.identify(robot, scara / "scara_s2.csv", METHOD)
    fit.save(tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text().startswith("name,value,unit,sigma,low_95,high_95,verdict,regrouped\nZZ1R,")
    q, qd, qdd = np.random.default_rng(3).normal(size=(3, 5, 2))
    model = robot.model(tmp_path / "x.csv")
    expected = fit.model(parameters="estimate").inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(model.inverse_dynamics(q, qd, qdd), expected, rtol=1e-9)
    with pytest.raises(rivid.InputError, match=r"must end in \.json, or in \.csv"):
        fit.save(tmp_path / "x.txt")


def test_a_doubtful_fit_warns(robot, columns, scara):
    v = np.column_stack([columns["v1"], -columns["v2"]])
    log = rivid.Log(t=columns["t"], q=np.column_stack([columns["q1"], columns["q2"]]), v_tau=v)
    with pytest.warns(rivid.RividWarning, match="doubtful: ") as told:
        rivid.identify(robot, log, METHOD)
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rivid.identify(robot, scara / "scara_s2.csv", METHOD)


def test_what_can_not_be_exported_or_compared_says_why(robot, scara, tmp_path):
    fit = rivid.identify(robot, scara / "scara_s2.csv", rivid.Wls(decimation=20, torque_held=True))
    with pytest.raises(rivid.InputError, match="--to"):
        rivid.export(fit, "gazebo", tmp_path / "a.sdf")
    with pytest.raises(TypeError, match="first model"):
        rivid.compare([scara / "scara.urdf"], scara / "scara_s2.csv")
    assert "Cure" in rivid.explain("torque_sign")
    with pytest.raises(KeyError):
        rivid.explain("nothing")


def test_drawings_and_the_cell_of_a_notebook(robot, scara):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    fit = rivid.identify(robot, scara / "scara_s2.csv", METHOD)
    assert len(fit.plot_torques()) == len(fit.plot_residuals()) == len(fit.plot_friction()) == 2
    joint = fit.plot_residuals()[0].lines[0].get_ydata()
    assert np.array_equal(joint, fit.residuals["joint_1"])
    bars = fit.plot_intervals().patches
    assert bars[0].get_width() == pytest.approx(50.0 * np.ptp(fit["ZZ1R"]["interval_95"]) / fit["ZZ1R"]["value"])
    axes = matplotlib.figure.Figure().subplots()
    assert fit.plot_correlation(axes) is axes
    log = scara / "scara_validation.csv"
    found = rivid.compare([fit, scara / "scara.urdf"], log, rollout=True)["rollouts"]["found"]
    axes = fit.plot_rollout(log, scara / "scara.urdf")
    assert [line.get_label() for line in axes[0].lines] == ["model 1", str(scara / "scara.urdf")]
    for j, axis in enumerate(axes):
        for m, line in enumerate(axis.lines):
            assert line.get_xdata().tolist() == [one["horizon"] for one in found]
            assert line.get_ydata().tolist() == [one["models"][m]["position"][j] for one in found]
            assert 0.0 < line.get_ydata()[0] < line.get_ydata()[-1]
    for shown in (fit, pickle.loads(pickle.dumps(fit))):
        assert "ZZ1R" in shown._repr_html_()
        assert len(shown._repr_html_()) < 100_000
