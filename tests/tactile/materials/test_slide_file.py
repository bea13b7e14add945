"""Files of slides: which NPZ files are some, however damaged."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile.materials.slide_file import NEEDED, is_slide_file


@pytest.mark.parametrize("at", [6, 28])
def test_a_damaged_directory_is_none_of_slides(tmp_path: Path, at: int) -> None:
    """Byte 6 of an entry: the version it asks for; byte 28 and on: a name that is no UTF-8, which byte 9 promises."""
    path = tmp_path / "s.npz"
    arrays: dict[str, Any] = {name: np.zeros(3) for name in NEEDED}
    np.savez(path, **arrays)
    assert is_slide_file(path)
    data = bytearray(path.read_bytes())
    entry = data.index(b"PK\x01\x02")
    if at == 6:
        data[entry + 6] = 200
    else:
        data[entry + 9] |= 8
        data[entry + 46] = 0x93
    path.write_bytes(data)
    assert not is_slide_file(path)
