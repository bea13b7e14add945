"""Live view on a terminal: an arrow per taxel, events, rates, latency and losses."""

from collections.abc import Callable

import numpy as np
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from cnnsim.support.terminal import printable
from tactile.cli.port.console import tare_words
from tactile.cli.port.live import LiveMonitor, status_words
from tactile.core.frame import NORMAL
from tactile.pipeline import FrameReport
from tactile.thresholds.threshold import CONTACT

KEYS = "t and Return: tare; t! and Return: tare by force; q and Return, or Ctrl-C: end"
SHADES = ("dim", "white", "yellow", "red")
"""Style by pressing: below the dead band, up to 4 and 16 times it, above."""


class LiveView:
    """Renders the state of a `LiveMonitor` when rich asks; ``state`` returns the status of the port."""

    def __init__(self, monitor: LiveMonitor, title: str, state: Callable[[], str]) -> None:
        self._monitor, self._title, self._state = monitor, title, state

    def __rich__(self) -> RenderableType:
        hand = Table.grid(padding=(0, 3))
        reports = tuple(self._monitor.newest.values())
        if reports:
            hand.add_row(*(Panel(_arrows(report), title=_shown(report.array.name)) for report in reports))
        events = Table("time [s]", "finger", "what", box=None, title="events", title_justify="left")
        for event in tuple(self._monitor.events):
            events.add_row(f"{event.t:.3f}", event.finger, event.words)
        return Panel(
            Group(hand, events, _shown(self._figures()), _shown(self._state()), Text(KEYS, style="dim")),
            title=_shown(self._title),
        )

    def _figures(self) -> str:
        rate, lost = status_words(self._monitor.status())
        tares = "".join(
            f"\ntare of {finger} at {last['t_s']:.3f} s: {tare_words(last)}"
            for finger, last in self._monitor.tared.items()
        )
        return f"{rate}\n{lost}{tares}"


def _shown(text: str) -> Text:
    return Text(printable(text))


def _arrows(report: FrameReport) -> Text:
    """Return the arrows of the taxels, brighter with more pressing."""
    unit = CONTACT[report.array.quantity].dead_band
    pressing = np.abs(np.nan_to_num(report.frame.values[..., NORMAL])) / unit
    level = np.digitize(pressing, (1, 4, 16))
    text = Text()
    for arrows, levels in zip(report.code.arrows().split(" "), level.tolist(), strict=True):
        for arrow, shade in zip(arrows, levels, strict=True):
            text.append(f"{arrow} ", style=SHADES[shade])
        text.append("\n")
    text.right_crop(1)
    return text
