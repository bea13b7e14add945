"""What does not fit into memory is refused before it runs; what is free is measured."""

import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from cnnsim import (
    InputError,
    explain,
    library,
    read_picture,
    run,
    run_program,
)
from cnnsim.cli.group import main
from cnnsim.support import memory


def test_explain_allocates_no_plane() -> None:
    explain("edge", (10, 10))
    tracemalloc.start()
    for name in ("edge", "hole-filler", "autowave", "median", "moving-parts", "path-tracing"):
        found = explain(library.load(name), (100_000, 100_000))
        assert found.cells >= 10**10
        assert "GB" in found.memory or "TB" in found.memory
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def test_explain_on_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(memory.VARIABLE, "8G")
    done = CliRunner().invoke(main, ["explain", "edge", "--size", "100000x100000"])
    assert done.exit_code == 0, done.output
    assert "12 bytes a cell in float32 on cpu, pictures and result included: 120 GB, more than the 8 GB" in " ".join(
        done.output.split()
    )
    facts = json.loads(CliRunner().invoke(main, ["explain", "hole-filler", "--size", "9x9", "--json"]).output)
    assert (facts["bytes_a_cell"], facts["cells"]) == (20, 81)


def test_a_run_that_does_not_fit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cnnsim.task.LARGE", 100)
    picture = np.ones((100, 100), np.float32)
    monkeypatch.setenv(memory.VARIABLE, "170k")
    assert run("hole-filler", picture, duration=1.0).x.shape == (100, 100)  # 16 bytes a cell, and the picture is there
    monkeypatch.setenv(memory.VARIABLE, "150k")
    with pytest.raises(InputError, match=r"'hole-filler' on 100 x 100 cells needs 160 kB of memory, 150 kB are"):
        run("hole-filler", picture, duration=1.0)
    with pytest.raises(InputError, match="needs 200 kB"):
        run("hole-filler", picture.astype("float64"), duration=1.0)  # and its copy in float32


def test_a_program_that_does_not_fit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """OPENING has bits alone: three planes of numbers of a transient and an eighth of a byte for each of its own."""
    monkeypatch.setattr("cnnsim.program.machine.LARGE", 100)
    monkeypatch.setenv(memory.VARIABLE, "100k")
    with pytest.raises(InputError, match=r"program 'opening' on 100 x 100 cells needs 12\d kB of memory, 100 kB are"):
        run_program("opening", picture=np.ones((100, 100), np.float32))


def test_a_picture_that_does_not_fit_is_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.new("L", (3000, 2000)).save("large.png")
    monkeypatch.setenv(memory.VARIABLE, "30M")
    monkeypatch.setattr(Image.Image, "load", lambda _: pytest.fail("it was read"))
    with pytest.raises(InputError, match=r"large.png: reading 2000 x 3000 pixels needs 66 MB of memory, 30 MB"):
        read_picture("large.png")
    done = CliRunner().invoke(main, ["run", "edge", "large.png"])
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    monkeypatch.setenv(memory.VARIABLE, "much")
    done = CliRunner().invoke(main, ["run", "edge", "large.png"])
    assert "CNNSIM_MEMORY=much; bytes wanted, such as 8G" in done.stderr


def test_pictures_beyond_pillow_s_limits_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its limit is set low here; above twice of it Pillow raises, above it warns, and warnings are errors here."""
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 100)
    for size in ((15, 10), (30, 20)):
        image = Image.new("L", size)
        image.save(tmp_path / "x.png")
        image.save(tmp_path / "x.gif", save_all=True, append_images=[Image.new("L", size, 255)])
        assert read_picture(tmp_path / "x.png").shape == size[::-1]
        from cnnsim import read_pictures

        assert read_pictures(tmp_path / "x.gif").shape == (2, *size[::-1])
    assert Image.MAX_IMAGE_PIXELS == 100


def test_free_memory_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(memory.VARIABLE, raising=False)
    assert 1e6 < memory.free_memory() < 1e15
    for text, size in (("500", 500), ("2k", 2e3), ("1.5G", 1.5e9)):
        monkeypatch.setenv(memory.VARIABLE, text)
        assert memory.free_memory() == size


def test_the_memory_of_a_container_counts(tmp_path: Path) -> None:
    for name, text in (("memory.max", "1000"), ("memory.current", "700"), ("memory.stat", "anon 1\ninactive_file 50")):
        (tmp_path / name).write_text(text)
    assert memory._group(tmp_path) == 350
    (tmp_path / "memory.max").write_text("max")
    assert memory._group(tmp_path) == float("inf")
