"""Channels of terms as OpenCL text: which are copied into a tile, and from which layer of which plane."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cnnsim.backends.opencl.device.build import Defines
from cnnsim.backends.term_table import Channel, TermTable


class ChannelSource(NamedTuple):
    """A plane that channels are filled from: of the ``input`` or the state, so many steps ``ago``; ``late``: for stages
    that look at what is at the end of a step.
    """

    input: bool
    ago: int
    late: bool = False


class ChannelText:
    """How the terms of a table read its channels: state and output of the cell itself where they are, else a copy.

    ``outputs``: the output is another thing than the state. ``copied`` are the channels that a tile has a copy of, with
    its virtual cells, in their order there.
    """

    def __init__(self, table: TermTable, *, outputs: bool) -> None:
        self._table, self._outputs = table, outputs
        self.copied: list[int] = []
        for layer, of, centre, times, times_centre, first, after, *_ in np.stack(table.terms, axis=1).tolist():
            alone = not (table.taps.k[first:after].any() or table.taps.l[first:after].any())
            for channel, here in ((of, alone), (centre, True), (times, alone), (times_centre, True)):
                if channel >= 0 and channel not in self.copied and not (here and self._is_own(channel, layer)):
                    self.copied.append(channel)

    def _is_own(self, channel: int, layer: int) -> bool:
        """Whether a channel is of the state that the cell of a layer has now."""
        quantity, of_layer, ago = self._table.channels[channel]
        return quantity != "u" and not ago and of_layer == layer

    def read(self, channel: int, k: object = 0, l: object = 0) -> str:
        """Return the text of a channel's value at an offset."""
        if channel in self.copied:
            return f"NEIGHBOUR({self.copied.index(channel)}, {k}, {l})"
        through = self._outputs and self._table.channels[channel].quantity == "y"
        return "output_of_vec(state)" if through else "state"

    def seen(self) -> list[Channel]:
        """Return what the copied channels are."""
        return [self._table.channels[number] for number in self.copied]


def channel_defines(text: ChannelText, ahead: Sequence[int], *, outputs: bool) -> tuple[Defines, list[ChannelSource]]:
    """Return the definitions FILLS, SOURCES and SOURCES_GIVEN for stages.cl, and the planes that SOURCES stands for.

    Arguments: ``ahead`` says of each stage whether it looks at the end of the step; ``outputs``: the output is another
    thing than the state.
    """
    sources: dict[ChannelSource, str] = {}

    def name(*source: int) -> str:
        given, ago, *late = source
        return sources.setdefault(ChannelSource(bool(given), ago, *map(bool, late)), f"source{len(sources)}")

    def fill(number: int, channel: Channel) -> str:
        layer, output = channel.layer, int(channel.quantity == "y" and outputs)
        if channel.quantity == "u":
            return f"FILL_INPUT({number}, {layer}, {name(1, channel.ago)}) "
        if not channel.ago:
            return f"FILL_STATE({number}, {layer}, {output}) "
        plane = name(0, channel.ago)
        if any(ahead):
            plane = f"(ahead >> stage & 1 ? {name(0, channel.ago, 1)} : {plane})"
        return f"FILL_PLANE({number}, {layer}, {output}, {plane}) "

    fills = "".join(map(fill, range(len(text.copied)), text.seen()))
    return {
        "FILLS": f"if (!bare) {{ {fills}}}",
        "SOURCES": "".join(f", __global const real *{plane}" for plane in sources.values()),
        "SOURCES_GIVEN": "".join(f", {plane}" for plane in sources.values()),
    }, list(sources)
