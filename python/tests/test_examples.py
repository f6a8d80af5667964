"""The programs of examples/python run, and keep what they promise."""

import subprocess
import sys

import pytest
from conftest import REPOSITORY

EXAMPLES = sorted((REPOSITORY / "examples" / "python").glob("*.py"))


@pytest.mark.parametrize("program", EXAMPLES, ids=lambda path: path.stem)
def test_example(program, scara):
    done = subprocess.run([sys.executable, program, scara], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_all_examples_are_found():
    assert len(EXAMPLES) >= 6
