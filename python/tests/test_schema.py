"""docs/experiment.schema.json: all experiment files of the repository keep to it, mistakes do not."""

import json
import tomllib
from pathlib import Path

import pytest

jsonschema = pytest.importorskip("jsonschema")
ROOT = Path(__file__).parents[2]
SCHEMA = jsonschema.Draft7Validator(json.loads((ROOT / "docs/experiment.schema.json").read_text(encoding="utf-8")))


def faults(experiment):
    return [f"{list(fault.path)}: {fault.message}" for fault in SCHEMA.iter_errors(experiment)]


def test_holds_of_all_experiment_files():
    files = [file for folder in ("data", "tests/real") for file in sorted((ROOT / folder).rglob("*.toml"))]
    experiments = {file: tomllib.loads(file.read_text(encoding="utf-8")) for file in files}
    experiments = {file: content for file, content in experiments.items() if "robot" in content}
    assert len(experiments) > 10
    for file, content in experiments.items():
        assert faults(content) == [], file


@pytest.mark.parametrize(
    "experiment",
    [
        {"robt": {}},
        {"robot": {"urdf": "a.urdf", "fiction": "coulomb"}},
        {"robot": {"friction": "columb"}},
        {"log": {"rate_hz": "fast"}},
        {"method": {"name": "olz"}},
        {"control": {"law": "pd", "omega": 1.0}},
        {"simulation": {"rtol": 2.0}},
    ],
)
def test_refuses_mistakes(experiment):
    assert faults(experiment) != []
