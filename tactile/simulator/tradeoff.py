"""Error and time of a scene with the effects and the accuracy chosen for several tolerances."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter, thread_time

from tactile.simulator.auto_effects import choose
from tactile.simulator.scene.scene import Scene
from tactile.simulator.sizes import Sample

TOLERANCES = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
FRAMES = 400
"""Frames that are computed; of a longer scene as many, at a lower rate."""


@dataclass(frozen=True)
class Trade:
    """One choice of effects.

    ``tolerance`` 0 for all effects of the scene; ``bound`` of the error and the largest ``error`` measured with some
    seeds, relative to the peak; ``left_out``: dropped effects; ``choosing`` [s]; ``seconds`` of processor time per
    frame of one finger.
    """

    tolerance: float
    bound: float
    error: float
    left_out: tuple[str, ...]
    choosing: float
    seconds: float


def trades(scene: Scene, tolerances: Sequence[float] = TOLERANCES, seeds: int = 3, rounds: int = 5) -> Iterator[Trade]:
    """Yield all effects of the scene, then the choice for each tolerance.

    Arguments: ``seeds``: number of seeds with which the error is measured, the scene's own first; ``rounds``: number of
    timed runs, of which the best counts, alternating with all effects.
    """
    if scene.samples > FRAMES:
        scene = replace(scene, rate=FRAMES / scene.duration)
    samples = [Sample(replace(scene, seed=seed)) for seed in (scene.seed, *range(10_001, 10_000 + seeds))]
    truth = [sample.run(scene.effects) for sample in samples]
    base = min(_seconds(scene) for _ in range(rounds))
    yield Trade(0.0, 0.0, 0.0, (), 0.0, base)
    for tolerance in tolerances:
        start = perf_counter()
        choice = choose(scene, tolerance, reused=True)
        choosing, error = perf_counter() - start, 0.0
        for sample, true in zip(samples, truth, strict=True):
            chosen = Sample(replace(choice.scene, seed=sample.scene.seed))
            error = max(error, sample.gap(chosen.run(choice.scene.effects), true))
        pairs = [(_seconds(choice.scene), _seconds(scene)) for _ in range(rounds)]
        ratio = min(one for one, _ in pairs) / min(other for _, other in pairs)
        yield Trade(tolerance, choice.bound, error, tuple(choice.left_out), choosing, base * ratio)


def _seconds(scene: Scene) -> float:
    """Processor time [s] of this thread per frame of one finger, which other work on the machine changes little."""
    start = thread_time()
    for finger in range(len(scene.arrays)):
        for _ in scene.batches(finger):
            pass
    return (thread_time() - start) / scene.samples / len(scene.arrays)
