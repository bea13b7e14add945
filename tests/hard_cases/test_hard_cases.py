"""Every hard case on every backend and dtype: within its bound or refused; the naive form fails if the case says so."""

import numpy as np
import pytest

from cnnsim import InputError
from cnnsim.backends.base import Backend
from tests.hard_cases import FAMILIES
from tests.hard_cases.case import HardCase

CASES = [
    pytest.param(case, id=f"{family}: {case.name}")
    for family, cases in FAMILIES.items()
    for case in cases
    if not case.page
]


@pytest.mark.parametrize("case", CASES)
def test_ours_is_within_the_bound_or_refused(case: HardCase, backend: Backend) -> None:
    if case.slow and backend.name != "cpu":
        pytest.skip(f"{case.name} take more than seconds on the {backend.name} backend")
    if case.refused:
        with pytest.raises(InputError, match=case.refused):
            case.ours(backend)
        return
    bound = case.bound if backend.dtype == "float64" else case.bound32
    assert np.abs(case.ours(backend) - case.truth(backend)).max() <= bound


@pytest.mark.parametrize("case", [case for case in CASES if case.values[0].naive is not None])  # type: ignore[union-attr]  # a HardCase
def test_the_naive_form_fails_where_that_is_said(case: HardCase) -> None:
    assert case.naive is not None
    assert case.exact is not None
    with np.errstate(all="ignore"):
        off = np.abs(case.naive() - case.exact()).max()
    assert (not off <= case.bound) == case.naive_fails
