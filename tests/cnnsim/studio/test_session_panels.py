"""The playground without its page: links, cells, library, precision, files and programs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cnnsim import library, run_program
from cnnsim.library.write import template_keys
from cnnsim.network import Template
from cnnsim.studio.colours import values
from cnnsim.studio.exports import command_line, python_text
from cnnsim.studio.link import link_of, read_link
from cnnsim.studio.pictures import make_picture
from cnnsim.studio.session import Session
from cnnsim.studio.setup import Setup, changed, example_setup, first_setup, given_setup
from cnnsim.support import InputError
from tests.kits.studio import GRID, ask


def test_a_link_holds_everything() -> None:
    setup = first_setup("hole-filler", GRID, "black and white noise", 5)
    network = template_keys(setup.entry.network) | {"z": -0.25}
    setup = changed(setup, {"network": network, "boundary": "fixed:0.5,-1", "scheme": "rk4", "step": 0.05})
    setup = changed(setup, {"cell": "full-range", "duration": 3.0, "backend": "reference", "initial_state": "given"})
    again = read_link("#" + link_of(setup))
    assert link_of(again) == link_of(setup)
    task, other = setup.task(), again.task()
    assert np.array_equal(task.state, other.state)
    assert task.plan.decisions == other.plan.decisions
    free = changed(first_setup("autowave"), {"step": None})  # its file has a step
    assert read_link(link_of(free)).entry.step is None
    drawn = Setup(setup.entry, setup.own, make_picture("shapes", GRID), None, make_picture("dot", GRID))
    again = read_link(link_of(drawn))
    assert np.array_equal(again.picture, drawn.picture)
    assert again.second is not None
    assert np.array_equal(again.second, make_picture("dot", GRID))


WRONG_LINKS = ["template=../x", "template=nothing", "size=9x", "size=9999x9999", "seed=-1", "weights=x",
               "drawn=eJwDAAAAAAE", "boundary=round", "picture=none", "step=x", "scheme=x"]  # fmt: skip


@pytest.mark.parametrize("text", WRONG_LINKS)
def test_a_wrong_link_is_an_error(text: str) -> None:
    with pytest.raises(InputError):
        read_link(text).task()


def test_a_cell_shows_its_contributions_and_equilibria(session: Session) -> None:
    ask(session, "frame", to=30)
    facts = ask(session, "cell", row=3, col=5).content
    y, u, template = session.run.y, session.setup.picture, session.setup.entry.template
    assert np.allclose(facts["A"], template.A * y[2:5, 4:7])
    assert np.allclose(facts["B"], template.B * u[2:5, 4:7])
    assert facts["drive"] == pytest.approx(np.sum(facts["A"]) + np.sum(facts["B"]) + template.z)
    assert facts["x"][-1] == pytest.approx(float(session.run.x[3, 5]))
    assert len(facts["t"]) == len(facts["x"]) == 31
    x, rates = np.array(facts["route"]["x"]), np.array(facts["route"]["rate"])
    push = facts["drive"] - 3 * float(y[3, 5])  # all but the cell's own output
    assert np.allclose(rates, -x + 3 * np.clip(x, -1, 1) + push)
    for point in facts["route"]["equilibria"]:
        assert -point["x"] + 3 * np.clip(point["x"], -1, 1) + push == pytest.approx(0, abs=1e-6)
        assert point["stable"] == (abs(point["x"]) > 1)


@pytest.mark.parametrize("name", ["median", "motion-right", "autowave", "life-discrete", "diffusion", "recall"])
def test_other_kinds_of_templates_run_are_inspected_and_edited(name: str) -> None:
    session = Session(example_setup(library.load(name)))
    ask(session, "frame", to=6)
    facts = ask(session, "cell", row=1, col=1).content
    assert len(facts["x"]) == 7
    rebuilt = ask(session, "set", changes={"network": template_keys(session.setup.entry.network)}).content
    assert rebuilt["changed"] is False
    assert read_link(link_of(session.setup)).entry.name == name


RULES: list[dict[str, Any]] = [{"scheme": "adaptive"}, {"accuracy": 1e-3}, {"cell": "full-range"},
    {"cell": "discrete-time"}, {"boundary": "periodic"}, {"scheme": "heun", "step": 0.2}]  # fmt: skip


@pytest.mark.parametrize("changes", RULES, ids=str)
def test_all_rules_run_forward_and_back(changes: dict[str, Any], session: Session) -> None:
    ask(session, "set", changes=changes)
    ask(session, "frame", by=3)
    while session.run.index < 6:
        ask(session, "frame", by=1, rest=True)
    there = session.run.x
    ask(session, "frame", to=2)
    ask(session, "frame", to=6)
    assert np.array_equal(session.run.x, there)
    ask(session, "cell", row=2, col=3)


def test_the_library_is_searched_and_judged(session: Session) -> None:
    found = ask(session, "library", words="HOLE fill").content
    assert "hole-filler" in [row["name"] for row in found["found"]]
    assert found["of"] == len(library.names())
    tagged = ask(session, "library", tag="morphology").content["found"]
    assert [row["name"] for row in tagged] == library.names("morphology")
    reply = ask(session, "compare", example=1)
    assert reply.content["passed"]
    assert reply.content["wrong"] == 0
    assert all(ask(session, "check").content["passed"])
    network = template_keys(session.setup.entry.network) | {"z": 9}
    ask(session, "set", changes={"network": network})
    reply = ask(session, "compare", example=0)
    assert not reply.content["passed"]
    assert sum(reply.buffers[3]) == reply.content["wrong"] > 0
    assert not all(ask(session, "check").content["passed"])


def test_chips_with_errors_fail_more_with_larger_ones(session: Session) -> None:
    exact = ask(session, "chip", sigma=0.0, seed=1).content
    assert (exact["wrong"], exact["good"]) == (0, 1)
    for _ in range(4):
        reply = ask(session, "chip", sigma=0.6, seed=1)
    assert reply.content["count"] == 4
    assert reply.content["share"] > 0
    assert max(reply.buffers[0]) > 0
    assert max(reply.buffers[0]) == np.ceil(session.chips.failed.max() * 255 / 4)  # type: ignore[union-attr]  # just made


def test_accuracy_is_measured_on_the_picture() -> None:
    session = Session(first_setup("diffusion", GRID))
    coarse, fine = (ask(session, "precision", number=number).content["row"] for number in (4, 23))
    assert coarse["error"] > 1e-3 > fine["error"]


def test_files_can_be_saved_and_read_again(session: Session, tmp_path: Path) -> None:
    network = template_keys(session.setup.entry.network) | {"z": -0.75}
    ask(session, "set", changes={"network": network})
    ask(session, "frame", to=12)
    for what in ("toml", "tem", "png", "gif", "picture", "start"):
        reply = ask(session, "save", what=what, name="my-filler" if what in ("toml", "tem") else "")
        (tmp_path / reply.content["name"]).write_bytes(reply.buffers[0])
    entry = library.load_file(tmp_path / "my-filler.toml")
    assert entry.template.z == -0.75
    assert ask(session, "save", what="toml").content["name"] == "hole-filler-changed.toml"
    assert (tmp_path / "my-filler.tem").stat().st_size
    with Image.open(tmp_path / "hole-filler.gif") as film:
        assert getattr(film, "n_frames", 0) == 13
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size == GRID[::-1]
        assert np.array_equal(np.asarray(picture) == 0, session.setup.picture == 1)


@pytest.mark.parametrize("name", ["hole-filler", "median", "autowave"])
def test_the_copied_python_gives_what_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    setup = changed(first_setup(name, GRID, "noise"), {"boundary": "periodic", "duration": 1.0})
    network = template_keys(setup.entry.network)
    (network["layer"][0] if "layer" in network else network)["z"] = 0.125
    setup = changed(setup, {"network": network})
    session = Session(setup)
    (tmp_path / "picture.png").write_bytes(ask(session, "save", what="picture").buffers[0])
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {}
    exec(compile(python_text(setup), "copied", "exec"), space)
    assert (
        isinstance(getattr(space["entry"].network, "template", space["entry"].network), Template) or name == "autowave"
    )
    read = Setup(setup.entry, setup.own, space["picture"])
    task = read.task()
    assert np.allclose(space["result"].x, task.start(session.run.backend).x, atol=1e-5)


def test_the_copied_command_has_what_was_changed() -> None:
    setup = changed(first_setup("hole-filler", GRID), {"boundary": "periodic", "scheme": "rk4", "step": 0.05})
    wanted = "cnnsim run hole-filler picture.png -o out.png --boundary periodic --scheme rk4 --step 0.05"
    assert command_line(setup) == wanted
    network = template_keys(setup.entry.network) | {"z": 2}
    setup = changed(setup, {"network": network, "initial_state": "given"})
    wanted = "cnnsim run hole-filler-changed.toml picture.png -o out.png --state start.png --scheme rk4"
    assert command_line(setup) == wanted


def test_a_program_shows_each_step(session: Session) -> None:
    reply = ask(session, "program", name="skeleton")
    steps = reply.content["steps"]
    assert {"number", "does", "to"} <= steps[1].keys()
    assert any("template" in step for step in steps)
    expected = run_program("skeleton", picture=session.setup.picture)["skeleton"]
    last = [step for step in steps if step["to"] == "skeleton"][-1]
    assert reply.content["shown"] <= reply.content["ran"]
    if reply.content["shown"] == reply.content["ran"]:
        assert np.array_equal(values(reply.buffers[last["plane"]], GRID) > 0, expected > 0)
    counted = ask(session, "program", name="count-objects").content
    assert counted["numbers"]
    assert len(ask(session, "programs").content["found"]) > 30


def test_a_picture_file_is_what_is_shown(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 255] * 4] * 6, np.uint8)).save(tmp_path / "small.png")
    setup = given_setup("edge", tmp_path / "small.png")
    assert setup.picture.tolist() == [[1, -1] * 4] * 6
    Image.new("L", (2000, 5)).save(tmp_path / "wide.png")
    with pytest.raises(InputError, match="5 x 2000 pixels"):
        given_setup("edge", tmp_path / "wide.png")
    assert given_setup("motion-right", tmp_path / "small.png").picture.ndim == 3
