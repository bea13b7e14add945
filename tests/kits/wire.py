"""Boards, signals and packet streams of every wire format."""

from typing import Any

import numpy as np

from tactile.wire.base import Decoder, Encoder, Options
from tactile.wire.reading import Reading
from tactile.wire.registry import NAMES, find_format

SHAPES: dict[str, tuple[tuple[int, int], ...]] = {
    "reskin": ((1, 5),), "papillarray": ((3, 3), (3, 3)), "paxini-fast": ((3, 3),), "paxini-serial": ((3, 3),),
    "lowiek": ((2, 2),), "native": ((2, 3), (1, 2)), "csv": ((2, 2),),
}  # fmt: skip
VARIANTS: list[tuple[str, dict[str, Any]]] = [
    *((name, {}) for name in NAMES),
    ("papillarray", {"pillar": "displacement first", "slip_entry": 1}),
    ("paxini-fast", {"resultant": False}),
    ("lowiek", {"mode": "force"}),
    ("native", {"value": "int16"}),
    ("csv", {"before": [], "check": True}),
]
STEP = {"reskin": 0.25, "lowiek": 0.0, "papillarray": 0.25, "paxini-fast": 0.1, "paxini-serial": 0.1}


def pair(name: str, extra: dict[str, Any] | None = None) -> tuple[Decoder, Encoder]:
    options = Options(SHAPES[name], extra or {})
    return find_format(name).decoder(options), find_format(name).encoder(options)


def signals(name: str, count: int, seed: int = 0) -> list[list[np.ndarray]]:
    """Return smooth readings that the format represents exactly."""
    rng = np.random.default_rng(seed)
    shapes = Options(SHAPES[name]).taxels
    base = [rng.integers(20, 60, (taxels, 3)) for taxels in shapes]
    frames = [[one + rng.integers(-3, 4, one.shape) for one in base] for _ in range(count)]
    if name == "lowiek":
        return [[one * np.array([0.150, 0.150, 0.242]) for one in boards] for boards in frames]
    return [[one * STEP.get(name, 1.0) for one in boards] for boards in frames]


def stream(name: str, extra: dict[str, Any], count: int, seed: int = 0) -> tuple[list[bytes], list[np.ndarray]]:
    encoder = pair(name, extra)[1]
    boards = signals(name, count, seed)
    packets = [encoder.encode(one, 1000 + n, 0.001 * n) for n, one in enumerate(boards)]
    packets[0] = encoder.preamble() + packets[0]
    whole = [np.concatenate(one) for one in boards]
    if name == "native":  # one frame per board
        return packets, [one for pair_ in boards for one in pair_]
    return packets, whole


def decoded(decoder: Decoder, *chunks: bytes) -> list[Reading]:
    return [reading for chunk in chunks for reading in decoder.feed(chunk)] + decoder.finish()
