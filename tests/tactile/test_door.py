"""The public interface of `tactile`: names, lazy imports, errors of wrong arguments."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import tactile
from tactile.cli.group import main
from tactile.output.json_data import settings_data
from tests.kits.paths import SCENES


def test_every_public_name_exists() -> None:
    assert all(getattr(tactile, name) is not None for name in tactile.__all__)
    assert dir(tactile) == tactile.__all__
    with pytest.raises(AttributeError, match="no attribute 'roll'"):
        tactile.roll  # type: ignore[attr-defined]  # noqa: B018


def test_importing_the_package_imports_nothing_slow() -> None:
    slow = "{'numpy', 'scipy', 'numba', 'cnnsim.network', 'cnnsim.support', 'tactile.pipeline'}"
    code = f"import sys, tactile; print(sorted({slow} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"


def test_a_result_has_events_frames_loads_codes_and_a_figure() -> None:
    result = tactile.run(SCENES / "needle.toml")
    assert [event.kind for event in result.events] == ["contact", "hold", "release"]
    assert [event.kind for event in result.events[1:]] == ["hold", "release"]
    (array,) = result.arrays
    count = result.times[array.name].size
    assert result.frames[array.name].shape == (count, *array.shape, 3)
    assert result.codes[array.name].shape == (count, *array.shape, 2)
    assert result.loads[array.name].F.shape == (count,)
    assert result.events[0].words in result._repr_html_()
    assert len(repr(result.events).splitlines()) == 4
    assert any(axis.get_ylabel() == "y [mm]" for axis in result.plot())


def test_a_result_has_the_events_and_loads_of_the_command(tmp_path: Path) -> None:
    """The defaults of `tactile run` hold also for an opened source, and programs' planes are kept."""
    done = CliRunner().invoke(main, ["run", str(SCENES.parent / "grasp.npz"), "--json"])
    told = json.loads(done.stdout)
    result = tactile.run(tactile.open_source(SCENES.parent / "grasp.npz"))
    assert [(event.t, event.end, event.words) for event in result.events] == [
        (event["t_s"], event["end_s"], event["words"]) for event in told["events"]
    ]
    assert settings_data(result.settings) == told["settings"]
    seen = tactile.run(SCENES / "needle.toml", tactile.Settings(programs=("event-code",))).programs
    assert seen and seen[0].outputs["contact"].shape == tactile.open_source(SCENES / "needle.toml").arrays[0].shape


def test_events_become_a_data_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas", reason="needs pandas")
    events = tactile.run(SCENES / "needle.toml").events
    frame = events.to_pandas()
    assert list(frame["kind"]) == ["contact", "hold", "release"]
    assert frame["t_s"][0] == events[0].t
    assert frame["data"][0]["of_taxels"] == events[0].data["of_taxels"]
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(tactile.InputError, match="needs pandas, which is not installed: pip install pandas"):
        events.to_pandas()


API: Any = tactile  # for arguments of wrong types


def test_numpy_numbers_become_python_numbers() -> None:
    array = API.TaxelArray("a", np.int64(2), np.int32(2), np.float64(0.004), np.float64(0.001))
    assert repr(array) == repr(tactile.TaxelArray("a", 2, 2, 0.004, 0.001))
    assert repr(API.Threshold(np.float64(0.5), np.int64(1))) == "Threshold(dead_band=0.5, hysteresis=1.0)"


SCENE = tactile.open_source(SCENES / "needle.toml")
ARRAY = tactile.TaxelArray("a", 2, 2, 1e-3, 1e-3)
PATH = [[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]


@pytest.mark.parametrize(("wrong", "message"), [
    (lambda: API.TaxelArray("a", 3.5, 5, 1e-3, 1e-3), "3.5 x 5 taxels"),
    (lambda: API.TaxelArray("a", 3, 5, "x", 1e-3), "pitch 'x'"),
    (lambda: API.TaxelArray(1, 3, 5, 1e-3, 1e-3), "taxel array 1"),
    (lambda: API.Settings(window="x"), "window 'x'; a whole number of frames wanted"),
    (lambda: API.Settings(tare="sometimes"), "tare 'sometimes'; one of 'auto', 'manual', 'off'"),
    (lambda: API.Settings(programs="two-blobs.toml"), "programs 'two-blobs.toml'; a tuple"),
    (lambda: API.run("scene.toml"), "no scene or recording scene.toml"),
    (lambda: API.TaxelArray("a", 3, 5, 1e-3, 1e-3, "strain"), "origin 'strain'; its centre"),
    (lambda: API.TaxelArray("a", 3, 5, pich=1e-3, depth=1e-3), "no keyword 'pich'; did you mean 'pitch'"),
    (lambda: API.Settings(windw=3), "no keyword 'windw'; did you mean 'window'"),
    (lambda: API.Settings(shear=0.1), "shear 0.1; a Threshold wanted"),
    (lambda: API.Settings(sigmas=(4, 6, 3)), r"sigmas \(4, 6, 3\); Sigmas wanted"),
    (lambda: API.Settings(gains=3), "gains 3; Gains wanted"),
    (lambda: API.Settings(depth="a"), "depth 'a'; a number wanted"),
    (lambda: API.Threshold("a", 1), "dead_band is 'a'; a number"),
    (lambda: API.Indenter("sphere", "a"), "radius 'a'; a number"),
    (lambda: API.run(SCENE, {}), "settings {}; Settings"),
    (lambda: API.run(3), "source 3; a file or a source of frames"),
    (lambda: API.open_source(3), "path 3; the name of a file"),
    (lambda: API.read_detector(3), "path 3; the name of a file"),
    (lambda: API.make_effect(3), "effect 3; the name of one"),
    (lambda: API.make_effect("read_noise", rms="a"), "effect read_noise: rms = 'a'; a number"),
    (lambda: API.MovingContact(0, "sphere", PATH), "indenter 'sphere' of a contact; an Indenter"),
    (lambda: API.MovingContact(0, API.Indenter(), [[1], [1, 2]]), "path of a contact of shape"),
    (lambda: API.MovingContact(0, API.Indenter(), PATH, "a"), "friction 'a' of a contact"),
    (lambda: API.Scene("s", "a", 1, 2e6, [ARRAY]), "rate 'a', a positive number"),
    (lambda: API.Scene("s", 100, 1, 2e6, ARRAY), r"arrays TaxelArray.*; a list of them wanted: \[TaxelArray"),
    (lambda: API.Scene("s", 100, 1, 2e6, [3]), "arrays with 3; each a TaxelArray"),
    (lambda: API.Scene("s", 100, 1, 2e6, [ARRAY], [3]), "3; a finger from 0 to 0"),
    (lambda: API.Scene("s", 100, 1, 2e6, [ARRAY], API.MovingLoad("a", PATH)), "loads MovingLoad.*; a list of them"),
    (lambda: API.Scene("s", 100, 1, 2e6, [ARRAY], [API.MovingLoad("a", PATH)]), "MovingLoad.*; a finger from 0"),
    (lambda: API.Scene("s", 100, 1, 2e6, [ARRAY], seed=1.5), "seed = 1.5, a whole number"),
    (lambda: API.Scene("s", 100, 1, 2e6, [ARRAY], effects=API.make_effect("drift")), "effects Drift.*; a list"),
    (lambda: API.Frame(0, 0.0, 0, [[[1, 2, 3]]], [[True]]), "frame 0: lists of values; arrays"),
])  # fmt: skip
def test_wrong_arguments_are_refused(wrong: Callable[[], Any], message: str) -> None:
    with pytest.raises(tactile.InputError, match=message):
        wrong()


def test_scenes_can_be_compared() -> None:
    array = tactile.TaxelArray("a", 2, 2, 1e-3, 1e-3)
    one, other = (tactile.MovingLoad(0, [[0.1, 0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0, 0.2]]) for _ in range(2))
    scene = tactile.Scene("s", 100.0, 1.0, 2.4e6, (array,), (one,))
    assert scene == tactile.Scene("s", 100.0, 1.0, 2.4e6, (array,), (one,))
    assert scene != tactile.Scene("s", 100.0, 1.0, 2.4e6, (array,), (other,))
