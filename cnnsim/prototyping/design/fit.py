"""Fit coupled templates to pairs of pictures by differential evolution over whole runs.

Storn and Price, J. Global Optimization 11 (1997) 341, in scipy. Templates from examples by evolution: Kozek, Roska and
Chua, "Genetic algorithm for CNN template learning", IEEE Trans. CAS-I 40 (1993) 392.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Literal

import numpy as np

from cnnsim import backends
from cnnsim.network import Boundary, Template
from cnnsim.network.cell import output
from cnnsim.planning.step import DEFAULT_STEP
from cnnsim.prototyping.design.rule_files import PicturePair, as_pair
from cnnsim.support import Array, Floats, InputError
from cnnsim.task import make_task

Symmetry = Literal["all", "mirror", "none"]

_SHARED: dict[Symmetry, list[list[int]]] = {
    "all": [[1, 3, 5, 7], [0, 2, 6, 8], [4]],
    "mirror": [[0, 2], [1], [3, 5], [4], [6, 8], [7]],
    "none": [[i] for i in range(9)],
}
"""Entries of a 3 x 3 matrix, row by row, that are one number."""

_DENSE = np.full((3, 3), 0.1)


@dataclass(frozen=True)
class Fit:
    """The best template: ``wrong`` of ``cells`` cells are wrong on the pairs, after ``runs`` transients."""

    template: Template
    initial_state: str | float
    wrong: int
    cells: int
    runs: int

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading

        text = f"{self.wrong} of {self.cells} cells wrong after {self.runs} runs, x(0) = {self.initial_state}"
        return heading("Fit", text) + self.template._repr_html_()


def fit(
    pairs: Sequence[PicturePair], boundary: Boundary, *, name: str = "fitted", symmetry: Symmetry = "all",
    initial_state: str | float = "picture", largest: float = 5.0, limit: float = 60.0, seed: int = 0,
    generations: int = 60, report: Callable[[int, float], None] | None = None,
) -> Fit:  # fmt: skip
    """Search for a template with neighbours in A that turns every input into its output; the input is the picture.

    Arguments: ``symmetry``: which entries share a number; ``initial_state`` is "picture" or a constant; entries lie
    within +-``largest``, a from 1 up, so that outputs are black and white; a run is read out after ``limit`` time
    constants at the latest. ``report`` is called after each generation with its number and the best share of wrong
    cells. All pairs of one size run as one batch. The same seed gives the same template.

    Raises:
        InputError: no pairs.
    """
    from scipy.optimize import differential_evolution

    if not pairs:
        raise InputError("no pairs of pictures to fit a template to")
    search = _Search([as_pair(pair) for pair in pairs], boundary, symmetry, initial_state, limit, name)
    number = len(_SHARED[symmetry])
    bounds = [(-largest, largest)] * (2 * number + 1)
    bounds[_SHARED[symmetry].index([4])] = (1.0, largest)
    count = iter(range(1, generations + 2))

    def after(_best: Floats, convergence: float = 0.0) -> bool:
        if report is not None:
            report(next(count), search.best)
        return search.best == 0

    found = differential_evolution(
        search.share_of_wrong, bounds, seed=seed, maxiter=generations, popsize=8, tol=0.0,
        polish=False, callback=after, init="sobol",
    )  # fmt: skip
    best = search.shortened(found.x, largest)
    return Fit(search.template(best), initial_state, search.wrong(best), search.cells, search.runs)


class _Search:
    """The error of a parameter vector on pairs of pictures, in batches of one size."""

    def __init__(
        self, pairs: Sequence[PicturePair], boundary: Boundary, symmetry: Symmetry, initial_state: str | float,
        limit: float, name: str,
    ) -> None:  # fmt: skip
        self.shared, self.name = _SHARED[symmetry], name
        by_size = sorted(pairs, key=lambda pair: pair[0].shape)
        self.backend, self.batches = backends.get(), []
        for _, group in groupby(by_size, key=lambda pair: pair[0].shape):
            picture, wanted = (np.stack(planes) for planes in zip(*group, strict=True))
            state = picture if initial_state == "picture" else np.full(picture.shape, initial_state)
            task = make_task(
                Template(_DENSE, _DENSE), state=state, input=picture, boundary=boundary, limit=limit,
                without=["shared sums"],
            )  # fmt: skip
            self.batches.append((task, wanted))
        self.cells = sum(pair[0].size for pair in pairs)
        self.runs, self.best = 0, np.inf

    def template(self, numbers: Floats) -> Template:
        """Return the template for (A, B, z), each distinct entry once."""
        size = len(self.shared)
        matrices = np.zeros((2, 9))
        for number, places in enumerate(self.shared):
            matrices[0, places], matrices[1, places] = numbers[number], numbers[size + number]
        return Template(matrices[0].reshape(3, 3), matrices[1].reshape(3, 3), float(numbers[-1]), self.name)

    def wrong(self, numbers: Floats) -> int:
        """Return the number of wrong cells."""
        return sum(int((y * wanted <= 0).sum()) for y, wanted in self._outputs(numbers))

    def share_of_wrong(self, numbers: Floats) -> float:
        """Return the share of wrong cells; cells that are not quite black or white count a little."""
        total = 0.0
        for y, wanted in self._outputs(numbers):
            total += float((y * wanted <= 0).sum()) + 0.1 * float((np.abs(y - wanted) > 0.01).sum())
        self.best = min(self.best, total / self.cells)
        return total / self.cells

    def shortened(self, numbers: Floats, largest: float) -> Floats:
        """Round the numbers to as few digits, and as many zeros, as keep the error."""
        best, value = numbers, self.share_of_wrong(numbers)
        for digits in (3, 2, 1):
            trial = np.clip(np.round(best, digits), -largest, largest)
            if self.share_of_wrong(trial) <= value:
                best = trial
        for place in np.argsort(np.abs(best)):
            trial = best.copy()
            trial[place] = 1.0 if place == self.shared.index([4]) else 0.0
            if self.share_of_wrong(trial) <= value:
                best = trial
        return best

    def _outputs(self, numbers: Floats) -> list[tuple[Array, Array]]:
        template, found = self.template(numbers), []
        # one plan for all templates, as a new one would cost more than a run; Gershgorin: no mode decays faster
        fastest = max(1.0, 1.0 - 2.0 * template.self_feedback + float(np.abs(template.A).sum()))
        for task, wanted in self.batches:
            self.runs += 1
            plan = replace(task.plan, template=template, step=min(DEFAULT_STEP, 1.0 / fastest))
            try:
                outcome = task.start(self.backend, plan=plan)
            except InputError:
                found.append((np.zeros(wanted.shape), wanted))
                continue
            y = output(self.backend.read(outcome.x))
            found.append((y if outcome.settled else 0.5 * y, wanted))  # its colours count, but not as final
        return found
