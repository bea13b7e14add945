"""Numbers and files that are valid TOML but not usable."""

import pytest

from cnnsim.support import InputError
from cnnsim.support.toml_file import numbers, parse_toml, take
from cnnsim.support.toml_lines import is_too_deep

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


def test_a_number_that_the_reader_cannot_hold_is_no_toml() -> None:
    with pytest.raises(InputError, match="here: not TOML"):
        parse_toml("a = " + "9" * 5000, "here")


@pytest.mark.parametrize("text", [
    "[" + "a." * 10**5 + "a]", "a." * 32 + "a = 1", "'a' . " * 32 + "a = 1", "a = " + "[" * 33 + "]" * 33,
    "a = " + "{a=" * 33 + "1" + "}" * 33, "a = '''['''\nb = " + "[" * 33, "a = " + "[" * 10**5,
])  # fmt: skip
def test_keys_and_brackets_nested_deeper_than_32_are_refused_before_they_are_read(text: str) -> None:
    with pytest.raises(InputError, match=r"^here: keys or brackets nested deeper than 32"):
        parse_toml(text, "here")


@pytest.mark.parametrize("text", [
    "a." * 31 + "a = 1", "a = " + "[" * 32 + "]" * 32, "a = '" + "a." * 40 + "'", "# " + "[" * 40,
    'a = """' + "a." * 40 + '\n["' + "[" * 40 + '"""', "a = '''" + "{" * 40 + "'''",
])  # fmt: skip
def test_what_only_looks_deep_is_read(text: str) -> None:
    parse_toml(text, "here")


@pytest.mark.parametrize("unit", ['"', "'", '"\\', '"""', "'''\\", "a.a ", "[]", "a"])
def test_the_depth_of_a_text_is_found_in_linear_time(unit: str) -> None:
    assert not is_too_deep(unit * 20_000)
