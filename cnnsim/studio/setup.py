"""Setup: what is run, on which picture, and how."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim import library
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.library.read_network import read_template
from cnnsim.library.write import template_keys
from cnnsim.network import AnyTemplate, Boundary, parse_boundary
from cnnsim.network.characteristic import Cell
from cnnsim.studio.pictures import SIDES, make_picture, moving
from cnnsim.support import Array, InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import shown
from cnnsim.support.pictures.read import read_picture
from cnnsim.support.values import is_number
from cnnsim.task import Task, make_task


@dataclass(frozen=True, eq=False)
class Setup:
    """A template of the library, perhaps changed, with its planes and choices.

    ``entry`` has the network, boundary, cell, step and accuracy as they are now, ``own`` as in its file; ``picture``
    (rows, cols), or (frames, rows, cols) of a template for sequences; ``made`` the name and seed it was made from, None
    where it was drawn or read; ``second`` the picture of x(0) where it has one of its own.
    """

    entry: LibraryEntry
    own: LibraryEntry
    picture: Array
    made: tuple[str, int] | None = None
    second: Array | None = None
    scheme: str | None = None
    backend: str = "cpu"

    @property
    def grid(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.picture.shape[-2], self.picture.shape[-1]

    @property
    def takes_second(self) -> bool:
        """Whether x(0) is a picture of its own."""
        roles = self.entry.initial_state
        return "given" in roles if isinstance(roles, tuple) else roles == "given"

    def task(self, **changes: Any) -> Task:
        """Return the checked task."""
        white = np.full(self.grid, -1.0) if self.second is None else self.second
        given = self.entry.task(self.picture, white if self.takes_second else None)
        given = self.entry.changed(given, {"scheme": self.scheme} if self.scheme else {})
        return make_task(self.entry.network, **self.entry.changed(given, changes))

    def on_grid(self, grid: tuple[int, int]) -> "Setup":
        """Return the setup on another grid; drawn pictures are made new.

        Raises:
            InputError: a grid of a size that is not allowed.
        """
        if not all(SIDES[0] <= side <= SIDES[1] for side in grid):
            raise InputError(f"a grid of {grid[0]} x {grid[1]}; sides of {SIDES[0]} to {SIDES[1]} cells wanted")
        name, seed = self.made or ("curves", 0)
        return replace(self, picture=self._sequence(make_picture(name, grid, seed)), made=(name, seed), second=None)

    def with_picture(self, picture: Array, made: tuple[str, int] | None = None) -> "Setup":
        """Return the setup with another picture (rows, cols); a template for sequences has it moving."""
        second = self.second if self.second is not None and self.second.shape == picture.shape[-2:] else None
        return replace(self, picture=self._sequence(picture), made=made, second=second)

    def _sequence(self, picture: Array) -> Array:
        if not self.entry.frame_time or picture.ndim == 3:
            return picture
        return moving(picture, max((len(one.input) for one in self.entry.examples if one.input is not None), default=8))

    @property
    def changed(self) -> bool:
        """Whether the numbers of the template were changed."""
        return template_keys(self.entry.network) != template_keys(self.own.network)


def boundary_text(boundary: Boundary) -> str:
    """Return a boundary as `parse_boundary` reads it."""
    return boundary.kind if boundary.kind != "fixed" else f"fixed:{boundary.y:g},{boundary.u:g}"


def first_setup(name: str, grid: tuple[int, int] = (64, 64), picture: str = "curves", seed: int = 0) -> Setup:
    """Return the setup of a template of the library, or of a file, with a made picture.

    Raises:
        InputError: no such template or picture.
    """
    entry = library.load(name)
    return Setup(entry, entry, np.zeros((1, 1)), (picture, seed)).on_grid(grid)


def example_of(entry: LibraryEntry, number: int) -> Example:
    """Return an example of a number.

    Raises:
        InputError: there is none.
    """
    if number >= len(entry.examples):
        raise InputError(f"example {number} of {entry.name!r}, which has {len(entry.examples)}")
    return entry.examples[number]


def example_setup(entry: LibraryEntry, number: int = 0) -> Setup:
    """Return the setup of a template on one of its worked examples.

    Raises:
        InputError: it has no such example.
    """
    example = example_of(entry, number)
    picture = example.state if example.input is None else example.input
    assert picture is not None
    setup = Setup(entry, entry, picture if picture.ndim == 2 or entry.frame_time else picture[0])
    second = None if example.state is None or example.state.ndim > 2 else example.state
    return replace(setup, second=second if setup.takes_second else None)


def given_setup(name: str, path: Path | None, *, binary: bool = False) -> Setup:
    """Return the setup of a template on a picture file; without one on its example if it takes several pictures.

    Raises:
        InputError: no such template, or a picture that cannot be read or is too large.
    """
    setup = first_setup(name)
    if path is None:
        several = setup.takes_second or setup.entry.frame_time
        return example_setup(setup.entry) if several and setup.entry.examples else setup
    picture = read_picture(path, binary=binary)
    if not all(SIDES[0] <= side <= SIDES[1] for side in picture.shape):
        raise InputError(
            f"{path}: {picture.shape[0]} x {picture.shape[1]} pixels; sides of {SIDES[0]} to {SIDES[1]} wanted"
        )
    return setup.with_picture(picture)


def changed(setup: Setup, changes: dict[str, Any]) -> Setup:
    """Return a setup with changes of a page: boundary, cell, scheme, step, accuracy, backend, network and others.

    Raises:
        InputError: a change that is not known, or of a wrong value.
    """
    entry = setup.entry
    for key, value in changes.items():
        match key:
            case "network":
                network = setup.own.network if value == "own" else network_of(value, entry.name)
                entry = replace(entry, network=network)
            case "boundary":
                entry = replace(entry, boundary=parse_boundary(value))
            case "cell":
                keeps = entry.cell.characteristic if value == entry.cell.model or value == "chua-yang" else None
                entry = replace(entry, cell=Cell(value, keeps))
            case "initial_state" if value not in ("picture", "given", "any"):
                if not is_number(value) or abs(value) > 1:
                    raise InputError(f"x(0) is {shown(value)}; picture, given, any or a number from -1 to 1 wanted")
                entry = replace(entry, initial_state=float(value))
            case "duration" if value != "settled" and not is_number(value):
                raise InputError(f"running time {shown(value)}; settled or a number of time constants wanted")
            case "step" if value is not None and not is_number(value):
                raise InputError(f"step {shown(value)}; a number of time constants wanted")
            case "step" | "accuracy" | "duration" | "initial_state":
                entry = replace(entry, **{key: value})
            case "scheme":
                setup = replace(setup, scheme=value or None)
            case "backend":
                setup = replace(setup, backend=value)
            case _:
                raise InputError(f"change of {shown(key)}, which is not known")
    if changes.get("accuracy") is not None:
        entry, setup = replace(entry, step=None), replace(setup, scheme=None)
    elif changes.get("scheme") or changes.get("step") is not None:
        entry = replace(entry, accuracy=None)
    return replace(setup, entry=entry)


def network_of(data: Any, name: str) -> AnyTemplate:
    """Return the network of the keys of a template file, as `template_keys` gives them.

    Raises:
        InputError: all errors.
    """
    if not isinstance(data, dict):
        raise InputError(f"network {shown(data)}; the keys of a template file wanted")
    errors = ErrorList()
    network = read_template(data, name, errors)
    errors.raise_all()
    assert network is not None
    return network
