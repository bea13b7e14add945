"""Learning of a detector: examples, a fit to all of them, and a trial of fits to parts of them."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from cnnsim.support import InputError
from tactile.core.source import Source
from tactile.events.detector_file import KIND
from tactile.learning.collect import Example, collect
from tactile.learning.detector import detector_text
from tactile.learning.fit import Learned, fit
from tactile.learning.front import Front
from tactile.learning.trial import Held, folds, made_by_shipped
from tactile.score.labels import LabelledSource
from tactile.settings import Settings

Watch = Callable[[Iterable[LabelledSource]], Iterable[LabelledSource]]


@dataclass(frozen=True)
class LearningTask:
    """What is learned: the ``kind`` of event, from the planes of ``front``, with at most ``limit`` weights.

    An event lasts at least ``lasting`` [s]; the rest of its contact is not used. The same ``seed`` gives the same
    detector.

    Raises:
        InputError: a kind that is no name.
    """

    kind: str
    front: Front
    limit: int = 10
    lasting: float = 0.2
    seed: int = 0

    def __post_init__(self) -> None:
        if not KIND.fullmatch(self.kind):
            raise InputError(f"kind {self.kind!r}; lower-case letters, digits and _ wanted, such as 'two_taps'")

    @property
    def own_kind(self) -> str:
        """The kind of the learned detector's events: no shipped detector makes it."""
        return f"learned_{self.kind}" if made_by_shipped(self.kind) else self.kind


@dataclass(frozen=True)
class Lesson:
    """The examples of a task, and the detector that is learned from all of them."""

    task: LearningTask
    examples: Sequence[Example]
    learned: Learned

    def text(self, name: str) -> str:
        """Return the detector file."""
        return _text(self.task, self.learned, self.examples, name)

    @contextmanager
    def held_out(self) -> Iterator[dict[str, list[Held]]]:
        """Yield detectors that are learned with recordings left out, and with arrays left out, in temporary files."""
        found = dict[str, list[Held]]()
        with TemporaryDirectory() as folder:
            for by in ("recording", "array"):
                found[by] = []
                for n, part in enumerate(folds(self.examples, by)):
                    others = [one for k, one in enumerate(self.examples) if k not in part]
                    learned = fit(others, self.task.front, self.task.limit, self.task.lasting, self.task.seed)
                    path = Path(folder) / f"without-{by}-{n}.toml"
                    path.write_text(_text(self.task, learned, others, path.stem), encoding="utf-8")
                    mine = [self.examples[k] for k in part]
                    found[by].append(Held(frozenset((one.recording, one.finger) for one in mine), path))
            yield found


def learn(
    cases: Sequence[LabelledSource], task: LearningTask, settings: Callable[[Source], Settings], watch: Watch = iter
) -> Lesson:
    """Learn a detector from labelled recordings; ``watch`` passes them on and may show progress.

    Raises:
        InputError: readings that are missing or not finite, a finger without a tare, no time of the event.
    """
    if not any(task.kind in label.times for case in cases for label in case.labels):
        raise InputError(f"no time of a {task.kind} in the labels of {len(cases)} recordings; one or more wanted")
    examples = collect(watch(cases), task.kind, task.front, settings)
    return Lesson(task, examples, fit(examples, task.front, task.limit, task.lasting, task.seed))


def _text(task: LearningTask, learned: Learned, examples: Sequence[Example], name: str) -> str:
    with_event = sum(bool(one.known) for one in examples)
    source = f"{len(examples)} fingers of recordings, {with_event} of them with the event"
    return detector_text(learned, name, task.own_kind, source)
