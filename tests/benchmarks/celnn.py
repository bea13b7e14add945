"""Training next to celnn 1.0 on the same pairs, in one run: ``python -m tests.benchmarks.celnn``.

celnn, torch and deap are needed. Edges of pictures are learned by its genetic algorithm, edges of rows by its torch
gradient. The right pixels are those of unseen pictures.
"""

from collections.abc import Callable
from importlib import import_module
from time import process_time
from typing import Any

import numpy as np

import cnnsim
from cnnsim import Stage, TrainingTask, train
from cnnsim.support import Array

DURATION, STEP, UNSEEN = 6.0, 0.1, 30
LONG = {"pop_size": 60, "n_generations": 40}
ROW = [[0, 0, 0], ["free"] * 3, [0, 0, 0]]


def blobs(count: int, shape: tuple[int, int], seed: int) -> tuple[Array, Array]:
    """Return random black and white pictures and their edges."""
    noise = np.random.default_rng(seed).standard_normal((count, *shape))
    smooth = noise + np.roll(noise, 1, -1) + (np.roll(noise, 1, -2) + np.roll(noise, (1, 1), (-2, -1))) * (shape[0] > 1)
    pictures = np.where(smooth > 0, 1.0, -1.0)
    return pictures, np.sign(cnnsim.run("edge", pictures, boundary=cnnsim.fixed(-1)).y)


def ours(pictures: Array, targets: Array, stage: Stage, seed: int) -> Callable[[Array], Array]:
    """Return the trained template as a function of pictures."""
    return train(TrainingTask(list(zip(pictures, targets, strict=True)), [stage], seed=seed))


def genetic(pictures: Array, targets: Array, settings: dict[str, Any], seed: int) -> Callable[[Array], Array]:
    """Return the template that celnn's genetic algorithm evolves."""
    core, training = import_module("celnn"), import_module("celnn.training")
    config = core.SimulationConfig(t_end=DURATION, dt=STEP)
    start = core.Template(name="start", feedback=np.zeros((3, 3)), control=np.zeros((3, 3)), bias=0.0)
    where = {"boundary": "constant", "boundary_value": -1.0}
    best = training.GATrainer(
        start, training.TrainingDataset.from_pairs(list(pictures), list(targets)), config,
        ga_config=training.GAConfig(**settings), seed=seed, **where,
    ).run().best_template  # fmt: skip

    def run(unseen: Array) -> Array:
        networks = [core.CellularNetwork.from_template(best, input=one, **where) for one in unseen]
        return np.array([network.run(config).output for network in networks])

    return run


def by_torch(pictures: Array, targets: Array, seed: int) -> Callable[[Array], Array]:
    """Return the one-dimensional network that torch trains, with the hinge on the state that `train` uses."""
    torch, model = import_module("torch"), import_module("celnn.differentiable")
    torch.manual_seed(seed)
    network = model.DifferentiableCellularNetwork(1, boundary="constant", boundary_value=-1.0, dt=STEP,
                                                  steps=round(DURATION / STEP))  # fmt: skip
    with torch.no_grad():
        for weights in network.parameters():
            weights.copy_(0.5 * torch.randn(weights.shape))
    u, target = (torch.tensor(one[:, 0], dtype=torch.float32) for one in (pictures, targets))
    optimiser = torch.optim.Adam(network.parameters(), lr=0.05)
    for _ in range(500):
        optimiser.zero_grad()
        x = network(u)
        loss = (torch.relu(2 - target * x) ** 2).mean()
        loss.backward()
        optimiser.step()
        if bool((target * x > 1).all()):
            break

    def run(unseen: Array) -> Array:
        with torch.no_grad():
            return np.asarray(network(torch.tensor(unseen[:, 0], dtype=torch.float32)))[:, None]

    return run


def compare(
    name: str,
    learn: Callable[[Array, Array, int], Callable[[Array], Array]],
    shape: tuple[int, int],
    *,
    seeds: int = 3,
    warm: bool = True,
) -> None:
    """Print right pixels on unseen pictures and processor time of some seeds."""
    for seed in range(-1 if warm else 0, seeds):  # the first compiles loops and imports packages
        pictures, targets = blobs(8, shape, max(seed, 0))
        unseen, wanted = blobs(UNSEEN, shape, 100 + seed)
        start = process_time()
        found = learn(pictures, targets, max(seed, 0))
        seconds = process_time() - start
        right = float((found(unseen) * wanted > 0).mean())
        if seed < 0:
            continue
        print(f"{name:<44} seed {seed}  right {right:.4%}  {seconds:.1f} s", flush=True)


if __name__ == "__main__":
    square, line = (32, 32), (1, 64)
    free = Stage(initial_state=0.0, duration=DURATION)
    compare("edge, cnnsim, all 19 free", lambda p, t, s: ours(p, t, free, s), square)
    held = Stage(A=1, initial_state=0.0, duration=DURATION)
    compare("edge, cnnsim, A held at 1", lambda p, t, s: ours(p, t, held, s), square)
    compare("rows, celnn torch", by_torch, line)
    row = Stage(A=ROW, B=ROW, initial_state=0.0, duration=DURATION)
    compare("rows, cnnsim", lambda p, t, s: ours(p, t, row, s), line)
    compare("edge, celnn GA, its defaults", lambda p, t, s: genetic(p, t, {}, s), square, warm=False)
    compare("edge, celnn GA, four times as long", lambda p, t, s: genetic(p, t, LONG, s), square, seeds=1, warm=False)
