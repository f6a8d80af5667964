"""What Python saves, the tools take."""

import json

import numpy as np
import pytest

import rivid

METHOD = rivid.Wls(decimation=20, torque_held=True, physical=True)


@pytest.fixture(scope="module", params=["path", "arrays"])
def saved(request, robot, scara, columns, tmp_path_factory):
    """result.json of a fit to a file, and to arrays."""
    if request.param == "path":
        log = scara / "scara_s2.csv"
    else:
        log = rivid.Log(
            t=columns["t"],
            q=np.column_stack([columns["q1"], columns["q2"]]),
            v_tau=np.column_stack([columns["v1"], columns["v2"]]),
        )
    file = tmp_path_factory.mktemp("saved") / "fit.json"
    rivid.identify(robot, log, METHOD).save(file)
    return file


def test_validate_and_compare_read_logs_by_the_usual_names(saved, scara, tool):
    done = tool("rivid_identify", "validate", saved, scara / "scara_validation.csv", "--json")
    assert json.loads(done.stdout)["models"][0]["relative_error"] < 0.03
    done = tool("rivid_identify", "compare", saved, scara / "scara.urdf", "--log", scara / "scara_validation.csv", "--json")
    first, second = json.loads(done.stdout)["models"]
    assert max(first["relative_error"], second["relative_error"]) < 0.03


@pytest.mark.parametrize("format", ["mjcf", "sdf", "drake", "pinocchio", "urdf", "header"])
def test_export_finds_the_urdf(saved, tool, tmp_path, format):
    file = tmp_path / {"mjcf": "a.xml", "sdf": "a.sdf", "header": "a.h"}.get(format, "a.urdf")
    tool("rivid_identify", "export", saved, "--to", format, "--output", file, "--force")
    assert file.stat().st_size > 0


def test_online_takes_it(saved, scara, tool, tmp_path):
    done = tool("rivid_online", scara / "scara_validation.csv", "--result", saved, "--output", tmp_path / "online")
    assert (tmp_path / "online/online.csv").exists(), done.stderr
