"""What a page takes away: template files, Python, a command, pictures and films of the run."""

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim.formats.files import WRITERS
from cnnsim.library.entry import LibraryEntry
from cnnsim.library.write import template_text
from cnnsim.network import LayeredTemplate, Template
from cnnsim.studio.link import link_of
from cnnsim.studio.message import Message
from cnnsim.studio.setup import Setup, boundary_text
from cnnsim.support import InputError
from cnnsim.support.files import check_name
from cnnsim.support.pictures.film import write_film
from cnnsim.support.pictures.picture import to_image

if TYPE_CHECKING:
    from cnnsim.studio.session import Session

FILM_FRAMES = 60
"""Pictures of a film, at most."""


def has_file(setup: Setup) -> bool:
    """Return whether a template file of its own is needed: for other numbers, or another x(0)."""
    return setup.changed or setup.entry.initial_state != setup.own.initial_state


def file_name(setup: Setup) -> str:
    """Return the name of the template's file."""
    return setup.entry.name + "-changed" * has_file(setup)


def _choices(setup: Setup, own: LibraryEntry) -> dict[str, Any]:
    """Return the arguments of a run that differ from the template's file, without template and pictures."""
    entry = setup.entry
    now: dict[str, Any] = {
        "boundary": boundary_text(entry.boundary),
        "cell": entry.cell.model,
        "duration": entry.duration,
    }
    usual: dict[str, Any] = {"boundary": boundary_text(own.boundary), "cell": own.cell.model, "duration": own.duration}
    now |= {"scheme": setup.scheme, "step": entry.step, "accuracy": entry.accuracy, "backend": setup.backend}
    usual |= {"scheme": None, "step": own.step, "accuracy": own.accuracy, "backend": "cpu"}
    return {key: value for key, value in now.items() if value != usual[key]}


def command_line(setup: Setup) -> str:
    """Return the command that runs the setup on picture.png; a changed template is in a file of its own."""
    name = f"{file_name(setup)}.toml" if has_file(setup) else setup.entry.name
    words = ["cnnsim run", name, "picture.png", "-o out.png", *["--state start.png"] * setup.takes_second]
    choices = _choices(setup, setup.entry if has_file(setup) else setup.own)
    words += [
        f"--{'time' if key == 'duration' else key} {value}" for key, value in choices.items() if value != "settled"
    ]
    return " ".join(words)


def python_text(setup: Setup) -> str:
    """Return Python that runs the setup on picture.png."""
    entry, own, names = setup.entry, setup.own, {"read_picture", "run", "write_picture"}
    changes = {"network": _network_code(entry.network)} if setup.changed else {}
    if entry.initial_state != own.initial_state:
        changes["initial_state"] = repr(entry.initial_state)
    head, words, lines = list[str](), [repr(entry.name), "picture"], ['picture = read_picture("picture.png")']
    if changes:
        names |= {"library"} | {word for word in _CLASSES if f"{word}(" in changes.get("network", "")}
        given = "".join(f",\n    {key}={value}" for key, value in changes.items())
        lines.append(f"entry = replace(\n    library.load({entry.name!r}){given},\n)")
        head, words[0] = ["from dataclasses import replace", ""], "entry"
    if setup.takes_second:
        lines.append('start = read_picture("start.png")')
        words.append("state=start")
    words += [f"{key}={value!r}" for key, value in _choices(setup, own).items()]
    lines += [f"result = run({', '.join(words)})", 'write_picture(result.y, "out.png")']
    return "\n".join([*head, f"from cnnsim import {', '.join(sorted(names))}", "", *lines]) + "\n"


_CLASSES = ("LayeredTemplate", "Table", "Template", "Term")


def _network_code(network: Template | LayeredTemplate) -> str:
    if isinstance(network, LayeredTemplate):
        layers = ", ".join(map(_network_code, network.layers))
        return f"LayeredTemplate([{layers}], {list(network.time_constants)!r}, {network.name!r})"
    terms = []
    for term in network.terms:
        parts = [repr(term.weights.tolist()), repr(str(term.of))]
        if term.table is not None:
            parts.append(f"table={term.table!r}")
        if term.times is not None:
            parts.append(f"times={str(term.times)!r}")
        parts += [f"delay={term.delay!r}"] if term.delay else []
        parts += [f"layer={term.layer!r}"] if term.layer is not None else []
        terms.append(f"Term({', '.join(parts)})")
    numbers = f"{network.A.tolist()!r}, {network.B.tolist()!r}, {network.z!r}, {network.name!r}"
    return f"Template({numbers}, [{', '.join(terms)}])"


def _save(session: "Session", message: Message) -> Message:
    """Reply with a file: toml, tem, png, gif, mp4, picture or start."""
    what, setup, run = message.text("what"), session.setup, session.run
    name = message.text("name", "") or (file_name(setup) if what in ("toml", "tem") else setup.entry.name)
    check_name(name, "template")
    match what:
        case "toml" | "tem":
            entry = replace(setup.entry, name=name, network=_named(setup.entry.network, name))
            if has_file(setup):
                entry = replace(entry, examples=(), margin=None, reference=f"changed from {setup.own.name}")
            text = template_text(entry) if what == "toml" else WRITERS["tem"](entry)
            return _file(f"{name}.{what}", text.encode())
        case "png":
            return _file(f"{name}.png", _png(session.layer(run.y, message)))
        case "picture" | "start":
            plane = setup.picture if what == "picture" else np.asarray(run.task.state)
            return _file(f"{what}.png", _png(plane[0] if plane.ndim == 3 else plane))
        case "gif" | "mp4":
            count = min(FILM_FRAMES, run.index - run.first + 1)
            steps = [int(i) for i in np.unique(np.linspace(run.first, run.index, count).round())]
            frames = [run.task.plan.output(x) for x in run.states(steps)]
            with TemporaryDirectory() as folder:
                path = Path(folder) / f"{name}.{what}"
                write_film(frames, path, times=[step * run.step for step in steps])
                return _file(path.name, path.read_bytes())
    raise InputError(f"what = {what!r}; toml, tem, png, gif, mp4, picture or start wanted")


def _named(network: Template | LayeredTemplate, name: str) -> Template | LayeredTemplate:
    if isinstance(network, LayeredTemplate):
        return LayeredTemplate(network.layers, network.time_constants, name)
    return Template(network.A, network.B, network.z, name, network.terms)


def _file(name: str, data: bytes) -> Message:
    return Message({"is": "file", "name": name, "bytes": len(data)}, [data])


def _png(plane: np.ndarray) -> bytes:
    file = BytesIO()
    to_image(plane).save(file, format="PNG")
    return file.getvalue()


def _code(session: "Session", _message: Message) -> Message:
    setup = session.setup
    return Message({"is": "code", "python": python_text(setup), "command": command_line(setup), "link": link_of(setup)})


HANDLERS = {"save": _save, "code": _code}
