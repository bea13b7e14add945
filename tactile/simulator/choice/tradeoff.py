"""What accuracy costs in a scene: effects chosen for several tolerances, their error and time against all effects."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter, thread_time

from tactile.simulator.choice.auto_effects import all_effects, choose
from tactile.simulator.choice.estimate import Sample
from tactile.simulator.scene.scene import Scene

TOLERANCES = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
FRAMES, FEWEST = 400, 40
"""Frames of a scene that are computed; of a longer one as many, evenly spread over its duration, and fewer of a slow
one."""
BUDGET = 0.4
"""Seconds that one run of all effects may take."""


@dataclass(frozen=True)
class Trade:
    """One choice of effects.

    ``tolerance`` 0 for all effects; ``bound`` of its error and the largest ``error`` found over some seeds, relative to
    the peak; ``left_out``: effects; ``choosing`` [s], once; ``seconds`` of processor time a frame of one finger.
    """

    tolerance: float
    bound: float
    error: float
    left_out: tuple[str, ...]
    choosing: float
    seconds: float


def shortened(scene: Scene) -> Scene:
    """The scene at a rate at which it has as many frames as are computed."""
    few = replace(scene, rate=max(min(scene.samples, 8), 1) / scene.duration)
    _seconds(few)  # whatever is compiled, and tables
    most = int(min(max(BUDGET / _seconds(few), FEWEST), FRAMES))
    return scene if scene.samples <= most else replace(scene, rate=most / scene.duration)


def trades(scene: Scene, tolerances: Sequence[float] = TOLERANCES, seeds: int = 3, rounds: int = 5) -> Iterator[Trade]:
    """Yield all effects on, then the choice for each tolerance.

    Arguments: ``seeds``: on how many seeds the error is measured, the scene's own first; ``rounds``: of so many runs,
    in turn with all effects on, the best time counts.
    """
    described = scene.effects
    whole = shortened(scene.with_effects(all_effects(scene)))
    scene = whole.with_effects(described)
    draws = [scene.seed, *range(10_001, 10_000 + seeds)]
    samples = [Sample(replace(scene, seed=seed)) for seed in draws]
    truth = [sample.run(whole.effects) for sample in samples]
    base = min(_seconds(whole) for _ in range(rounds))
    yield Trade(0.0, 0.0, 0.0, (), 0.0, base)
    for tolerance in tolerances:
        start = perf_counter()
        choice = choose(scene, tolerance, reused=True)
        choosing = perf_counter() - start
        runs = zip(samples, truth, strict=True)
        error = max(sample.gap(sample.run(choice.scene.effects), true) for sample, true in runs)
        pairs = [(_seconds(choice.scene), _seconds(whole)) for _ in range(rounds)]
        ratio = min(one for one, _ in pairs) / min(other for _, other in pairs)
        yield Trade(tolerance, choice.bound, error, tuple(choice.left_out), choosing, base * ratio)


def _seconds(scene: Scene) -> float:
    """Processor time of a frame of one finger, which other work on the machine changes little.

    That of this thread: others of a parallel loop go on waiting for more work long after it, each as it happens.
    """
    start = thread_time()
    for finger in range(len(scene.arrays)):
        for _ in scene.batches(finger):
            pass
    return (thread_time() - start) / scene.samples / len(scene.arrays)
