"""Robots, regressors and models."""

import json

import numpy as np
import pytest

import rivid
from rivid import signal


def test_a_faulty_urdf_is_refused_with_its_line(tmp_path):
    (tmp_path / "bad.urdf").write_text("<robot name='x'><link name='a'/><joint name='j'/></robot>")
    with pytest.raises(rivid.InputError, match=r"bad\.urdf:1"):
        rivid.Robot.from_urdf(tmp_path / "bad.urdf")
    with pytest.raises(rivid.InputError, match="missing.urdf"):
        rivid.Robot.from_urdf(tmp_path / "missing.urdf")


def test_keys_of_the_robot_are_checked(scara):
    with pytest.raises(rivid.InputError, match=r"\[robot\] friction is \"coulom\".*did you mean"):
        rivid.Robot.from_urdf(scara / "scara.urdf", friction="coulom")
    with pytest.raises(rivid.InputError, match="unknown key"):
        rivid.Robot.from_urdf(scara / "scara.urdf", frictoin="coulomb")


def test_base_parameters_are_named_and_regrouped(robot):
    base = robot.base_parameters()
    assert list(base) == ["ZZ1R", "Fv1", "Fc1", "ZZ2", "MX2", "MY2", "Fv2", "Fc2"]
    assert base.regrouping("ZZ1R") == pytest.approx({"ZZ1": 1.0, "M2": 0.25}, rel=1e-12)
    chi_st = np.random.default_rng(1).normal(size=len(robot.standard_parameters))
    moved = chi_st + base.null_space() @ np.random.default_rng(2).normal(size=base.null_space().shape[1])
    assert np.allclose(base.from_standard(chi_st), base.from_standard(moved), atol=1e-12)


def test_the_regressor_gives_the_torques_of_the_model(robot):
    q, qd, qdd = np.random.default_rng(5).normal(size=(3, 20, 2))
    chi = robot.base_parameters().from_standard(list(robot.standard_parameters.values()))
    tau = robot.regressor(q, qd, qdd) @ chi
    model = robot.model()
    assert np.allclose(tau, model.inverse_dynamics(q, qd, qdd), rtol=0, atol=1e-12 * np.abs(tau).max())
    assert np.allclose(model.direct_dynamics(q, qd, tau), qdd, rtol=0, atol=1e-9)
    assert np.allclose(robot.model(chi).inverse_dynamics(q, qd, qdd), tau, rtol=0, atol=1e-12 * np.abs(tau).max())


def test_series_of_another_size_are_refused(robot):
    q = np.zeros((4, 2))
    with pytest.raises(rivid.InputError, match="one row a sample"):
        robot.model().inverse_dynamics(q, q[1:], q)
    with pytest.raises(rivid.InputError, match="joint"):
        robot.regressor(np.zeros((4, 3)), np.zeros((4, 3)), np.zeros((4, 3)))


def test_a_loop_has_the_torques_of_the_model(robot):
    model = robot.model()
    loop = rivid.InverseDynamics(model)
    q, qd, qdd = np.random.default_rng(6).normal(size=(3, 2))
    assert np.array_equal(loop.torque(q, qd, qdd), model.inverse_dynamics(q, qd, qdd))
    assert np.allclose(loop.bias(q, qd), loop.gravity(q) + loop.coriolis(q, qd))
    assert np.allclose(loop.mass_matrix(q), model.mass_matrix(q))


def test_a_table_describes_the_robot_of_its_file(tmp_path):
    rows = [
        {"type": "R", "alpha": 0.0, "a": 0.0, "d": 0.3, "theta": 0.1},
        {"type": "P", "alpha": 1.2, "a": 0.2, "d": 0.0, "theta": 0.0},
    ]
    lines = [",".join(map(str, (k + 1, *row.values()))) for k, row in enumerate(rows)]
    (tmp_path / "arm.csv").write_text("joint,type,alpha,a,d,theta\n" + "\n".join(lines) + "\n")
    by_rows, by_file = rivid.Robot.from_mdh(rows), rivid.Robot.from_mdh(tmp_path / "arm.csv")
    assert by_file.name == "arm"
    assert repr(by_rows.base_parameters()) == repr(by_file.base_parameters())


def test_parameters_come_from_files_and_names(robot, scara, tmp_path):
    names = robot.base_parameters().names
    (tmp_path / "values.json").write_text(json.dumps(dict.fromkeys(names, 1.0)))
    q, qd, qdd = np.random.default_rng(7).normal(size=(3, 3, 2))
    by_file = robot.model(tmp_path / "values.json").inverse_dynamics(q, qd, qdd)
    assert np.array_equal(by_file, robot.model(dict.fromkeys(names, 1.0)).inverse_dynamics(q, qd, qdd))
    with pytest.raises(rivid.InputError, match="neither"):
        robot.model({"ZZ1R": 1.0})


def test_filters_agree_with_their_definition():
    x = np.random.default_rng(8).normal(size=(400, 2))
    assert np.allclose(signal.zero_phase(np.ones((100, 1)), 100.0, 5.0), 1.0, rtol=0, atol=1e-12)
    q, qd, _ = signal.differentiate(x, 10.0)
    assert np.array_equal(q, x)
    assert np.allclose(qd[1:-1], (x[2:] - x[:-2]) * 5.0)
    assert signal.decimate(x, 4).shape == (100, 2)
    assert np.array_equal(signal.decimate(x, [2, 2]), signal.decimate(signal.decimate(x, 2), 2))


def test_methods_know_their_keys():
    method = rivid.Iv(cutoff_hz="off", max_iterations=7, control=rivid.ComputedTorque(omega_n=5.0))
    assert method.sections() == {
        "signal": {"cutoff_hz": "off"},
        "method": {"name": "iv", "max_iterations": 7},
        "control": {"law": "computed_torque", "omega_n": 5.0},
    }
    assert "cutoff_hz" in rivid.Wls.__doc__
    assert repr(rivid.Wls(decimation=3)) == "Wls(decimation=3)"
