"""The notebooks of examples/python run from their first cell to the last, which asserts what they promise, and show what they hold stored.

RIVID_WRITE_PAGES=1 stores outputs and pictures anew.
"""

import os

import pytest
from conftest import REPOSITORY

NOTEBOOKS = sorted((REPOSITORY / "examples" / "python").glob("*.ipynb"))


def shown(content):
    """What each cell shows: streams, and the kinds of pictures and tables, but not what Dask says of a slow machine."""
    return [
        [out.get("name") or sorted(out.data) for out in cell.get("outputs", []) if "distributed" not in out.get("text", "")]
        for cell in content.cells
    ]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(notebook, monkeypatch, tmp_path):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("RIVID_DATA", str(REPOSITORY / "data"))
    stored = nbformat.read(notebook, as_version=4)
    run = nbformat.read(notebook, as_version=4)
    resources = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(run, timeout=1400, resources=resources, record_timing=False).execute()
    if "RIVID_WRITE_PAGES" in os.environ:
        run.metadata.pop("language_info", None)
        nbformat.write(run, notebook)
    assert shown(run) == shown(stored)
    text = notebook.read_text(encoding="utf-8")
    assert "image/png" in text
    assert len(text) < 300_000
    assert not any(place in text for place in ("/tmp/", str(REPOSITORY), os.path.expanduser("~/")))


def test_all_notebooks_are_found():
    assert len(NOTEBOOKS) == 3
