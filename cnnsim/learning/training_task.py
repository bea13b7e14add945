"""Training task: pairs of pictures, the stages to be trained, and the options, checked."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

import numpy as np

from cnnsim.learning.losses import LossName, checked_target
from cnnsim.learning.objective import Pair
from cnnsim.learning.stage import Stage
from cnnsim.network import Boundary, fixed
from cnnsim.network.boundary import parse_boundary
from cnnsim.support import InputError
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import as_picture, is_number, is_whole


@spelled_class
@dataclass(frozen=True, eq=False)
class TrainingTask:
    """Pairs of pictures, the stages that should turn the first ones into the second ones, and how they are trained.

    ``pairs``: (picture, target) or (picture, target, second picture), of CNN values (rows, cols). ``loss``: see
    `loss_of`; None is "hinge" if all targets are black or white, else "squares". ``noise`` on the pictures and
    ``mismatch`` (relative errors of the weights) are sigmas. ``decay`` weighs the sum of squares of the free numbers,
    ``sparsity`` the sum of their moduli; free numbers lie within +-``largest``. ``starts`` random ones at most, each
    of at most ``iterations``. The same ``seed`` gives the same templates.

    With a ``frame_time`` [time constants] a picture is a sequence (frames, rows, cols), and "picture" as initial state
    is its first frame. There is one stage. Targets are outputs at the end, or (times, rows, cols) at ``times`` [time
    constants].

    Raises:
        InputError: pictures of different sizes, targets beyond +-1, numbers that are not finite or out of range.
    """

    pairs: Sequence[Any]
    stages: Sequence[Stage] = (Stage(),)
    name: str = "trained"
    boundary: Boundary | str = field(default_factory=lambda: fixed(-1))
    loss: LossName | None = None
    noise: float = 0.0
    mismatch: float = 0.0
    decay: float = 1e-4
    sparsity: float = 0.0
    largest: float = 10.0
    starts: int = 10
    iterations: int = 200
    seed: int = 0
    frame_time: float | None = None
    times: Sequence[float] = ()

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "stages", tuple(self.stages))
        set_(self, "boundary", parse_boundary(self.boundary))
        set_(self, "times", tuple(self.times))
        if self.frame_time is not None or self.times:
            self._check_timing()
        set_(self, "pairs", tuple(_pair(number, pair, self) for number, pair in enumerate(self.pairs, start=1)))
        if not self.pairs or not self.stages:
            raise InputError(f"{len(self.pairs)} pairs and {len(self.stages)} stages to train; one or more wanted")
        for name in ("noise", "mismatch", "decay", "sparsity", "largest"):
            value = getattr(self, name)
            if not is_number(value) or not 0 <= value < np.inf:
                raise InputError(f"{name} {value!r}; a number from 0 up wanted")
        for name, least in (("starts", 1), ("iterations", 1), ("seed", 0)):
            value = getattr(self, name)
            if not is_whole(value) or value < least:
                raise InputError(f"{name} {value!r}; a whole number from {least} up wanted")
        if any("given" in (s.input, s.initial_state) for s in self.stages) and any(p.given is None for p in self.pairs):
            raise InputError(
                "a stage takes the second picture ('given'), and a pair has none; one for each pair wanted"
            )
        targets = np.concatenate([pair.target.ravel() for pair in self.pairs])
        set_(self, "loss", self.loss or ("hinge" if (np.abs(targets) == 1).all() else "squares"))
        if self.binary and not 0 < np.mean(targets > 0) < 1:
            colour = "black" if targets[0] > 0 else "white"
            raise InputError(f"all cells of all targets are {colour}; black and white ones wanted")

    def _check_timing(self) -> None:
        if self.frame_time is None or not is_number(self.frame_time) or not 0 < self.frame_time < np.inf:
            raise InputError(f"frame_time {self.frame_time!r}; a positive number of time constants wanted")
        if len(self.stages) != 1:
            raise InputError(f"sequences and {len(self.stages)} stages; one stage wanted")
        wrong = [t for t in self.times if not is_number(t) or not 0 < t <= self.stages[0].duration]
        if wrong:
            wanted = f"times of the targets above 0, up to the duration {self.stages[0].duration:g} wanted"
            raise InputError(f"times {', '.join(map(repr, wrong))}; {wanted}")

    @property
    def binary(self) -> bool:
        """Whether the outputs are black and white."""
        return self.loss == "hinge"

    @property
    def digest(self) -> str:
        """The checksum of all that decides the result."""
        rest = [repr(value) for name, value in vars(self).items() if name != "pairs"]
        planes = [
            plane for pair in self.pairs for plane in (pair.picture, pair.target, pair.given) if plane is not None
        ]
        return sha256(b"".join([*map(str.encode, rest), *(plane.tobytes() for plane in planes)])).hexdigest()


def _pair(number: int, given: Sequence[Any], task: TrainingTask) -> Pair:
    where = f"pair {number}"
    if not isinstance(given, Sequence | np.ndarray) or len(given) not in (2, 3):
        raise InputError(f"{where}: {type(given).__name__}; (picture, target) or (picture, target, second one) wanted")
    planes = [as_picture(f"{where}: picture", given[0]), given[1], *given[2:]]
    *frames, rows, cols = planes[0].shape
    shape = rows, cols
    if len(frames) != (task.frame_time is not None):
        wanted = "(rows, cols)" if task.frame_time is None else "(frames, rows, cols)"
        raise InputError(f"{where}: picture has shape {planes[0].shape}; {wanted} wanted")
    if task.frame_time is not None and frames[0] * task.frame_time > task.stages[0].duration + 1e-9:
        end = frames[0] * task.frame_time
        raise InputError(f"{where}: {frames[0]} frames last {end:g}; a stage of that duration wanted")
    wanted_shape = (len(task.times), *shape) if task.times else shape
    target = checked_target(given[1], wanted_shape, f"{where}: target")
    second = checked_target(given[2], shape, f"{where}: second picture") if len(given) == 3 else None
    if not np.isfinite(planes[0]).all():
        raise InputError(f"{where}: picture holds numbers that are not finite; CNN values from -1 to 1 wanted")
    return Pair(np.asarray(planes[0], np.float64), target, second)
