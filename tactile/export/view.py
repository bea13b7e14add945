"""Live views in Foxglove and Rerun on this machine."""

from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.extras import need
from tactile.core.frame import NORMAL, TaxelArray
from tactile.export.drawable import PERIOD, Message
from tactile.pipeline import FrameReport

HOST, PORT = "127.0.0.1", 8765
"""Address of the WebSocket server, the one that Foxglove and Lichtblick propose."""


class FoxgloveView:
    """A WebSocket server for Foxglove and Lichtblick that sends messages to whoever is connected.

    Raises:
        InputError: foxglove-sdk is not installed, or the port is in use.
    """

    def __init__(self, port: int = PORT) -> None:
        self._library = need("foxglove", "--view foxglove", "foxglove")
        self._channels: dict[str, Any] = {}
        try:
            self._server = self._library.start_server(name="tactile", host=HOST, port=port)
        except (OSError, RuntimeError) as error:
            raise InputError(f"--view foxglove: no server at {HOST}:{port}: {error}") from error
        self.hint = f"in Foxglove or Lichtblick: open connection ws://{HOST}:{self._server.port}"

    def send(self, message: Message) -> None:
        """Send a message; its channel is made with the first message of a topic."""
        if message.topic not in self._channels:
            encoding, text = message.definition
            schema = self._library.Schema(name=message.schema, encoding=encoding, data=text)
            self._channels[message.topic] = self._library.Channel(
                message.topic, schema=schema, message_encoding=message.encoding
            )
        self._channels[message.topic].log(message.data, log_time=message.ns)

    def close(self) -> None:
        """Stop the server."""
        self._server.stop()


class RerunView:
    """A sink that logs taxels, shear, normal, load and events to a Rerun viewer, which it starts.

    ``start_ns``: Unix time [ns] at which t is 0.

    Raises:
        InputError: rerun-sdk is not installed.
    """

    def __init__(self, arrays: tuple[TaxelArray, ...]) -> None:
        self._rerun = need("rerun", "--view rerun", "rerun")
        self.start_ns, self._last = 0, dict.fromkeys((array.name for array in arrays), -np.inf)
        self._places = {array.name: np.concatenate(
            (array.positions().reshape(-1, 2), np.zeros((array.rows * array.cols, 1))), 1) for array in arrays
        }  # fmt: skip
        self._largest = dict.fromkeys(self._last, 0.0)
        self._rerun.init("tactile")
        self._start()
        self.hint = "the Rerun viewer starts on this machine"

    def _start(self) -> None:
        self._rerun.spawn()

    def __call__(self, report: FrameReport) -> None:
        """Log one report: pictures 30 times a second, load and events of every frame."""
        rerun, name, frame, load = self._rerun, report.array.name, report.frame, report.load
        rerun.set_time("time", timestamp=self.start_ns * 1e-9 + frame.t)
        if load.F == load.F:
            rerun.log(f"{name}/load", rerun.Scalars([load.Q, load.R, load.F]))
        for event in report.events:
            rerun.log("events", rerun.TextLog(f"{event.finger}: {event.words}", level="INFO"))
        if frame.t - self._last[name] >= PERIOD * (1 - 1e-9) and frame.valid.any():
            self._last[name] = frame.t
            values = np.where(frame.valid[..., None], frame.values, 0.0)
            shear = values[..., :NORMAL].reshape(-1, 2)
            self._largest[name] = largest = max(self._largest[name], float(np.hypot(*shear.T).max()), 1e-12)
            arrows = np.concatenate((shear * report.array.pitch / largest, np.zeros((len(shear), 1))), 1)
            rerun.log(f"{name}/taxels", rerun.Points3D(self._places[name], radii=report.array.pitch / 10))
            rerun.log(f"{name}/shear", rerun.Arrows3D(vectors=arrows, origins=self._places[name]))
            rerun.log(f"{name}/normal", rerun.Tensor(values[..., NORMAL], dim_names=("row", "col")))

    def close(self) -> None:
        """Send what is left to the viewer."""
        self._rerun.disconnect()
