"""identify(): the same bits as the command line, and what a result offers."""

import json
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import rivid


@pytest.fixture(scope="module")
def fit(robot, scara):
    return rivid.identify(robot, scara / "scara_s2.csv", rivid.Wls(torque_held=True, cutoff_hz="off", decimation=20))


def test_an_experiment_gives_the_bits_of_the_command_line(scara, tool, tmp_path):
    tool("rivid_identify", scara / "scara.toml", "--output", tmp_path, "--quiet")
    by_tool = json.loads((tmp_path / "result.json").read_text())
    found = rivid.identify(scara / "scara.toml").document
    assert found["parameters"] == by_tool["parameters"]
    assert found["validation"] == by_tool["validation"]
    assert [w["code"] for w in found["warnings"]] == [w["code"] for w in by_tool["warnings"]]


def test_arrays_give_the_bits_of_the_file(robot, columns, scara):
    method = rivid.Wls(torque_held=True, decimation=20)
    q = np.column_stack([columns["q1"], columns["q2"]])
    v = np.column_stack([columns["v1"], columns["v2"]])
    by_file = rivid.identify(robot, scara / "scara_s2.csv", method)
    for order in ("C", "F"):
        log = rivid.Log(columns["t"], np.array(q, order=order), v_tau=np.array(v, order=order))
        by_array = rivid.identify(robot, log, method)
        assert np.array_equal(by_array.chi, by_file.chi)
        assert np.array_equal(by_array.covariance, by_file.covariance)
        assert by_array.document["parameters"] == by_file.document["parameters"]


def test_friction_laws_are_chosen(scara):
    robot = rivid.Robot.from_urdf(scara / "scara.urdf", friction="auto")
    fit = rivid.identify(robot, scara / "scara_s2.csv", rivid.Wls(torque_held=True))
    assert [note for note in fit.document["notes"] if "by cross-validation" in note]
    assert fit.robot is not robot
    assert np.allclose(fit.chi, rivid.identify(fit.robot, scara / "scara_s2.csv", rivid.Wls(torque_held=True)).chi)


def test_threads_change_nothing(robot, scara):
    log = rivid.read_log(scara / "scara_s2.csv", robot)
    one, two = (rivid.identify(robot, log, rivid.Wls(), threads=k) for k in (1, 2))
    assert one.document["parameters"] == two.document["parameters"]


def test_the_truth_is_within_the_intervals(fit, scara):
    truth = json.loads((scara / "truth.json").read_text())
    true = truth["parameters"]
    for p in fit.parameters:
        value = true[p["name"]]
        value = value["value"] if isinstance(value, dict) else value
        assert abs(p["value"] - value) < 4.0 * p["sigma"], p["name"]


def test_views_agree_with_the_document(fit):
    assert fit.status == "identified"
    assert fit.identified
    assert np.array_equal(fit.parameters["value"], fit.chi)
    assert np.allclose(fit.sigma, np.sqrt(np.diag(fit.covariance)), rtol=1e-12)
    assert fit.parameters.row("ZZ1R")["unit"] == "kg·m²"
    assert fit.fit["name"] == fit.robot.joints
    with pytest.raises(KeyError, match="ZZ1R"):
        fit.parameters.row("nothing")


def test_predictions_have_the_error_of_the_fit(fit, scara):
    prediction = fit.predict(scara / "scara_validation.csv")
    figures = fit.validate(scara / "scara_validation.csv")
    for j, joint in enumerate(figures["joints"]):
        samples, residual = prediction.rows(joint["name"])
        assert len(samples) == joint["rows"]
        # In a validation no degrees of freedom are taken off.
        assert np.sqrt(np.mean(residual**2)) == pytest.approx(joint["sigma_rho"], rel=1e-12)
        assert prediction.measured[:, j].shape == prediction.t.shape
    assert prediction.kept.dtype == bool
    assert np.array_equal(prediction.residual, prediction.measured - prediction.predicted)
    assert fit.document["validation"][-1]["relative_error"] == figures["relative_error"]


def test_the_score_is_the_share_of_the_torque_that_is_explained(fit, scara):
    before = json.dumps(fit.document)
    joints = fit.validate(scara / "scara_validation.csv")["joints"]
    expected = np.mean([1.0 - joint["centred_relative_error"] ** 2 for joint in joints])
    assert fit.score(scara / "scara_validation.csv") == pytest.approx(expected, rel=1e-12)
    assert fit.score([scara / "scara_validation.csv", scara / "scara_s2.csv"]) > 0.99
    assert json.dumps(fit.document) != before  # by validate alone
    assert len(fit.document["validation"]) == len(json.loads(before)["validation"]) + 1


def test_params_are_the_settings_of_the_fit(fit, scara):
    params = fit.get_params()
    assert params["method.name"] == "wls"
    assert params["signal.decimation"] == [20]
    assert params["signal.torque_held"] is True
    again = rivid.Experiment(scara / "scara.toml", {"signal.decimation": params["signal.decimation"]})
    assert rivid.identify(again).get_params()["signal.decimation"] == params["signal.decimation"]


def test_residuals_are_those_of_the_rows(fit):
    for joint in fit.fit:
        assert len(fit.residuals[joint["name"]]) == joint["rows"]


def test_plots_show_what_the_fit_sees(fit, scara):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    prediction = fit.predict(scara / "scara_s2.csv")
    for axis, joint in zip(prediction.plot(), prediction.joints):
        measured, predicted = (line.get_ydata() for line in axis.lines)
        rows, residual = prediction.rows(joint)
        at = rows - (len(prediction.t) - len(measured)) // 2
        inside = (at >= 0) & (at < len(measured))
        assert inside.sum() > 0.9 * len(rows)
        np.testing.assert_allclose((measured - predicted)[at[inside]], residual[inside], atol=1e-9 * np.abs(measured).max())


def test_results_are_written_and_shown(fit, tmp_path):
    fit.save(tmp_path / "result.json")
    assert json.loads((tmp_path / "result.json").read_text())["parameters"] == fit.document["parameters"]
    page = fit.to_html(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == page
    assert page.startswith("<!DOCTYPE html>")
    assert "ZZ1R" in fit._repr_html_()
    assert "ZZ1R" in fit.parameters._repr_html_()
    assert "ZZ1R" in repr(fit.parameters)
    assert "IDIM-WLS" in str(fit)


def test_a_saved_result_makes_a_model(fit, tmp_path):
    fit.save(tmp_path / "result.json")
    q, qd, qdd = np.random.default_rng(3).normal(size=(3, 5, 2))
    read = rivid.DynamicModel.from_result(tmp_path / "result.json")
    assert np.array_equal(read.inverse_dynamics(q, qd, qdd), fit.model().inverse_dynamics(q, qd, qdd))


def test_options_are_those_of_experiment_files(robot, scara):
    log = rivid.read_log(scara / "scara_s2.csv", robot)
    fit = rivid.identify(
        robot, log, rivid.Wls(decimation=[5, 4], robust="huber", essential=True, physical={"weight": 10.0}, covariance="hac")
    )
    assert fit.document["covariance"]["kind"] == "hac"
    assert fit.document["robust"]["joints"][0]["name"] == "joint_1"
    assert set(fit.physical) == {"arm", "forearm"}
    with pytest.raises(rivid.InputError, match=r"rivid\.Wls: \[signal\] cutoff_hz .*frequency"):
        rivid.identify(robot, log, rivid.Wls(cutoff_hz=-3.0))
    with pytest.raises(ValueError, match=r"covariance is \"hak\", must be one of .*did you mean"):
        rivid.identify(robot, log, rivid.Wls(covariance="hak"))
    with pytest.raises(TypeError, match="cutof_hz"):
        rivid.Wls(cutof_hz=3.0)


def test_a_log_that_does_not_fit_is_refused(robot, columns):
    with pytest.raises(rivid.InputError, match="joint"):
        rivid.identify(robot, rivid.Log(columns["t"], columns["q1"], columns["v1"]))
    with pytest.raises(rivid.InputError, match="rows"):
        rivid.Log(columns["t"], columns["q1"][1:], columns["v1"])
    bad = columns["q1"].copy()
    bad[7] = np.nan
    with pytest.raises(rivid.InputError, match=r"nan|finite"):
        rivid.Log(columns["t"], bad, columns["v1"])


def test_instrumental_variables_in_a_simulated_loop(robot):
    control = rivid.Pd(omega_n=[1, 10], zeta=1, rate_hz=200)
    via = [[0, 0], [1.5, 2], [-1, -1], [1, 1.5], [-1.5, -2], [1, -0.5], [0, 0]]
    simulated = rivid.simulate(
        robot, control, rivid.PointToPoint(via=via, durations=2.5), position_noise=2e-5, disturbance=[0.06, 0.015], seed=3
    )
    assert simulated.outcome == "completed"
    assert simulated.log.q_r is not None
    fit = rivid.identify(robot, simulated.log, rivid.Iv(control=control, decimation=20, torque_held=True))
    truth = robot.base_parameters().from_standard(list(robot.standard_parameters.values()))
    assert fit.identified
    assert np.abs((fit.chi - truth) / fit.sigma).max() < 4.5
    assert len(fit.document["iterations"]) >= 2
    with pytest.raises(rivid.InputError, match=r"\[control\]"):
        rivid.identify(robot, simulated.log, rivid.Iv())


def test_a_simulation_of_a_file_is_that_of_the_command_line(scara, tool, tmp_path):
    tool("rivid_simulate", scara / "simulate_s1.toml", "--output", tmp_path, "--quiet")
    rivid.simulate(scara / "simulate_s1.toml").log.to_csv(tmp_path / "log_python.csv")
    assert (tmp_path / "log_python.csv").read_text() == (tmp_path / "log.csv").read_text()


def test_progress_is_told_and_may_end_the_work(robot, scara):
    told = []
    rivid.identify(robot, scara / "scara_s2.csv", rivid.Wls(), progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told
    assert all(isinstance(stage, str) and 0.0 <= fraction <= 1.0 for stage, fraction in told)

    class Enough(Exception):
        pass

    def stop(stage, fraction):
        raise Enough

    with pytest.raises(Enough):
        rivid.identify(robot, scara / "scara_s2.csv", rivid.Wls(), progress=stop)


def test_other_threads_run_meanwhile(scara):
    study = rivid.Study(scara / "montecarlo_s1.toml")
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.0005)

    thread = threading.Thread(target=count)
    thread.start()
    study.run(range(2))
    done.set()
    thread.join()
    assert counted > 20


def test_an_interrupt_ends_long_work(scara):
    script = f"import rivid; print('go', flush=True); rivid.montecarlo({str(scara / 'montecarlo_s1.toml')!r}, runs=100000)"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.readline()
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=600)
    assert b"KeyboardInterrupt" in errors
    assert process.returncode != 0


def test_a_study_is_the_same_in_pieces(scara):
    study = rivid.Study(scara / "montecarlo_s1.toml")
    whole = study.run(range(4), threads=2)
    pieces = study.run([3, 1]) + pickle.loads(pickle.dumps(study)).run([0, 2])
    assert study.results(whole).document == study.results(pieces).document
    assert list(study.results(whole).trials)


def test_logs_and_robots_can_be_pickled(robot, scara):
    log = rivid.read_log(scara / "scara_s2.csv", robot)
    again, twin = pickle.loads(pickle.dumps((log, robot)))
    assert np.array_equal(again.q, log.q)
    assert again.rate_hz == log.rate_hz
    assert twin.standard_parameters == robot.standard_parameters
    assert rivid.identify(twin, again, rivid.Wls(decimation=20)).document == rivid.identify(
        robot, log, rivid.Wls(decimation=20)
    ).document


def test_check_finds_a_torque_of_the_other_sign(robot, columns):
    q = np.column_stack([columns["q1"], columns["q2"]])
    good = rivid.Log(columns["t"], q, v_tau=np.column_stack([columns["v1"], columns["v2"]]))
    bad = rivid.Log(columns["t"], q, v_tau=np.column_stack([columns["v1"], -columns["v2"]]))
    assert "torque_sign" not in [f.code for f in rivid.check(robot, good)]
    found = [f for f in rivid.check(robot, bad) if f.code == "torque_sign"]
    assert found
    assert found[0].subject == "joint_2"
    assert "Cure" in found[0].explain()
