"""Held load: mean of the normal load over a part of the contact's age, and whether the contact is let go."""

from math import exp

AGE, LONGEST = 0.25, 2.0
"""Time constant of the held load as a part of the contact's age, at most LONGEST [s]: it knows no tempo of its own."""
SHORTEST = 1e-3
"""[s] Added to it: the first frame of a contact."""
HALF, LITTLE, NOTHING = 0.5, 0.3, 0.08
"""Parts of the held load between which the fall is timed, and below which nothing is held: silicone keeps up to 0.25 of
a light grip for a while."""
SETTLED, MOVED = 0.05, 0.2
"""Differences from the held load, as parts of it, below which a grip is settled and above which it is not."""
STAYS = 0.2
"""Part of the contact's age for which the load must stay within `SETTLED`: a falling overshoot crosses it."""
FRAMES = 2
"""Least duration of the fall and of a steady load, in frames."""


class HeldLoad:
    """Held load H of a finger, dH/dt = (F - H) / (a age), and whether it is ``settled`` or ``loosened``.

    A load that grows evenly from the first touch stays a fifth above H, so that a closing grip is not settled.

    It is loosened where F falls below `NOTHING` H, or where it stays below `LITTLE` H for as long as it took to fall
    from `HALF` H: the knee of the fall. Both are ratios, so neither depends on gain or tempo.
    """

    def __init__(self) -> None:
        self.loosened = self.settled = False
        self._age = self._half = self._still = 0.0
        self._little: float | None = None

    def follows(self, dt: float, contact: bool) -> float:
        """Return the factor by which H moves towards F in this frame, ``dt`` [s] after the last."""
        self._age = self._age + dt if contact else 0.0
        return 1 - exp(-dt / (min(AGE * self._age, LONGEST) + SHORTEST)) if contact else 1.0

    def update(self, t: float, load: float, held: float, interval: float, calm: bool, contact: bool) -> None:
        """Process F = ``load`` and H = ``held`` at ``t`` [s].

        ``interval`` [s] between frames; ``calm``: F is near its mean of 0.1 s.
        """
        away = abs(load - held)
        if not contact or away > (MOVED if self.settled else SETTLED) * held:
            self.settled, self._still = False, self._age
        least = FRAMES * interval
        self.settled = self.settled or (calm and self._age - self._still > max(STAYS * self._age, least))
        if not contact or load > HALF * held:
            self._half, self._little, self.loosened = t, None, False
        elif load > LITTLE * held:
            self._little, self.loosened = None, False
        else:
            self._little = t if self._little is None else self._little
            lasted = t - self._little
            fell = load < NOTHING * held and lasted >= least
            self.loosened = self.loosened or fell or lasted > max(self._little - self._half, least)
