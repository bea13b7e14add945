"""Good files cut short, with bytes changed, and with others in between."""

import random

from tests.fuzz.broken_texts import Broken


def bytes_changed(name: str, data: bytes, count: int, seed: int = 0) -> Broken:
    """A file cut short, with bytes changed, and followed by others."""
    rng = random.Random(seed)
    for _ in range(count):
        at = rng.randrange(len(data))
        yield name, data[:at]
        changed = bytearray(data)
        for _ in range(rng.choice((1, 1, 4, 64))):
            changed[rng.randrange(len(changed))] = rng.randrange(256)
        yield name, bytes(changed)
        yield name, data[:at] + rng.randbytes(64) + data[at:]
    yield name, b""
    yield name, rng.randbytes(3000)
