"""The long runs that the test suite only samples. Each prints its figures and fails if something was lost unseen.

python -m tests.fuzz.endurance rate --hz 1000 --seconds 60     through a pseudo-terminal into a recording
python -m tests.fuzz.endurance unplug --times 50
python -m tests.fuzz.endurance kill --times 20 --hz 1000
python -m tests.fuzz.endurance random --count 1000000          random and mutated bytes, every decoder
"""

import json
import os
import random
import signal
import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click
import numpy as np

from tactile.recording.reader import open_recording
from tactile.wire.registry import NAMES
from tests.fuzz.random_bytes import random_bytes
from tests.fuzz.two_ends import busy, emulator, metronome, peak_mib, processor_seconds, reader


@contextmanager
def listening() -> Iterator[tuple[int, list[int]]]:
    """Yield the port of a listener for datagrams, and the list of their lengths, which a thread fills."""
    lengths: list[int] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**24)
        one.bind(("127.0.0.1", 0))
        one.settimeout(0.2)
        over = threading.Event()

        def listen() -> None:
            while not over.is_set():
                with suppress(TimeoutError):
                    lengths.append(len(one.recv(65536)))

        thread = threading.Thread(target=listen)
        thread.start()
        try:
            yield one.getsockname()[1], lengths
        finally:
            over.set()
            thread.join()


@click.group()
def main() -> None:
    """Long runs."""


@main.command()
@click.option("--protocol", type=click.Choice(list(NAMES)), default="native")
@click.option("--hz", type=float, default=1000.0)
@click.option("--seconds", type=float, default=60.0)
@click.option("--others", type=int, default=0, help="Number of other busy processes.")
@click.option("--record-only", is_flag=True, help="Without the pipeline.")
@click.option("--publish", is_flag=True, help="Each frame also as a datagram, to a listener of this process.")
@click.option("--fingers", type=click.IntRange(1), default=1, help="Arrays of 8 x 8, where the protocol has no own.")
@click.option(
    "--p99-ms", type=float, help="Fail if the 99th percentile of the latency is above this, or a frame is lost."
)
def rate(
    protocol: str, hz: float, seconds: float, others: int, record_only: bool, publish: bool, fingers: int,
    p99_ms: float | None,
) -> None:  # fmt: skip
    """Frames at this rate with the pipeline running: nothing lost, or every loss counted."""
    with (
        tempfile.TemporaryDirectory() as name,
        emulator(Path(name), hz, min(seconds, 4.0), "--loop", protocol=protocol, fingers=fingers) as device,
        busy(others),
        metronome() as paused,
        listening() as (port, received),
    ):
        folder = Path(name)
        options = [] if record_only else ["--tare", "off"]
        options += ["--publish", f"udp://127.0.0.1:{port}"] if publish else []
        process = reader(
            folder, "r", "--seconds", str(seconds + 2.0), *options, command="record" if record_only else "live"
        )
        assert process.stdout is not None
        memory: list[float] = []
        spent: list[tuple[float, int, float]] = []
        end: dict[str, Any] = {}
        for text in process.stdout:
            line: dict[str, Any] = json.loads(text)
            if line["type"] == "status":
                memory.append(peak_mib(process))
                spent.append((processor_seconds(process), line["counts"]["good"], time.monotonic()))
            elif line["type"] == "end":
                end = line
        said = device()
        recorded = open_recording(folder / "r.mcap")
        seen = end["counts"]
        stored = sum(count for topic, count in recorded.messages.items() if topic.startswith("/frames/"))
        print(f"{protocol}, {others} other busy processes, load {os.getloadavg()[0]:.1f}\ndevice: {said}")
        print(f"longest pause of the machine itself {1e3 * paused():.2f} ms")
        print(f"counts: {seen}, recorded frames: {stored}, clock {end['clock']}")
        if spent:
            used, frames, took = (last - first for first, last in zip(spent[0], spent[-1], strict=True))
            print(f"{frames / took:.0f} frames/s, {1e3 * used / frames:.2f} ms of processor a frame, all threads of the"
                  f" reader: {100 * used / took:.0f} % of one")  # fmt: skip
            latency = {key: f"{1e3 * value:.2f} ms" for key, value in end["latency"].items()}
            print(f"{latency}; peak memory {memory[0]:.0f} MiB after 1 s, {memory[-1]:.0f} MiB at the end")
        if publish:
            time.sleep(0.5)
            print(f"published {end['published']}, received {len(received)} datagrams")
            assert end["published"] == {"sent": stored, "unsent": 0}
            assert len(received) == stored
        boards = len(recorded.description.boards)
        assert stored == seen["good"] * (1 if protocol == "native" else boards)
        assert recorded.complete
        if p99_ms is not None:
            assert [seen[name] for name in ("missing", "bad_checksum", "overflowed")] == [0, 0, 0], "frames were lost"
            assert end["latency"]["latency_p99_s"] * 1e3 < p99_ms


@main.command()
@click.option("--times", type=int, default=50)
def unplug(times: int) -> None:
    """Take the port away again and again; the reader always comes back and the frames between are counted."""
    with (
        tempfile.TemporaryDirectory() as name,
        emulator(Path(name), 200, 4.0, "--loop", "--unplug", "0.6", "--unplug-for", "0.2") as device,
    ):
        folder = Path(name)
        process = reader(folder, "u", "--tare", "off")
        time.sleep(0.8 * times + 6)
        process.send_signal(signal.SIGINT)
        out, errors = process.communicate(timeout=60)
        said = device()
        end = json.loads(out.splitlines()[-1])
        print(f"device: {said}\nunplugged {end['unplugged']} times: {end['counts']} {errors}")
        sent = int(said.split()[1])
        recorded = open_recording(folder / "u.mcap")
        plugged = sum(note["note"] == "plugged" for note in recorded.notes("/port"))
        print(f"plugged {plugged} times by the recording, complete: {recorded.complete}; device sent {sent}")
        assert end["unplugged"] >= times
        assert end["counts"]["bad_checksum"] <= end["unplugged"]  # a frame that the port was opened in the middle of


@main.command()
@click.option("--times", type=int, default=20)
@click.option("--hz", type=float, default=1000.0)
@click.option("--seed", type=int, default=0)
def kill(times: int, hz: float, seed: int) -> None:
    """Kill the recorder at random moments: every frame older than 0.5 s must be there."""
    rng, worst, least = random.Random(seed), 0.0, 10**9
    with tempfile.TemporaryDirectory() as name, emulator(Path(name), hz, 4.0, "--loop"):
        folder = Path(name)
        for n in range(times):
            process = reader(folder, f"k{n}", command="record")
            path = folder / f"k{n}.mcap"
            while not path.exists() or (path.stat().st_size < 20_000 and process.poll() is None):
                time.sleep(0.01)
            time.sleep(rng.uniform(0.3, 2.0))
            process.kill()
            killed = time.time_ns()
            process.communicate()
            recorded = open_recording(path)
            last = recorded.start + [chunk.t for chunk in recorded.chunks() if chunk.data][-1]
            frames, stored = list(recorded.source()), list(recorded.stored_frames())
            steps = np.diff([frame.sequence for frame in frames])
            missing = (killed - last) * 1e-9
            worst, least = max(worst, missing), min(least, len(frames))
            assert not recorded.complete
            assert (steps == 1).all(), (n, steps[steps != 1])
            assert [frame.sequence for frame in stored] == [frame.sequence for frame in frames[: len(stored)]]
            assert frames[-1].t - stored[-1].t < 0.5
            assert missing < 0.5, f"the last {missing:.3f} s are gone"
    print(f"{times} kills at {hz:g}/s: of {least} frames or more none missing, at most the last {worst:.3f} s gone")


main.add_command(random_bytes)

if __name__ == "__main__":
    main()
