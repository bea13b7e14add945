"""The strain or stress field at the taxels of one finger over some frames, before any electronics."""

from dataclasses import dataclass, replace

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.summation import Summation, sum_loads


@dataclass(frozen=True)
class Field:
    """What the taxels feel, with all that is needed to add a term to it.

    ``times`` (n,) [s]; ``first``: number of the first frame; ``values`` (n, rows, cols, 3) in the medium's reading.
    """

    array: TaxelArray
    medium: Medium
    times: Floats
    first: int
    loads: Loads
    values: Floats

    def under(self, loads: Loads, medium: Medium) -> "Field":
        """The same with other loads or another medium: what ideal taxels then feel, less what they felt, is added."""
        at, depth = self.array.positions(), self.array.depth
        term = field_at(at, depth, loads, medium) - field_at(at, depth, self.loads, self.medium)
        return replace(self, loads=loads, medium=medium, values=self.values + term)


def field_at(positions: Floats, depth: float, loads: Loads, medium: Medium, method: Summation | None = None) -> Floats:
    """What taxels at ``positions`` (..., 2) feel of all loads: (frames, ..., 3).

    Points are summed by the method, circles and twists by their own quadrature; what is not there is not imported.
    """
    values = sum_loads(method, positions, depth, loads.points, medium)
    extra = (1,) * (positions.ndim - 1)
    for disc in loads.discs:
        from tactile.elastic.discs import disc_load  # only where called for

        frames, count = disc.radii.shape
        rows, radii, lam = (
            part.reshape(frames, *extra, count, *part.shape[2:]) for part in (disc.loads, disc.radii, disc.lam)
        )
        values += disc_load(positions, depth, rows, radii, disc.profile, medium, lam)
    for twist in loads.twists:
        from tactile.elastic.discs import twist_load  # the same

        frames, count = twist.radii.shape
        values += twist_load(
            positions,
            depth,
            twist.twists.reshape(frames, *extra, count, 3),
            twist.radii.reshape(frames, *extra, count),
            medium,
        )
    return values
