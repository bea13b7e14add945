"""Users' own libraries."""

from pathlib import Path

import pytest

from cnnsim import InputError, library

MINIMAL = 'name = "{0}"\nsummary = "{1}"\nreference = "r"\nA = {2}\nz = 0\ninput = "none"\ninitial_state = "picture"\n'


def own(folder: Path, name: str, summary: str, a: float = 2) -> None:
    folder.mkdir(exist_ok=True)
    text = MINIMAL.format(name, summary, a) + 'boundary = "zero-flux"\nduration = "settled"\n'
    (folder / f"{name}.toml").write_text(text)


def test_later_folders_come_first(tmp_path: Path) -> None:
    first, second = tmp_path / "1", tmp_path / "2"
    own(first, "edge", "first")
    own(first, "mine", "first")
    own(second, "edge", "second")
    shipped = library.names()
    with library.using(first, second):
        assert library.load("edge").summary == "second"
        assert library.load("edge").file == second / "edge.toml"
        assert library.load("mine").summary == "first"
        assert library.load("corner").shipped
        assert library.names() == sorted([*shipped, "mine"])
        own(second, "edge", "changed later", 3)
        assert library.load("edge").template.z == 0
    assert library.names() == shipped
    assert library.load("edge").shipped


def test_add_is_for_good_and_a_second_time_moves_to_the_front(tmp_path: Path) -> None:
    own(tmp_path / "1", "x", "first")
    own(tmp_path / "2", "x", "second")
    with library.using():  # puts things back
        library.add(tmp_path / "1", tmp_path / "2")
        assert library.load("x").summary == "second"
        library.add(tmp_path / "1")
        assert library.load("x").summary == "first"
    with pytest.raises(InputError, match="no template 'x'"):
        library.load("x")


def test_a_library_that_is_no_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a folder of template files wanted"), library.using(tmp_path / "none"):
        pass


def test_shipped_templates_have_worked_examples_and_own_ones_may_do_without(tmp_path: Path) -> None:
    assert all(library.load(name).examples for name in library.names())
    own(tmp_path, "bare", "no example")
    assert library.load_file(tmp_path / "bare.toml").examples == ()


@pytest.mark.parametrize(("text", "message"), [
    ("[[example]]\ninput = 5\noutput = ['#']", "a picture is 5; a list of rows wanted"),
    ("[[example]]\ninput = [5]\noutput = ['#']", "row 1 of a picture is 5; a text or a list of numbers"),
    ("[[example]]\ninput = [[0.5, {}]]\noutput = ['#']", "row 1 of a picture is .* a list of numbers wanted"),
    ("[[example]]\ninput = [[]]\noutput = ['#']", "a picture without cells"),
    ("[[example]]\ninput = [['#'], 5]\noutput = ['#']", "a list of pictures, each a list of rows"),
    (f"B = 1{'0' * 400}", "B is no rectangular matrix of numbers"),
    (f"tags = {[1] * 1000}", r"tags = \[1, 1.{90,130} \.\.\., a list of texts wanted"),
    ("example = [5]", r"\[5\], \[\[example\]\] tables wanted"),
])  # fmt: skip
def test_entries_of_a_wrong_kind_are_named(text: str, message: str, tmp_path: Path) -> None:
    own(tmp_path, "mine", "not right")
    file = tmp_path / "mine.toml"
    file.write_text(f"{file.read_text()}{text}\n")
    with pytest.raises(InputError, match=rf"mine\.toml: .*{message}"):
        library.load_file(file)


def test_a_picture_of_true_and_false_is_black_and_white(tmp_path: Path) -> None:
    own(tmp_path, "mine", "of booleans")
    file = tmp_path / "mine.toml"
    file.write_text(f"{file.read_text()}[[example]]\ninput = [[true, false]]\noutput = [[true, 0.5]]\n")
    (example,) = library.load_file(file).examples
    assert example.input is not None
    assert example.input.tolist() == [[1, -1]]
    assert example.output.tolist() == [[1, 0.5]]
