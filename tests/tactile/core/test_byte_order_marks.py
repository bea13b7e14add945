"""Text files with a byte-order mark or in another encoding."""

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cnnsim import InputError, library
from tactile import open_source
from tactile.calibration.weights_file import read_weights
from tactile.cli.group import main
from tactile.core.label_lines import read_lines
from tactile.sources.convert import convert
from tactile.wire.description_file import read_description
from tests.kits.example_files import RECORDING, SCENE
from tests.kits.paths import ROOT


def _template(path: Path) -> Any:
    return repr(library.load(str(path)))


def _frames(path: Path) -> Any:
    return [(frame.t, frame.finger, frame.values.tolist()) for frame in islice(open_source(path), 5)]


def _weights(path: Path) -> Any:
    times, loads = read_weights(path)
    return times.tolist(), repr(loads)


READERS: dict[str, Callable[[Path], Any]] = {"edge.toml": _template, "grip.toml": _frames, "grasp.csv": _frames,
                                             "hand.toml": read_description, "weights.csv": _weights,
                                             "labels.csv": read_lines}  # fmt: skip


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plain")
    (folder / "edge.toml").write_bytes((ROOT / "templates" / "edge.toml").read_bytes())
    (folder / "grip.toml").write_bytes(SCENE.read_bytes())
    convert(RECORDING, folder / "grasp.csv")
    assert CliRunner().invoke(main, ["new", "array", "hand", "-o", str(folder)]).exit_code == 0
    (folder / "weights.csv").write_text("from_s,to_s,grams\n1,2,10\n3,4,20\n")
    (folder / "labels.csv").write_text("file,finger\na.mcap,left\n")
    return folder


@pytest.mark.parametrize("name", READERS)
def test_a_byte_order_mark_is_ignored(plain: Path, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"\xef\xbb\xbf" + (plain / name).read_bytes())
    read = READERS[name]
    assert str(read(tmp_path / name)).replace(str(tmp_path), "") == str(read(plain / name)).replace(str(plain), "")


@pytest.mark.parametrize("name", READERS)
def test_text_that_is_not_utf_8_is_refused(plain: Path, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes((plain / name).read_text(encoding="utf-8").encode("utf-16"))
    with pytest.raises(InputError, match=rf"{name}: cannot be read as an? .*: no UTF-8 text \(line 1\)$"):
        READERS[name](tmp_path / name)
