"""The tactile layer: frames of three-axial taxel arrays in; events, located loads and texture figures out.

from tactile import Settings, open_source, run
run(open_source("grip.toml"), Settings(), [lambda report: print(*(event.words for event in report.events))])
"""

__all__ = [
    "Calibration", "DetectorFile", "Event", "EventLog", "EventRule", "Frame", "FrameReport", "Indenter", "InputError",
    "Load", "MovingContact", "MovingLoad", "Scene", "Settings", "Sink", "SlidingTexture", "Source", "TaxelArray",
    "Threshold", "Validity", "__version__", "load_calibration", "make_effect", "open_source", "read_detector", "run",
    "warm_up",
]  # fmt: skip

from cnnsim import __version__

TYPE_CHECKING = False  # as in typing, which takes longer to import than all that stands here
if TYPE_CHECKING:  # at run time a name is imported when it is first asked for
    from cnnsim.support import InputError
    from tactile.calibration.file import Calibration, load_calibration
    from tactile.core.frame import Frame, TaxelArray
    from tactile.core.source import Source
    from tactile.events.detector_file import DetectorFile, EventRule, read_detector
    from tactile.events.event import Event, EventLog
    from tactile.inverse.load import Load
    from tactile.inverse.validity import Validity
    from tactile.pipeline import FrameReport, Sink, run, warm_up
    from tactile.settings import Settings
    from tactile.simulator.contacts.indenter import Indenter
    from tactile.simulator.contacts.moving_contact import MovingContact
    from tactile.simulator.contacts.moving_load import MovingLoad
    from tactile.simulator.contacts.sliding_texture import SlidingTexture
    from tactile.simulator.effects import make_effect
    from tactile.simulator.scene.scene import Scene
    from tactile.sources import open_source
    from tactile.thresholds.threshold import Threshold
else:
    from cnnsim.lazy import importer

    _MODULES = {
        "cnnsim.support": ("InputError",),
        "tactile.calibration.file": ("Calibration", "load_calibration"),
        "tactile.core.frame": ("Frame", "TaxelArray"),
        "tactile.core.source": ("Source",),
        "tactile.events.detector_file": ("DetectorFile", "EventRule", "read_detector"),
        "tactile.events.event": ("Event", "EventLog"),
        "tactile.inverse.load": ("Load",),
        "tactile.inverse.validity": ("Validity",),
        "tactile.pipeline": ("FrameReport", "Sink", "run", "warm_up"),
        "tactile.settings": ("Settings",),
        "tactile.simulator.contacts.indenter": ("Indenter",),
        "tactile.simulator.contacts.moving_contact": ("MovingContact",),
        "tactile.simulator.contacts.moving_load": ("MovingLoad",),
        "tactile.simulator.contacts.sliding_texture": ("SlidingTexture",),
        "tactile.simulator.effects": ("make_effect",),
        "tactile.simulator.scene.scene": ("Scene",),
        "tactile.sources": ("open_source",),
        "tactile.thresholds.threshold": ("Threshold",),
    }

    __getattr__ = importer(__name__, _MODULES)

    def __dir__() -> list[str]:
        return __all__
