"""Texture models: training on simulated slides, classification, files, cross-validation splits."""

from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.materials.classification import strange, told_slides
from tactile.materials.features import feature_set
from tactile.materials.model import TextureModel, hop, train
from tactile.materials.model_file import read_model, write_model
from tactile.materials.split import by_block, by_place, by_slide
from tactile.materials.windows import WindowTable, cut
from tests.kits.touch.slides import slide, slides

KNOWN = ("screw", "smooth wood", "fine textile")
WINDOW = 100


@pytest.fixture(scope="module")
def learned() -> TextureModel:
    made = slides(6, KNOWN)
    model, unknown = train(made, feature_set("full", WINDOW, made))
    assert set(unknown) == set(KNOWN)
    assert np.mean(list(unknown.values())) > 0.9
    return model


def others(model: TextureModel, *names: str) -> WindowTable:
    return cut([slide(name, 900 + n) for n, name in enumerate(names)], model.features, WINDOW)


def test_slides_are_classified_and_an_unknown_material_is_unknown(learned: TextureModel) -> None:
    table = others(learned, *KNOWN, "rasp")
    results = told_slides(learned, table, 0.5)
    assert [one["told"] for one in results] == [*KNOWN, "unknown"]
    assert min(one["confidence"] for one in results[:3]) > 0.6 > 0.4 > results[3]["confidence"]
    assert [len(one["windows"]) for one in results] == [4] * 4
    assert told_slides(learned, table, 0.0)[3]["told"] in KNOWN
    assert strange(learned, others(learned, "screw")) == []
    (again,) = strange(learned, cut(slides(6, KNOWN), learned.features, WINDOW))
    assert "are training windows" in again
    fast = cut([slide("screw", 7, rate=500.0)], learned.features, WINDOW)
    assert strange(learned, fast)[0].startswith("rate_hz ")


def test_a_model_round_trips(learned: TextureModel, tmp_path: Path) -> None:
    write_model(tmp_path / "m.npz", learned)
    again = read_model(tmp_path / "m.npz")
    table = others(learned, "rasp", "screw")
    for ours, theirs in zip(learned.tell(table), again.tell(table), strict=True):
        assert (ours == theirs).all()
    assert again.conditions == learned.conditions
    with np.load(tmp_path / "m.npz", allow_pickle=False) as file:  # object arrays would be refused
        assert all(file[name].dtype != object for name in file.files)


def test_damaged_and_foreign_files_are_refused(learned: TextureModel, tmp_path: Path) -> None:
    good, bad = tmp_path / "m.npz", tmp_path / "bad.npz"
    write_model(good, learned)
    raw = good.read_bytes()
    for broken in (b"", b"hello", raw[: len(raw) // 2], raw[:5000] + b"\0" * 40 + raw[5040:]):
        bad.write_bytes(broken)
        with pytest.raises(InputError, match=r"bad\.npz"):
            read_model(bad)
    with np.load(good, allow_pickle=False) as file:
        parts = {name: file[name] for name in file.files}
    for name, wrong in (
        ("projection", parts["projection"][:, :0].T), ("material", parts["material"] + 9),
        ("centre", parts["centre"] * np.nan),
        ("head", np.array('{"format": "tactile texture model", "version": 2}')), ("head", np.array("[")),
    ):  # fmt: skip
        np.savez(bad, **{**parts, name: wrong})
        with pytest.raises(InputError, match=r"bad\.npz"):
            read_model(bad)
    np.savez(bad, force=np.zeros(3))
    with pytest.raises(InputError, match="missing; a texture model wanted"):
        read_model(bad)


def test_splits_are_disjoint() -> None:
    made = slides(4, KNOWN)
    features = feature_set("full", WINDOW, made)
    table = cut(made, features, hop(features))
    assert len(set(table.start % WINDOW)) > 1
    for train_on, test_on in by_slide(table, WINDOW):
        assert not set(table.slide[train_on]) & set(table.slide[test_on])
        assert set(table.material[test_on]) == set(KNOWN)
        assert not (table.start[test_on] % WINDOW).any()
    tested = [test_on for _, test_on in by_slide(table, WINDOW)]
    assert sorted(np.concatenate(tested)) == np.flatnonzero(table.start % WINDOW == 0).tolist()
    splits = list(by_block(table, WINDOW))
    assert [set(table.block[test_on]) for _, test_on in splits] == [{0}, {1}, {2}, {3}]
    assert not any(set(table.block[a]) & set(table.block[b]) for a, b in splits)
    for train_on, test_on in by_place(table, WINDOW):
        low, high = sorted((table.start[train_on], table.start[test_on]), key=lambda one: one[0])
        assert low.max() + WINDOW <= 200 <= high.min()


def test_too_few_slides_are_refused() -> None:
    made = slides(2, KNOWN)
    features = feature_set("figures", WINDOW, made)
    for few, message in ((made[:2], "two materials"), (made[:3], "1 slide with windows of smooth wood")):
        with pytest.raises(InputError, match=message):
            train(few, features)
    nameless = [*made, cut([slide("rasp", 1)], features, WINDOW).slides[0].__class__("x", made[0].t, made[0].force)]
    with pytest.raises(InputError, match="slide x: no material"):
        train(nameless, features)
