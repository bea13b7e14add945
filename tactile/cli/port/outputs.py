"""Outputs of a live run besides events: JSON lines and datagrams of frames, messages for viewers."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support.extras import need
from tactile.cli.port import console

if TYPE_CHECKING:
    from tactile.core.frame import TaxelArray
    from tactile.export.drawable import Message
    from tactile.export.view import FoxgloveView, RerunView
    from tactile.output.publish import Publisher
    from tactile.output.stream_frame import FrameSink, StreamFrame
    from tactile.pipeline import FrameReport, Sink
    from tactile.serial.session import Session

VIEWS = ("foxglove", "rerun")


@dataclass(frozen=True)
class OutputChoices:
    """Options of `tactile live`: ``every_frame`` as JSON lines, ``publish`` to a URL, ``msgpack`` datagrams.

    ``drawable`` messages in the recording; ``view`` of `VIEWS`.
    """

    every_frame: bool = False
    publish: str | None = None
    msgpack: bool = False
    drawable: bool = False
    view: str | None = None

    def check(self, recorded: bool) -> None:
        """Refuse options without the option that they belong to."""
        if self.msgpack and self.publish is None:
            raise click.UsageError("--msgpack is the format of --publish URL")
        if self.drawable and not recorded:
            raise click.UsageError("--drawable messages are part of --record FILE")


class LiveOutputs:
    """The outputs, opened before the port, so that wrong options cost no recording.

    Raises:
        InputError: a wrong address, an array too large for a datagram, or a library that is not installed.
    """

    def __init__(self, choices: OutputChoices, arrays: "tuple[TaxelArray, ...]") -> None:
        self._choices, self._arrays = choices, arrays
        self.publisher: Publisher | None = None
        self._foxglove: FoxgloveView | None = None
        self._rerun: RerunView | None = None
        if choices.publish is not None:
            module = need("tactile.output.publish", "--publish")
            self.publisher = module.Publisher(choices.publish, arrays, packed=choices.msgpack)
        self._frames = self._frame_sink() if choices.every_frame or self.publisher is not None else None
        if choices.drawable or choices.view is not None:
            need("tactile.export.drawable", "messages for viewers")
        if choices.view == "foxglove":
            self._foxglove = need("tactile.export.view", "--view").FoxgloveView()
        elif choices.view == "rerun":
            self._rerun = need("tactile.export.view", "--view").RerunView(arrays)

    def _frame_sink(self) -> "FrameSink":
        from tactile.output.stream_frame import FrameOutput, FrameSink, frame_json  # imported when used

        def say(frame: "StreamFrame", data: dict[str, Any]) -> None:
            sys.stdout.write(frame_json(frame, data).decode() + "\n")
            sys.stdout.flush()

        outputs: list[FrameOutput] = [say] if self._choices.every_frame else []
        return FrameSink(self._arrays, [*outputs, *filter(None, [self.publisher])])

    @contextmanager
    def open(self, session: "Session") -> "Iterator[list[Sink]]":
        """Yield the sinks of a session; close the views at the end."""
        start = session.reader.epoch.unix
        sinks: list[Sink] = []
        if self._frames is not None:
            self._frames.convert.start_ns = start
            sinks.append(self._frames)
        receivers: list[Callable[[Message], None]] = []
        if self._choices.drawable and session.recording is not None:
            receivers.append(session.recording.other)
        if self._foxglove is not None:
            receivers.append(self._foxglove.send)
        if receivers:
            sinks.append(_drawing(self._arrays, start, receivers))
        if self._rerun is not None:
            self._rerun.start_ns = start
            sinks.append(self._rerun)
        view = self._foxglove or self._rerun
        if view is not None:
            console.warn(view.hint, "note")
        try:
            yield sinks
        finally:
            if view is not None:
                view.close()


def _drawing(
    arrays: "tuple[TaxelArray, ...]", start_ns: int, receivers: "list[Callable[[Message], None]]"
) -> "Sink":  # fmt: skip
    """Return a sink that passes the messages of each report to the receivers."""
    from tactile.export.drawable import Drawable  # rosbags is slow to import

    drawable = Drawable(arrays, start_ns, ros=False)

    def draw(report: "FrameReport") -> None:
        for message in drawable(report):
            for receiver in receivers:
                receiver(message)

    return draw
