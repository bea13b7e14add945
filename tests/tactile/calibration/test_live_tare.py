"""Tares of a live run: when they are taken, and what readings are after them."""

import numpy as np

from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import LiveTare
from tactile.core.frame import Frame, TaxelArray

ARRAY = TaxelArray("tip", 1, 2, 1e-3, 1e-3, quantity="strain")


def fed(tare: LiveTare, values: np.ndarray, start: int = 0) -> list[Frame]:
    return [tare(Frame(0, 0.01 * (start + n), start + n, one, np.ones((1, 2), bool))) for n, one in enumerate(values)]


def test_tare_at_the_start_idle_and_never_while_loaded() -> None:
    rng = np.random.default_rng(3)

    def held(level: float, n: int = 50, noise: float = 1e-5) -> np.ndarray:
        return 0.5 + level + noise * rng.standard_normal((n, 1, 2, 3))

    tare = LiveTare(0, ARRAY, block=50)
    assert not any(frame.valid.any() for frame in fed(tare, held(0.0)[:49]))
    (first,) = fed(tare, held(0.0, 1))
    assert np.abs(first.values).max() < 1e-4
    assert [note.why for note in tare.notes] == ["at the start"]
    fed(tare, held(2e-4))  # drift, well below half a dead band
    assert tare.notes[-1].why == "idle"
    assert np.abs(fed(tare, held(2e-4, 1))[0].values).max() < 1e-4
    fed(tare, held(2e-4, 49))
    known = len(tare.notes)
    loaded = fed(tare, held(-0.01, 200))  # a still load is no drift
    assert len(tare.notes) == known
    assert np.abs(loaded[-1].values + 0.0102).max() < 1e-4
    tare.ask()
    fed(tare, held(-0.01, 50))
    assert (tare.notes[-1].why, tare.notes[-1].offset) == ("refused: loaded", None)
    assert tare.notes[-1].detail.startswith("20.")
    assert "‰ normal, " in tare.notes[-1].detail
    assert tare.notes[-1].detail.endswith("off the tare: let nothing touch it, then ask for a tare")
    tare.ask()
    fed(tare, held(2e-4, 50))
    assert tare.notes[-1].why == "on request"
    manual = LiveTare(0, ARRAY, automatic=False, block=50)
    fed(manual, held(0.0))
    fed(manual, held(1e-4))
    assert [note.why for note in manual.notes] == ["at the start"]
    assert "taken away; loaded, or an offset of that size" in manual.notes[0].detail


def test_the_first_tare_waits_for_stillness() -> None:
    tare = LiveTare(0, ARRAY, block=20)
    moving = np.linspace(0, 0.01, 20)[:, None, None, None] * np.ones((1, 1, 2, 3))
    assert not fed(tare, moving)[-1].valid.any()
    assert tare.notes[-1].why == "refused: not still"
    assert tare.notes[-1].detail == "a taxel moves by 10.00 ‰: let nothing touch it, then ask for a tare"
    still = np.full((20, 1, 2, 3), 0.3)
    still[:, 0, 1] = np.nan  # a taxel without readings is not waited for
    last = fed(tare, still)[-1]
    assert last.valid.tolist() == [[True, False]]
    assert np.abs(last.values[0, 0]).max() < 1e-15


def test_a_tare_knows_what_its_readings_will_be() -> None:
    """Readings over the gains are judged like the readings."""
    rng, gains = np.random.default_rng(4), Gains(2.0**-10, -(2.0**-6))
    quiet, loud = (size * rng.standard_normal((20, 1, 2, 3)) for size in (1e-4, 1e-2))
    for values, why in ((quiet, "at the start"), (loud, "refused: not still")):
        plain, scaled = LiveTare(0, ARRAY, block=20), LiveTare(0, ARRAY, block=20, gains=gains)
        fed(plain, values)
        fed(scaled, values / gains(np.ones(3)))
        assert [note.why for note in plain.notes] == [note.why for note in scaled.notes] == [why]
