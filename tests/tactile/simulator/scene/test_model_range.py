"""Where a scene leaves the range of its models it says so, with both numbers."""

from typing import Literal

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.elastic.strip_contact import strip_contact
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.materials import PRESETS
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.effects.adhesion import Adhesion
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.mounting.curved_fingertip import CurvedFingertip
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.field import Contact
from tactile.simulator.scene.model_range import out_of_range
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene.unit_range import doubtful_units


def pressed(*pushes: float, by_depth: bool = False) -> MovingContact:
    path = np.array([(t, 0, 0, 1e-4, 0, push) for t, push in enumerate(pushes)])
    return MovingContact(0, Indenter("sphere", 5e-3), path, None, by_depth)


def said(contact: MovingContact, *effects: object, depth: float = 1e-3) -> str:
    array = TaxelArray("pad", 2, 2, 1e-3, depth)
    return "\n".join(out_of_range(Scene("s", 100.0, 2.0, 2.4e6, (array,), (), (contact,), effects)))


def test_a_scene_says_where_its_models_end() -> None:
    assert said(pressed(0.0, 0.05, 0.0)) == ""
    pulled = said(pressed(0.5, -0.5))
    assert "contact 1, a sphere: pulled with 0.5 N; a dry contact cannot pull: it lifts off" in pulled
    assert "([effect.adhesion] lets it stick)" in pulled
    assert "pulled" not in said(pressed(0.05, -5e-4), Adhesion())
    for shape in (Indenter("disc", 1e-3), Indenter("cylinder", 2e-2, 8e-3), Indenter("edge", 0.0, 8e-3)):
        for effects in ((), (Adhesion(),)):  # which does not hold these
            held = MovingContact(0, shape, np.array([(0.0, 0, 0, 0, 0, 0.05), (1, 0, 0, 0, 0, -0.5)]))
            assert said(held, *effects).endswith("it lifts off and carries nothing")
    assert "of a sphere of radius 5 mm; at most 0.5 of it wanted" in said(pressed(0.0, 50.0), depth=5e-3)
    needle = MovingContact(0, Indenter("needle", 5e-5), np.array([(0.0, 0, 0, 0, 0, 1.5e-3)]), None, True)
    assert "30 times its radius" in said(needle)
    with pytest.raises(
        InputError, match=r"6\.\d+ mm in radius of a sphere of radius 5 mm; at most the sphere's own wanted"
    ):
        said(pressed(0.0, 200.0), depth=5e-3)
    point = np.array([(0.0, 5e-4, 5e-4, 0, 0, 1.0)])
    assert "strains to 0." in said(MovingContact(0, Indenter(), point * [1, 1, 1, 0, 0, 4.0]))
    with pytest.raises(InputError, match=r"strains to 3\.98; at most 1 wanted"):
        said(MovingContact(0, Indenter(), point * [1, 1, 1, 0, 0, 20.0]))
    layered = said(pressed(0.0, 5e-4, by_depth=True), FiniteThickness(1.2e-3))
    assert "0.5 mm deep in a cover of 1.2 mm; at most 0.3 of it wanted" in layered


@pytest.mark.parametrize("quantity", ("strain", "stress"))
def test_strains_are_judged_whatever_the_taxels_feel(quantity: Literal["strain", "stress"]) -> None:
    array = TaxelArray("pad", 3, 3, 1e-3, 1e-3, quantity=quantity)

    def lines(load: MovingLoad | MovingContact, *effects: object) -> list[str]:
        loads, contacts = ((load,), ()) if isinstance(load, MovingLoad) else ((), (load,))
        return list(out_of_range(Scene("s", 100.0, 0.1, 2.4e6, (array,), loads, contacts, effects)))

    # pulled aside at a place x depths off: u_xz = 3 (1 + nu) Q x^2 (1 + x^2)^-5/2 / (2 pi E z^2), most at x^2 = 2/3
    for nu in (0.3, 0.5):
        unit = 3 * (1 + nu) * (2 / 3) * (5 / 3) ** -2.5 / (2 * np.pi * 2.4)
        little, much = (
            lines(MovingLoad(0, [(0.0, np.sqrt(2 / 3) * 1e-3, 0, strain / unit, 0, 0)]), PoissonRatio(nu))
            for strain in (0.29, 0.31)
        )
        assert little == []
        assert much == ["pad: strains to 0.31; below 0.3 wanted: the cover is taken to be linear"]
    # a wide ball on a thin cover, which cannot give way to its sides: stresses of 1.8 times the modulus, strains of 0.1
    wide = MovingContact(0, Indenter("sphere", 0.1), np.array([(0.0, 0, 0, 0, 0, 400.0)]))
    assert lines(wide, FiniteThickness(1.2e-3)) == []


def test_a_scene_says_where_a_cylinder_ends() -> None:
    def lying(force: float, radius: float, length: float) -> MovingContact:
        return MovingContact(0, Indenter("cylinder", radius, length), np.array([(0.0, 0, 0, 0, 0, force)]))

    # b = sqrt(4 P R / (pi E* L)): 0.69 mm
    assert said(lying(0.6, 1e-2, 5e-3), depth=2e-3) == ""
    assert "0.688 mm to either side of a cylinder of radius 1 mm; at most 0.5" in said(lying(5.95, 1e-3, 5e-3))
    for layer in ((), (FiniteThickness(2e-3),)):
        with pytest.raises(InputError, match=r"0\.\d+ mm to either side of a cylinder of radius 0\.3 mm; at most the"):
            said(lying(20.0, 3e-4, 5e-3), *layer)
    assert "1.38 mm wide and 1 mm long" in said(lying(1.19, 1e-3, 1e-3))
    assert "times its radius; at most the radius wanted" in said(lying(230.0, 5e-3, 2e-2), depth=5e-3)
    assert "mm deep in a cover of 2 mm; at most 0.3 of it wanted" in said(
        lying(400.0, 5e-3, 2e-2), FiniteThickness(2e-3)
    )


def test_a_body_on_a_dome_is_as_wide_as_it_touches_there() -> None:
    # 1 / R = 1 / 10 mm + 1 / 1 mm: under 8 N wider than that sphere, on a plane a quarter as wide as its own
    ball, dome = MovingContact(0, Indenter("sphere", 1e-2), np.array([(0.0, 0, 0, 0, 0, 8.0)])), CurvedFingertip(1e-3)
    chip = TaxelArray("chip", 2, 2, 4e-4, 2e-3)
    flat, curved = (Scene("s", 100.0, 1.0, 2.4e6, (chip,), (), (ball,), effects) for effects in ((), (dome,)))
    assert flat.range_notes == ()
    wide = np.cbrt(0.75 * 8.0 / (1 / 1e-2 + 1 / 1e-3) / Medium(2.4e6).contact_modulus) * 1e3
    with pytest.raises(InputError, match=rf"like one of radius 0\.909 mm: a contact {wide:.3g} mm in radius.*at most"):
        _ = curved.range_notes


def test_what_sticks_is_as_wide_as_it_is_drawn_in() -> None:
    # Johnson, Kendall and Roberts, without a force: a = cbrt(9 pi w R^2 / 2 E*)
    ball = MovingContact(0, Indenter("sphere", 5e-5), np.array([(0.0, 0, 0, 0, 0, 0.0)]))
    wide = np.cbrt(4.5 * np.pi * 5.0 * 5e-5**2 / Medium(2.4e6).contact_modulus) * 1e3
    assert f"a contact {wide:.3g} mm in radius of a sphere of radius 0.05 mm; at most 0.5" in said(ball, Adhesion(5.0))
    with pytest.raises(InputError, match=r"mm in radius of a sphere of radius 0\.05 mm; at most the sphere's own"):
        said(ball, Adhesion(20.0))
    assert said(ball, Adhesion(0.05)) == ""


def test_partial_slip_over_a_thin_cover_is_told() -> None:
    # the ball touches over 5, 4 or 3 mm
    def pulled(friction: float | None, wide: float, pull: float = 0.1, grows: bool = False) -> MovingContact:
        force = float(Indenter("sphere", 0.2).round.force_on(np.array(wide), Medium(2.4e6, thickness=1e-3)))
        first = (0.0, 0, 0, 0.0, 0, force / 2 if grows else force)
        return MovingContact(0, Indenter("sphere", 0.2), [first, (0.1, 0, 0, pull * force, 0, force)], friction)

    thin = FiniteThickness(1e-3)
    told = "5 thicknesses of the cover in radius, slips from its rim inwards under a pull; at most 4.1 wanted"
    assert told in said(pulled(0.5, 5e-3), thin)
    assert told in said(pulled(0.5, 5e-3, grows=True), thin)
    for friction, wide, pull, grows in (
        (None, 5e-3, 0.1, False), (0.5, 5e-3, 0.0, True), (0.5, 3e-3, 0.1, False), (0.5, 4e-3, 0.1, True),
    ):  # fmt: skip
        assert "slips" not in said(pulled(friction, wide, pull, grows), thin)


def test_a_flat_end_that_sticks_to_a_thin_cover_and_is_pulled_is_told() -> None:
    told = "sticks while it is pulled; at most 0.5 wanted: the pull is spread like its pressure"
    for pull, thickness, wanted in ((0.1, 1e-3, True), (0.0, 1e-3, False), (0.1, 5e-3, False)):
        body = MovingContact(0, Indenter("flat_punch", 2e-3), [(0.0, 0, 0, pull, 0, 1.0)], 0.5)
        assert (told in said(body, FiniteThickness(thickness))) == wanted


def test_a_cover_that_a_cylinder_squeezes_out_at_its_ends_is_told() -> None:
    def lying(force: float, length: float) -> MovingContact:
        return MovingContact(0, Indenter("cylinder", 2e-2, length), np.array([(0.0, 0, 0, 0, 0, force)]))

    thin = FiniteThickness(1e-3)
    # over three thicknesses to either side: solved on a grid, the mean is 17 % too deep, the middle 18 % too little
    assert "so thin a cover is squeezed out at the ends of 16 mm" in said(lying(1000.0, 16e-3), thin)
    # over two thicknesses to either side of a long one its force is 7 % too small, on that grid
    wide = strip_contact(0.5).force(np.array(2.0)) * 2.4e6 / 0.75 * 20e-3 * 1e-6 / 2e-2
    assert "squeezed out at the ends of 20 mm, and its force" in said(lying(float(wide), 20e-3), thin)
    assert "squeezed out" not in said(lying(5.0, 16e-3), thin)
    assert "squeezed out" not in said(lying(60.0, 16e-3), FiniteThickness(8e-3))


def scene(contacts: tuple[Contact, ...], *effects: object, modulus: float = 2.4e6, rate: float = 100.0) -> Scene:
    return Scene("s", rate, 2.0, modulus, (TaxelArray("pad", 2, 2, 1e-3, 1e-3),), (), contacts, effects)


PATH = np.array([(0.0, 0, 0, 0, 0, 1e-3)])


def held(push: float = 0.05, x: float = 5e-4, until: float = 1.0) -> tuple[MovingContact]:
    path = [(0.0, x, 5e-4, 0, 0, push), (until, x, 5e-4, 0, 0, push)]
    return (MovingContact(0, Indenter("sphere", 5e-3), path),)


@pytest.mark.parametrize(
    ("doubtful", "wanted"),
    [
        (scene(held(), modulus=2.4), "modulus 2.4 Pa; 1000 (a soft gel) to 1e+10 Pa"),
        (scene(held(), modulus=2.4e12), "modulus 2.4e+12 Pa"),
        (scene(held(x=0.5)), "500 mm or more from the taxels of 'pad'; at most 3 depths of 1 mm"),
        (scene(held(until=2000.0)), "a path until 2e+03 s in a scene of 2 s, at most 300 times"),
        (scene(held(until=1e-3)), "a path of 0.001 s; at least a frame of 0.01 s"),
        (scene(held(5e-5)), "above the dead band of 0.001 wanted"),
        (scene(held(), ReadNoise(1.0)), "above the noise of"),
        (scene(held(), Quantisation(2, 100.0)), "above one count of"),
        (scene((HeightMap(0, np.array([[0.0, 1.0]] * 2), 1e-4, PATH),)), "heights over 1e+03 mm"),
        (
            scene((SlidingTexture(0, (0, 0), PRESETS["screw"], 0, 1, 0.0715, 0, 0.05, 1e3),), rate=1 / 15e-3),
            "a tone of 143 Hz at 66.7 frames/s shows as 9.7 Hz; at most half the frame rate, 33.3 Hz",
        ),
    ],
)
def test_numbers_of_a_wrong_unit_are_reported_with_both_sides(doubtful: Scene, wanted: str) -> None:
    assert wanted in "\n".join(doubtful_units(doubtful))
    for sound in (scene(held()), scene(held(until=500.0))):  # a scene that is cut short on purpose
        assert list(doubtful_units(sound)) == []
