"""The half-space at any Poisson's ratio: against displacements, Tamaas, equilibrium, symmetries and hard cases."""

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load, point_load_strain
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.elastic.sums.direct import direct_sum
from tactile.elastic.sums.spectral import TractionTransform
from tests.oracles.elastic.boussinesq import strain_tensor
from tests.oracles.elastic.layer import periodic_field

NUS = (0.0, 1e-12, 0.2, 0.45, 0.5 - 1e-12, 0.5)
random = np.random.default_rng(7)


def some_loads(*shape: int, reach: float = 1e-3) -> NDArray[np.float64]:
    return np.concatenate([random.uniform(-reach, reach, (*shape, 2)), random.uniform(-1, 1, (*shape, 3))], axis=-1)


@pytest.mark.parametrize("nu", NUS)
def test_strain_is_the_symmetric_gradient_of_the_displacement(nu: float) -> None:
    for at, load in zip(random.uniform(-8e-4, 8e-4, (12, 2)), some_loads(12), strict=True):
        tensor = strain_tensor((at[0] - load[0], at[1] - load[1], 2e-4), tuple(load[2:]), 2.4e6, nu)
        got = point_load_strain(at, 2e-4, [load], 2.4e6, nu)
        assert np.abs(got - tensor[:, 2]).max() < 1e-12 * np.abs(tensor).max()


@pytest.mark.parametrize("nu", (0.0, 0.3, 0.49))
def test_tamaas_gives_the_same_gradients(nu: float) -> None:
    tamaas = pytest.importorskip("tamaas", reason="Tamaas is not installed: pip install tamaas")
    tamaas.set_log_level(tamaas.LogLevel.error)
    count, layers, height = 48, 9, 0.25
    model = tamaas.Model(tamaas.model_type.volume_2d, [height, 1.0, 1.0], [layers, count, count])
    model.E, model.nu = 2.0, nu
    tamaas.ModelFactory.registerVolumeOperators(model)
    x, y = np.meshgrid(*2 * (np.arange(count) / count - 0.5,))
    traction = np.exp(-(x**2 + 2 * y**2 + x * y) / 2 / 0.06**2)[..., None] * (0.3, -0.2, 0.5)
    strain = np.zeros((layers, count, count, 6))
    model.operators["boussinesq_gradient"](np.ascontiguousarray(np.swapaxes(traction, 0, 1)), strain)
    # theirs: x first, components xx yy zz xy xz yz with shear times sqrt(2); the mean is free in a periodic cell
    for layer in (2, 4, 8):
        theirs = np.swapaxes(strain[layer], 0, 1)[..., [4, 5, 2]] / (np.sqrt(2), np.sqrt(2), 1)
        ours = periodic_field(traction, 1 / count, layer * height / (layers - 1), np.inf, Medium(2.0, nu))
        gap = (theirs - theirs.mean((0, 1))) - (ours - ours.mean((0, 1)))
        assert np.abs(gap).max() < 1e-12 * np.abs(ours).max()  # 0.1 % was asked for


def test_a_smooth_map_in_space_is_the_same_map_in_waves() -> None:
    # ties the closed form to Tamaas: pulled and pressed equally, so that the images of the periodic cell hardly count
    count, pitch = 256, 0.05
    x, y = np.meshgrid(*2 * ((np.arange(count) - count / 2) * pitch,))
    bump = np.exp(-((x - 0.2) ** 2 + y**2) / 2 / 0.3**2) - np.exp(-((x + 0.2) ** 2 + y**2) / 2 / 0.3**2)
    traction = bump[..., None] * (0.3, -0.2, 0.5)
    medium = Medium(2.0, 0.3)
    waves = periodic_field(traction, pitch, 0.4, np.inf, medium)
    space = TractionTransform((count, count), (count, count), pitch, 0.4, medium)(traction)
    assert np.abs(waves - space).max() < 1e-3 * np.abs(space).max()


@pytest.mark.parametrize("quantity", ("strain", "stress"))
@pytest.mark.parametrize("nu", (0.0, 0.3, 0.5))
def test_the_compiled_sum_is_the_reference(quantity: FieldQuantity, nu: float) -> None:
    medium = Medium(2.4e6, nu, quantity)
    for shape, frames, count in (((8, 8), 40, 1), ((3, 5), 7, 20), ((1, 300), 4, 3), ((2, 2), 3, 1000), ((2,), 0, 4)):
        at, loads = random.uniform(-1e-3, 1e-3, (*shape, 2)), some_loads(frames, count)
        wanted = point_load(at, 4e-4, loads.reshape(frames, *(1,) * len(shape), count, 5), medium)
        got = direct_sum(at, 4e-4, loads, medium)
        assert got.shape == wanted.shape
        assert np.abs(got - wanted).max(initial=0) <= 1e-13 * np.abs(wanted).max(initial=0)


def test_reciprocity() -> None:
    # component i of the traction on a plane from a load along j is component j from a load along i
    at = random.uniform(-1, 1, (20, 2))
    unit = np.zeros((3, 1, 5))
    unit[range(3), 0, range(2, 5)] = 1
    felt = np.stack([point_load(at, 0.3, load, Medium(1.0, quantity="stress")) for load in unit], axis=-1)
    assert np.abs(felt - np.swapaxes(felt, -1, -2)).max() < 1e-14 * np.abs(felt).max()


@pytest.mark.parametrize("force", (1e-12, 1e6))
@pytest.mark.parametrize("depth", (1e-100, 1e-9, 2e-4, 1e3))
def test_extreme_forces_and_depths_on_the_axis_and_beside_it(depth: float, force: float) -> None:
    loads = np.array([[[0.0, 0.0, 0.0, 0.0, force]]])
    for felt in (direct_sum, lambda *given: point_load(given[0], given[1], given[2][:, None], given[3])):
        on, beside = felt(np.array([[0.0, 0.0], [1e-3, 0.0]]), depth, loads, Medium(1.0))[0]
        assert on[2] == pytest.approx(-3 * force / (2 * np.pi) / depth / depth, rel=1e-12)
        assert on[:2].tolist() == [0, 0]
        assert np.isfinite(beside).all()


def test_no_force_no_strain_and_what_is_no_number_is_refused() -> None:
    assert not direct_sum(np.zeros((2, 2)), 1e-3, np.zeros((3, 4, 5)), Medium(1.0)).any()
    assert direct_sum(np.zeros((2, 2)), 1e-3, np.zeros((3, 0, 5)), Medium(1.0)).tolist() == np.zeros((3, 2, 3)).tolist()
    with pytest.raises(InputError, match="overflows"):
        point_load_strain((0, 0), 1e-160, [(0, 0, 0, 0, 1)], 1.0)
    with pytest.raises(InputError, match=r"load \[0, 1\] is not finite"):
        direct_sum(np.zeros((2, 2)), 1.0, np.array([[[0, 0, 0, 0, 1], [0, 0, 0, 0, np.nan]]]), Medium(1.0))
    with pytest.raises(InputError, match=r"\(frames, n, 5\)"):
        direct_sum(np.zeros((2, 2)), 1.0, np.zeros((2, 5)), Medium(1.0))
    for wrong, message in ((-0.1, "Poisson"), (0.51, "0 to 0.5"), (np.nan, "ratio nan")):
        with pytest.raises(InputError, match=message):
            point_load_strain((0, 0), 1.0, [(0, 0, 0, 0, 1)], 1.0, wrong)
    with pytest.raises(InputError, match="quantity"):
        Medium(1.0, quantity="force")  # type: ignore[arg-type]  # that is the point
