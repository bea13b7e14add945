"""An analogic program of the user's own on every frame's planes, beside the pipeline's."""

from collections.abc import Callable
from typing import Any

import numpy as np

from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.support import InputError
from tactile.events.code import CONTACT, SHEAR, Threshold, encode
from tactile.pipeline import FrameReport

PLANES = ("shear_x", "shear_y", "pressing")
"""What a program may have as inputs: the planes of `tactile.events.code.encode`."""


class UserProgram:
    """A sink that runs a program, one machine for each finger, and says its outputs whenever they change.

    Arguments: ``name`` of a program of the library or a file (.toml); ``say`` gets
    {"type": "program", "t_s", "finger", "program", "outputs"}, planes as lists of rows.

    Raises:
        InputError: no such program, or one that wants other planes than there are.
    """

    def __init__(
        self, name: str, shear: Threshold | None, backend: str, say: Callable[[dict[str, Any]], None]
    ) -> None:  # fmt: skip
        self._program, self._shear, self._backend, self._say = load_program(name), shear, backend, say
        self._machines: dict[str, UniversalMachine] = {}
        self._said: dict[str, dict[str, Any]] = {}
        wrong = [plane for plane in self._program.inputs if plane not in PLANES]
        if wrong:
            raise InputError(f"program {name!r} wants {', '.join(wrong)}; a frame has {', '.join(PLANES)}")

    def __call__(self, report: FrameReport) -> None:
        """Take one report."""
        finger, quantity = report.array.name, report.array.quantity
        if finger not in self._machines:
            self._machines[finger] = UniversalMachine(self._backend)
        planes = encode(report.frame, quantity, self._shear or SHEAR[quantity], CONTACT[quantity])
        inputs = {name: planes[name] for name in self._program.inputs}
        outputs = {name: _plain(out) for name, out in self._machines[finger].run(self._program, **inputs).items()}
        if outputs != self._said.get(finger):
            self._said[finger] = outputs
            line = {"type": "program", "t_s": report.frame.t, "finger": finger, "program": self._program.name}
            self._say(line | {"outputs": outputs})


def _plain(out: Any) -> Any:
    """Return a plane or a number as plain data, logic as 0 and 1, analog numbers to six digits."""
    values = np.asarray(out)
    return values.astype(int).tolist() if values.dtype == bool else np.round(values.astype(float), 6).tolist()
