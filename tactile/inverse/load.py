"""Load: one point load as several taxels locate it, with its uncertainty."""

from dataclasses import dataclass

from tactile.inverse.validity import Validity

NAN, INF = float("nan"), float("inf")


@dataclass(frozen=True)
class Load:
    """A located load: place (x, y) [m] in the finger's frame, components (Q, R, F) [N] along x, y and into the body.

    Attributes:
        sigma: Standard deviations of (x, y, Q, R, F) [m, m, N, N, N] from noise, geometry, and what the load leaves
            unexplained; infinite where the taxels do not measure a component, which is NaN then.
        misfit: Share of the signals, as root mean squares, that neither the loads nor the noise explain.
        taxels: Number of taxels used.
        validity: INSIDE or OUTSIDE as seen from the nearest taxel; AMBIGUOUS where another place or model explains
            about as much, the place is not known to half a depth (a depth if a reading may be false), or it depends on
            what the load does not explain; NOT_ONE where no few point loads fit; NO_LOAD or INVALID without an answer.
        left_out: (row, column) of taxels that contradict all others, of which one reading does or is dead (only that
            reading is not used then), and of taxels under the load that cannot be read.
        saturated: (row, column) of taxels at the end of their range, or with a reading that all others say is clipped.
        others: Further loads at the same time, the strongest first.
        torque: [N m] about the place, from x to y, where taxels measure forces; else NaN.
        scatter: Standard deviations from noise and geometry alone, from frame to frame; the rest of ``sigma`` is the
            same in all frames of a contact.

    Limits. With known noise (`LiveTare` measures it in a quiet second) 1 to 3 % of loads with a false reading, of balls
    up to a depth and of covers of 1 to 2 depths read as a half-space lie beyond five deviations, on lines of taxels up
    to 4 %. With unknown noise on fewer than 25 taxels the residuals pass for noise: 7 % of such covers, 9 % of second
    loads of 5 to 10 % lie beyond. An error in a reading that the load absorbs, on pads two depths apart, is not
    visible; a load that would fit as well with a reading of opposite sign is not considered. Taxels on a line measure F
    less R times the distance from the line over the depth, R being the shear across: ``F`` holds for R = 0.
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
