"""The archive of rivid identify --write-rows is what docs/result.md says of it."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import REPOSITORY

TOOLS = os.environ.get("RIVID_TOOLS", "")


@pytest.mark.skipif(not (Path(TOOLS) / "rivid_identify").exists(), reason="no tools in RIVID_TOOLS")
def test_rows_give_the_estimate(tmp_path):
    command = [Path(TOOLS) / "rivid_identify", REPOSITORY / "data/scara/scara.toml", "--quiet", "--output", tmp_path]
    subprocess.run([*command, "--write-rows", tmp_path / "rows.npz"], check=True)
    result = json.loads((tmp_path / "result.json").read_text())

    rows = np.load(tmp_path / "rows.npz")
    w = rows["weight"]
    chi = np.linalg.lstsq(w[:, None] * rows["W"], w * rows["Y"], rcond=None)[0]

    sigma = np.array([p["sigma"] for p in result["parameters"]])
    assert rows["parameters"].tolist() == [p["name"] for p in result["parameters"]]
    assert rows["joints"].tolist() == [j["name"] for j in result["robot"]["joints"]]
    np.testing.assert_array_equal(rows["chi"], [p["value"] for p in result["parameters"]])
    # Another factorisation of rows whose condition is some hundred.
    np.testing.assert_allclose((chi - rows["chi"]) / sigma, 0, atol=1e-9)
    assert rows["W"].shape == (result["fit"]["rows"], len(sigma))
    np.testing.assert_allclose(np.linalg.norm(rows["residual"]), result["fit"]["error_norm"], rtol=1e-12)
    np.testing.assert_allclose(rows["leverage"].sum(), len(sigma), rtol=1e-12)
    # Symmetric up to rounding.
    np.testing.assert_allclose(rows["covariance"], rows["covariance"].T, rtol=1e-9)
    assert set(rows["joint"]) == {0, 1}
    assert Path(str(rows["logs"][0])).name == "scara_s2.csv"
