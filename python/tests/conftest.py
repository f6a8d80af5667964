"""What the tests share."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rivid

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def scara() -> Path:
    """The folder of the SCARA."""
    return REPOSITORY / "data" / "scara"


@pytest.fixture(scope="session")
def robot(scara: Path) -> rivid.Robot:
    """The SCARA as its experiment files describe it."""
    return rivid.Robot.from_urdf(scara / "scara.urdf", gravity=[0, 0, -9.81], friction="coulomb", rotor_inertia=False)


@pytest.fixture(scope="session")
def columns(scara: Path) -> dict[str, np.ndarray]:
    """The columns of its log, by their names."""
    names = (scara / "scara_s2.csv").read_text().split("\n", 1)[0].split(",")
    values = np.loadtxt(scara / "scara_s2.csv", delimiter=",", skiprows=1)
    return {name.strip(): values[:, j] for j, name in enumerate(names)}


@pytest.fixture(scope="session")
def tool():
    """Runs a command line tool of the same build."""
    folder = Path(os.environ.get("RIVID_TOOLS", Path(rivid.__file__).parent / "bin"))

    def run(name, *arguments, code=0):
        program = folder / name
        if not program.exists():
            pytest.skip(f"{program} is not there")
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == code, done.stderr
        return done

    return run


@pytest.fixture
def program(tmp_path):
    """Runs the program `rivid`."""

    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "rivid", *map(str, arguments)], capture_output=True, text=True, check=False
        )

    return run


def pytest_sessionfinish(session):
    """In continuous integration nothing is skipped: everything that a test may need is installed there."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CI") and reporter is not None and reporter.stats.get("skipped"):
        reporter.write_line("tests were skipped, which counts as a failure where CI is set")
        session.exitstatus = 1
