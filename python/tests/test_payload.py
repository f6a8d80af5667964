"""identify_payloads(): the numbers of the command line."""

import json

import numpy as np
import pytest

import rivid


@pytest.fixture(scope="module")
def six_axis(scara, tool, tmp_path_factory):
    """Folder of the six-axis arm with its log and that of the same arm with two kilograms more in its last link, and the robot."""
    source = scara.parent / "six_axis"
    folder = tmp_path_factory.mktemp("six_axis")
    for file in ("six_axis.toml", "six_axis.urdf", "simulate.toml", "six_axis_reference.csv"):
        (folder / file).write_text((source / file).read_text())
    heavy = (folder / "six_axis.urdf").read_text().replace('<mass value="0.2"/>', '<mass value="2.2"/>')
    (folder / "loaded.urdf").write_text(heavy)
    plan = (folder / "simulate.toml").read_text().replace('urdf = "six_axis.urdf"', 'urdf = "loaded.urdf"')
    (folder / "loaded.toml").write_text(plan.replace("4001", "77"))
    tool("rivid_simulate", folder / "simulate.toml", "-o", folder / "made", "-q")
    tool("rivid_simulate", folder / "loaded.toml", "-o", folder / "heavy", "-q")
    tool("rivid_identify", folder / "six_axis.toml", "--method", "wls", "-o", folder / "arm", "-q")
    return folder, rivid.Experiment(folder / "six_axis.toml").robot


_METHOD = {"cutoff_hz": "off", "torque_held": True, "decimation": 10}


def _by_tool(tool, folder, *arguments):
    tool("rivid_identify", "payload", folder / "six_axis.toml", *arguments, "-o", folder / "by_tool", "-q")
    return json.loads((folder / "by_tool" / "payload.json").read_text())


def test_a_payload_is_that_of_the_command_line(six_axis, tool):
    folder, robot = six_axis
    heavy = folder / "heavy" / "log.csv"
    found = rivid.identify_payloads(
        robot, heavy, rivid.Wls(**_METHOD), without=folder / "made" / "log.csv", gains=1.0
    )
    assert found.identified
    assert found.document == _by_tool(tool, folder, "--loaded", heavy, "--gains", "1")
    payload = found["payload"]
    assert payload.mass == pytest.approx(2.0, abs=0.1)
    assert payload.com[2] == pytest.approx(0.042, abs=0.005)
    assert np.isnan(payload.inertia).all() == (payload.model == "point")
    assert payload.values.row("mass")["unit"] == "kg"
    assert "set_target_payload" in str(found)


def test_payloads_are_told_on_a_result(six_axis, tool):
    folder, robot = six_axis
    logs = {"heavy": folder / "heavy" / "log.csv", "none": folder / "made" / "log.csv"}
    method = rivid.Wls(**_METHOD)
    found = rivid.identify_payloads(robot, logs, method, arm=folder / "arm" / "result.json")
    words = [f"{name}={file}" for name, file in logs.items()]
    by_tool = _by_tool(tool, folder, "--arm", folder / "arm" / "result.json", "--loaded", *words)
    assert found.document == by_tool
    assert found["none - heavy"].mass == pytest.approx(-2.0, abs=0.05)
    assert np.isnan(found["none"].com).all()
    fit = rivid.identify(robot, folder / "made" / "log.csv", method)
    of_fit = rivid.identify_payloads(robot, logs, method, arm=fit)
    assert of_fit["heavy"].mass == pytest.approx(found["heavy"].mass, rel=1e-6)


def test_gains_follow_from_a_known_mass(six_axis):
    folder, robot = six_axis
    found = rivid.identify_payloads(
        robot,
        folder / "heavy" / "log.csv",
        rivid.Wls(**_METHOD),
        without=folder / "made" / "log.csv",
        gains="estimate",
        mass=2.0,
    )
    assert len(found.gains) == 6
    assert found.gains["value"][1] == pytest.approx(1.0, abs=0.02)


def test_what_does_not_fit_is_refused(six_axis):
    folder, robot = six_axis
    log = folder / "made" / "log.csv"
    with pytest.raises(TypeError, match="give one of them"):
        rivid.identify_payloads(robot, log)
    with pytest.raises(KeyError, match="box"):
        rivid.identify_payloads(robot, log, without=log, mass={"box": 1.0})
    with pytest.raises(rivid.InputError, match="must be automatic, point or body"):
        rivid.identify_payloads(robot, log, without=log, model="plate")
    with pytest.raises(rivid.InputError, match="give the mass of a payload"):
        rivid.identify_payloads(robot, log, without=log, gains="estimate")
