"""Sliding texture: an object drawn over the cover, its normal force from a profile, its shear by stick and slip."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.keywords import spelled_class
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.materials import Material
from tactile.simulator.contacts.mounting import STILL, Rig, at_a_point

FINEST = 24
"""Steps per shortest length: grain, period, and the path on which shear builds up to slip."""
MOST_STEPS = 5_000_000


@spelled_class
@dataclass(frozen=True)
class SlidingTexture:
    """An object drawn along a straight line over one point of the cover.

    The normal force is F (1 + profile(s)) along the path s, at least 0. The shear grows at ``stiffness`` until it
    reaches static * normal, then drops to kinetic * normal and grows again; where kinetic = static it slides
    smoothly.

    Arguments: ``place`` (x, y) [m]; ``material``; ``start``, ``stop`` [s]; ``speed`` [m/s]; ``direction`` [rad] of
    the object's motion, from x towards y; ``force`` F [N]; ``stiffness`` [N/m] of the cover against shear;
    ``seed`` of the profile.

    Raises:
        InputError: a stop before the start, a negative speed or force, a stiffness that is not positive, or a path
            that is too long for its profile: over five million steps.
    """

    finger: int
    place: tuple[float, float]
    material: Material
    start: float
    stop: float
    speed: float
    direction: float
    force: float
    stiffness: float
    seed: int = 0

    def __post_init__(self) -> None:
        if not (self.stop > self.start and self.speed >= 0 and self.force >= 0 and self.stiffness > 0):
            raise InputError(
                f"object drawn from {self.start} to {self.stop} s at {self.speed} m/s with {self.force} N on "
                f"{self.stiffness} N/m: stop after start, speed and force from 0 up, a positive stiffness wanted"
            )
        if self._steps > MOST_STEPS:
            raise InputError(f"{self._steps} steps to draw {self.material.name!r}, at most {MOST_STEPS} wanted")

    @property
    def _steps(self) -> int:
        jump = (self.material.static - self.material.kinetic) * self.force / self.stiffness
        finest = min(length for length in (self.material.grain, self.material.period, jump) if length > 0)
        return 2 + int(np.ceil(self.speed * (self.stop - self.start) / finest * FINEST))

    @cached_property
    def _series(self) -> tuple[Floats, Floats, Floats]:
        """(path, shear, normal force) along the whole path."""
        path = np.linspace(0, self.speed * (self.stop - self.start), self._steps)
        profile = self.material.profile(path, np.random.default_rng(self.seed))
        normal = self.force * np.maximum(1 + profile, 0)
        shear, pull = np.empty_like(path), 0.0
        grown = self.stiffness * (path[1] - path[0])
        for k, (most, least) in enumerate(
            zip((self.material.static * normal).tolist(), (self.material.kinetic * normal).tolist(), strict=True)
        ):
            pull += grown
            if pull > most:
                pull = least
            shear[k] = pull
        return path, shear, normal

    def series(self, times: Floats) -> tuple[Floats, Floats]:
        """Return (shear along the motion, normal force) [N] at the times [s]; 0 before the start and after the stop.

        Both are those of the last step, not interpolated: a slip is a jump.
        """
        path, shear, normal = self._series
        at = self.speed * (np.clip(times, self.start, self.stop) - self.start)
        here = (times >= self.start) & (times <= self.stop)
        step = np.clip(np.searchsorted(path, at, side="right") - 1, 0, len(path) - 1)
        return np.where(here, shear[step], 0.0), np.where(here, normal[step], 0.0)

    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = STILL) -> Loads:
        """Return the load on the finger at the times [s], with the object in the rig."""
        shear, normal = self.series(times)
        x, y = (np.full(len(times), place) for place in self.place)
        pull = shear * np.cos(self.direction), shear * np.sin(self.direction)
        return at_a_point(np.stack([x, y, *pull, normal], axis=-1), medium, rig)
