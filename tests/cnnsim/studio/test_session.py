"""The playground without its page: frames are those of `run_transient`, changes act, links hold everything."""

from typing import Any

import numpy as np
import pytest

from cnnsim import library, run, run_transient
from cnnsim.library.write import template_keys
from cnnsim.studio.colours import BLACK, GREY, WHITE, indices, values
from cnnsim.studio.message import Message
from cnnsim.studio.pictures import NAMES, make_picture
from cnnsim.studio.run import Run
from cnnsim.studio.session import Session
from cnnsim.studio.setup import example_setup, first_setup
from cnnsim.support import InputError
from tests.kits.studio import GRID, ask


def test_colours_keep_black_grey_and_white_and_show_what_is_beyond() -> None:
    x = np.array([[-9.0, -1.001, -1.0, 0.0, 1.0, 1.001, 9.0]], np.float32)
    assert indices(x).tolist() == [[0, WHITE - 1, WHITE, GREY, BLACK, BLACK + 1, 255]]
    assert values(bytes([0, WHITE, GREY, BLACK, 255]), (1, 5)).tolist() == [[-1, -1, 0, 1, 1]]
    levels = np.arange(WHITE, BLACK + 1, dtype=np.uint8)[None]
    assert (indices(values(levels.tobytes(), levels.shape)) == levels).all()


@pytest.mark.parametrize("name", ["hole-filler", "edge", "life-discrete", "motion-right", "median"])
def test_every_frame_is_the_state_of_a_run_of_that_time(name: str) -> None:
    setup = example_setup(library.load(name))
    run_ = Session(setup).run
    for index in (4, 9, 2, 9):  # on, back, and on again
        run_.go(index)
        task = setup.task(duration=index * run_.step)
        assert np.array_equal(run_.x, run_.backend.read(task.start(run_.backend).x)), index
    assert run_.states([0, 3])[1].shape == run_.x.shape
    assert run_.index == 9


def test_a_state_far_back_is_recomputed_from_the_nearest_kept_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cnnsim.studio.run.MOST_KEPT", 3000)
    setup = first_setup("hole-filler", GRID)
    task = setup.task()
    one = Run(task, Session(setup).run.backend)
    seen = []
    for _ in range(60):
        one.go(one.index + 1)
        seen.append(one.x)
    assert sum(x.nbytes for x in one.kept.values()) < 4000
    for index in (7, 33, 59, 1):
        one.go(index)
        assert np.array_equal(one.x, seen[index - 1])


def test_it_stops_at_rest_or_at_the_templates_own_time(session: Session) -> None:
    for _ in range(200):
        content = ask(session, "frame", by=5, rest=True).content
        if content["ended"]:
            break
    assert content["settled"]
    expected = run("hole-filler", session.setup.picture)
    assert np.array_equal(session.run.y > 0, expected.y > 0)
    timed = Session(first_setup("diffusion", GRID))
    content = ask(timed, "frame", by=10**6, rest=True).content
    assert (content["ended"], content["settled"], content["index"]) == (True, False, timed.run.last)


def test_a_change_while_it_runs_goes_on_from_the_present_state(session: Session) -> None:
    ask(session, "frame", to=7)
    before = session.run.x.copy()
    network = template_keys(session.setup.entry.network) | {"z": -0.5}
    content = ask(session, "set", changes={"network": network}, live=True).content
    assert content["changed"]
    assert (session.run.index, session.run.first) == (7, 7)
    ask(session, "frame", by=3)
    expected = run_transient(
        session.setup.entry.template, state=before, input=session.setup.picture, boundary="fixed:-1", duration=0.3,
        scheme="euler", step=0.1,
    )  # fmt: skip
    assert np.allclose(session.run.x, expected.x, atol=1e-5)
    assert ask(session, "set", changes={"network": "own"}).content["changed"] is False
    assert session.run.index == 0


def test_a_wrong_change_is_an_error_and_changes_nothing(session: Session) -> None:
    before = session.setup
    wrong: list[dict[str, Any]] = [
        {"scheme": "euler", "step": 50.0}, {"boundary": "fixed:7"}, {"network": {"A": [[1, 2]], "z": 0}},
        {"network": {"A": "x"}}, {"network": 3}, {"cell": "round"}, {"colour": 1}, {"accuracy": "much"},
        {"duration": -1}, {"backend": "gpu"}, {"network": {"A": [[1e400]], "z": 0}}, {"initial_state": "x"},
    ]  # fmt: skip
    for changes in wrong:
        with pytest.raises(InputError):
            ask(session, "set", changes=changes)
        assert session.setup is before
    for content in ({"do": "frame", "by": "1"}, {"do": "x"}, {}, {"do": 3}, {"do": "cell", "row": 99, "col": 0},
                    {"do": "save", "what": "exe"}, {"do": "save", "what": "toml", "name": "../x"},
                    {"do": "program", "name": "../x"}, {"do": "picture", "rows": 10**6}):  # fmt: skip
        with pytest.raises(InputError):
            session.receive(Message(content))
    assert session.setup is before


def test_drawing_changes_the_input_the_initial_and_the_present_state(session: Session) -> None:
    patch = bytes([BLACK] * 6)
    ask(session, "draw", patch, plane="input", row=1, col=2, rows=2, cols=3)
    assert (session.setup.picture[1:3, 2:5] == 1).all()
    assert session.setup.made is None
    ask(session, "draw", bytes([GREY] * 6), plane="start", row=0, col=0, rows=3, cols=2)
    assert (session.run.x[:3, :2] == 0).all()
    assert session.run.x[5, 5] == 1  # x(0) of the template elsewhere
    ask(session, "frame", to=4)
    ask(session, "draw", patch, plane="state", row=4, col=4, rows=1, cols=6)
    assert (session.run.x[4, 4:10] == 1).all()
    assert session.run.first == 4
    with pytest.raises(InputError, match="bytes for"):
        ask(session, "draw", b"1", plane="input", row=0, col=0, rows=2, cols=2)


@pytest.mark.parametrize("name", NAMES)
def test_made_pictures_are_the_same_for_the_same_seed(name: str) -> None:
    one, same = (make_picture(name, (20, 30), 3) for _ in range(2))
    assert one.shape == (20, 30)
    assert np.array_equal(one, same)
    assert np.abs(one).max() <= 1
