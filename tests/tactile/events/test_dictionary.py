"""The dictionary of codes on known motions, the reduction of larger arrays, and `tactile codes`."""

import json
from collections import Counter

import numpy as np
import pytest

from tactile.events.code import Code
from tactile.events.dictionary import entries, finger_word, reduced, word
from tests.kits.serial import call


def bits(field: tuple[np.ndarray, np.ndarray], size: int = 2) -> Code:
    signs = [np.sign(np.broadcast_to(part, (size, size))).astype(np.int8) for part in field]
    return Code(signs[0], signs[1], np.ones((size, size), bool))


@pytest.mark.parametrize("size", [2, 3, 4, 8])
def test_known_motions_on_arrays_of_every_size(size: int) -> None:
    y, x = np.mgrid[0:size, 0:size] - (size - 1) / 2
    one = np.ones((size, size))
    for field, motion in (
        ((-y, x), "twist clockwise"), ((y, -x), "twist anticlockwise"), ((x, y), "spread"), ((-x, -y), "pinch"),
        ((one, one), "pull +x +y"), ((-one, -one), "pull -x -y"), ((one, -one), "pull +x -y"),
    ):  # fmt: skip
        if size != 3 or motion.startswith("pull"):  # the middle line of three has sign 0
            assert finger_word(reduced(bits(field, size))) == motion


def test_two_by_two_keeps_its_code_and_larger_arrays_vote() -> None:
    for number in range(256):
        signs = np.array([1 if number >> (7 - n) & 1 else -1 for n in range(8)], np.int8).reshape(2, 2, 2)
        code = Code(signs[..., 0], signs[..., 1], np.ones((2, 2), bool))
        assert reduced(code) == code.signs() == number
    wrong = bits((np.ones((8, 8)), np.ones((8, 8))), 8)
    wrong.x[3, 3] = -1
    assert finger_word(reduced(wrong)) == "pull +x +y"


def test_the_dictionary_has_every_code_and_opposite_words_for_opposite_signs() -> None:
    assert sorted(dict(entries())) == list(range(1 << 16))
    swapped, looked_at = str.maketrans("+-", "-+"), Counter[str]()
    for number in range(256):
        mirrored = finger_word(number ^ 0xFF)  # every sign inverted
        here = finger_word(number)
        looked_at[here.split()[0]] += 1
        if here.startswith("pull"):
            assert mirrored == here.translate(swapped)
        pairs = {"spread": "pinch", "twist clockwise": "twist anticlockwise", "about a point": "about a point"}
        if here in pairs:
            assert mirrored == pairs[here]
    assert looked_at["pull"] >= 4
    assert looked_at["spread"] == looked_at["pinch"] >= 1
    assert looked_at["twist"] >= 2
    assert looked_at["about"] >= 1
    assert word(0xFF << 8 | 0xFF) == "both pull +x +y"


def test_the_command_prints_the_dictionary() -> None:
    result = call("codes", "65535", "--json")
    assert json.loads(result.stdout) == {"1" * 16: "both pull +x +y"}
    assert call("codes").stdout.count("\n") == 1 << 16
    assert "from 0 to 65535 wanted" in call("codes", "65536").output


@pytest.mark.parametrize(("typed", "bits", "note"), [
    ("0xd8d8", "1101100011011000", ""), ("d8d8", "1101100011011000", ""), ("0101", "0000000100000001", ""),
    ("1101", "0000010001001101", "0x1101 is the code that events print so"), ("0", "0" * 16, ""),
])  # fmt: skip
def test_a_code_is_read_as_events_print_it(typed: str, bits: str, note: str) -> None:
    result = call("codes", typed, "--json")
    assert list(json.loads(result.stdout)) == [bits]
    assert note in result.stderr
    assert bool(note) == bool(result.stderr)


@pytest.mark.parametrize("typed", ["0x12345", "g", "012345", "0x"])
def test_other_text_is_refused(typed: str) -> None:
    assert call("codes", typed).exit_code == 2
