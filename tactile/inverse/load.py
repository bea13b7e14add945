"""Load: one point load as several taxels locate it, with how sure that is."""

from dataclasses import dataclass

from tactile.inverse.validity import Validity

NAN, INF = float("nan"), float("inf")


@dataclass(frozen=True)
class Load:
    """A located load: place (x, y) [m] in the finger's frame, components (Q, R, F) [N] along x, y and into the body.

    ``sigma``: standard deviations of (x, y, Q, R, F) [m, m, N, N, N], from the noise of the signals, the geometry and
    what the load leaves unexplained; infinite where the taxels cannot tell (the component is NaN then, and F holds if
    it is zero). ``scatter``: those from noise and geometry alone, which is by how much the answer changes from frame to
    frame; the rest of ``sigma`` is alike in all frames of a contact. ``misfit``: share of
    the signals, as root mean squares, that neither this load and ``others`` nor the noise explain. ``taxels``: how
    many were used; ``left_out``: (row, column) of taxels that contradict all others, or of which one reading does,
    which is not used; ``saturated`` of those that are
    at the end of their range and not used, or of which the largest reading is not, since all others say that it is cut
    off. ``validity``: INSIDE or OUTSIDE as seen from the nearest taxel, AMBIGUOUS where another place fits about as
    well, where a taxel may read falsely or feel another load, where the place is known to half a depth only, or hangs
    on what the load leaves unexplained (`tactile.inverse.steadiness`), NOT_ONE where no few point loads fit, NO_LOAD
    or INVALID without an answer. ``others``: further loads
    at the same time, the strongest first. ``torque`` [N m] about the place, from x to y, where taxels measure forces;
    NaN where it is not known.

    What no reading contradicts no deviation can count. Of four taxels two depths apart the strongest is nearly alone:
    an error there moves the place by up to a hundred times what it leaves unexplained, and below that noise it is not
    seen. Where nobody knows the noise (without a tare) what is left is taken for noise, save for one reading that
    stands out: a cover half as thick as is thought, a wide tip or a weak second load then lie beyond five deviations
    in one frame of five.
    """

    x: float = NAN
    y: float = NAN
    Q: float = NAN
    R: float = NAN
    F: float = NAN
    sigma: tuple[float, float, float, float, float] = (NAN,) * 5
    misfit: float = NAN
    taxels: int = 0
    validity: Validity = Validity.NO_LOAD
    left_out: tuple[tuple[int, int], ...] = ()
    saturated: tuple[tuple[int, int], ...] = ()
    others: tuple["Load", ...] = ()
    torque: float = NAN
    scatter: tuple[float, float, float, float, float] = (NAN,) * 5

    def __repr__(self) -> str:
        words = self.validity.name.lower().replace("_", " ")
        if self.F != self.F:
            return f"Load({words})"
        place = f"({self.x * 1e3:.3g}, {self.y * 1e3:.3g}) mm"
        forces = ", ".join(f"{name} {getattr(self, name):.3g}" for name in ("Q", "R", "F"))
        more = f", {len(self.others)} more" if self.others else ""
        return f"Load({place}, {forces} N, {words}, {self.taxels} taxels{more})"
