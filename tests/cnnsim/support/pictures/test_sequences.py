"""Sequences of pictures: the order of a folder's files, the formats that are opened, the bound of all pages."""

from pathlib import Path

import numpy as np
import pytest
from PIL import EpsImagePlugin, Image

from cnnsim import InputError, read_picture, read_pictures, write_picture
from cnnsim.support.pictures import sequence


def test_files_of_a_folder_follow_their_numbers_whatever_else_is_in_their_names(tmp_path: Path) -> None:
    """A superscript two is a digit to Python, and no number."""
    names = ["1\N{SUPERSCRIPT TWO}3.png", "2.png", "10.png", "a\N{ARABIC-INDIC DIGIT THREE}.png"]
    for number, name in enumerate(names):
        write_picture(np.full((2, 2), number / 2 - 1), tmp_path / name)
    found = read_pictures(tmp_path)
    np.testing.assert_allclose(found[:, 0, 0], [-1, -0.5, 0, 0.5], atol=1 / 255)


def test_eps_is_not_opened_under_any_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EpsImagePlugin, "Ghostscript", lambda *_: pytest.fail("Ghostscript was started"))
    for name in ("a.eps", "a.png"):
        (tmp_path / name).write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n%%EndComments\nshowpage\n")
        with pytest.raises(InputError, match="is no picture that Pillow can read: cannot identify"):
            read_picture(tmp_path / name)
    (tmp_path / "a.png").unlink()
    with pytest.raises(InputError, match="holds no picture"):
        read_pictures(tmp_path)


def test_the_pages_of_a_small_file_are_bounded_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page, path = Image.new("L", (200, 200), 255), tmp_path / "a.tif"
    page.save(path, save_all=True, append_images=[page] * 9, compression="tiff_deflate")
    assert len(read_pictures(path)) == 10
    monkeypatch.setattr(sequence, "PAGES", 300_000)
    monkeypatch.setattr("cnnsim.support.limits.PACKING", 2)
    with pytest.raises(InputError, match=r"bytes that unpack to 400000; 2 times as many at most wanted"):
        read_pictures(path)


def test_one_picture_is_read_from_an_array_file_as_well(tmp_path: Path) -> None:
    values = np.random.default_rng(0).uniform(-1, 1, (4, 5))
    np.save(tmp_path / "one.npy", values)
    np.savez(tmp_path / "one.npz", values)
    for name in ("one.npy", "one.npz"):
        assert np.array_equal(read_picture(tmp_path / name), values)
    np.save(tmp_path / "two.npy", np.stack([values, values]))
    with pytest.raises(InputError, match="holds 2 pictures; one wanted"):
        read_picture(tmp_path / "two.npy")
