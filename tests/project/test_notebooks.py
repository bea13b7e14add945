"""The notebooks run from their first cell to their last, and keep small outputs."""

import warnings
from pathlib import Path
from typing import Any

import pytest

from tests.kits.paths import ROOT

NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
FAST = "a_grip_from_scene_to_events"
LARGEST = 200_000
"""[bytes] Largest file of a notebook with its outputs."""


def test_there_are_three_and_their_outputs_are_small_and_without_errors() -> None:
    nbformat = pytest.importorskip("nbformat", reason="needs nbformat")
    assert len(NOTEBOOKS) == 3
    for path in NOTEBOOKS:
        assert path.stat().st_size < LARGEST
        cells = [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]
        outputs = [output for cell in cells for output in cell.outputs]
        assert outputs
        assert not any(output.output_type == "error" for output in outputs)


def executed(path: Path) -> Any:
    nbclient = pytest.importorskip("nbclient", reason="needs nbclient")
    nbformat = pytest.importorskip("nbformat", reason="needs nbformat")
    pytest.importorskip("ipykernel", reason="needs ipykernel")
    notebook = nbformat.read(path, 4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Jupyter's own
        nbclient.NotebookClient(
            notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(ROOT)}}
        ).execute()
    return notebook


def test_the_notebook_of_a_grip_runs() -> None:
    """Its printed texts are those that the file keeps."""
    nbformat = pytest.importorskip("nbformat", reason="needs nbformat")
    (path,) = (one for one in NOTEBOOKS if one.stem == FAST)
    kept, found = nbformat.read(path, 4), executed(path)
    for before, after in zip(kept.cells, found.cells, strict=True):
        if before.cell_type == "code" and any(output.output_type == "stream" for output in before.outputs):
            printed = [
                output.text for output in after.outputs if output.output_type == "stream" and output.name == "stdout"
            ]
            assert printed == [output.text for output in before.outputs if output.output_type == "stream"]


@pytest.mark.slow
@pytest.mark.parametrize("path", [one for one in NOTEBOOKS if one.stem != FAST], ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path) -> None:
    executed(path)
