"""The notebooks of examples/python run from their first cell to the last, which asserts what they promise."""

import pytest
from conftest import REPOSITORY

NOTEBOOKS = sorted((REPOSITORY / "examples" / "python").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(notebook, monkeypatch, tmp_path):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("RIVID_DATA", str(REPOSITORY / "data"))
    monkeypatch.setenv("MPLBACKEND", "agg")
    content = nbformat.read(notebook, as_version=4)
    assert all(not cell.get("outputs") for cell in content.cells), "outputs are no part of the repository"
    nbclient.NotebookClient(content, timeout=1400, resources={"metadata": {"path": str(tmp_path)}}).execute()


def test_all_notebooks_are_found():
    assert len(NOTEBOOKS) == 3
