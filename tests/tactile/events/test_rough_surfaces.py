"""Intermittent contact on rough surfaces is one contact; vibration without slip is no slip."""

from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.core.frame import NORMAL
from tactile.events.detector_file import read_detector
from tactile.events.event import Event
from tests.kits.touch.made import events, force_stream, stream

RATE = 500
START, STOP = 0.1, 0.9
"""Time of contact [s], after 0.5 s without contact."""


def slide(normal: Floats, rate: float = RATE) -> list[Event]:
    """Return contacts and releases of a ball with normal force ``normal`` (n,) [N] and half of it as shear."""
    y, x = np.mgrid[-2.5:3.5, -2.5:3.5]
    under = np.sqrt(np.maximum(1 - (x**2 + y**2) / 2.2**2, 0))
    forces = np.zeros((len(normal), 6, 6, 3))
    forces[..., NORMAL] = normal[:, None, None] * under / under.sum()
    forces[..., 0] = 0.5 * forces[..., NORMAL]
    return [e for e in events(stream(forces, rate)) if e.kind in ("contact", "release")]


@pytest.mark.parametrize("rate", [200, 1000])
@pytest.mark.parametrize("teeth", [31, 63, 97])
@pytest.mark.parametrize("depth", [1.3, 2.5])
def test_intermittent_contact_is_one_contact(teeth: int, depth: float, rate: int) -> None:
    t = np.arange(round(1.2 * rate)) / rate
    inside = (t >= START) & (t < STOP)
    normal = np.where(inside, np.maximum(1 + depth * np.sin(2 * np.pi * teeth * t), 0), 0.0)
    assert (normal[inside] == 0).any()
    contact, release = slide(normal, rate)
    last = float(t[normal > 0][-1])
    assert (contact.kind, release.kind) == ("contact", "release")
    assert contact.t == pytest.approx(0.5 + START, abs=0.015)
    assert release.t == pytest.approx(0.5 + last, abs=0.015)
    assert contact.end == release.t
    assert release.told - release.t == pytest.approx(0.03, abs=1.5 / rate)


@pytest.mark.parametrize("pause", [0.05, 0.1])
def test_two_touches_with_a_pause_are_two_contacts(pause: float) -> None:
    t = np.arange(RATE) / RATE
    normal = np.where(((t >= 0.1) & (t < 0.3)) | ((t >= 0.3 + pause) & (t < 0.6)), 1.0, 0.0)
    found = slide(normal)
    assert [event.kind for event in found] == ["contact", "release"] * 2
    assert [event.t for event in found] == pytest.approx([0.6, 0.8, 0.8 + pause, 1.1], abs=0.015)


def test_unless_needs_a_binary_output(tmp_path: Path) -> None:
    text = (
        'name = "x"\nllm = ["touch"]\nlam = ["pressing"]\ninputs = ["touch", "pressing"]\noutputs = ["touch", {more}]\n'
        'step = [{{ copy = "touch", to = "touch" }}]\n[[event]]\nkind = "x"\nwhen = "touch"\nunless = "pressing"\n'
    )
    for more, wrong in (("", "pressing; of the outputs touch"), ('"pressing"', "unless = 'pressing' is analog")):
        (tmp_path / "x.toml").write_text(text.format(more=more), encoding="utf-8")
        with pytest.raises(InputError, match=wrong):
            read_detector(tmp_path / "x.toml")


@pytest.mark.parametrize(("side", "hertz", "part"), [(2, 30, 0.05), (6, 30, 0.2)])
def test_vibration_of_a_sticking_contact_is_no_slip(side: int, hertz: int, part: float) -> None:
    """Shear oscillates in proportion to the pressure on all taxels."""
    t = np.arange(600) / 200
    y, x = np.mgrid[0:side, 0:side] - (side - 1) / 2
    under = np.sqrt(np.maximum(1 - (x**2 + y**2) / (0.4 * side) ** 2, 0))
    normal = (2 * np.interp(t, [0.8, 0.95, 2.6, 2.7], [0, 1, 1, 0]))[:, None, None] * under / under.sum()
    swing = part * np.sin(2 * np.pi * hertz * t) * ((t > 1.4) & (t < 2.4))
    forces = np.stack([swing[:, None, None] * normal, np.zeros_like(normal), normal], axis=-1)
    forces += np.random.default_rng(0).standard_normal(forces.shape) * (1.1e-3, 1.1e-3, 3.6e-3)
    kinds = {event.kind for event in events(force_stream(t, forces, 3e-3), tare="auto")}
    assert {"contact", "hold", "release"} <= kinds
    assert "slip" not in kinds
