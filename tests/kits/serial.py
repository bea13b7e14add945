"""Devices emulated in a thread on a pseudo-terminal, with scenes and packets for them."""

import json
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner, Result

from tactile.cli.group import main
from tactile.serial.emulator import Emulator
from tactile.serial.faults import Faults
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene_file.file import read_scene
from tactile.wire.description import Description
from tactile.wire.packets import TimedPacket, emulated_description, packets
from tests.kits.paths import SCENES

GRIP = SCENES / "grip.toml"


def grip(seconds: float, fingers: int = 2) -> Scene:
    """Return the first seconds of the grip scene, with its loads 0.4 s earlier."""
    scene = read_scene(GRIP)
    early = [replace(load, path=load.path - [0.4, 0, 0, 0, 0, 0]) for load in scene.loads]
    return replace(scene, duration=seconds, arrays=scene.arrays[:fingers], loads=tuple(early[:fingers]))


def later(scene: Scene, seconds: float) -> Scene:
    """Return the scene with its loads shifted in time."""
    shift = np.array([seconds, 0, 0, 0, 0, 0])
    return replace(scene, loads=tuple(replace(load, path=load.path + shift) for load in scene.loads))


def sent(protocol: str, seconds: float = 0.5) -> tuple[Description, list[TimedPacket]]:
    """Return the array description and the timed packets of the grip in a protocol."""
    scene = grip(seconds, 1 if protocol == "paxini-serial" else 2)
    description = emulated_description(protocol, scene)
    return description, list(packets(description, scene))


@contextmanager
def device(stream: Iterable[TimedPacket], faults: Faults | None = None, **more: Any) -> Iterator[Emulator]:
    """Run an emulated device during the block."""
    emulator, stop = Emulator(faults, **more), threading.Event()
    thread = threading.Thread(target=emulator.run, args=(stream, stop))
    thread.start()
    try:
        yield emulator
    finally:
        stop.set()
        thread.join()


def call(*arguments: Any, text: str = "") -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments], input=text)


def lines(text: str, kind: str) -> list[str]:
    """Return the lines of JSON with this type."""
    return [line for line in text.splitlines() if json.loads(line)["type"] == kind]


def write_array(tmp_path: Path, text: str) -> Path:
    """Return an array file with this text."""
    path = tmp_path / "array.toml"
    path.write_text(text, encoding="utf-8")
    return path
