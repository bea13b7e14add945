"""Slip under a round body on a layer: where it still sticks, and what is taken off the tractions of full sliding there.

Under a pull that grows for the first time the traction is q = mu (p - p*): full sliding, less p* on the circle that
sticks, whose surface moves as one. With W, W* the line weights of p and p* (see ``profiles``) and M' the cosine
transform of 1 - T'(k h), T' being the layer's compliance against a drag over the half-space's,

    W*(t) - (1 / pi) integral over s = -c .. c of  M'(t - s) W*(s) ds  =  the same of W, over -a .. a,  - a constant,

the constant so that W*(c) = 0. On the half-space this is Cattaneo's and Mindlin's answer, p* being the pressure of a
contact of radius c; on a layer, which resists a drag otherwise than a push, it is another one: its weight is taken for
that of the body's own shape dragged, which it is but for a part that changes over a thickness only, and c follows
from the force that p* carries. As there, what moves across the pull is left out. Against slip solved cell by cell what
is felt of a first pull is off by 3 % of its largest where a = h, 6 % at 2 h and 9 % at 4 h at most (incompressible,
taxels at a fifth of the thickness; the half-space's rings: 10, 28 and 35 %), and by 10 % at 2 h once it turns back.
Where the normal force changes as well the rings are those of the half-space, kept by the force that they carry.

Source: Cattaneo (1938), Mindlin (1949); ``layer_contact`` for the weights.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator, RectBivariateSpline

from cnnsim.support import Floats
from tactile.elastic.layer_contact import LayerContact, kernel, layer_contact
from tactile.elastic.profiles import Profile

CONTACTS, CIRCLES, SHARES = 40, 24, 33
"""Contact radii in a table; circles that stick in each; roots of the share of the force that they carry."""


@dataclass(frozen=True)
class LayerSlip:
    """The circle that sticks under a body on a layer of unit thickness."""

    law: LayerContact

    @property
    def profile(self) -> Profile:
        """Shape of what is taken off; its lam is the radius of the circle that sticks over the thickness."""
        return layer_contact(self.law.body, self.law.nu, self.law.size, True).profile

    def radius(self, contact: Floats, share: Floats) -> Floats:
        """Radius of the circle on which p* carries a share, 0 to 1, of the force of a contact of this radius."""
        at, root = np.broadcast_arrays(self.law.place(contact), np.cbrt(np.clip(share, 0, 1)))
        out: Floats = contact * root * self._table.ev(at, root)
        return out

    @cached_property
    def _table(self) -> RectBivariateSpline:
        """c / a over the third root of the share, which is 1 on the half-space."""
        ends = self.law.place(np.array([self.law.widest]))
        at, roots = np.linspace(0, float(ends[0]), CONTACTS), np.linspace(0, 1, SHARES)
        found = np.ones((CONTACTS, SHARES))
        for n, a in enumerate(self.law.radius_at(at[1:]).tolist(), 1):
            circles = np.concatenate([[0.0], a * (np.arange(1, CIRCLES + 1) / CIRCLES)])
            share = np.cbrt(self._shares(a, circles[1:-1]))
            known = PchipInterpolator(np.concatenate([[0.0], share, [1.0]]), circles / a)
            found[n, 1:] = known(roots[1:]) / roots[1:]
            found[n, 0] = 2 * found[n, 1] - found[n, 2]
        return RectBivariateSpline(at, roots, found)

    def _shares(self, a: float, circles: Floats) -> Floats:
        """What p* carries of the force when circles of these radii stick."""
        push, drag = kernel(self.law.nu, False), kernel(self.law.nu, True)
        t, step, weight, depth = self.law.weights(a)

        def spread(at: Floats, of: Floats, width: Floats) -> Floats:
            both: Floats = (drag(np.abs(at[:, None] - of)) + drag(at[:, None] + of)) * width / np.pi
            return both

        def wanted(at: Floats) -> Floats:
            """The right side: W less what the dragged layer makes of it, W being known from the push."""
            pushed = (push(np.abs(at[:, None] - t)) + push(at[:, None] + t)) * step / np.pi
            out: Floats = depth - self.law.abel(at) + (pushed - spread(at, t, step)) @ weight
            return out

        out = np.empty(len(circles))
        for n, c in enumerate(circles.tolist()):
            at, width, rim = t * c / a, step * c / a, np.array([c])
            dragged = spread(at, at, width)
            sides = np.stack([np.ones_like(at), wanted(at)], axis=-1)
            solved = np.linalg.solve(np.eye(len(at)) - dragged, sides)
            level, given = (np.array([[1.0, wanted(rim)[0]]]) + spread(rim, at, width) @ solved)[0]
            out[n] = width @ (solved[:, 1] - given / level * solved[:, 0])
        found: Floats = np.clip(out / float(step @ weight), 0, 1)
        return np.maximum.accumulate(found) + np.arange(len(found)) * 1e-12


@lru_cache(maxsize=16)
def layer_slip(law: LayerContact) -> LayerSlip:
    """The table of a body, made once."""
    return LayerSlip(law)
