"""Objective of training: the loss of a sequence of stages on pairs of pictures, and its derivative."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from cnnsim.learning.adjoint import AdjointTransient
from cnnsim.learning.losses import Loss, loss_of, slope_of
from cnnsim.learning.stage import Stage
from cnnsim.network import Boundary, Frames
from cnnsim.network.characteristic import CLIP
from cnnsim.planning.step import check_whole_steps
from cnnsim.support import Floats
from cnnsim.task import make_task

STEP = 0.1
DRAWS = 4
"""Disturbed copies of the templates and pictures on which robust templates are trained."""
LEAK = 0.1
"""Slope of saturated outputs between stages, in place of 0: else a saturated cell of an inner stage has no derivative.

Bengio, Leonard and Courville, "Estimating or propagating gradients through stochastic neurons", arXiv 1308.3432.
"""


@dataclass(frozen=True, eq=False)
class Pair:
    """A picture, the outputs that it should give, and perhaps a second picture, all (rows, cols).

    Of a sequence the picture is (frames, rows, cols); with times of the targets these are (times, rows, cols).
    """

    picture: Floats
    target: Floats
    given: Floats | None = None


@dataclass(frozen=True)
class Disturbance:
    """Noise on the pictures (sigma), and relative errors of the weights (sigma)."""

    noise: float = 0.0
    mismatch: float = 0.0


@dataclass(frozen=True)
class Timing:
    """Time between the frames of a sequence, None for pictures, and the times of its targets, none for the end."""

    frame_time: float | None = None
    times: tuple[float, ...] = ()


class Objective:
    """The mean loss over all pairs, and over `DRAWS` fixed disturbances, if there are any, plus ``decay`` |p|^2 and
    ``sparsity`` sum |p|.
    """

    def __init__(
        self, pairs: Sequence[Pair], stages: Sequence[Stage], boundary: Boundary, loss: Loss, disturbance: Disturbance,
        penalties: tuple[float, float], seed: int, timing: Timing = Timing(),
    ) -> None:  # fmt: skip
        self.stages, self._loss, self._penalties, self._timing = stages, loss, penalties, timing
        self.sizes = [stage.map.shape[1] for stage in stages]
        rng, disturbed = np.random.default_rng([seed, 0]), disturbance != Disturbance()
        self._factors = [
            [1 + disturbance.mismatch * rng.standard_normal(stage.first.size) for stage in stages]
            for _ in range(DRAWS if disturbed else 1)
        ]
        self._ends: list[Floats] = []
        self.last = np.inf
        self._batches = []
        by_size = sorted(pairs, key=lambda pair: pair.picture.shape)
        for _, group in groupby(by_size, key=lambda pair: pair.picture.shape):
            some = list(group)
            picture, target = (np.stack([getattr(pair, name) for pair in some]) for name in ("picture", "target"))
            given = np.stack([pair.picture if pair.given is None else pair.given for pair in some])
            noisy = [
                np.clip(picture + disturbance.noise * rng.standard_normal(picture.shape), -1, 1) for _ in self._factors
            ]
            runs = [self._run(stage, self._planes(picture), boundary) for stage in stages]
            self._batches.append((runs, noisy, given, target, len(some) / len(pairs)))

    def _planes(self, picture: Floats) -> list[Floats]:
        """Return the frames of the pictures (n, rows, cols), one without a frame time."""
        return [picture] if self._timing.frame_time is None else list(np.moveaxis(picture, 1, 0))

    def _run(self, stage: Stage, planes: list[Floats], boundary: Boundary) -> AdjointTransient:
        period = self._timing.frame_time
        task = make_task(
            stage.template, state=np.zeros_like(planes[0]), input=Frames(planes, period) if period else planes[0],
            boundary=boundary, duration=stage.duration, scheme="euler", step=STEP, without=["closed form"],
        )  # fmt: skip
        check_whole_steps([t for t in self._timing.times if t], task.plan.step)
        return AdjointTransient(task, task.plan.steps)

    def _at(self, run: AdjointTransient) -> tuple[int, ...]:
        """Return the steps of the loss."""
        return tuple(round(t / STEP) for t in self._timing.times) or (run.steps,)

    def __call__(self, free: Floats) -> tuple[float, Floats]:
        """Return the objective and its derivative."""
        parts = np.split(free, np.cumsum(self.sizes)[:-1])
        decay, sparsity = self._penalties
        rounded = np.sqrt(free**2 + 1e-4)  # |p| without its kink
        value = decay * float(free @ free) + sparsity * float(rounded.sum())
        slope = 2 * decay * free + sparsity * free / rounded
        for runs, pictures, given, target, share in self._batches:
            for picture, factors in zip(pictures, self._factors, strict=True):
                numbers = [f * (stage.first + stage.map @ part)
                           for f, stage, part in zip(factors, self.stages, parts, strict=True)]  # fmt: skip
                x = self._forward(runs, numbers, picture, given)
                loss, bar = loss_of(self._loss, x, target, CLIP)
                weight = share / len(pictures)
                value += weight * loss
                pulled = self._backward(runs, weight * (bar if self._timing.times else bar[:, None]))
                slope += np.concatenate([
                    stage.map.T @ (f * own) for f, stage, own in zip(factors, self.stages, pulled, strict=True)
                ])  # fmt: skip
        self.last = value
        return value, slope

    def _forward(self, runs: list[AdjointTransient], numbers: list[Floats], picture: Floats, given: Floats) -> Floats:
        before, self._ends, x = self._planes(picture), [], picture
        for stage, run, own in zip(self.stages, runs, numbers, strict=True):
            planes = {"picture": before, "given": [given]}
            sources = {
                name: planes[source] if isinstance(source, str) else [np.full_like(before[0], source)]
                for name, source in (("input", stage.input), ("state", stage.initial_state))
            }
            run.inputs = [plane[:, None] for plane in sources["input"][: len(run.starts)]]
            run.state = sources["state"][0][:, None]
            states = run.forward(own[:-1], own[-1:], self._at(run))
            x = np.stack([states[step][:, 0] for step in self._at(run)], axis=1)
            before = [np.clip(x[:, -1], -1, 1)]
            self._ends.append(x[:, -1])
        return x if self._timing.times else x[:, 0]

    def _backward(self, runs: list[AdjointTransient], bar: Floats) -> list[Floats]:
        found: list[Floats] = []
        for number in range(len(runs) - 1, -1, -1):
            stage, run = self.stages[number], runs[number]
            pulled = run.backward(_by_step(self._at(run), bar))
            found.insert(0, np.append(pulled.weights, pulled.z))
            if number:
                back = [plane for name, plane in (("input", pulled.input[0]), ("initial_state", pulled.state))
                        if getattr(stage, name) == "picture"]  # fmt: skip
                slope = np.maximum(LEAK, slope_of(CLIP, self._ends[number - 1]))
                bar = (sum(plane[:, 0] for plane in back) * slope)[:, None]
        return found


def _by_step(at: tuple[int, ...], bar: Floats) -> dict[int, Floats]:
    """Return the derivatives (n, times, rows, cols) by the step at whose state they are."""
    found: dict[int, Floats] = {}
    for number, step in enumerate(at):
        found[step] = found.get(step, 0) + bar[:, number, None]
    return found
