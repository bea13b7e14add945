"""Progress of a program on a large grid: its step, and the blocks or the time of the operation in it."""

from collections.abc import Callable, Mapping

from cnnsim.support.progress import Watcher, watcher


class ProgramProgress:
    """Which ``step`` a program is at; ``shares``: of the program, done before each step by the name it has there."""

    def __init__(self, shares: Mapping[str, float]) -> None:
        self._shares, self.step = shares, ""

    def tell(self, words: str) -> None:
        """Tell whoever watches the step and a few words about it."""
        if (told := watcher()) is not None:
            told(self._shares.get(self.step), f"{self.step}: {words}")

    def of_blocks(self, blocks: int) -> Callable[[int], None]:
        """Return what takes how many blocks of an operation are done."""
        return lambda done: self.tell(f"{done} of {blocks} blocks")

    def of_supersteps(self) -> Watcher | None:
        """Return what watches supersteps for whoever watches the program, None where nobody does."""
        outer = watcher()
        return None if outer is None else _Step(outer, self._shares.get(self.step), self.step)


class _Step(Watcher):
    def __init__(self, outer: Watcher, share: float | None, step: str) -> None:
        self._outer, self._share, self._step = outer, share, step

    def __call__(self, _share: float | None, text: str) -> None:
        self._outer(self._share, f"{self._step}: {text}")

    def over(self) -> None:
        """See `Watcher`: the program is not over."""
