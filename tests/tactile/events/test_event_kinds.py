"""Events as values: every kind has words; words, JSON, table and picture follow from kind and data alone."""

import json
from pathlib import Path
from string import Formatter

import numpy as np
import pytest

from cnnsim.program.machine import UniversalMachine
from tactile.core.frame import Frame, TaxelArray
from tactile.events.code import Code
from tactile.events.contact_and_shear import ContactAndShear, TouchKind
from tactile.events.detector import Observation
from tactile.events.event import Data, Event, EventKind
from tactile.events.registry import detectors
from tactile.events.slip import REST, SlipDetector, SlipKind
from tactile.events.tangential_load import LoadKind, TangentialLoad
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.output.collected import Collected
from tactile.output.event_data import event_data
from tactile.output.plot import draw
from tactile.output.tables import grouped, tables

KINDS: list[EventKind] = [kind for kinds in EventKind.__subclasses__() for kind in kinds]
EVENTS: list[tuple[EventKind, Data, str]] = [
    (TouchKind.CONTACT, {"taxels": 1, "of_taxels": 4}, "contact"),
    (TouchKind.RELEASE, {"taxels": 0, "of_taxels": 4}, "release"),
    (TouchKind.CONTACT_CHANGES, {"taxels": 3, "of_taxels": 4}, "contact on 3 of 4 taxels"),
    (TouchKind.SHEAR_BEGINS, {"direction": "+x", "taxels": 1}, "shear +x"),
    (TouchKind.SHEAR_TURNS, {"direction": "+x -y", "taxels": 2, "from_direction": "+x"}, "shear turns +x -y"),
    (TouchKind.SHEAR_SPREADS, {"direction": "-y", "taxels": 3}, "shear -y spreads"),
    (TouchKind.SHEAR_FADES, {"direction": "-y", "taxels": 2}, "shear -y fades"),
    (TouchKind.SHEAR_SHIFTS, {"direction": "about a point", "taxels": 2}, "shear about a point shifts"),
    (TouchKind.SHEAR_GONE, {}, "shear gone"),
    (LoadKind.TANGENTIAL_LOAD, {"direction": "+y", "force_n": 0.256}, "tangential load +y: 0.26 N"),
    (LoadKind.TANGENTIAL_LOAD_GONE, {}, "tangential load gone"),
    (SlipKind.SLIP_BEGINS, {"direction": "-x", "length_m": 6e-5, "dx_m": -6e-5, "dy_m": 0.0}, "slip begins toward -x"),
    (SlipKind.SLIP_ENDS, {"direction": "+y", "length_m": 5e-4, "dx_m": 3e-4, "dy_m": 4e-4},
     "slip ends: 0.50 mm toward +y"),
]  # fmt: skip


def event(kind: EventKind, data: Data, t: float = 1.0) -> Event:
    return Event(t, "tip", 7, kind, data, "·→ ··", "00+00000", 32, 1e-4, Load(1e-3, 0.0, F=0.5, taxels=1))


def code(x: list[int], y: list[int], contact: list[int]) -> Code:
    planes = (np.array(plane, np.int8).reshape(2, 2) for plane in (x, y, contact))
    return Code(next(planes), next(planes), next(planes).astype(bool))


def observed(before: Code, after: Code, t: float = 0.0, load: Load | None = None, changed: bool = True) -> Observation:
    return Observation(Frame(0, t, 0, np.zeros((2, 2, 3)), np.ones((2, 2), bool)), before, after, changed, load)


NOTHING = code([0] * 4, [0] * 4, [0] * 4)
TOUCH = code([0] * 4, [0] * 4, [1, 1, 0, 0])


def test_the_list_above_has_every_kind_and_no_two_kinds_share_a_name_or_a_text() -> None:
    assert {kind for kind, _, _ in EVENTS} == set(KINDS)
    assert len({kind.label for kind in KINDS}) == len({kind.value for kind in KINDS}) == len(KINDS)
    assert all(len(kinds.__members__) == len(list(kinds)) for kinds in EventKind.__subclasses__())


@pytest.mark.parametrize(("kind", "data", "words"), EVENTS)
def test_words_are_made_of_the_data(kind: EventKind, data: Data, words: str) -> None:
    assert event(kind, data).words == words
    named = {name for _, name, _, _ in Formatter().parse(kind.value) if name}
    assert named <= {*data, *(f"{name}m" for name in data if name.endswith("_m"))}


@pytest.mark.parametrize(("kind", "data", "words"), EVENTS)
def test_json_has_kind_data_and_words(kind: EventKind, data: Data, words: str) -> None:
    plain = json.loads(json.dumps(event_data(event(kind, data)), allow_nan=False))
    assert (plain["kind"], plain["data"], plain["words"]) == (kind.name.lower(), data, words)
    assert (plain["arrows"], plain["ternary"], plain["hand"]) == ("·→ ··", "00+00000", "20")
    load = plain["load"]
    assert [load[name] for name in ("x", "y", "Q", "R", "F")] == [1e-3, 0.0, None, None, 0.5]


def test_picture_and_table_read_no_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With other words the same lines are joined, the same events drawn in the same colours."""
    collected, array = Collected(), TaxelArray("tip", 2, 2, 1e-3, 1e-3)
    collected.events += [event(kind, data, 0.01 * i) for i, (kind, data, _) in enumerate(EVENTS)]
    lines = [(one.kind, count) for one, count in grouped(collected.events)]
    assert lines[:3] == [(TouchKind.CONTACT, 1), (TouchKind.RELEASE, 1), (TouchKind.SHEAR_GONE, 7)]
    assert lines[3:] == [(kind, 1) for kind, _, _ in EVENTS[9:]]
    monkeypatch.setattr(Event, "words", property(lambda _: "?"))
    assert [(one.kind, count) for one, count in grouped(collected.events)] == lines
    tables(collected, (array,))
    draw(collected, (array,), "words", tmp_path / "touch.png")


@pytest.mark.parametrize(("before", "after", "kind", "data"), [
    (NOTHING, TOUCH, TouchKind.CONTACT, {"taxels": 2, "of_taxels": 4}),
    (TOUCH, NOTHING, TouchKind.RELEASE, {"taxels": 0, "of_taxels": 4}),
    (TOUCH, code([0] * 4, [0] * 4, [1, 1, 1, 0]), TouchKind.CONTACT_CHANGES, {"taxels": 3, "of_taxels": 4}),
    (TOUCH, code([1, 0, 0, 0], [0] * 4, [1, 1, 0, 0]), TouchKind.SHEAR_BEGINS, {"direction": "+x", "taxels": 1}),
    (code([1, 0, 0, 0], [0] * 4, [1] * 4), code([1, 0, 0, 0], [-1, 0, 0, 0], [1] * 4), TouchKind.SHEAR_TURNS,
     {"direction": "+x -y", "taxels": 1, "from_direction": "+x"}),
    (code([1, 0, 0, 0], [0] * 4, [1] * 4), code([1, 1, 0, 0], [0] * 4, [1] * 4), TouchKind.SHEAR_SPREADS,
     {"direction": "+x", "taxels": 2}),
    (code([1, 1, 0, 0], [0] * 4, [1] * 4), code([1, 0, 0, 0], [0] * 4, [1] * 4), TouchKind.SHEAR_FADES,
     {"direction": "+x", "taxels": 1}),
    (code([1, -1, 0, 0], [0] * 4, [1] * 4), code([0, 0, 1, -1], [0] * 4, [1] * 4), TouchKind.SHEAR_SHIFTS,
     {"direction": "about a point", "taxels": 2}),
    (code([1, 0, 0, 0], [0] * 4, [1] * 4), code([0] * 4, [0] * 4, [1] * 4), TouchKind.SHEAR_GONE, {}),
])  # fmt: skip
def test_a_change_of_the_code_is_one_event(before: Code, after: Code, kind: EventKind, data: Data) -> None:
    assert ContactAndShear().detect(observed(before, after)) == [(kind, data)]
    assert ContactAndShear().detect(observed(before, after, changed=False)) == []


def test_the_tangential_load_has_a_direction_and_newtons() -> None:
    detector = TangentialLoad(UniversalMachine("reference", "float64"))
    assert detector.detect(observed(TOUCH, TOUCH)) == []
    assert detector.detect(observed(TOUCH, TOUCH, load=Load(0, 0, 0.0, 0.0, 0.5))) == []
    ((kind, data),) = detector.detect(observed(TOUCH, TOUCH, load=Load(0, 0, 0.3, -0.4, 0.5)))
    assert kind is LoadKind.TANGENTIAL_LOAD
    assert data == {"direction": "+x -y", "force_n": pytest.approx(0.5)}
    assert detector.detect(observed(TOUCH, TOUCH, load=Load())) == [(LoadKind.TANGENTIAL_LOAD_GONE, {})]


def test_a_slip_has_a_beginning_and_a_length() -> None:
    detector, happened = SlipDetector(), []
    for t, x in ((0.0, 0.0), (0.1, -1e-4), (0.2, -3e-4), (0.3 + REST, -3e-4)):
        load = Load(x, 0.0, 0.0, 0.0, 0.5, taxels=4, validity=Validity.INSIDE)
        happened += detector.detect(observed(TOUCH, TOUCH, t, load))
    travelled = {"direction": "-x", "length_m": 3e-4, "dx_m": -3e-4, "dy_m": 0.0}
    assert happened[0] == (SlipKind.SLIP_BEGINS, travelled | {"length_m": 1e-4, "dx_m": -1e-4})
    assert happened[1:] == [(SlipKind.SLIP_ENDS, travelled)]


def test_each_finger_has_detectors_of_its_own() -> None:
    machine = UniversalMachine("reference", "float64")
    left, right = detectors(machine), detectors(machine)
    assert not any(one is other for one in left for other in right)
