"""Load: one point load as several taxels locate it, with how sure that is."""

from dataclasses import dataclass

from tactile.inverse.validity import Validity

NAN, INF = float("nan"), float("inf")


@dataclass(frozen=True)
class Load:
    """A located load: place (x, y) [m] in the finger's frame, components (Q, R, F) [N] along x, y and into the body.

    ``sigma``: standard deviations of (x, y, Q, R, F) [m, m, N, N, N], from the noise of the signals, the geometry, what
    the load leaves unexplained, and other loads that fit as well if a reading is turned round, the largest one cut off,
    or the tip wide; infinite where the taxels cannot tell (the component is NaN then, and F holds if it is zero).
    ``scatter``: those from noise and geometry alone, by which the answer changes from frame to frame; what ``sigma``
    has beyond is alike in all frames of a contact. ``misfit``: share of the signals, as root mean squares, that neither
    this load and ``others`` nor the noise explain. ``taxels``: how many were used; ``left_out``: (row, column) of
    taxels that contradict all others, or of which one reading does or is nothing at all, which alone is not used, and
    of those under the load that cannot be read: not a number, or no normal stress beside its shear; ``saturated`` of
    those that are at the end of their range and not used, or of which the largest reading is not, since all others say
    that it is cut off, or since it is the same number as another one. ``validity``: INSIDE or OUTSIDE as seen from the
    nearest taxel, AMBIGUOUS where another place fits about as well, where a taxel may read falsely or feel another
    load, where either of two readings may be the false one, where ``sigma`` of the place is more than half a depth, or
    it hangs on what the load leaves unexplained (`tactile.inverse.steadiness`), NOT_ONE where no few point loads fit,
    NO_LOAD or INVALID without an answer. ``others``: further loads at the same time, the strongest first. ``torque`` [N
    m] about the place, from x to y, where taxels measure forces; NaN where it is not known.

    Where the noise is known (a quiet second at the start, `LiveTare`) what is left beyond it counts in full, whatever
    it comes from: a false reading, a second load too weak or too near to be told, a cover thinner than is thought, a
    wide tip. Of layers of 1 to 2 depths read as a half-space all are noticed on 2 x 2 to 8 x 8 taxels with noise of up
    to a hundredth of the signal, and 1 % lie beyond five deviations; so do about 1 % of balls up to a depth, and of
    loads with a channel that is dead (one that reads nothing at all is named), turned round or cut off, or with a stuck
    taxel under them; on lines of taxels as many, of balls 4 %. What is left of cut off readings no data tell: the load
    that takes the reading for true and the one without it leave sums of squares that differ by less than two variances,
    0.0 to 1.1 in most, so the one is as likely as the other. One sound load in 20, on lines in 12, has wider deviations
    for a rival that fits as well, and one in 200, on lines in 100, is ambiguous for it. Two limits more the data set.
    Where nobody knows the noise, what is left passes for it on less than 25 taxels, but for a reading that stands out
    and for what looks like a width: beyond five deviations lie then 7 % of such layers, 9 % of second loads of 5 to 10
    %. And where the load hangs on one taxel, on pads two depths apart, an error in it leaves a hundredth of itself
    elsewhere: below the noise it is not seen. Taxels on a line tell F less R times the load's distance from the line
    over their depth, R being the shear across: ``F`` holds for R = 0.
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
