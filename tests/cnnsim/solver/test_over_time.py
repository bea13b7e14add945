"""States over time to an accuracy, against a wave on a torus that decays by a known exponential."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, InputError, Template, run, run_transient, trajectory

SIDE, ALONG = 12, 2 * np.pi * 2 / 12
HEAT = Template([[0.1, 0.15, 0.1], [0.15, 0, 0.15], [0.1, 0.15, 0.1]])
RATE = -1 + 0.3 + 0.3 * np.cos(ALONG) + 0.4 * np.cos(ALONG)
WAVE = 0.9 * np.tile(np.cos(ALONG * np.arange(SIDE)), (SIDE, 1))


def truth(t: np.ndarray) -> np.ndarray:
    return np.exp(RATE * t)[:, None, None] * WAVE


@pytest.mark.parametrize("accuracy", [1e-3, 1e-9])
def test_recorded_states_are_within_the_accuracy(accuracy: float) -> None:
    times = np.array([0.0, 0.37, 2.0, 5.0])
    found = run_transient(HEAT, state=WAVE, boundary=PERIODIC, duration=5.0, accuracy=accuracy, record=times)
    path = found.trajectory
    assert path is not None
    assert path.t.tolist() == times.tolist()
    assert np.abs(path.x - truth(times)).max() <= accuracy
    assert np.array_equal(path.x[-1], found.x)
    assert np.abs(path.x - truth(times)).max() <= max(found.error, 1e-15) * 2


def test_outputs_over_time_are_within_the_accuracy() -> None:
    """By the plan's own steps of 0.1 they would be 5.6e-3 off."""
    times, outputs = zip(
        *trajectory(HEAT, state=WAVE, boundary=PERIODIC, until=4.0, frames=3, accuracy=1e-6), strict=True
    )
    assert np.abs(np.array(outputs) - truth(np.array(times))).max() <= 1e-6


def test_delays_leave_whole_steps() -> None:
    frames = np.where(np.random.default_rng(1).random((3, 6, 7)) > 0.5, 1.0, -1.0)
    found = run("motion-right", frames, accuracy=1e-3, record=[0, 1.03])
    assert found.trajectory is not None
    step = found.plan.step
    assert found.trajectory.t[1] == pytest.approx(1.03, abs=0.1)
    assert round(found.trajectory.t[1] / step) * step == pytest.approx(found.trajectory.t[1])


def test_cells_have_no_steps_in_common() -> None:
    with pytest.raises(InputError, match="cells are recorded at every step"):
        run_transient(HEAT, state=WAVE, duration=1.0, accuracy=1e-3, record=[(0, 0)])
    with pytest.raises(InputError, match="time 3 after the end of the run; 0 to 1 wanted"):
        run_transient(HEAT, state=WAVE, duration=1.0, accuracy=1e-3, record=[3.0])


@pytest.mark.parametrize("duration", [2.0, "settled"])
def test_numbers_given_in_float32_are_computed_with_as_finely(duration: Any) -> None:
    """The drive B*u + z of such planes is no sum in float32: 0.1 has no number there."""
    rng = np.random.default_rng(5)
    planes: dict[str, Any] = {
        name: rng.uniform(-1, 1, (9, 11)).astype(np.float32) for name in ("state", "input", "bias")
    }
    template = Template(
        [[0.1, 0.6, -0.2], [-0.4, 1.6, 0.8], [0.3, -0.5, 0.2]],
        [[0.0, 0.3, 0.0], [1.0, -0.2, 0.4], [0.0, 0.0, 0.0]],
        0.1,
    )
    finely: dict[str, Any] = {name: plane.astype(np.float64) for name, plane in planes.items()}
    short, long = (run_transient(template, **of, duration=duration, accuracy=1e-9) for of in (planes, finely))
    assert np.array_equal(short.x, long.x)
