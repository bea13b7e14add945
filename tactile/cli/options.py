"""Options that several commands share, and what they name: array descriptions, calibrations, files to write."""

import os
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support import InputError
from cnnsim.support.exclusive_file import refuse_existing
from cnnsim.support.files import writing
from cnnsim.support.notices import Notices
from tactile.wire.registry import NAMES

if TYPE_CHECKING:
    from tactile.wire.description import Description

FILE = click.Path(path_type=Path)
PROTOCOL = click.option("--protocol", type=click.Choice(list(NAMES)), help="For devices that need no --array.")
LAYOUT = click.option(
    "--layout", type=FILE, help="Layout of tables of other programs (TOML) [layout.toml next to them]."
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
ARRAY = click.option("--array", "-a", type=FILE, help="Array description (TOML); CONNECT.md has the format.")


def chosen_description(protocol: str | None, array: Path | None) -> "Description":
    """Return what --array or --protocol name.

    Raises:
        InputError: the description is wrong, or the protocol needs one.
    """
    from tactile.wire.description_file import default_description, read_description  # NumPy is slow to import

    if array is None:
        if protocol is None:
            raise click.UsageError("--array or --protocol wanted")
        description = default_description(protocol)
        fingers = ", ".join(
            f"{one.name} of {one.rows} x {one.cols} at {one.pitch * 1e3:g} mm" for one in description.arrays
        )
        Notices.say(f"note: no --array: the arrays of {protocol} are supposed to be {fingers}")
        return description
    description = read_description(array)
    if protocol not in (None, description.wire.name):
        raise click.UsageError(f"--protocol {protocol}, but {array} says {description.wire.name}")
    return description


def kept_calibration(path: Path | None, description: "Description") -> str | None:
    """Return the text of a calibration's file, to be kept in a recording; None without one.

    Raises:
        InputError: the file cannot be read or is wrong; no calibration, and readings whose unit is no quantity.
    """
    if path is None:
        description.check_calibrated()
        return None
    from tactile.calibration.file import load_calibration  # slow to import

    load_calibration(path)  # so that messages name the file
    return path.read_text(encoding="utf-8")


def new_mcap(path: Path, replace: bool) -> Path:
    """Return the path of a recording to write.

    Raises:
        InputError: another suffix than .mcap, or a name that is taken.
    """
    if path.suffix != ".mcap":
        raise InputError(f"{path}: suffix {path.suffix!r}, .mcap wanted")
    refuse_existing(path, replace)
    return path


def write_new_text(path: Path, text: str) -> None:
    """Write a small file; a file of the same contents is left as it is.

    Raises:
        InputError: it cannot be written, or the name is taken by a file of other contents.
    """
    if path.is_file() and path.read_bytes() == text.encode():
        return
    if os.path.lexists(path):
        raise InputError(f"{path}: the name is taken; another name wanted")
    with writing(path) as beside:
        beside.write_bytes(text.encode())


class Finite(click.FloatRange):
    """A finite number in a range. Click's own range accepts NaN."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"{number}; a finite number wanted", param, ctx)
        return number


class TareChoice(click.ParamType):  # type: ignore[type-arg]  # generic only in newer versions
    """How an offset is taken: auto, off, or a number of frames."""

    name = "auto|off|N"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the mode or the number."""
        if value in ("auto", "off"):
            return value
        try:
            frames = int(value)
        except ValueError:
            self.fail(f"{value!r}; auto, off or a number of frames wanted", param, ctx)
        if frames < 0:
            self.fail(f"{frames} frames; 0 or more wanted", param, ctx)
        return frames


def detection(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of thresholds and detectors."""
    for option in reversed((
        click.option("--dead-band", type=float, help="Least shear that is a direction [unit of the quantity]."),
        click.option("--hysteresis", type=float, help="Distance above the dead band at which a direction starts."),
        click.option("--contact-level", type=float, help="Least pressing at which a taxel stays in contact [unit]."),
        click.option(
            "--sigmas", type=float, nargs=3,
            help="Dead band, hysteresis, contact level in sigma of a taxel's noise [4 6 3]; 0 0 0: fixed thresholds.",
        ),
        click.option("--sign-code", is_flag=True, help="The paper's code: the bare signs, no dead band."),
        click.option(
            "--program", multiple=True,
            help="Also run this detector or program (a name or a .toml file) on every frame; may be given again.",
        ),
        click.option(
            "--library", type=FILE, multiple=True, expose_value=False, callback=_add_library,
            is_eager=True, help="Look for programs and templates in this folder, too; may be given again.",
        ),
    )):  # fmt: skip
        command = option(command)
    return command


def _add_library(_context: click.Context, _option: click.Parameter, folders: tuple[Path, ...]) -> None:
    from cnnsim import library  # not for --help

    library.add(*folders)


def check_thresholds(chosen: dict[str, Any]) -> None:
    """Refuse thresholds that contradict each other, before anything is opened."""
    if chosen["sign_code"] and (chosen["dead_band"], chosen["hysteresis"]) != (None, None):
        raise click.UsageError("--sign-code has no dead band; leave out --dead-band and --hysteresis")
