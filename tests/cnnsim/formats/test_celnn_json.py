"""celnn's JSON, read and written."""

import json

import numpy as np
import pytest

from cnnsim import InputError, library, run_transient
from cnnsim.formats.celnn_json import celnn, read_celnn
from cnnsim.formats.differences import number_differences
from cnnsim.library.imported import plain
from cnnsim.network import Template, fixed
from cnnsim.support import Diagnostics


def test_library_templates_are_the_same_after_export_and_import() -> None:
    for entry in map(library.load, library.names()):
        if not isinstance(entry.network, Template) or not entry.network.linear:
            with pytest.raises(InputError, match="not linear"):
                celnn(entry.network, "", ())
            continue
        (imported,) = read_celnn(celnn(entry.network, entry.summary, entry.tags).encode(), Diagnostics("x"))
        assert list(number_differences(imported.network, entry.network)) == []
        assert (imported.name, imported.summary, imported.tags) == (entry.name, entry.summary, entry.tags)


ITEM = {"name": "My Edge", "feedback": [[2]], "control": [[3]], "bias": -1.5, "description": "d", "tags": ["t"],
        "initial_state": None, "metadata": {}}  # fmt: skip


def test_celnn_turns_the_sign_of_z_and_says_so() -> None:
    report = Diagnostics("x.json")
    (imported,) = read_celnn(json.dumps(ITEM).encode(), report)
    assert (
        plain(imported.network, "").A.tolist(),
        plain(imported.network, "").B.tolist(),
        plain(imported.network, "").z,
    ) == ([[2]], [[3]], 1.5)
    assert "sign of z is turned" in imported.note
    assert any("sign of z is turned" in item.message for item in report.of("warning"))
    assert (imported.name, imported.summary, imported.tags) == ("my-edge", "d", ("t",))
    exported = json.loads(celnn(imported.template, "d", ("t",)))
    assert exported["bias"] == -1.5
    assert exported["feedback"] == [[0, 0, 0], [0, 2, 0], [0, 0, 0]]


def test_turning_both_pictures_and_z_is_the_same_template() -> None:
    rng = np.random.default_rng(3)
    entry = library.load("corner-chip-1")
    picture = np.where(rng.random((9, 9)) < 0.5, 1.0, -1.0)
    turned = json.loads(celnn(entry.template, "", ()))
    theirs = Template(turned["feedback"], turned["control"], turned["bias"])
    ours = run_transient(entry.template, input=picture, state=0 * picture, boundary=fixed(-1), backend="reference")
    other = run_transient(theirs, input=-picture, state=0 * picture, boundary=fixed(1), backend="reference")
    assert np.array_equal(ours.y, -other.y)


def test_a_registry_loses_only_the_wrong_ones() -> None:
    wrong = [{**ITEM, "bias": [1, 2]}, {**ITEM, "control": [[1, 2]]}, {**ITEM, "feedback": [["1"]]}, 3, {"name": "x"},
             {**ITEM, "name": 3}, {**ITEM, "tags": "t"}, {**ITEM, "feedback": [[True]]}]  # fmt: skip
    report = Diagnostics("x.json")
    templates = read_celnn(json.dumps({"templates": [*wrong, ITEM]}).encode(), report)
    assert [imported.name for imported in templates] == ["my-edge"]
    assert len(report.of("error")) == len(wrong)


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"templates": 3}', '{"name": "x", "feedback": NaN}', "[" * 100000])
def test_no_celnn_json(text: str) -> None:
    report = Diagnostics("x.json")
    assert read_celnn(text.encode(), report) == []
    assert report.failed
