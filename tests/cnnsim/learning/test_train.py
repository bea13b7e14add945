"""Training: edges, shadows and a grey task from pairs alone, files, resumed trainings, and refused tasks."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.ndimage import gaussian_filter

from cnnsim import (
    Frames,
    InputError,
    Stage,
    Template,
    Training,
    TrainingTask,
    library,
    load_program,
    run,
    run_program,
    run_transient,
    train,
)
from cnnsim.cli.group import main
from cnnsim.learning.objective import Disturbance, Objective, Timing
from cnnsim.learning.spec import read_training
from cnnsim.network import ZERO_FLUX
from cnnsim.prototyping.robust.margin import margin_of
from tests.kits.paths import ROOT


def scenes(seed: int, count: int, side: int) -> Any:
    """Return black and white pictures of blobs of three sizes."""
    rng = np.random.default_rng(seed)
    fields = [gaussian_filter(rng.normal(size=(side, side)), (0.7, 1.2, 2.0)[n % 3]) for n in range(count)]
    return np.where(np.array(fields) > 0, 1.0, -1.0)


def task_of(name: str, side: int, stage: Stage, **options: Any) -> TrainingTask:
    """Return the task of learning a library template from eight pairs."""
    pictures, entry = scenes(5, 8, side), library.load(name)
    pairs = list(zip(pictures, np.sign(run(entry, pictures).y), strict=True))
    return TrainingTask(pairs, [stage], name="learned", boundary=entry.boundary, **options)


EDGE = Stage(A=1, initial_state=0.0, duration=6.0)


@pytest.fixture(scope="module")
def edge() -> Training:
    return train(task_of("edge", 16, EDGE))


def test_edges_are_learned_right_in_every_pixel_of_unseen_pictures(edge: Training) -> None:
    unseen = scenes(99, 10, 40)
    assert (edge.wrong, edge.starts) == (0, 1)
    assert np.array_equal(np.sign(edge(unseen)), np.sign(run("edge", unseen).y))
    assert edge.snapped == 1.0
    assert np.array_equal(edge.templates[0].B, [[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]])
    assert edge.curve[-1] < 0.1 * edge.curve[0]


def test_the_files_hold_the_template_its_margin_its_examples_and_the_record(edge: Training, tmp_path: Path) -> None:
    path, record = edge.write(tmp_path)
    entry = library.load(str(path))
    assert all(example.holds(library.run_example(entry, example).y) for example in entry.examples)
    assert len(entry.examples) == 2
    assert entry.margin == margin_of(entry).value == 1.0
    assert json.loads(record.read_text())["wrong"] == 0
    with pytest.raises(InputError, match="there already"):
        edge.write(tmp_path)


def test_a_stopped_training_goes_on_from_its_record(
    edge: Training, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record, count, judge = tmp_path / "record.json", iter(range(20)), Objective.__call__

    def stop(self: Objective, free: Any) -> Any:
        if next(count) == 15:
            raise KeyboardInterrupt
        return judge(self, free)

    monkeypatch.setattr(Objective, "__call__", stop)
    with pytest.raises(KeyboardInterrupt):
        train(edge.task, record)
    monkeypatch.setattr(Objective, "__call__", judge)
    before = json.loads(record.read_text())["curve"]
    again = train(edge.task, record)
    assert again.wrong == 0
    assert list(again.curve[: len(before)]) == before
    with pytest.raises(InputError, match="the record of another training"):
        train(replace(edge.task, seed=1, pairs=[(p.picture, p.target) for p in edge.task.pairs]), record)


def test_a_shadow_is_learned(monkeypatch: pytest.MonkeyPatch) -> None:
    stage = Stage(A=[[0, 0, 0], ["free"] * 3, [0, 0, 0]], B=[["free"]], initial_state=1.0, duration=20.0)
    found = train(task_of("shadow-left", 12, stage))
    unseen = scenes(99, 10, 20)
    assert np.array_equal(np.sign(found(unseen)), np.sign(run("shadow-left", unseen).y))


def test_two_stages_become_a_program(tmp_path: Path) -> None:
    """The grey output of the first stage is the input of the second one; the program gives what the training gives."""
    rng = np.random.default_rng(2)
    pictures = rng.uniform(-0.9, 0.9, (4, 8, 8))
    targets = np.stack([gaussian_filter(p, 1.0, mode="nearest") for p in pictures])
    stages = [Stage(A=0, z=0, symmetry="all", initial_state=0.0, duration=2.0)] * 2
    found = train(
        TrainingTask(list(zip(pictures, targets, strict=True)), stages, name="blur", boundary="zero-flux", starts=3)
    )
    assert found.error < 0.5 * np.sqrt(np.mean((pictures - targets) ** 2))
    *_, program, _ = found.write(tmp_path)
    y = run_program(load_program(program), backend="reference", picture=pictures[0])["stage_2"]
    np.testing.assert_allclose(y, found(pictures[0]), atol=1e-9)


def test_a_template_is_learned_from_sequences_with_targets_at_given_times(tmp_path: Path) -> None:
    """The outputs of another template on sequences at three times give back its weights, but for small errors."""
    teacher = Template([[0.5]], [[0, 0.3, 0], [0.2, 0.6, 0], [0, -0.3, 0]], 0.1)
    sequences, times = np.random.default_rng(3).uniform(-1, 1, (4, 3, 6, 7)), (0.5, 1.5, 3.0)
    given = {"state": 0.0 * sequences[0, 0], "boundary": ZERO_FLUX, "dtype": "float64"}
    pairs = [
        (frames, np.stack([run_transient(teacher, input=Frames(frames, 1.0), duration=t, **given).y for t in times]))
        for frames in sequences
    ]
    stage = Stage(A=[["free"]], initial_state=0.0, duration=3.0)
    task = TrainingTask(pairs, [stage], "told", ZERO_FLUX, decay=0.0, starts=1, frame_time=1.0, times=times)
    found = train(task)
    assert found.error < 0.01
    np.testing.assert_allclose(found.templates[0].A, teacher.A, atol=0.05)
    np.testing.assert_allclose(found.templates[0].B, teacher.B, atol=0.05)
    path, _ = found.write(tmp_path)
    entry = library.load(str(path))
    assert (entry.frame_time, len(entry.examples)) == (1.0, 2)
    assert all(example.holds(library.run_example(entry, example).y) for example in entry.examples)
    objective = Objective(task.pairs, task.stages, ZERO_FLUX, "squares", Disturbance(), (0, 0), 0, Timing(1.0, times))
    free, way = np.random.default_rng(0).normal(size=(2, 11)) / 3
    slope = (objective(free + 1e-6 * way)[0] - objective(free - 1e-6 * way)[0]) / 2e-6
    assert objective(free)[1] @ way == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frame_time": 1.0}, r"pair 1: picture has shape \(4, 4\); \(frames, rows, cols\) wanted"),
        ({"frame_time": 0.0}, "frame_time 0.0; a positive number"),
        ({"frame_time": 1.0, "times": [1.0, 11.0]}, "times 11.0; times of the targets above 0, up to the duration 10"),
        (
            {"frame_time": 3.0, "pairs": [(np.ones((4, 2, 2)), np.ones((2, 2)))]},
            "4 frames last 12; a stage of that duration",
        ),
        ({"times": [1.0]}, "frame_time None; a positive number"),
        ({"frame_time": 1.0, "stages": [Stage(), Stage()]}, "sequences and 2 stages; one stage wanted"),
    ],
)
def test_wrong_sequences_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        TrainingTask(**{"pairs": [(np.ones((4, 4)), np.ones((4, 4)))], **changes})


def test_the_objective_has_the_derivative_of_finite_differences() -> None:
    """With disturbances, terms, symmetry, penalties and pairs of two sizes."""
    terms = library.load("perona-malik").template.terms
    stage = Stage(symmetry="mirror", z=0.1, terms=terms, duration=1.0)
    task = TrainingTask([(p, 0.5 * p) for size in (6, 7) for p in scenes(1, 2, size)], [stage], boundary=ZERO_FLUX)
    objective = Objective(task.pairs, task.stages, ZERO_FLUX, "squares", Disturbance(0.1, 0.05), (0.01, 0.02), 0)
    rng = np.random.default_rng(0)
    free, way = 0.1 * rng.normal(size=(2, objective.sizes[0]))
    slope = (objective(free + 1e-6 * way)[0] - objective(free - 1e-6 * way)[0]) / 2e-6
    assert objective(free)[1] @ way == pytest.approx(slope, rel=1e-6)


def test_the_example_file_is_read_and_wrong_tasks_are_refused_in_one_line(tmp_path: Path) -> None:
    task = read_training(ROOT / "examples" / "learn" / "edge.toml")
    assert (len(task.pairs), task.binary) == (8, True)
    black = np.ones((4, 4))
    cases: list[tuple[str, Any]] = [
        (r"pair 1: target has shape \(3, 4\), the outputs have \(4, 4\)", [(black, np.ones((3, 4)))]),
        ("pair 1: target holds 2 in cell", [(black, 2 * black)]),
        ("pair 1: target holds nan", [(black, np.nan * black)]),
        ("pair 1: picture holds numbers that are not finite", [(np.nan * black, black)]),
        ("all cells of all targets are white", [(black, -black)]),
        ("0 pairs and 1 stages", []),
    ]
    for text, pairs in cases:
        with pytest.raises(InputError, match=text) as error:
            TrainingTask(pairs)
        assert "\n" not in str(error.value)
    for text, stage in (
        ("symmetry", {"symmetry": "al"}),
        ("some are held", {"A": [[0, 1, 0], ["free", 1, 1], [0, 1, 0]], "symmetry": "all"}),
        ("without a free", {"A": 1, "B": 1, "z": 0}),
        ("odd square", {"B": [[1, 2]]}),
    ):
        with pytest.raises(InputError, match=text):
            Stage(**stage)
    for text, more in (
        ("unknown key 'stat'", "[[stage]]\nstat = 1"),
        ("no picture", "[[pair]]\ninput = 'a.png'\noutput = 'b.png'"),
    ):
        path = tmp_path / "bad.toml"
        path.write_text(f"name = 'bad'\n{more}\n")
        with pytest.raises(InputError, match=text):
            read_training(path)


def test_the_command_writes_what_the_page_says_and_overwrites_nothing(tmp_path: Path) -> None:
    words = ["train", str(ROOT / "examples" / "learn" / "edge.toml"), "-o", str(tmp_path)]
    done = CliRunner().invoke(main, [*words, "--curve", str(tmp_path / "curve.png"), "--json"])
    assert done.exit_code == 0, done.output
    facts = json.loads(done.stdout)
    assert (facts["wrong"], facts["templates"][0]["margin"]) == (0, 1.0)
    assert {Path(path).name for path in facts["files"]} == {"learned-edge.toml", "learned-edge-training.json"}
    assert (tmp_path / "curve.png").stat().st_size > 1000
    again = CliRunner().invoke(main, words)
    assert again.exit_code == 2
    assert "--replace" in again.output
    assert "0 of 8192 cells wrong" in CliRunner().invoke(main, [*words, "--replace"]).output


def test_the_python_of_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    for block in re.findall(
        r"```python\n(.*?)```", (ROOT / "docs" / "how-to" / "learn.md").read_text("utf-8"), re.DOTALL
    ):
        exec(compile(block, "learn.md", "exec"), names)
    assert "(8, 16, 16)" in capsys.readouterr().out
