"""Tables of loads over circles: as accurate as they say, as wide as their circles, and no finer than that takes."""

import numpy as np
import pytest

from tactile.elastic.disc_loops import add_discs
from tactile.elastic.disc_table import disc_table, table_size
from tactile.elastic.discs import disc_load
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tests.oracles.elastic.layer import layer_load


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_tables_keep_their_accuracy_under_the_load_at_the_rim_and_at_the_largest_radius(accuracy: float) -> None:
    medium, widest = Medium(1.0), 3.6  # the largest of the table of size 2, nearly
    table = disc_table(1.0, float(table_size(np.array([widest]), 1.0, HERTZ, np.inf).max()), HERTZ, np.inf, medium,
                       accuracy)  # fmt: skip
    rng = np.random.default_rng(2)
    for radius in (0.0, 0.1, 0.9, 2.0, widest):
        x = np.concatenate([[0.0, 1e-5, 1e-3, 0.01], radius + rng.uniform(-1, 1, 60), rng.uniform(0, 8, 20)])
        at = np.stack([x, 0.3 * rng.uniform(-1, 1, x.size) * (np.arange(x.size) > 3)], axis=-1)
        for force in ((0, 0, 1.0), (1.0, 0.5, 0.0)):
            load = np.array([[[0.0, 0.0, *force]]])
            found = np.zeros((1, x.size, 3))
            add_discs(found, at, 1.0, load, np.full((1, 1), radius), table, medium)
            known = disc_load(at, 1.0, load[:, None], np.full((1, 1, 1), radius), HERTZ, medium)
            assert np.abs(found - known).max() < accuracy * np.abs(known).max()


def test_beside_the_load_a_table_is_as_accurate_as_what_is_felt_there() -> None:
    medium = Medium(1.0, 0.3, "stress", 1.05)
    table = disc_table(1.0, 0.0, HERTZ, np.inf, medium, 1e-6)
    at = np.array([[2.2, 0.3], [0.4, -2.5], [2.0, 2.0]])
    load, found = np.array([[[0.0, 0.0, 0.3, -0.2, 1.0]]]), np.zeros((1, 3, 3))
    add_discs(found, at, 1.0, load, np.zeros((1, 1)), table, medium)
    known = layer_load(at, 1.0, load[0], 1.05, medium)
    assert np.abs(found[0] - known).max() < 1e-6 * np.abs(known).max()
