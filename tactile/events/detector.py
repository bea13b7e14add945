"""Event detectors: what one is given of every frame, and what it returns."""

from dataclasses import dataclass
from typing import Protocol

from tactile.core.frame import Frame
from tactile.events.code import Code
from tactile.events.event import Happening
from tactile.inverse.load import Load


@dataclass(frozen=True)
class Observation:
    """What is known of one finger after a frame.

    ``frame`` calibrated; ``code`` of its taxels, ``before`` that of the frame before, ``changed`` whether they differ;
    ``load`` located in the frame, None for arrays that measure force themselves.
    """

    frame: Frame
    before: Code
    code: Code
    changed: bool
    load: Load | None


class Detector(Protocol):
    """Recognises events of one finger; it may remember what it has seen of earlier frames."""

    def detect(self, seen: Observation) -> list[Happening]:
        """Return what has happened in this frame, each as a kind and its data; `pipeline.run` makes events of them."""
        ...
