"""Round bodies on a layer: against the layer's own surface displacement, published series and the half-space."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.special import j0, j1

from cnnsim.support import InputError
from tactile.elastic.layer_contact import WIDEST, Body, layer_contact
from tactile.elastic.layer_surface import excess
from tactile.elastic.lines import line_indentation
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import hertz_force, hertz_radius, punch_force
from tactile.simulator.contacts.indenter import Indenter


def compliance(k: float, nu: float) -> float:
    """Displacement of a layer's surface over the half-space's under a wave, from the equations as a system in z."""
    lam, g = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    m = lam + 2 * g
    system = np.array(
        [[0, -k, 1 / g, 0], [lam * k / m, 0, 0, 1 / m], [k * k * (m - lam**2 / m), 0, 0, -k * lam / m], [0, 0, k, 0]]
    )
    through = expm(system)
    sunk = np.linalg.solve(through[:2, :2], -through[:2, 2:] @ (0, -1.0))[1]
    return float(sunk * k / (2 * (1 - nu**2)))


@pytest.mark.parametrize("nu", (0.0, 0.3, 0.49))
def test_a_wave_sinks_in_as_the_equations_say(nu: float) -> None:
    for k in (0.05, 0.5, 2.0, 6.0):
        assert 1 - excess(np.array(k), nu) == pytest.approx(compliance(k, nu), rel=1e-10)


def shape(body: Body, r: NDArray[np.float64]) -> NDArray[np.float64]:
    if body == "flat":
        return np.zeros_like(r)
    return r**2 / 2 if body == "paraboloid" else 2.0 - np.sqrt(4.0 - r**2)


@pytest.mark.parametrize(("body", "nu"), [("paraboloid", 0.5), ("paraboloid", 0.3), ("flat", 0.5), ("sphere", 0.5)])
@pytest.mark.parametrize("radius", (0.1, 0.8, 1.9))
def test_the_pressure_pushes_the_surface_onto_the_body(body: Body, nu: float, radius: float) -> None:
    law = layer_contact(body, nu, 2.0 if body == "sphere" else 1.0)
    force, depth = float(law.force(np.array(radius))), float(law.indentation(np.array(radius)))
    nodes, weights = np.polynomial.legendre.leggauss(400)
    theta = (nodes + 1) * np.pi / 4
    weight = law.profile.weight(theta, np.full(400, radius)) * weights * np.pi / 2
    assert weight.sum() == pytest.approx(1, abs=2e-5)
    # the half-space's share in closed form: a source at depth i t is felt inside where t < r; the layer's by its waves
    r = radius * np.array([0.0, 0.3, 0.6, 0.9])
    t = radius * np.sin(theta)
    # (1 / pi E*) integral of w / sqrt(r^2 - t^2) over |t| < r, by t = r sin(psi)
    psi = (nodes + 1) * np.pi / 4
    line = r[:, None] * np.sin(psi) / radius
    on_line = law.profile.weight(np.arcsin(line), np.full(line.shape, radius)) / np.sqrt(1 - line**2) / radius
    plain = force / np.pi * 2 * (on_line * weights * np.pi / 4).sum(1)
    # w(theta) is per angle: divided by a cos(theta) it is per length
    k, step = (nodes + 1) * 15, weights * 15
    spread = np.cos(np.outer(k, t)) @ weight
    less = force / np.pi * (j0(np.outer(r, k)) * excess(k, nu) * spread * step).sum(1)
    assert plain - less == pytest.approx(depth - shape(body, r), rel=3e-4, abs=1e-5 * depth)


def test_published_series_where_they_hold() -> None:
    law = layer_contact("paraboloid", 0.5)
    for x in (0.02, 0.05, 0.1, 0.2):
        radius = law.radius_of(np.array(x**2), "indentation")
        got = float(law.force(radius)) * 4 / 3  # E* = 4/3 E
        hertz = 16 / 9 * x**3
        dimitriadis = hertz * (1 + 1.133 * x + 1.283 * x**2 + 0.769 * x**3 + 0.0975 * x**4)
        garcia = hertz * (1 + 1.133 * x + 1.497 * x**2 + 1.469 * x**3 + 0.755 * x**4)
        assert got == pytest.approx(dimitriadis, rel=0.003 + 0.25 * x**2)
        assert got == pytest.approx(garcia, rel=0.002)


def test_a_thick_cover_is_the_half_space_and_a_thin_one_hard() -> None:
    ball, end, needle = Indenter("sphere", 5e-3), Indenter("flat_punch", 1e-3), Indenter("needle", 5e-4)
    thick, thin, plain = (Medium(2.4e6, thickness=h) for h in (10.0, 1.2e-3, np.inf))
    deep = np.array([0.0, 1e-6, 1e-4, 5e-4])
    for body in (ball, end, needle):
        assert body.force_at(deep, thick) == pytest.approx(body.force_at(deep, plain), rel=3e-4)
        forces = body.force_at(deep, thin)
        assert body.indentation(forces, thin) == pytest.approx(deep, rel=1e-9, abs=1e-15)
        assert (forces[2:] > 1.2 * body.force_at(deep, plain)[2:]).all()
        assert body.contact_radius(forces, thick) == pytest.approx(body.contact_radius(forces, plain), rel=1e-3)
    assert ball.force_at(deep, thin)[3] / hertz_force(5e-4, 5e-3, 3.2e6) == pytest.approx(8.118, rel=1e-3)
    assert end.force_at(deep, plain)[2] == pytest.approx(float(punch_force(1e-4, 1e-3, 3.2e6)))
    assert ball.contact_radius(np.array([0.5]), thin)[0] < 0.96 * hertz_radius(0.5, 5e-3, 3.2e6)


def test_what_goes_through_the_cover_is_refused() -> None:
    thin = Medium(2.4e6, thickness=1.2e-3)
    with pytest.raises(InputError, match=r"sinks 3 mm into a cover of 1\.2 mm; less than its thickness wanted"):
        Indenter("sphere", 5e-3).force_at(np.array([3e-3]), thin)
    with pytest.raises(InputError, match=r"under 1000 N into a cover of 1\.2 mm"):
        Indenter("sphere", 5e-3).contact_radius(np.array([1e3]), thin)
    with pytest.raises(InputError, match=f"at most {WIDEST:g} thicknesses wanted"):
        Indenter("flat_punch", 1.0).force_at(np.array([1e-4]), thin)


@pytest.mark.parametrize(("length", "nu"), [(1.0, 0.3), (6.0, 0.49)])
def test_a_line_sinks_into_a_layer_by_what_the_waves_of_its_pressure_do(length: float, nu: float) -> None:
    medium, force = Medium(1.0, nu, thickness=1.0), 0.01
    nodes, weights = np.polynomial.legendre.leggauss(60)
    k, step = 8 * (nodes + 1), 8 * weights
    less = 1 - np.array([compliance(one, nu) for one in k.tolist()])
    turn, around = np.pi / 4 * (nodes + 1), np.pi / 4 * weights
    along, across = np.multiply.outer(k, np.cos(turn)), np.multiply.outer(k, np.sin(turn))
    for width in (0.02, 0.08):  # so narrow that the pressure across is an ellipse
        waves = np.sinc(along * length / 2 / np.pi) ** 2 * 2 * j1(across * width) / (across * width)
        taken = 4 * force / (2 * np.pi**2 * medium.contact_modulus) * float((less * step) @ waves @ around)
        # of 1 / r between all points of the line: 2 times the integral of (1 - x / L) / r, over an ellipse across
        s = width * np.sin(np.pi / 4 * (nodes + 1))
        on_line = np.arcsinh(length / s) - (np.hypot(length, s) - s) / length
        across_weights = np.cos(np.pi / 4 * (nodes + 1)) ** 2 * weights
        mean = 2 * float(on_line @ across_weights) / float(across_weights.sum())
        plain = force * mean / (np.pi * medium.contact_modulus * length)
        found = float(line_indentation(force, length, np.array(width), medium))
        assert found == pytest.approx(plain - taken, rel=1e-3)
        assert taken > 0.1 * plain
        deep = Medium(1.0, nu, thickness=1e4)
        assert float(line_indentation(force, length, np.array(width), deep)) == pytest.approx(plain, rel=1e-3)


@pytest.mark.parametrize(("body", "size"), [("paraboloid", 1.0), ("sphere", 0.3), ("sphere", 12.0)])
def test_a_radius_is_found_from_force_and_indentation(body: Body, size: float) -> None:
    law = layer_contact(body, 0.49, size)
    radii = law.widest * np.geomspace(1e-6, 0.9, 60)
    assert law.radius_of(law.force(radii), "force") == pytest.approx(radii, rel=1e-10)
    assert law.radius_of(law.indentation(radii), "indentation") == pytest.approx(radii, rel=1e-10)
    assert law.radius_of(np.array([0.0, -1.0]), "force").tolist() == [0, 0]
    with pytest.raises(InputError, match=r"force .* of the layer's units; at most"):
        law.radius_of(1.01 * law.force(np.array([law.widest])), "force")
