"""Partial slip under a round body on a layer: the circle that sticks, and the reduction of the traction in it.

Under a pull that grows for the first time the traction is q = mu (p - p*): that of full sliding, less p* on the circle
that sticks, which moves as one. A layer moves under waves along a drag by other shares of the half-space than under
those across it, so that p* is q0(r) along the pull and q2(r) (cos 2 phi, sin 2 phi). With W of p, W0 and W2 their line
weights (see ``profiles``; the transform of q2 is that of W2, whose integral is 0), X = W0 + W2 and Y = W0 - W2 part:

    X(t) - (1 / pi) integral over s = -c .. c of  M_along(t - s) X(s) ds  =  the same of W, over -a .. a,  - a constant

and alike Y with M_across, M being the cosine transforms of 1 - T(k h), T the layer's compliance over the half-space's.
The two constants make the integral of X - Y and W0(c) vanish. On the half-space this is Cattaneo's and Mindlin's
answer, p* being the pressure of a contact of radius c, and W2 = 0. On a layer it is interpolated, by its force, between
two shapes that depend on the stuck circle alone, so that tables of one radius suffice: the pressure of a contact of
radius c, and p* under one wider by a quarter. As there, slip is taken to lie along the pull: the part
across is left out, 2.5 % of the largest reading on the half-space (nu = 1/2) and no more on a layer.

Source: Cattaneo (1938), Mindlin (1949); ``layer_contact`` for the weights.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import BarycentricInterpolator, PchipInterpolator, RectBivariateSpline

from cnnsim.support import Floats
from tactile.elastic.gauss import gauss
from tactile.elastic.layer_contact import LayerContact
from tactile.elastic.layer_surface import across_excess, along_excess, cosine_transform, excess, spread
from tactile.elastic.profiles import Profile

CONTACTS, CIRCLES, SHARES = 32, 20, 33
"""Contact radii in a table; circles that stick in each; roots of the share of the force that they carry."""
RADII, ANGLES = 64, 33
"""Of the table of the shape under a wider contact."""
WIDER = 1.25
"""Contact over circle of that shape: of 1.25 to 5, the nearest to the rings of light pulls, the hardest case."""
ALIKE = 3e-4
"""Relative difference below which two shapes are the same."""
Stuck = tuple[Floats, Floats]
"""W0 and W2 at places from 0 to 1 of the circle's radius, for a force of 1, times that radius."""


@dataclass(frozen=True)
class LayerSlip:
    """The stuck circle under a body on a layer of unit thickness."""

    law: LayerContact

    @cached_property
    def profile(self) -> Profile:
        """p* under a contact ``WIDER``; its lam is the radius of the circle that sticks over the thickness."""
        law = self.law
        places = np.linspace(0, float(law.place(np.array([law.widest]))[0]), RADII)
        angles = np.linspace(0, np.pi / 2, ANGLES)
        at = np.sin(angles[:-1])
        along, turned = np.empty((2, RADII, ANGLES))
        along[0], turned[0] = 0.75 * np.cos(angles) ** 2, 0.0
        for n, c in enumerate(law.radius_at(places[1:]).tolist(), 1):
            (w0, w2), _ = _Under(law, min(WIDER * c, law.widest)).stuck(c, np.append(at, 1.0))
            along[n], turned[n] = w0, w2
        tables = [RectBivariateSpline(places, angles, table) for table in (along, turned)]

        def weight(of: RectBivariateSpline) -> Callable[[Floats, Floats], Floats]:
            def read(theta: Floats, lam: Floats) -> Floats:
                out: Floats = np.cos(theta) * of.ev(law.place(np.broadcast_to(lam, theta.shape)), np.abs(theta))
                return out

            return read

        size = law.size if law.body == "sphere" else np.inf
        return Profile(f"drag under a {law.body} on a layer", weight(tables[0]), size, turned=weight(tables[1]))

    def radius(self, contact: Floats, share: Floats) -> Floats:
        """Return the radius of the circle on which p* carries a share, 0 to 1, of a contact's force."""
        at, root = self._at(contact, share)
        out: Floats = contact * root * self._tables[0].ev(at, root)
        return out

    def share(self, contact: Floats, circle: Floats) -> Floats:
        """Return the share of the force that p* carries on a circle: the inverse of ``radius``."""
        part = np.clip(circle / np.where(contact > 0, contact, 1.0), 0, 1)
        out: Floats = (part * self._tables[2].ev(*np.broadcast_arrays(self.law.place(contact), part))) ** 3
        return np.clip(out, 0, 1)

    def pressed(self, contact: Floats, share: Floats) -> Floats:
        """Return the share of p* with the shape of a contact's pressure on that circle; the rest has ``profile``."""
        out: Floats = self._tables[1].ev(*self._at(contact, share))
        return out

    def _at(self, contact: Floats, share: Floats) -> Stuck:
        at, root = np.broadcast_arrays(self.law.place(contact), np.cbrt(np.clip(share, 0, 1)))
        return at, root

    @cached_property
    def _tables(self) -> tuple[RectBivariateSpline, RectBivariateSpline, RectBivariateSpline]:
        """Tables of c / a over the cube root of the share, of ``pressed``, and of that root over c / a."""
        law = self.law
        at = np.linspace(0, float(law.place(np.array([law.widest]))[0]), CONTACTS)
        roots, nodes = np.linspace(0, 1, SHARES), (gauss(24)[0] + 1) / 2
        found, pressed, carried = np.ones((3, CONTACTS, SHARES))
        for n, a in enumerate(law.radius_at(at[1:]).tolist(), 1):
            circles = a * np.sin(np.linspace(0, np.pi / 2, CIRCLES + 1))
            under, shares, mixed = _Under(law, a), np.ones(CIRCLES + 1), np.ones(CIRCLES + 1)
            shares[0] = 0.0
            for m, c in enumerate(circles[1:-1].tolist(), 1):
                here, shares[m] = under.stuck(c, nodes)
                mixed[m] = self._mixed(c, here, nodes)
            mixed[0] = mixed[1]
            root = np.maximum.accumulate(np.cbrt(np.clip(shares, 0, 1))) + np.arange(CIRCLES + 1) * 1e-12
            found[n, 1:] = PchipInterpolator(root, circles / a)(roots[1:]) / roots[1:]
            found[n, 0] = 2 * found[n, 1] - found[n, 2]
            pressed[n] = PchipInterpolator(root, mixed)(roots)
            carried[n, 1:] = PchipInterpolator(circles / a, root)(roots[1:]) / roots[1:]
            carried[n, 0] = 2 * carried[n, 1] - carried[n, 2]
        one, two, three = (RectBivariateSpline(at, roots, table) for table in (found, pressed, carried))
        return one, two, three

    def _mixed(self, circle: float, here: Stuck, nodes: Floats) -> float:
        """Return the share of the first shape in the mixture nearest to the solution."""
        theta, lam, step = np.arcsin(nodes), np.full(len(nodes), circle), gauss(24)[1]
        narrow = np.concatenate([self.law.profile.weight(theta, lam) / np.cos(theta), 0 * nodes])
        turned = self.profile.turned
        assert turned is not None
        wide = np.concatenate([of(theta, lam) / np.cos(theta) for of in (self.profile.weight, turned)])
        both, gap = np.tile(step, 2), narrow - wide
        # the pressure where both hardly differ
        rest = ALIKE**2 * float(both @ narrow**2)
        return float((both @ ((np.concatenate(here) - wide) * gap) + rest) / (both @ gap**2 + rest))


class _Under:
    """Stuck circles under a contact of one radius."""

    def __init__(self, law: LayerContact, radius: float) -> None:
        self.law, self.radius = law, radius
        self.t, self.step, self.weight, self.depth = law.weights(radius)
        self.push = cosine_transform(excess, law.nu)
        self.drags = cosine_transform(along_excess, law.nu), cosine_transform(across_excess)

    def stuck(self, circle: float, at: Floats) -> tuple[Stuck, float]:
        """Return W0 and W2 at places 0 to 1 on a circle, and its share of the force."""
        nodes, weights = gauss(16 + int(4 * circle))
        t, step, rim = circle * (nodes + 1) / 2, circle * weights / 2, np.array([circle])
        every = np.concatenate([t, rim])
        here = self.depth - self.law.abel(every) + spread(self.push, every, self.t, self.step) @ self.weight
        solved, ends = [], []
        for drag in self.drags:
            wanted = np.stack([here - spread(drag, every, self.t, self.step) @ self.weight, np.ones(len(every))], -1)
            own = spread(drag, every, t, step)
            found = np.linalg.solve(np.eye(len(t)) - own[:-1], wanted[:-1])
            solved.append(found)
            ends.append(wanted[-1] + own[-1] @ found)
        (x, y), (x_end, y_end) = solved, ends
        sides = np.array([[step @ x[:, 1], -step @ y[:, 1]], [x_end[1], y_end[1]]])
        levels = np.linalg.solve(sides, [step @ (x[:, 0] - y[:, 0]), x_end[0] + y_end[0]])
        along, across = x @ (1, -levels[0]), y @ (1, -levels[1])
        force = float(step @ (along + across))  # of both halves
        last = x_end @ (1, -levels[0])
        known = BarycentricInterpolator(
            np.append(t, circle) / circle,
            np.stack([np.append((along + across) / 2, 0.0), np.append((along - across) / 2, last)], -1),
        )
        w0, w2 = known(at).T * (circle / force)
        return (w0, w2), force / (2 * float(self.step @ self.weight))


@lru_cache(maxsize=16)
def layer_slip(law: LayerContact) -> LayerSlip:
    """Return the tables of a body, cached."""
    return LayerSlip(law)
