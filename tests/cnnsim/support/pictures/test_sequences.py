"""Sequences of pictures: the order of a folder's files."""

from pathlib import Path

import numpy as np

from cnnsim import read_pictures, write_picture


def test_files_of_a_folder_follow_their_numbers_whatever_else_is_in_their_names(tmp_path: Path) -> None:
    """A superscript two is a digit to Python, and no number."""
    names = ["1\N{SUPERSCRIPT TWO}3.png", "2.png", "10.png", "a\N{ARABIC-INDIC DIGIT THREE}.png"]
    for number, name in enumerate(names):
        write_picture(np.full((2, 2), number / 2 - 1), tmp_path / name)
    found = read_pictures(tmp_path)
    np.testing.assert_allclose(found[:, 0, 0], [-1, -0.5, 0, 0.5], atol=1 / 255)
