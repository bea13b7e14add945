"""Template files as they are written: reading one gives the entry it was written from."""

from dataclasses import fields
from pathlib import Path

import numpy as np

from cnnsim import library
from cnnsim.formats.differences import number_differences
from cnnsim.library.write import template_text


def test_what_is_written_reads_as_the_same_entry(tmp_path: Path) -> None:
    for name in library.names():
        entry = library.load(name)
        path = tmp_path / f"{name}.toml"
        path.write_text(template_text(entry), encoding="utf-8")
        again = library.load_file(path)
        assert list(number_differences(again.network, entry.network)) == [], name
        for part in fields(entry):
            if part.name not in ("network", "examples", "file"):
                assert getattr(again, part.name) == getattr(entry, part.name), (name, part.name)
        for ours, theirs in zip(again.examples, entry.examples, strict=True):
            for part in fields(ours):
                np.testing.assert_array_equal(getattr(ours, part.name), getattr(theirs, part.name), err_msg=name)
