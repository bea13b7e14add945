"""Coverage-guided fuzzing of one decoder with atheris: no exception, no hang, one result for every cutting.

    python -m tests.fuzz.harness reskin -max_total_time=60 -timeout=5

Every protocol of `tactile.wire.registry.NAMES` has its run. The first two bytes of an input choose where the rest is
cut. Before the run the corpus folder (the last argument, if any) may be empty: a few encoded frames are given at once.
"""

import importlib
import sys
import tempfile
from pathlib import Path
from typing import Any

atheris: Any = importlib.import_module("atheris")  # wanted here only, so no part of the checks

with atheris.instrument_imports(include=["tactile.wire"]):
    from tactile.wire.registry import find_format
    from tests.kits.wire import decoded, pair, stream

    find_format(sys.argv[1])  # imports the module of that format, and so instruments it


def main() -> None:
    """Fuzz the decoder that the first argument names."""
    name = sys.argv.pop(1)

    def once(data: bytes) -> None:
        if len(data) < 2:
            return
        step, body = 1 + int.from_bytes(data[:2], "little") % 997, data[2:]
        whole, cut = pair(name)[0], pair(name)[0]
        a = decoded(whole, body)
        b = decoded(cut, *(body[at : at + step] for at in range(0, len(body), step)))
        if [reading.end for reading in a] != [reading.end for reading in b] or whole.counts != cut.counts:
            raise AssertionError(f"cut every {step} bytes: {whole.counts} became {cut.counts}")
        if any(x.values.tobytes() != y.values.tobytes() for x, y in zip(a, b, strict=True)):
            raise AssertionError(f"cut every {step} bytes: other values")

    with tempfile.TemporaryDirectory() as folder:
        packets, _ = stream(name, {}, 8)
        Path(folder, "frames").write_bytes(b"\x07\x00" + b"".join(packets))
        atheris.Setup([*sys.argv, folder], once)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
