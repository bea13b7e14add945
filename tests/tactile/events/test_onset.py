"""Where a tangential load set in: the bend of a known course, weak pulls, real recordings at other tempos."""

from dataclasses import replace

import numpy as np
import pytest

from cnnsim.program.machine import UniversalMachine
from tactile.core.frame import Frame, TaxelArray
from tactile.core.noise import measured
from tactile.core.source import FrameStream, Provenance
from tactile.events.detector_file import SHIPPED, shipped_detectors
from tactile.events.event import Event, EventLog
from tactile.events.signals.names import LEVELS
from tactile.events.signals.onset_numba import KEPT, bend, remember
from tactile.events.signals.signals import Signals
from tactile.pipeline import run
from tactile.settings import Settings
from tactile.sources import open_source
from tactile.thresholds.levels import SIGMAS, levels
from tests.kits.paths import DATA

REAL = DATA / "papillarray"
ONSETS = {"rigid_obj_slide_23-08-23": 1.10, "rigid_obj_moment_23-06-07": 0.95}


def told(array: TaxelArray, frames: list[Frame]) -> list[Event]:
    log = EventLog()
    source = FrameStream("", (array,), None, len(frames), frames, Provenance(untared=True))
    run(source, Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    return log.events


@pytest.mark.parametrize("since", [0.06, 0.15, 0.22])
def test_the_bend_of_a_course_that_drifts_is_where_it_was_made(since: float) -> None:
    times, past, state = np.zeros(KEPT), np.zeros((KEPT, 1, 2, 3)), np.zeros(2, np.int64)
    rng, now = np.random.default_rng(3), 1.0
    for t in np.arange(0.0, now, 0.005):
        course = 0.2 - 0.05 * t + 0.8 * max(t - (now - since), 0.0) + 1e-3 * rng.standard_normal()
        remember(t, np.array([[[-course, 0.0, 4.0], [0.0, 9.0, 4.0]]]), times, past, state)
    drawn = np.array([[[-0.3, 0.1]], [[0.0, 0.0]]])  # the second taxel is not drawn
    scratch = np.zeros((2, KEPT)), np.zeros((KEPT, KEPT))
    found = bend(now, drawn, past[0], False, times, past, state, *scratch)
    assert found == pytest.approx(now - since, abs=0.008)
    state[:] = 0
    assert bend(now, drawn, past[0], False, times, past, state, *scratch) == now


def test_of_two_bends_the_load_began_at_the_steeper() -> None:
    """What creeps at a tenth of the pull's rate for 0.12 s before it is no load yet, nor is one that yields after."""
    scratch = np.zeros((2, KEPT)), np.zeros((KEPT, KEPT))
    drawn = np.array([[[0.3]], [[0.0]]])
    for creeps, pulls, rates in ((0.8, 0.92, (0.2, 1.8)), (0.85, 0.93, (1.8, -1.2))):
        times, past, state = np.zeros(KEPT), np.zeros((KEPT, 1, 1, 3)), np.zeros(2, np.int64)
        rng, begins = np.random.default_rng(5), creeps if rates[0] > 1 else pulls
        for t in np.arange(0.5, 1.0, 0.004):
            course = rates[0] * max(t - creeps, 0.0) + rates[1] * max(t - pulls, 0.0) + 1e-3 * rng.standard_normal()
            remember(t, np.array([[[course, 0.0, 4.0]]]), times, past, state)
        assert bend(1.0, drawn, past[0], False, times, past, state, *scratch) == pytest.approx(begins, abs=0.008)


def test_a_pull_that_no_taxel_could_tell_alone_is_told_by_all_of_them() -> None:
    """0.9 N in 0.6 s over nine taxels, 0.17 N/s each, with noise of 15 mN: nine sigma of one taxel would take 0.4 s."""
    rng, array = np.random.default_rng(11), TaxelArray("pad", 3, 3, 4e-3, 0.0, quantity="force")
    t = np.arange(0.0, 3.2, 0.002)
    force = 4.5 * np.interp(t, [0.6, 0.7, 3.0, 3.1], [0, 1, 1, 0])
    pull = 0.9 * np.clip((t - 2.0) / 0.6, 0, 1) * (force > 0)
    values = np.stack([0.8 * pull, -0.6 * pull, force], -1)[:, None, None] / 9 * np.ones((1, 3, 3, 1))
    values += 0.015 * rng.standard_normal(values.shape)
    every = np.ones(array.shape, bool)
    frames = [Frame(0, time, n, one, every) for n, (time, one) in enumerate(zip(t.tolist(), values, strict=True))]
    pulls = [event for event in told(array, frames) if event.kind == "tangential_load"]
    assert [event.data["direction"] for event in pulls] == ["+x -y"]
    assert pulls[0].t == pytest.approx(2.0, abs=0.03)
    assert pulls[0].told < 2.2


@pytest.mark.skipif(not REAL.exists(), reason="the recordings lie beside the project, and are not here")
@pytest.mark.parametrize("tempo", [0.5, 0.6, 2.0])
@pytest.mark.parametrize("name", ONSETS)
def test_a_tangential_load_is_told_at_any_tempo(name: str, tempo: float) -> None:
    """Played twice as fast to half as fast; the relaxing grip before is none, and no part of the slide is a twist."""
    source, until = open_source(REAL / f"{name}.npz"), 3.4 if tempo > 1 else 1.5
    frames = [replace(frame, t=tempo * frame.t) for frame in source if frame.finger == 0 and frame.t < until]
    found = told(source.arrays[0], frames)
    first = [event.t for event in found if event.kind == "tangential_load"]
    assert first
    assert first[0] == pytest.approx(tempo * ONSETS[name], abs=0.06)
    turns = [event.data["sense"] for event in found if event.kind == "twist"]
    assert turns[:1] == (["clockwise"] if "moment" in name else [])


@pytest.mark.skipif(not REAL.exists(), reason="the recordings lie beside the project, and are not here")
@pytest.mark.parametrize(("dead", "shear"), [(0, 1.0), (4, 1.0), (None, 1.5)])
def test_what_a_closing_grip_goes_on_with_is_no_onset_with_a_dead_taxel_or_more_shear(
    dead: int | None, shear: float
) -> None:
    source, name = open_source(REAL / "rigid_obj_slide_23-08-23.npz"), "rigid_obj_slide_23-08-23"
    frames = []
    for frame in source:
        values = frame.values * np.array([shear, shear, 1.0])
        if dead is not None:
            values[divmod(dead, 3)] = 0.0
        frames += [replace(frame, values=values)] if frame.t < 1.5 else []
    first, *_ = (event.t for event in told(source.arrays[0], frames) if event.kind == "tangential_load")
    assert first == pytest.approx(ONSETS[name], abs=0.06)


def test_the_noise_of_a_still_hold_is_no_change_of_shear_and_a_slow_pull_is_one() -> None:
    rng, shape = np.random.default_rng(4), (3, 3)
    sigma, every = np.array([0.015, 0.015, 0.003]), np.ones(shape, bool)  # shear reads noisier than pressing
    noise = measured(sigma * rng.standard_normal((50, *shape, 3)))
    limits = levels(shape, "force", SIGMAS, None, None, noise)
    signals, outweighs = Signals(shape, "force"), []
    signals.set_noise(noise, limits)
    for n in range(1000):
        pull = 0.3 * max(n * 0.002 - 1.5, 0.0)  # [N] a taxel
        values = np.array([pull, 0.0, 0.5]) + sigma * rng.standard_normal((*shape, 3))
        signals.update(Frame(0, n * 0.002, n, values, every), every, limits)
        outweighs.append(signals.levels[LEVELS.index("outweighs")] > 0.25)
    assert not any(outweighs[100:750])
    assert all(outweighs[900:])


def test_while_the_load_falls_only_shear_that_outweighs_the_fall_begins_a_tangential_load() -> None:
    (file,) = (one for one in shipped_detectors(SHIPPED) if one.name == "tangential")
    machine = UniversalMachine("cpu", "float64")
    black, white, drawn = np.ones((3, 3)), -np.ones((3, 3)), np.where(np.eye(3) > 0, 1.0, -1.0)

    def moving(what: str = "moving", **planes: np.ndarray) -> bool:
        given = dict.fromkeys(file.program.inputs, white) | {"contact": black} | planes
        return bool(machine.run(file.program, **given)[what])

    assert not moving()  # a steady grip
    assert moving(drawn_left=drawn)
    assert not moving(drawn_left=drawn, falling=black)
    assert not moving(drawn_left=drawn, falling=black, sheared=black)  # both may be noise
    assert moving(drawn_left=drawn, falling=black, outweighs=black)
    assert moving(drawn_left=drawn, falling=black, turning_back=black)
    rows = np.array([[1.0] * 3, [-1.0] * 3, [-1.0] * 3])
    around = {"drawn_right": rows, "drawn_left": rows[::-1]}
    assert moving("twisting", **around)
    assert not moving("twisting", **around, balanced=black)  # opposing signs that make no torque


def test_a_turn_is_told_before_the_grip_is_at_rest_and_a_pull_is_not() -> None:
    (file,) = (one for one in shipped_detectors(SHIPPED) if one.name == "tangential")
    machine = UniversalMachine("cpu", "float64")
    black, white = np.ones((3, 3)), -np.ones((3, 3))
    given = dict.fromkeys(file.program.inputs, white) | {"contact": black, "unsteady": black, "drawn_up": black}
    assert not machine.run(file.program, **given)["moving"]
    assert machine.run(file.program, **given | {"turning": black})["twisting"]
    assert not machine.run(file.program, **given | {"turning": black, "contact": white})["moving"]


@pytest.mark.skipif(not REAL.exists(), reason="the recordings lie beside the project, and are not here")
def test_a_hold_that_ends_slowly_has_no_tangential_load() -> None:
    source = open_source(REAL / "grasp_release_30degree_0offset_23-15-57.npz")
    log = EventLog()
    run(source, Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    onsets = [event.t for event in log.events if event.finger == "sensor-1" and event.kind == "tangential_load"]
    assert not [t for t in onsets if 0.95 < t < 4.479]  # half a second after the peak; opens
