"""The head of a short program, programs from text, random pictures."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.program.file import load_program

HEAD = 'name = "p"\nlam = ["a", "b"]\nllm = ["p", "q", "r"]\nwire = ["n"]\ninputs = ["p", "q"]\noutputs = ["r"]\n'


def load(tmp_path: Path, text: str, **changes: Any) -> Any:
    file = tmp_path / "p.toml"
    file.write_text(text, encoding="utf-8")
    return load_program(file, **changes)


def picture(seed: int = 0, shape: tuple[int, int] = (12, 15)) -> np.ndarray:
    return np.random.default_rng(seed).random(shape) < 0.5
