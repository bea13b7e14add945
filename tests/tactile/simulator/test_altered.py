"""Values with other fields, made without a look at them."""

from dataclasses import replace

import numpy as np
import pytest

from tactile.simulator.altered import altered
from tests.kits.touch.random_scenes import needle


def test_what_is_altered_is_as_replaced_and_keeps_nothing_that_was_computed() -> None:
    field = needle().skin.field(0, np.arange(4) / 100)
    computed = field.values
    other = altered(field, accuracy=1e-3)
    assert other == replace(field, accuracy=1e-3)
    assert vars(other).keys() == vars(replace(field, accuracy=1e-3)).keys()
    assert np.array_equal(other.values, computed)
    with pytest.raises(TypeError, match="Field without acuracy"):
        altered(field, acuracy=1e-3)
