"""The cover of bumps: loads shared, the matrix against the elements, the cache, finite strain, scenes."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.bump import response, table
from tactile.bump.body import Body
from tactile.bump.kinematics import PRESSED
from tactile.bump.law import Mixed
from tactile.bump.mesh import half_section
from tactile.bump.probe import Probe
from tactile.bump.response import finite_strain, small_strain
from tactile.bump.shape import Shape
from tactile.bump.touch import lower
from tactile.core.frame import TaxelArray
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import Medium
from tactile.simulator.bump_cover import Bumps, shared
from tactile.simulator.contacts.loads import Loads, point_loads
from tactile.simulator.explain import explain
from tactile.simulator.scene_file.file import scene_from
from tests.kits.paths import ROOT

SCENE: dict[str, Any] = tomllib.loads((ROOT / "examples" / "scenes" / "bump.toml").read_text(encoding="utf-8"))
CHIP = TaxelArray("chip", 2, 2, 1.5e-3, 0.2e-3, (1e-3, 0.0))
COARSE = Shape(thickness=1e-3, reach=4e-3)


def made(table: str = "", **changes: Any) -> Any:
    parts = copy.deepcopy(SCENE)
    if table:
        parts[table] |= changes
    else:
        parts |= changes
    return scene_from(parts, "here")


def loads_of(*rows: tuple[float, ...]) -> Loads:
    return point_loads(np.array(rows, dtype=float))


def test_loads_are_shared_without_loss() -> None:
    array, random = TaxelArray("a", 3, 4, 1e-3, 2e-4, (2e-3, -1e-3)), np.random.default_rng(0)
    at = array.positions().reshape(-1, 2)
    low, high = at.min(axis=0), at.max(axis=0)
    loads = np.concatenate([random.uniform(low, high, (20, 7, 2)), random.normal(size=(20, 7, 3))], axis=-1)
    forces = shared(loads, array)
    assert forces.sum(axis=1) == pytest.approx(loads[..., 2:].sum(axis=1))
    for k in (0, 1):  # moments too
        got, wanted = (at[:, k] * forces[..., 2]).sum(axis=1), (loads[..., k] * loads[..., 4]).sum(axis=1)
        assert got == pytest.approx(wanted, abs=1e-15)
    on = np.zeros((1, 1, 5))
    on[0, 0] = *at[5], 1, 2, 3
    assert shared(on, array)[0, 5] == pytest.approx((1, 2, 3))
    on[0, 0, :2] = 1.0, 1.0  # far away: the corner's
    assert shared(on, array)[0, -1] == pytest.approx((1, 2, 3))
    single = TaxelArray("one", 1, 1, 1e-3, 2e-4)
    assert shared(on, single)[0, 0] == pytest.approx((1, 2, 3))


@pytest.mark.parametrize("quantity", ("strain", "stress"))
def test_the_matrix_is_the_elements(quantity: Any) -> None:
    medium, bumps = Medium(0.87e6, quantity=quantity), Bumps(Shape(thickness=1e-3))
    close, load = TaxelArray("close", 2, 2, 0.5e-3, 0.2e-3, (1e-3, 0.0)), (0.75e-3, -0.25e-3, 0.003, 0.004, 0.005)
    felt = bumps.readings(close, medium, loads_of(load))[0]
    # straight from elements on a mesh of another size, at the distances at hand
    radii = np.array([0.0, 0.5e-3])
    own = small_strain(Shape(thickness=1e-3, reach=6e-3), Medium(0.87e6, 0.499, quantity), 0.2e-3, radii, 1.5)
    (q, r, f), (zz, even, odd) = load[2:], own.shear[0].T
    under = q * even[0], r * even[0], f * own.normal[0, 0, 0]
    normal, along = own.normal[0, 1]
    right = q * (even[1] - odd[1]) + f * along, r * (even[1] + odd[1]), q * zz[1] + f * normal
    below = q * (even[1] + odd[1]), r * (even[1] - odd[1]) + f * along, r * zz[1] + f * normal
    for got, wanted in ((felt[0, 0], under), (felt[0, 1], right), (felt[1, 0], below)):
        assert got == pytest.approx(wanted, abs=0.01 * np.abs(wanted).max())
    again = bumps.readings(close, Medium(0.435e6, quantity=quantity), loads_of(load))[0]
    assert again == pytest.approx(felt * (2 if quantity == "strain" else 1), rel=1e-12)


def test_the_cover_is_linear_and_symmetric() -> None:
    medium, bumps = Medium(0.87e6), Bumps(Shape(thickness=1e-3))
    array = TaxelArray("s", 2, 2, 1.5e-3, 0.2e-3)
    corners = array.positions().reshape(-1, 2)
    one = bumps.readings(array, medium, loads_of((*corners[0], 0, 0, 1e-3)))[0]
    assert one[0, 0, 2] < 0
    assert not one[0, 0, :2].any()  # no cross-talk under the bump
    sheared = bumps.readings(array, medium, loads_of((*corners[0], 1e-3, 0, 0)))[0]
    assert sheared[0, 0, 2] == 0
    other = bumps.readings(array, medium, loads_of((*corners[0], 0, 1e-3, 0)))[0]
    assert other == pytest.approx(sheared.swapaxes(0, 1)[..., [1, 0, 2]], abs=1e-12)
    mirrored = bumps.readings(array, medium, loads_of((*corners[1], -1e-3, 0, 0)))[0]
    assert mirrored == pytest.approx(sheared[:, ::-1] * (-1, 1, 1), abs=1e-12)
    both = bumps.readings(array, medium, loads_of((*corners[0], 1e-3, 0, 1e-3)))[0]
    assert both == pytest.approx(one + sheared, abs=1e-15)
    assert not bumps.readings(array, medium, loads_of((0, 0, 0, 0, 0))).any()
    with pytest.raises(InputError, match="a twisted contact"):
        bumps.readings(array, medium, Loads(*([np.zeros((1, 0, 5))] * 2), np.zeros(0, np.int64), (), (None,)))  # type: ignore[arg-type, call-arg]


def test_what_was_computed_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setattr(table, "folder", lambda: tmp_path / "new" / "folder")
    calls: list[float] = []

    def counted(shape: Shape, medium: Medium, depth: float, radii: Floats) -> table.Response:
        calls.append(depth)
        return small_strain(shape, medium, depth, radii, 0.4)

    monkeypatch.setattr(response, "small_strain", counted)
    bumps = Bumps(Shape(thickness=1e-3))
    first = bumps.response(CHIP, "strain")
    again = Bumps(Shape(thickness=1e-3)).response(CHIP, "strain")
    assert len(calls) == 1
    for name in vars(first):
        assert np.array_equal(getattr(first, name), getattr(again, name), equal_nan=True)
    Bumps(Shape(thickness=1e-3), nu=0.4).response(CHIP, "strain")  # another bump: computed
    bumps.response(CHIP, "stress")
    assert len(calls) == 3
    for kept in (tmp_path / "new" / "folder").iterdir():
        kept.write_bytes(kept.read_bytes()[:100])  # half written by someone else
    bumps.response(CHIP, "strain")
    assert len(calls) == 4
    monkeypatch.setattr(table, "VERSION", 99)
    bumps.response(CHIP, "strain")
    assert len(calls) == 5
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setattr(table, "folder", lambda: blocked / "below")
    bumps.response(CHIP, "strain")  # nowhere to keep it: computed all the same
    assert len(calls) == 6
    assert capsys.readouterr().err.count("finite elements, once") == 6


@pytest.fixture(scope="module")
def finite() -> table.Response:
    radii = np.array([0.0, 0.2e-3, 1.5e-3])
    return finite_strain(Shape(thickness=1e-3, reach=3e-3, contact=2e-5), Medium(1.0, 0.49), 0.2e-3, radii, 6e-5, 0.45)


def test_a_table_of_finite_strain(finite: table.Response, monkeypatch: pytest.MonkeyPatch) -> None:
    assert (np.diff(finite.forces) > 0).all()
    assert finite.indentations == pytest.approx(np.linspace(0, 6e-5, 9))
    assert not finite.normal[0].any()
    assert (np.diff(finite.normal[:, 0, 0]) < 0).all()
    monkeypatch.setattr("tactile.simulator.bump_cover.remembered", lambda key, make: finite)
    bumps, array = Bumps(Shape(thickness=1e-3), 0.49, 6e-5), TaxelArray("one", 1, 1, 1e-3, 0.2e-3)
    medium = Medium(2e6)
    knots = finite.forces * 2e6
    rows = [(0, 0, 1e-4, 0, force) for force in knots]
    felt = bumps.readings(array, medium, loads_of(*rows))[:, 0, 0]
    assert felt[:, 2] == pytest.approx(finite.normal[:, 0, 0], abs=1e-12)
    assert felt[:, 0] == pytest.approx(1e-4 / 2e6 * finite.shear[:, 0, 1], rel=1e-9)
    between = bumps.readings(array, medium, loads_of((0, 0, 0, 0, (knots[4] + knots[5]) / 2)))[0, 0, 0, 2]
    assert finite.normal[5, 0, 0] < between < finite.normal[4, 0, 0]
    for force in (knots[-1] * 1.01, -1e-3):
        with pytest.raises(InputError, match=r"the table of finite strain ends at 60 um"):
            bumps.readings(array, medium, loads_of((0, 0, 0, 0, force)))


def test_a_finite_table_begins_like_a_small_one(finite: table.Response) -> None:
    shape = Shape(thickness=1e-3, reach=3e-3, contact=2e-5)
    body = Body(half_section(shape, 0.45, True), PRESSED, Mixed(Medium(1.0, 0.49)))
    last = list(lower(body, shape, finite.indentations[1] * np.arange(1, 6) / 5, False))[-1]
    assert finite.forces[1] == pytest.approx(last.force, rel=0.03)
    strain = Probe(body, np.array([[0.0, 0.2e-3]])).strain(last.state)
    assert finite.normal[1, 0, 0] == pytest.approx(strain[0, 2, 2], rel=0.03)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "bumps"}, r"\[cover\]: kind = 'bumps', 'flat' or 'bump'"),
        ({"kind": "flat"}, r"\[cover\]: unknown keys 'diameter_mm', 'thickness_mm'"),
        ({"diametre_mm": 1}, "did you mean 'diameter_mm'"),
        ({"diameter_mm": -1}, "diameter_mm = -1.0, a positive"),
        ({"poissons_ratio": 0.6}, "Poisson's ratio 0.6"),
        ({"contact_mm": 0.3}, "a contact below 0.95"),
        ({"strain": "large"}, "strain = 'large', 'small' or 'finite'"),
        ({"strain": "finite"}, "a contact_mm with strain = 'finite'"),
        ({"indentation_mm": 0.1}, "an indentation_mm without strain = 'finite'"),
        ({"thickness_mm": 0.1}, "taxels 0.2 mm deep under bumps on 0.1 mm"),
        ({"diameter_mm": 1.6}, "bumps 1.838 mm wide|a fillet|mm apart"),
    ],
)
def test_wrong_covers_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        made("cover", **changes)
    assert str(caught.value).startswith("here: [cover]")


def test_effects_of_the_flat_cover_are_refused() -> None:
    with pytest.raises(InputError, match="poisson_ratio on bumps"):
        made(effect={"poisson_ratio": {}, "read_noise": {}})
    with pytest.raises(InputError, match=r"indentation 0.0002 m"):
        Bumps(Shape(), 0.4, 0.2e-3)
    with pytest.raises(InputError, match="read stress"):
        finite_strain(COARSE, Medium(1.0, 0.4, "stress"), 1e-4, np.zeros(1), 1e-5)
    for depth, radii in ((2e-3, np.zeros(1)), (1e-4, np.array([5e-3]))):
        with pytest.raises(InputError, match="taxels"):
            small_strain(COARSE, Medium(1.0), depth, radii)


def test_a_scene_of_bumps_is_explained() -> None:
    told = explain(made())
    assert {part.name: part.what for part in told.parts}["field"].startswith("bumps 0.4 mm wide on 2 mm")
    assert any("against the flat cover" in note for note in told.notes)
    assert "finite_thickness" not in {part.name for part in told.parts}
    chosen = made(effects="auto", tolerance=0.02, effect={"read_noise": {"rms": 1e-6}, "viscoelastic": {}})
    assert [name for name, _ in chosen.effects] == ["viscoelastic"]


def test_finite_strain_takes_the_middle_of_its_table(finite: table.Response, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tactile.simulator.bump_cover.remembered", lambda key, make: finite)
    array = TaxelArray("one", 1, 1, 1e-3, 0.2e-3)
    factor = Bumps(Shape(thickness=1e-3), 0.49, 6e-5).over_flat(array, "strain")
    secants = finite.normal[1:, 0, 0] / finite.forces[1:]
    assert point_load(np.zeros(2), 0.2e-3, [(0, 0, 0, 0, 1.0)], Medium(1.0))[2] / secants == pytest.approx(
        factor, rel=0.05
    )
