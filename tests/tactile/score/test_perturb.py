"""`tactile score --perturb`: perturbations of recordings, and the table of the score under them."""

import json
from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream
from tactile.score import perturb
from tactile.score.perturb import ALL, Readings, chosen_perturbations, perturbed
from tests.kits.serial import call

RNG = np.random.default_rng(1)
T = np.arange(400) / 200
HELD = np.clip(np.minimum(T - 0.3, 1.7 - T) / 0.1, 0, 1)[:, None, None, None] * (0.2, 0.1, 2.0)
VALUES = HELD * np.ones((1, 2, 3, 1)) + 1e-3 * RNG.standard_normal((400, 2, 3, 3))
READ = Readings(T, VALUES, np.ones((400, 2, 3), bool))


def changed(change: perturb.Change) -> Readings:
    return change(READ, 1.0, np.random.default_rng(0))


def test_perturbations_of_values() -> None:
    x, y, normal = np.moveaxis(READ.values, -1, 0)
    assert np.array_equal(changed(perturb.rotation(90)).values, np.stack([-y, x, normal], -1))
    both = changed(perturb.rotation(45)).values
    assert both[..., :2] == pytest.approx(np.stack([x - y, x + y], -1) / np.sqrt(2))
    assert np.array_equal(changed(perturb.mirror).values[:, :, 0], READ.values[:, :, 2] * (-1, 1, 1))
    assert changed(perturb.steps(0.05)).values / 0.05 == pytest.approx(np.round(READ.values / 0.05))
    assert np.array_equal(changed(perturb.gain(10)).values, 10 * READ.values)
    frozen = changed(perturb.frozen).values
    stuck = np.flatnonzero((frozen[-1] == frozen[200]).all(-1).ravel())
    assert len(stuck) == 1
    assert np.array_equal(frozen[:150], READ.values[:150])
    assert np.diff(changed(perturb.drift(0.1)).values - READ.values, axis=0) == pytest.approx(0.1 / 200)
    assert np.abs(changed(perturb.sway).values - READ.values).max() == pytest.approx(0.05)
    assert (changed(perturb.noise(0.01)).values - READ.values).std() == pytest.approx(0.01, rel=0.05)
    spiked = changed(perturb.spikes).values != READ.values
    assert 0 < spiked.mean() < 3e-3


def test_perturbations_of_times() -> None:
    """Lost frames keep their order; a lower rate keeps frames, a higher one interpolates."""
    assert changed(perturb.tempo(4)).t == pytest.approx(T / 4)
    lost = changed(perturb.lost)
    assert 150 < len(lost.t) < 250
    assert np.array_equal(lost.values, READ.values[np.searchsorted(T, lost.t)])
    assert np.diff(changed(perturb.gaps).t).max() == pytest.approx(0.155)
    assert len(set(changed(perturb.blocks).t)) == 41
    repeated = changed(perturb.repeated).values
    assert np.array_equal(repeated[3], READ.values[0])
    slow, fast = changed(perturb.rate(50)), changed(perturb.rate(1000))
    assert slow.values == pytest.approx(READ.values[::4][: len(slow.t)])
    assert fast.values[2] == pytest.approx(0.6 * READ.values[0] + 0.4 * READ.values[1])


def test_a_source_is_perturbed_by_every_change_and_unknown_groups_are_refused() -> None:
    array = TaxelArray("pad", 2, 3, 2e-3, 0.0, quantity="force")
    frames = [Frame(0, t, n, READ.values[n], READ.valid[n]) for n, t in enumerate(T.tolist())]
    source = FrameStream("held", (array,), None, len(frames), frames)
    for how in ALL:
        times = [frame.t for frame in perturbed(source, how)]
        assert times == sorted(times)
    groups = [one.group for one in chosen_perturbations("mirror, rotation")]
    assert groups == ["unchanged", "rotation", "rotation", "mirror"]
    with pytest.raises(InputError, match="perturbation wind; all, or some of steps, tempo"):
        chosen_perturbations("wind")


def test_the_command_scores_perturbed_grasps_and_names_missing_recordings(tmp_path: Path) -> None:
    done = call("score", "--grasps", "1", "--from-seed", "8", "--perturb", "gain", "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)["perturbations"]
    assert list(found) == ["unchanged", "gain x 0.01", "gain x 0.1", "gain x 10", "gain x 100"]
    assert found["gain x 10"]["kinds"]["contact"]["hit"] == 1
    assert "--perturb is of labelled" in call("score", "--idle-minutes", "1", "--perturb").output
    (tmp_path / "l.csv").write_text("recording,sensor,contact_s\nnone,0,1.0\n")
    refused = call("score", tmp_path, "--labels", tmp_path / "l.csv")
    assert refused.exit_code == 2
    assert "no recording of the labels none" in refused.output
