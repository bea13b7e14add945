"""The library: templates as data. One TOML file is one template with its source and its own worked pictures."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.backends.base import Backend
from cnnsim.characteristic import CHUA_YANG, Cell, parse_cell
from cnnsim.errors import InputError
from cnnsim.frames import Frames
from cnnsim.grid import Boundary, parse_boundary
from cnnsim.layers import AnyTemplate, LayeredTemplate
from cnnsim.library_kinds import TEMPLATE_KEYS, read_pictures, read_template
from cnnsim.library_path import add as add  # ours to offer: `library.add(DIR)`, `with library.using(DIR)`
from cnnsim.library_path import files, not_found
from cnnsim.library_path import folder as folder
from cnnsim.library_path import using as using
from cnnsim.plan import DEFAULT_STEP, Duration, usual_limit
from cnnsim.running_time import RunningTime, guaranteed_time
from cnnsim.template import Template
from cnnsim.toml_file import check_keys, read_toml
from cnnsim.transient import Choices, Dtype, Result, run_transient

Role = Literal["picture", "given", "none", "any"] | float


@dataclass(frozen=True)
class Example:
    """Planes in and the output that must come out (to ``tolerance``; None: a binary output, compared by sign)."""

    input: NDArray[np.float64] | None
    state: NDArray[np.float64] | None
    output: NDArray[np.float64]
    mask: NDArray[np.float64] | None
    bias: NDArray[np.float64] | None
    tolerance: float | None

    def holds(self, y: NDArray[Any]) -> bool:
        """Return whether an output is the one that was worked out: right sign and |y| > 0.99, or within tolerance."""
        if self.tolerance is not None:
            return bool(np.abs(y - self.output).max() <= self.tolerance)
        return bool(np.all(y * self.output > 0.99))


@dataclass(frozen=True)
class LibraryEntry:
    """A template with all that is needed to use it as meant: roles of the pictures, boundary, running time, examples.

    ``input`` (u): "picture", a constant, or "none". ``initial_state`` (x(0)): "picture" (the same one), "given" (a
    second one), a constant, or "any" (0 is used); for a ``network`` of layers it may be one of these a layer. With
    ``frame_time`` [time constants] the picture is a sequence (frames, rows, cols), x(0) its first frame. ``cell`` and
    ``step`` belong to the template where it works with no other.
    """

    name: str
    summary: str
    reference: str
    tags: tuple[str, ...]
    network: AnyTemplate
    input: Role
    initial_state: Role | tuple[Role, ...]
    boundary: Boundary
    duration: Duration
    margin: float | None
    note: str
    aliases: tuple[str, ...]
    examples: tuple[Example, ...]
    file: Path | None = None
    cell: Cell = CHUA_YANG
    step: float | None = None
    frame_time: float | None = None

    @property
    def shipped(self) -> bool:
        """True if the file is one of ours, not of a user's own library."""
        return self.file is not None and self.file.parent == folder()

    @property
    def template(self) -> Template:
        """The template of a single layer.

        Raises:
            InputError: this one has several.
        """
        if isinstance(self.network, LayeredTemplate):
            raise InputError(f"template {self.name!r} has {len(self.network.layers)} layers; a single layer wanted")
        return self.network

    def running_time(self, shape: tuple[int, int], *, step: float | None = None, walls: bool = False) -> RunningTime:
        """Return `guaranteed_time` on a grid (rows, cols), for the file's own step unless another is given.

        ``walls`` says that a mask may hold cells.
        """
        if not isinstance(self.network, Template) or isinstance(self.initial_state, tuple):
            return RunningTime(None, "it has several layers")
        if self.cell.model == "discrete-time" or self.cell.characteristic is not None:
            return RunningTime(None, "its cells are not those of Chua and Yang")
        return guaranteed_time(
            self.network, shape, self.boundary, input=self.input, initial_state=self.initial_state,
            step=step or self.step or DEFAULT_STEP, walls=walls,
        )  # fmt: skip

    def limit(self, shape: tuple[int, int], *, walls: bool = False) -> float:
        """Return how long to wait for rest on a grid: as usual, or the guaranteed time if that is longer.

        One time constant is added to it, as rest is looked for once in each.
        """
        known, usual = self.running_time(shape, walls=walls).time, usual_limit(shape)
        return usual if known is None else max(usual, known + 1.0)

    def task(self, picture: ArrayLike, state: ArrayLike | None = None) -> dict[str, Any]:
        """Return what `run_transient` takes for a picture (and a second one): planes, boundary, time, cell, step."""
        task = {**self.planes(picture, state), "boundary": self.boundary, "duration": self.duration, "cell": self.cell}
        if self.duration == "settled":
            task["limit"] = self.limit(task["state"].shape[-2:])
        elif self.frame_time:  # a longer sequence than that of the file is seen to its end
            task["duration"] = max(self.duration, self.frame_time * len(np.asarray(picture)))
        return task if self.step is None else {**task, "step": self.step}

    def planes(self, picture: ArrayLike, state: ArrayLike | None = None) -> dict[str, Any]:
        """Return the planes ``input`` and ``state`` that the picture (and the second one) stand for.

        Raises:
            InputError: a second picture is missing, or there is no use for it.
        """
        roles = self.initial_state if isinstance(self.initial_state, tuple) else (self.initial_state,)
        layers = len(self.network.layers) if isinstance(self.network, LayeredTemplate) else 0
        shape = (layers, *np.shape(picture)[-2:]) if layers else np.shape(picture)
        shape = shape[-2:] if self.frame_time else shape
        if state is None and "given" in roles:
            raise InputError(f"template {self.name!r} takes a second picture, as initial state, and none was given")
        if state is not None and "given" not in roles:
            raise InputError(f"template {self.name!r} takes one picture; a second one, as initial state, was given")
        first = np.asarray(picture)[0] if self.frame_time else picture

        def start(role: Any) -> NDArray[np.float64]:
            return np.asarray({"picture": first, "given": state, "any": 0.0}.get(str(role), role), dtype=np.float64)

        if len(roles) == 1:
            planes: dict[str, Any] = {"state": np.broadcast_to(start(roles[0]), shape)}
        else:
            planes = {"state": np.array([np.broadcast_to(start(role), shape[-2:]) for role in roles])}
        if self.input != "none":
            heard = Frames(list(np.asarray(picture)), self.frame_time) if self.frame_time else picture
            planes["input"] = heard if self.input == "picture" else np.full(shape, self.input)
        return planes


_REQUIRED = ("name", "summary", "reference", "input", "initial_state", "boundary", "duration")
_OPTIONAL = ("tags", "margin", "note", "aliases", "example", "cell", "step", "frame_time", *TEMPLATE_KEYS)
_PLANES = ("input", "state", "output", "mask", "bias")


def run(
    entry: LibraryEntry | str, picture: ArrayLike, *, state: ArrayLike | None = None, backend: str | Backend = "cpu",
    dtype: Dtype | None = None, **changes: Unpack[Choices],
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
    try:
        entry = replace(_entry(data, path.stem), file=path)
        if entry.shipped and not entry.examples:
            raise InputError("no worked example; at least one [[example]] wanted")
        return entry
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _entry(data: dict[str, Any], stem: str) -> LibraryEntry:
    check_keys(data, (*_REQUIRED, *_OPTIONAL), required=_REQUIRED)
    if data["name"] != stem:
        raise InputError(f"the name is {data['name']!r}, the file is {stem}.toml; one name wanted")
    template, roles = read_template(data, data["name"]), data["initial_state"]
    words = ("picture", "given", "any")
    entry = LibraryEntry(
        data["name"], data["summary"], data["reference"], tuple(data.get("tags", ())), template,
        _role("input", data["input"], ("picture", "none")),
        tuple(_role("initial_state", role, words) for role in roles) if isinstance(roles, list)
        else _role("initial_state", roles, words),
        parse_boundary(data["boundary"]), data["duration"], data.get("margin"), data.get("note", ""),
        tuple(data.get("aliases", ())), tuple(_example(item) for item in data.get("example", ())),
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
