"""The widget of notebooks: its messages, and a notebook that runs it. Its module is the page's view, tested there."""

import warnings
from typing import Any

import numpy as np
import pytest

pytest.importorskip("anywidget", reason="needs the extra notebook")

from cnnsim import InputError, Template, library
from cnnsim.notebook import Playground

PICTURE = np.where(np.indices((8, 9)).sum(axis=0) % 3 == 0, 1.0, -1.0)
CELLS = """
import numpy as np
from cnnsim.notebook import Playground
picture = np.where(np.indices((8, 9)).sum(axis=0) % 3 == 0, 1.0, -1.0)
playground = Playground("hole-filler", picture)
for _ in range(7):
    playground._handle_custom_msg({"do": "frame", "by": 1, "id": 1}, [])
print(round(playground.t, 3), playground.x.shape)
playground
"""


def sent(playground: Playground, monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, Any]]:
    found: list[tuple[Any, Any]] = []
    monkeypatch.setattr(playground, "send", lambda content, buffers=None: found.append((content, buffers)))
    return found


def test_it_answers_the_view_and_takes_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    playground = Playground("hole-filler", PICTURE, boundary="periodic")
    found = sent(playground, monkeypatch)
    for _ in range(4):
        playground._handle_custom_msg({"do": "frame", "by": 1, "id": 3}, [])
    content, buffers = found.pop()
    assert (content["is"], content["id"], content["index"], len(buffers[0])) == ("frame", 3, 4, PICTURE.size)
    assert playground.t == pytest.approx(0.4)
    assert np.array_equal(playground.y, np.clip(playground.x, -1, 1))
    playground.change(template=Template(2.0, 1.0, 0.5), boundary="zero-flux")
    assert playground.template.reads_input
    assert found.pop()[0]["is"] == "planes"
    with pytest.raises(InputError):
        playground.change(step=99.0)
    playground._handle_custom_msg("nonsense", [])
    assert found.pop()[0]["is"] == "error"


def test_it_shows_entries_and_templates_of_your_own() -> None:
    assert Playground(library.load("edge"), PICTURE).session.setup.entry.name == "edge"
    own = Template([[0.1, 0.15, 0.1], [0.15, 0, 0.15], [0.1, 0.15, 0.1]], name="heat")
    playground = Playground(own, PICTURE, duration=2.0)
    assert np.array_equal(playground.x, PICTURE.astype(np.float32))
    assert playground.template is own


def test_the_module_of_the_view_stands_alone() -> None:
    text = str(Playground(picture=PICTURE)._esm)
    assert "export default" in text
    assert "\nimport " not in text


def test_a_notebook_shows_it() -> None:
    nbclient = pytest.importorskip("nbclient", reason="needs nbclient")
    nbformat = pytest.importorskip("nbformat", reason="needs nbformat")
    pytest.importorskip("ipykernel", reason="needs ipykernel")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELLS)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Jupyter's own
        nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3").execute()
    outputs = notebook.cells[0].outputs
    assert outputs[0].text == "0.7 (8, 9)\n"
    assert "application/vnd.jupyter.widget-view+json" in outputs[-1].data
