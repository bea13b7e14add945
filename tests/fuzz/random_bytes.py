"""Random bytes, and streams with faults, into every decoder: time, false frames and wrong ones."""

import time

import click
import numpy as np

from tactile.wire.registry import NAMES
from tests.kits.wire import pair, stream

WRONG = {"reskin": 0.15, "lowiek": 0.15, "csv": 0.15, "papillarray": 1e-3, "paxini-fast": 0.01, "paxini-serial": 0.01}
"""Parts of the frames that may be wrong where one byte in 500 is: none with a CRC, few with a sum of 16 or 8 bits."""


@click.command("random")
@click.option("--count", type=int, default=1_000_000)
@click.option("--seed", type=int, default=1)
@click.argument("names", nargs=-1)
def random_bytes(count: int, seed: int, names: tuple[str, ...]) -> None:
    """Random bytes, then streams in which one byte in 500 is changed, lost or added: time and false frames."""
    for name in names or NAMES:
        rng = np.random.default_rng(seed)
        decoder, begun = pair(name)[0], time.perf_counter()
        false = sum(len(decoder.feed(rng.bytes(4096))) for _ in range(count // 4096 + 1)) + len(decoder.finish())
        seconds = time.perf_counter() - begun
        packets, _ = stream(name, {}, 4000, seed)
        clean = b"".join(packets)
        truth = {reading.values.tobytes() for reading in pair(name)[0].feed(clean)}
        data = bytearray()
        while len(data) < count:
            data += clean
        whole, mutated = len(data), _mutate(bytes(data[:count]), rng)
        decoder, begun = pair(name)[0], time.perf_counter()
        got = [reading for at in range(0, len(mutated), 4096) for reading in decoder.feed(mutated[at : at + 4096])]
        wrong = sum(reading.values.tobytes() not in truth for reading in got)
        assert wrong <= WRONG.get(name, 0.0) * len(got), f"{name}: {wrong} of {len(got)} frames are wrong"
        print(f"{name}: random {count} bytes: {false} false frames in {seconds:.1f} s; mutated: {len(got)} frames,"
              f" {wrong} wrong in {time.perf_counter() - begun:.1f} s; {decoder.counts} ({whole} clean)")  # fmt: skip
        assert false == 0


def _mutate(data: bytes, rng: np.random.Generator) -> bytes:
    out, places = bytearray(), np.flatnonzero(rng.random(len(data)) < 1 / 500).tolist()
    for a, b in zip([0, *places], [*places, len(data)], strict=True):
        out += data[a:b]
        kind = rng.integers(3)
        if b < len(data) and kind == 0:
            out += rng.bytes(1)
        elif out and kind == 1:
            out[-1] ^= 1 << int(rng.integers(8))
        elif out:
            del out[-1]
    return bytes(out)
