"""Catalogue of the library: finds a template by name, reads and checks its file, and runs it as the file says."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Unpack

from numpy.typing import ArrayLike

from cnnsim.backends.base import Backend
from cnnsim.library.entry import Example, LibraryEntry, Role
from cnnsim.library.folders import files, not_found
from cnnsim.library.read import TEMPLATE_KEYS, read_pictures, read_template
from cnnsim.network import LayeredTemplate, parse_boundary
from cnnsim.network.characteristic import parse_cell
from cnnsim.support import InputError, naming
from cnnsim.support.toml_file import check_keys, read_toml
from cnnsim.transient import Dtype, Result, TaskOptions, run_transient

_REQUIRED = ("name", "summary", "reference", "input", "initial_state", "boundary", "duration")
_OPTIONAL = ("tags", "margin", "note", "aliases", "example", "cell", "step", "frame_time", *TEMPLATE_KEYS)
_PLANES = ("input", "state", "output", "mask", "bias")


def run(
    entry: LibraryEntry | str, picture: ArrayLike, *, state: ArrayLike | None = None, backend: str | Backend = "cpu",
    dtype: Dtype | None = None, **changes: Unpack[TaskOptions],
) -> Result:  # fmt: skip
    """Run a library template on a picture (rows, cols) of CNN values as its file says.

    ``state`` is the second picture of templates that take one. ``changes`` replace what the file says: boundary,
    duration, cell, scheme, step, limit, bias, mask, as in `run_transient`; so are ``backend`` and ``dtype``.
    """
    entry = load(entry) if isinstance(entry, str) else entry
    return run_transient(entry.network, **{**entry.task(picture, state), **changes}, backend=backend, dtype=dtype)


def run_example(entry: LibraryEntry, example: Example, backend: str | Backend = "cpu", **changes: Any) -> Result:
    """Run a template on one of its own examples."""
    picture = example.state if example.input is None else example.input
    given = "given" in entry.initial_state if isinstance(entry.initial_state, tuple) else entry.initial_state == "given"
    second = example.state if given else None
    assert picture is not None
    return run(entry, picture, state=second, backend=backend, mask=example.mask, bias=example.bias, **changes)


def names(tag: str | None = None) -> list[str]:
    """Return the names of all templates, or of those with a tag, in alphabetical order."""
    return list(files()) if tag is None else [name for name in files() if tag in load(name).tags]


def load(name: str) -> LibraryEntry:
    """Return the library template called ``name``, from the last folder that has it.

    Raises:
        InputError: there is none (the message has the nearest names), or its file is wrong.
    """
    path = files().get(name)
    if path is None:
        raise not_found("template", name, names(), "cnnsim list")
    return _load_once(path, path.stat().st_mtime_ns)


@cache
def _load_once(path: Path, changed: int) -> LibraryEntry:
    """Load a file again only when it has changed."""
    return load_file(path)


def load_file(path: Path) -> LibraryEntry:
    """Read and check one template file. A shipped one has a worked example; a user's own may do without.

    Raises:
        InputError: what is wrong, with the file's name.
    """
    data = read_toml(path, "template file")
    with naming(path):
        entry = replace(_entry(data, path.stem), file=path)
        if entry.shipped and not entry.examples:
            raise InputError("no worked example; at least one [[example]] wanted")
        return entry


def _entry(data: dict[str, Any], stem: str) -> LibraryEntry:
    check_keys(data, (*_REQUIRED, *_OPTIONAL), required=_REQUIRED)
    if data["name"] != stem:
        raise InputError(f"the name is {data['name']!r}, the file is {stem}.toml; one name wanted")
    template, roles = read_template(data, data["name"]), data["initial_state"]
    words = ("picture", "given", "any")
    entry = LibraryEntry(
        data["name"], data["summary"], data["reference"], template, _role("input", data["input"], ("picture", "none")),
        tuple(_role("initial_state", role, words) for role in roles) if isinstance(roles, list)
        else _role("initial_state", roles, words),
        parse_boundary(data["boundary"]), data["duration"], tuple(data.get("tags", ())), data.get("margin"),
        data.get("note", ""), tuple(data.get("aliases", ())), tuple(_example(item) for item in data.get("example", ())),
        cell=parse_cell(data.get("cell", "chua-yang")), step=data.get("step"), frame_time=data.get("frame_time"),
    )  # fmt: skip
    if template.reads_input and entry.input == "none":
        raise InputError("B is not zero, or a term reads u, but input is 'none'")
    if isinstance(roles, list) and not (isinstance(template, LayeredTemplate) and len(roles) == len(template.layers)):
        raise InputError(f"{len(roles)} initial states; one, or one a layer, wanted")
    return entry


def _role(key: str, value: Any, words: tuple[str, ...]) -> Role:
    if value in words or (isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 1):
        return value
    raise InputError(f"{key} is {value!r}; one of {', '.join(map(repr, words))} or a number from -1 to 1 wanted")


def _example(data: dict[str, Any]) -> Example:
    check_keys(data, (*_PLANES, "tolerance"), required=("output",))
    planes = {key: read_pictures(data[key]) if key in data else None for key in _PLANES}
    if planes["input"] is None and planes["state"] is None:
        raise InputError("an example without input and without state; at least one of them wanted")
    shapes = {key: plane.shape[-2:] for key, plane in planes.items() if plane is not None}
    if len(set(shapes.values())) > 1:
        raise InputError(f"an example's planes have different shapes: {shapes}")
    return Example(**planes, tolerance=data.get("tolerance"))  # type: ignore[arg-type]  # output is required above
