"""The library as a page shows it: search, worked examples with their difference, and the verdict on all of them."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim import library
from cnnsim.convergence import NotSettledError
from cnnsim.library.catalogue import run_example, sound
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.network import LayeredTemplate
from cnnsim.studio.colours import indices
from cnnsim.studio.message import Message
from cnnsim.studio.setup import Setup, example_of, example_setup
from cnnsim.support import Array, InputError

if TYPE_CHECKING:
    from cnnsim.studio.session import Session


def matches(entry: LibraryEntry, words: str) -> bool:
    """Return whether each word is in the name, an alias, the summary or a tag."""
    text = " ".join([entry.name, entry.summary, *entry.aliases, *entry.tags]).lower()
    return all(word in text for word in words.lower().split())


def _library(session: "Session", message: Message) -> Message:
    """Reply with the templates that have all words of a search, and a tag if one is given."""
    words, tag = message.text("words", ""), message.text("tag", "")
    entries = sound()[0]
    found = [entry for entry in entries if matches(entry, words) and (not tag or tag in entry.tags)]
    tags = sorted({tag for entry in entries for tag in entry.tags})
    rows = [{"name": e.name, "summary": e.summary, "tags": e.tags, "kind": _kind(e)} for e in found]
    return Message({"is": "library", "found": rows, "tags": tags, "of": len(entries)})


def _kind(entry: LibraryEntry) -> str:
    network = entry.network
    if isinstance(network, LayeredTemplate):
        return f"{len(network.layers)} layers"
    delayed = any(term.delay for term in network.terms)
    kinds = ["sequence"] * bool(entry.frame_time) + ["delayed"] * delayed + ["non-linear"] * bool(network.terms)
    return ", ".join(kinds or ["discrete-time" if entry.cell.model == "discrete-time" else "linear"])


def load_template(setup: Setup, name: str, example: int | None = None) -> Setup:
    """Return a setup with another template, on the same picture, or on one of the template's examples.

    A template that takes several pictures begins on its first example.
    """
    entry = library.load(name)
    fresh = replace(setup, entry=entry, own=entry, scheme=None)
    if example is None and (fresh.takes_second or entry.frame_time) and entry.examples:
        example = 0
    if example is not None:
        return replace(example_setup(entry, example), backend=setup.backend)
    return fresh.with_picture(setup.picture[0] if setup.picture.ndim == 3 else setup.picture, setup.made)


def _template(session: "Session", message: Message) -> Message:
    """Take another template of the library, on the present picture or on its example of a number."""
    number = message.whole("example", 0, 1000) if "example" in message.content else None
    session.change(load_template(session.setup, message.text("name"), number))
    return session.receive(Message({"do": "planes"}))


def _compare(session: "Session", message: Message) -> Message:
    """Reply with an example's input, its expected output, what the template gives, and where they differ.

    The numbers of the template are the present ones, the rules (boundary, cell, time) those of the page.
    """
    entry, number = session.setup.entry, message.whole("example", 0, 1000, 0)
    example = example_of(entry, number)
    y, passed, said = _output(entry, example)
    wrong = np.abs(y - example.output) > (0.01 if example.tolerance is None else example.tolerance)
    layer = message.whole("layer", 0, session.layers() - 1, 0)
    given = example.state if example.input is None else example.input
    planes = [_flat(plane, layer) for plane in (given, example.output, y, wrong)]
    content = {"is": "compared", "example": number, "passed": passed, "said": said,
               "wrong": int(wrong.sum()), "shape": planes[1].shape}  # fmt: skip
    data = [indices(plane).tobytes() for plane in planes[:3]] + [planes[3].astype(np.uint8).tobytes()]
    return Message(content, data)


def _check(session: "Session", _message: Message) -> Message:
    """Reply with PASS or FAIL of the present numbers on each of the template's own examples."""
    entry = session.setup.entry
    found = [_output(entry, example)[1:] for example in entry.examples]
    return Message({"is": "checked", "passed": [passed for passed, _ in found], "said": [said for _, said in found]})


def _output(entry: LibraryEntry, example: Example) -> tuple[Array, bool, str]:
    """Return the output on an example, whether it holds, and what went wrong."""
    try:
        y = run_example(entry, example).y
    except NotSettledError as error:
        return np.asarray(error.result.y), False, "it does not settle"
    except InputError as error:
        return np.zeros_like(example.output), False, str(error)
    return y, example.holds(y), ""


def _flat(plane: Any, layer: int) -> Array:
    return np.asarray(plane if plane.ndim == 2 else plane[min(layer, len(plane) - 1)])


HANDLERS = {"library": _library, "template": _template, "compare": _compare, "check": _check}
