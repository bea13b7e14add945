"""The tactile layer: frames of three-axial taxel arrays in; events, located loads and texture figures out.

import tactile
result = tactile.run("grip.toml")
result.events  # a table
result.plot()
"""

__all__ = [
    "Calibration", "DetectorFile", "Event", "EventRule", "EventTable", "Frame", "Indenter", "InputError", "Load",
    "MovingContact", "MovingLoad", "Scene", "Settings", "SlidingTexture", "Source", "Stream", "StreamFrame",
    "TaxelArray", "Threshold", "TouchResult", "Validity", "__version__", "load_calibration", "make_effect",
    "open_source", "read_detector", "run", "stream",
]  # fmt: skip

from cnnsim import __version__

TYPE_CHECKING = False  # not from typing, which takes longer to import than this file
if TYPE_CHECKING:  # at run time `cnnsim.lazy` imports a name from here when it is first used
    from cnnsim.support import InputError
    from tactile.calibration.file import Calibration, load_calibration
    from tactile.core.frame import Frame, TaxelArray
    from tactile.core.source import Source
    from tactile.events.detector_file import DetectorFile, EventRule, read_detector
    from tactile.events.event import Event
    from tactile.inverse.load import Load
    from tactile.inverse.validity import Validity
    from tactile.output.stream_frame import StreamFrame
    from tactile.results import EventTable, TouchResult, run
    from tactile.settings import Settings
    from tactile.simulator.contacts.indenter import Indenter
    from tactile.simulator.contacts.moving_contact import MovingContact
    from tactile.simulator.contacts.moving_load import MovingLoad
    from tactile.simulator.contacts.sliding_texture import SlidingTexture
    from tactile.simulator.effects import make_effect
    from tactile.simulator.scene.scene import Scene
    from tactile.sources import open_source
    from tactile.streaming import Stream, stream
    from tactile.thresholds.threshold import Threshold
else:
    from cnnsim.lazy import importer

    __getattr__ = importer(__name__)

    def __dir__() -> list[str]:
        return __all__
