"""What stands between bytes and frames on the host: device clocks, tares, array descriptions."""

import ctypes
import platform
import threading
from dataclasses import replace

import numpy as np
import pytest

from cnnsim.support.errors import InputError
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import LiveTare
from tactile.core.frame import Frame, TaxelArray
from tactile.serial.time_slice import ATTRIBUTES, SLICE, ask_for_short_slices
from tactile.wire.arrange import Arrange, back
from tactile.wire.base import Reading
from tactile.wire.clock import ENOUGH, LATE, ClockLine
from tactile.wire.description import default_description, parse_description
from tactile.wire.packets import emulated_description, packets
from tests.kits.serial import grip, sent


def clocked(n: int, drift: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Device time, true host time, arrival: delays are never negative, often 1 ms, sometimes 50."""
    true = np.arange(n) * 0.001
    delay = rng.exponential(1e-3, n) + (rng.random(n) < 0.02) * 0.05
    return 500 + true * (1 + drift), true, true + delay


@pytest.mark.parametrize("drift", [0.0, 80e-6, -300e-6])
def test_the_clock_line_finds_drift_under_one_sided_delays(drift: float) -> None:
    device_time, true, arrival = clocked(20_000, drift, np.random.default_rng(2))
    line = ClockLine()
    mapped = np.array([line(a, b) for a, b in zip(device_time.tolist(), arrival.tolist(), strict=True)])
    assert (np.diff(mapped) >= 0).all()
    assert np.abs(mapped - true)[5000:].max() < 2e-4  # where arrivals are off by up to 60 ms
    report = line.report()
    assert report["drift_ppm"] == pytest.approx(-drift * 1e6, abs=10)  # host over device
    assert report["residual_median_s"] == pytest.approx(np.log(2) * 1e-3, rel=0.2)
    late = int((arrival - true > LATE)[5000:].sum())
    assert line.late == pytest.approx(late * 20 / 15, rel=0.2)


def test_the_clock_line_starts_anew_with_the_device() -> None:
    line = ClockLine()
    for n in range(4 * ENOUGH * 100):
        line(10 + n * 0.01, 1 + n * 0.01)
    before = line(10 + 32.0, 33.0)
    assert before == pytest.approx(33.0, abs=1e-9)
    assert line(0.001, 35.0) == pytest.approx(35.0, abs=1e-9)
    assert line(1000.0, 35.5) == pytest.approx(35.5, abs=1e-9)
    assert line(float("nan"), 36.0) == 36.0
    assert line(float("nan"), 35.0) == 36.0  # never backwards
    assert ClockLine().report()["drift_ppm"] is None


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
    tare.ask()
    fed(tare, held(2e-4, 50))
    assert tare.notes[-1].why == "on request"
    manual = LiveTare(0, ARRAY, automatic=False, block=50)
    fed(manual, held(0.0))
    fed(manual, held(1e-4))
    assert [note.why for note in manual.notes] == ["at the start"]


def test_the_first_tare_waits_for_stillness() -> None:
    tare = LiveTare(0, ARRAY, block=20)
    moving = np.linspace(0, 0.01, 20)[:, None, None, None] * np.ones((1, 1, 2, 3))
    assert not fed(tare, moving)[-1].valid.any()
    assert tare.notes[-1].why == "refused: not still"
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


TEXT = """
title = "hand"
protocol = "reskin"
youngs_modulus_mpa = 0.4
[[finger]]
name = "thumb"
rows = 2
cols = 3
pitch_mm = 7.0
depth_mm = 2.0
quantity = "strain"
axes = ["-y", "x", "-z"]
gains = [1e-5, 2e-5]
cells = [[-1, 1, 3], [2, 0, -1]]
"""


def test_a_description_turns_chips_into_frames_and_back() -> None:
    description = parse_description(TEXT, "here")
    assert description.options.shapes == ((1, 4),)
    chips = np.arange(12.0).reshape(4, 3) + 1
    (frame,) = Arrange(description)(Reading(chips, 66), 1.5)
    assert frame.valid.tolist() == [[False, True, True], [True, True, False]]
    x, y, z = chips[0]
    assert frame.values[1, 1] == pytest.approx([-y * 1e-5, x * 1e-5, -z * 2e-5], rel=1e-12)
    assert back(frame, description.boards[0]) == pytest.approx(chips, rel=1e-12)
    assert (description.modulus, description.baudrate) == (400000.0, 115200)
    again = parse_description(description.text, "again")
    assert again.arrays == description.arrays


@pytest.mark.parametrize(("change", "message"), [
    (('"reskin"', '"risken"'), "one of reskin"),
    (("title", "titel"), "did you mean 'title'"),
    (('["-y", "x", "-z"]', '["x", "x", "z"]'), "each of x, y, z once"),
    (('["-y", "x", "-z"]', '["x"]'), "each of x, y, z once"),
    (("[1e-5, 2e-5]", "[0, 1]"), "shear gain 0.0"),
    (("[[-1, 1, 3]", "[[-1, 1, 4]"), "chip numbers 0, 1"),
    (("[[-1, 1, 3], ", "["), "2 x 3 chip numbers"),
    (("rows = 2", "rows = 0"), "at least 1 x 1"),
    (('protocol = "reskin"', 'protocol = "reskin"\\nbaudrate = 0'), "positive numbers wanted"),
    (("[[finger]]", "[options]\\nvalue = 1\\n[[finger]]"), "unknown key 'value'"),
    (("0.4", "0..4"), "not TOML"),
])  # fmt: skip
def test_wrong_descriptions_are_refused(change: tuple[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_description(TEXT.replace(change[0], change[1].replace("\\n", "\n")), "here")


def test_devices_that_need_no_description_and_those_that_do() -> None:
    assert [array.shape for array in default_description("papillarray").arrays] == [(3, 3), (3, 3)]
    with pytest.raises(InputError, match="--array FILE wanted"):
        default_description("reskin")
    plain = parse_description(TEXT.replace("gains", "#"), "here")
    with pytest.raises(InputError, match="gains"):
        plain.check_calibrated()
    parse_description(TEXT, "here").check_calibrated()
    with pytest.raises(InputError, match="carries one array"):
        emulated_description("paxini-serial", grip(0.1))
    description, _ = sent("native", 0.1)
    with pytest.raises(InputError, match="different shapes"):
        packets(description, replace(grip(0.1), arrays=grip(0.1).arrays[:1]))


def test_short_slices_are_asked_for_where_the_kernel_has_them() -> None:
    """In a thread of its own, since it stays so; what the kernel says afterwards tells."""
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        pytest.skip("the number of the call that asks back is that of x86_64 Linux")
    said: list[tuple[bool, int, int]] = []

    def ask() -> None:
        agreed, answer = ask_for_short_slices(), ctypes.create_string_buffer(ATTRIBUTES.size)
        failed = ctypes.CDLL(None).syscall(315, 0, answer, ATTRIBUTES.size, 0)
        said.append((agreed, failed, ATTRIBUTES.unpack(answer.raw)[5]))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    ((agreed, failed, slice_),) = said
    if failed:
        pytest.skip("this kernel does not know the call")
    assert agreed
    if tuple(int(part) for part in platform.release().split(".")[:2]) >= (6, 12):
        assert slice_ == SLICE
