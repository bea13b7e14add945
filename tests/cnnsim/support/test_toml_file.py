"""Numbers and files that are valid TOML but not usable."""

import pytest

from cnnsim.support import InputError
from cnnsim.support.toml_file import numbers, parse_toml, take

LONG = 10**400
"""TOML's whole numbers have no end; a float has."""


@pytest.mark.parametrize("value", [LONG, -LONG, float("inf"), float("nan"), True, "1"], ids=lambda v: repr(v)[:9])
def test_a_number_that_no_float_holds_is_refused(value: object) -> None:
    with pytest.raises(InputError, match=r"here: depth = .* number wanted"):
        take({"depth": value}, "depth", float, "here")
    with pytest.raises(InputError, match=r"here: path = .*, a list of 2 finite numbers wanted"):
        numbers([0.0, value], 2, "here: path")


def test_whole_numbers_stand_for_floats() -> None:
    assert take({"depth": 10**300}, "depth", float, "here") == 1e300
    assert numbers([1, 2.5], 2, "here") == [1.0, 2.5]


@pytest.mark.parametrize("text", ["a = " + "[" * 5000, "a = " + "9" * 5000], ids=["brackets", "digits"])
def test_files_that_the_reader_cannot_hold_are_no_toml(text: str) -> None:
    with pytest.raises(InputError, match="here: not TOML"):
        parse_toml(text, "here")
