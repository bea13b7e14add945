"""Library entry: a template with its inputs, boundary, running time and worked examples."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.library.folders import folder
from cnnsim.network import CHUA_YANG, ZERO_FLUX, AnyTemplate, Boundary, Cell, Frames, LayeredTemplate, Template
from cnnsim.planning.plan import usual_limit
from cnnsim.planning.step import DEFAULT_STEP, Duration
from cnnsim.solver.tolerance import Accuracy
from cnnsim.support import Array, Floats, InputError
from cnnsim.support.notices import Notices
from cnnsim.support.values import as_numbers, as_picture, has_zeros_for_white
from cnnsim.theory.running_time import RunningTime, guaranteed_time

Role = Literal["picture", "given", "none", "any"] | float


@dataclass(frozen=True)
class Example:
    """A worked example: planes and their output, exact to ``tolerance`` (None: a binary output, compared by sign)."""

    input: Floats | None
    state: Floats | None
    output: Floats
    mask: Floats | None = None
    bias: Floats | None = None
    tolerance: float | None = None

    def __post_init__(self) -> None:
        for name in ("input", "state", "output", "mask", "bias"):
            plane = getattr(self, name)
            if plane is not None:
                plane = as_numbers(name, plane, levels=name == "bias", logic=name == "mask")
                object.__setattr__(self, name, plane)

    def holds(self, y: Array) -> bool:
        """Return whether an output agrees with the example: same sign and |y| > 0.99, or within the tolerance."""
        if self.tolerance is not None:
            return bool(np.abs(y - self.output).max() <= self.tolerance)
        return bool(np.all(y * self.output > 0.99))


@dataclass(frozen=True, repr=False)
class LibraryEntry:
    """A template of the library with the roles of pictures, boundary, running time and examples.

    ``input`` (u): "picture", a constant, or "none". ``initial_state`` (x(0)): "picture" (the same one), "given" (a
    second one), a constant, or "any" (0 is used); for a ``network`` of layers it may be one per layer. With
    ``frame_time`` [time constants] the picture is a sequence (frames, rows, cols), x(0) its first frame. ``cell`` and
    ``step`` are set if the template works with no other; ``accuracy`` replaces a step.
    """

    name: str
    summary: str
    reference: str
    network: AnyTemplate
    input: Role = "picture"
    initial_state: Role | tuple[Role, ...] = "picture"
    boundary: Boundary = ZERO_FLUX
    duration: Duration = "settled"
    tags: tuple[str, ...] = ()
    margin: float | None = None
    note: str = ""
    aliases: tuple[str, ...] = ()
    examples: tuple[Example, ...] = ()
    file: Path | None = None
    cell: Cell = CHUA_YANG
    step: float | None = None
    frame_time: float | None = None
    accuracy: Accuracy | None = None

    def __repr__(self) -> str:
        return f"LibraryEntry({self.name!r}, {self.summary!r}, {self.network!r})"

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import facts, heading

        said = {"input u": self.input, "initial state": self.initial_state, "boundary": self.boundary,
                "running time": self.duration, "source": self.reference}  # fmt: skip
        return heading(self.name, self.summary) + self.network._repr_html_() + facts(said)

    @property
    def shipped(self) -> bool:
        """Whether the file is in the shipped library."""
        return self.file is not None and self.file.parent == folder()

    @property
    def template(self) -> Template:
        """The template of a network of one layer.

        Raises:
            InputError: the network has several layers.
        """
        if isinstance(self.network, LayeredTemplate):
            raise InputError(f"template {self.name!r} has {len(self.network.layers)} layers; a single layer wanted")
        return self.network

    def running_time(self, shape: tuple[int, int], *, step: float | None = None, has_mask: bool = False) -> RunningTime:
        """Return `guaranteed_time` on a grid (rows, cols), with the step of the file if none is given."""
        if not isinstance(self.network, Template) or isinstance(self.initial_state, tuple):
            return RunningTime(None, "it has several layers")
        if self.cell.model == "discrete-time" or self.cell.characteristic is not None:
            return RunningTime(None, "its cells are not those of Chua and Yang")
        return guaranteed_time(
            self.network, shape, self.boundary, input=self.input, initial_state=self.initial_state,
            step=step or self.step or DEFAULT_STEP, has_mask=has_mask,
        )  # fmt: skip

    def limit(self, shape: tuple[int, int], *, has_mask: bool = False) -> float:
        """Return the limit of a run until it settles: the usual one, or the guaranteed time + 1 if that is longer."""
        known, usual = self.running_time(shape, has_mask=has_mask).time, usual_limit(shape)
        return usual if known is None else max(usual, known + 1.0)

    def task(self, picture: ArrayLike, state: ArrayLike | None = None) -> dict[str, Any]:
        """Return the arguments of `run_transient` for a picture and a second one."""
        planes = self.planes(picture, state)
        return planes | self.rules(planes["state"].shape[-2:], len(np.asarray(picture)))

    def rules(self, grid: tuple[int, int], frames: int, *, limit: float | None = None) -> dict[str, Any]:
        """Return the arguments of `run_transient` besides planes: boundary, time, cell and step.

        Arguments: ``grid`` (rows, cols); ``frames`` of a sequence; ``limit`` of the time, None for `limit`.
        """
        rules: dict[str, Any] = {"boundary": self.boundary, "duration": self.duration, "cell": self.cell}
        if self.duration == "settled":
            rules["limit"] = self.limit(grid) if limit is None else limit
        elif self.frame_time:  # a longer sequence is run to its end
            rules["duration"] = max(self.duration, self.frame_time * frames)
        own = {"step": self.step, "accuracy": self.accuracy}
        return rules | {key: value for key, value in own.items() if value is not None}

    @staticmethod
    def changed(task: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
        """Return arguments with ``changes``; an accuracy replaces a step, a scheme or a step replaces an accuracy."""
        dropped = {"step", "scheme"} if changes.get("accuracy") is not None else set()
        dropped |= {"accuracy"} if changes.get("scheme") is not None or changes.get("step") is not None else set()
        return {**{key: value for key, value in task.items() if key not in dropped}, **changes}

    def _black_and_white(self) -> bool:
        """Whether the template is for black and white pictures only, by its tags and worked examples."""
        pictures = [plane for one in self.examples for plane in (one.input, one.state) if plane is not None]
        return "binary" in self.tags and all((np.abs(plane) == 1).all() for plane in pictures)

    def _warn_of_zeros(self, picture: Array, state: Array | None) -> None:
        """Warn of floats 0 and 1 for a black and white template; a state of zeros is valid."""
        given = [("picture", picture)] + ([("state", state)] if state is not None and state.any() else [])
        for name, plane in given:
            if has_zeros_for_white(plane) and self._black_and_white():
                held = "0 and 1" if plane.any() else "0"
                said = f"{name} holds {held} alone; template {self.name!r} takes -1 as white, 0 as mid-grey"
                Notices.say(f"{said}: values > 0 is black and white")

    def planes(self, picture: ArrayLike, state: ArrayLike | None = None) -> dict[str, Any]:
        """Return the planes ``input`` and ``state`` for a picture and a second one.

        A picture outside of [-1, 1] gives a warning: the margins of templates are not valid there.

        Raises:
            InputError: a second picture is missing or not used; whole numbers that look like grey levels.
        """
        picture, state = as_picture("picture", picture), None if state is None else as_picture("state", state)
        self._warn_of_zeros(picture, state)
        if picture.ndim < 2:
            raise InputError(f"picture has shape {picture.shape}; (rows, cols) with at least one cell wanted")
        roles = self.initial_state if isinstance(self.initial_state, tuple) else (self.initial_state,)
        layers = len(self.network.layers) if isinstance(self.network, LayeredTemplate) else 0
        shape = (layers, *picture.shape[-2:]) if layers else picture.shape
        shape = shape[-2:] if self.frame_time else shape
        if state is None and "given" in roles:
            raise InputError(f"template {self.name!r} takes a second picture, as initial state, and none was given")
        if state is not None and "given" not in roles:
            raise InputError(f"template {self.name!r} takes one picture; a second one, as initial state, was given")
        if state is not None and state.ndim and picture.ndim and state.shape[-2:] != picture.shape[-2:]:
            raise InputError(f"the second picture has shape {state.shape}, the first {picture.shape}; one shape wanted")
        first = picture[0] if self.frame_time else picture

        def start(role: Any) -> Array:
            return np.asarray(
                {"picture": first, "given": state}.get(role, 0.0) if isinstance(role, str) else float(role)
            )

        if len(roles) == 1:
            x = start(roles[0])
            planes: dict[str, Any] = {"state": x if x.shape == shape else np.broadcast_to(x, shape)}
        else:
            starts = [np.broadcast_to(start(role), shape[-2:]) for role in roles]
            if all(x.strides == (0, 0) for x in starts):  # constant layers need no planes
                planes = {"state": np.broadcast_to(np.array([x[:1, :1] for x in starts]), (len(starts), *shape[-2:]))}
            else:
                planes = {"state": np.array(starts)}
        if self.input != "none":
            shown = Frames(list(picture), self.frame_time) if self.frame_time else picture
            planes["input"] = shown if self.input == "picture" else np.broadcast_to(float(self.input), shape)
        return planes
