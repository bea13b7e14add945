"""Which event detectors watch a finger. Adding one is one file with its kinds, and its name here."""

from cnnsim.program.machine import UniversalMachine
from tactile.events.contact_and_shear import ContactAndShear
from tactile.events.detector import Detector
from tactile.events.slip import SlipDetector
from tactile.events.tangential_load import TangentialLoad


def detectors(machine: UniversalMachine) -> tuple[Detector, ...]:
    """Return one finger's detectors, in the order in which events of the same frame are told."""
    return ContactAndShear(), TangentialLoad(machine), SlipDetector()
