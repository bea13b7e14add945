"""Channels of terms as OpenCL text: from which layer of which plane a tile fills each of them."""

from collections.abc import Sequence
from typing import NamedTuple

from cnnsim.backends.opencl.build import Defines
from cnnsim.backends.term_table import Channel, TermTable


class ChannelSource(NamedTuple):
    """A plane that channels are filled from: of the ``input`` or the state, so many steps ``ago``; ``late``: for stages
    that look at what is at the end of a step.
    """

    input: bool
    ago: int
    late: bool = False


def channel_defines(
    tables: Sequence[TermTable], ahead: Sequence[int], *, outputs: bool
) -> tuple[Defines, list[ChannelSource]]:
    """Return the definitions FILLS and SOURCES for stages.cl, and the planes that the kernel is given by SOURCES.

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

    cases = ""
    for part, table in enumerate(tables):
        cases += f"case {part}: {{ " + "".join(map(fill, range(len(table.channels)), table.channels)) + "break; } "
    arguments = "".join(f", __global const real *{plane}" for plane in sources.values())
    return {"FILLS": f"switch (part) {{ {cases}}}", "SOURCES": arguments}, list(sources)
