"""Cells that compare their own state with inputs: their exact flow is where ever shorter Euler steps lead."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Table, Template, Term, fixed, library, run_transient
from cnnsim.library.catalogue import run_example
from tests.benchmarks.accuracy.library_signs import large

STEP = 1e-3


def euler(given: dict[str, Any], term: Term, until: float) -> Any:
    """The definition, by steps so short that chatter and error are of their size: x' = -x + a y + w + sum w_k f."""
    template, x, u, bias = given["template"], given["state"].copy(), given["input"], given["bias"]
    constant = getattr(given["boundary"], "u", 0.0)
    mode: Any = {"zero-flux": "edge", "periodic": "wrap"}.get(given["boundary"].kind, "constant")
    around = np.pad(u, 1, mode, **({"constant_values": constant} if mode == "constant" else {}))
    rows, cols = x.shape
    near = [(w, around[1 + k : 1 + k + rows, 1 + l : 1 + l + cols]) for k, l, w in term.taps]
    assert term.table is not None
    drive = template.z + bias + template.B[1, 1] * u
    for _ in range(round(until / STEP)):
        pull = sum(w * term.table(v - x) for w, v in near)
        x = np.where(given["mask"] > 0, x, x + STEP * (template.self_feedback * x.clip(-1, 1) - x + drive + pull))
    return x


@pytest.mark.parametrize("seed", range(6))
def test_it_is_where_short_steps_lead(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape, tables = (7, 9), [Table("step", (0.0,), (-1.0, 1.0)), Table("step", (-0.2, 0.3), (0.4, -1.0, 1.5), "left")]
    term = Term(
        0.5 * (rng.random((3, 3)) < 0.7) * rng.choice([1.0, 1.0, -0.4], (3, 3)), "u_kl - x_ij", tables[seed % 2]
    )
    A, B = np.zeros((3, 3)), np.zeros((3, 3))
    A[1, 1], B[1, 1] = rng.choice([0.0, 0.5, 1.0, 1.6]), 0.3
    boundary = (ZERO_FLUX, PERIODIC, fixed(0.1))[seed % 3]
    given: dict[str, Any] = {
        "template": Template(A, B, z=float(rng.normal()), terms=[term]), "state": 1.5 * rng.uniform(-1, 1, shape),
        "input": rng.uniform(-1, 1, shape), "bias": 0.3 * rng.normal(size=shape), "boundary": boundary,
        "mask": (rng.random(shape) < 0.1).astype(float),
    }  # fmt: skip
    for until in (0.5, 4.0):
        found = run_transient(**given, duration=until, accuracy="exact", dtype="float64")
        assert "from jump to jump" in found.how
        away = np.abs(found.x - euler(given, term, until))
        away[tuple(found.undecided.T)] = 0
        assert np.percentile(away, 95) < 10 * STEP  # a cell that passes near a ridge keeps what the steps do to it
        assert away.max() < 0.2


def test_a_rank_is_found_exactly_and_faster_than_by_steps() -> None:
    for name, rank in (("gray-erosion", 0), ("gray-dilation", -1)):
        entry = library.load(name)
        example = large(entry.examples[0], 12)
        u = example.input
        found = run_example(entry, example, accuracy="binary", dtype="float64")
        assert u is not None
        around = np.pad(u, 1, "edge")
        near = [around[i : i + 12, j : j + 12] for i in range(3) for j in range(3)]
        np.testing.assert_allclose(found.y, np.sort(near, axis=0)[rank], atol=1e-12)
        assert not len(found.undecided)


def test_a_start_on_a_ridge_is_named() -> None:
    term = Term([[1.0]], "u_kl - x_ij", Table("step", (0.0,), (1.0, -1.0)))  # drives off to both sides
    u = np.array([[0.2, -0.4, 0.5]])
    found = run_transient(
        Template(1.0, terms=[term]), state=np.array([[0.2, -0.3, 0.4]]), input=u, duration=3.0, accuracy="binary"
    )  # fmt: skip
    assert found.undecided.tolist() == [[0, 0]]
    assert found.y.tolist() == [[1.0, 1.0, -1.0]]


def test_a_settled_one_rests_at_a_place_or_where_its_drive_is_zero() -> None:
    term = Term([[0.5]], "u_kl - x_ij", Table("step", (0.0,), (-1.0, 1.0)))
    u = np.array([[0.3, 0.9, -0.2]])
    found = run_transient(
        Template(0.0, terms=[term]), state=np.zeros((1, 3)), input=u, accuracy=1e-6, duration="settled"
    )  # fmt: skip
    np.testing.assert_allclose(found.x, [[0.3, 0.5, -0.2]], atol=1e-12)  # x = 0.5 of f(u - x) = 1 comes before 0.9
    assert found.settled
