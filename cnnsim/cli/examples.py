"""The command `examples` of both command lines: writes example scripts, scenes, pictures and pages into a folder."""

from pathlib import Path

import click

from cnnsim.support import InputError
from cnnsim.support.command_line import examples as calls
from cnnsim.support.files import writing
from cnnsim.support.terminal import echo

_PACKAGE = Path(__file__).parents[1]
_CHECKOUT = _PACKAGE.parent
FOLDERS = ("examples", "docs")
PAGES = (
    "README.md", "CONVENTIONS.md", "CONTRIBUTING.md", "CHANGELOG.md", "templates/README.md",
    "templates/programs/README.md", "templates/programs/event-code.toml", "tactile/CONNECT.md",
    "tactile/wire/README.md",
)  # fmt: skip
"""The README and the files to which it links."""
_SKIPPED = {"__pycache__"}


def sources() -> dict[str, Path]:
    """Return the source of each file by its path in the folder, from the checkout or the installed wheel.

    Raises:
        InputError: the examples are missing.
    """
    root = _CHECKOUT if (_CHECKOUT / "examples").is_dir() else _PACKAGE / "shared"
    if not (root / "examples").is_dir():
        raise InputError(f"{root / 'examples'} is not there; an installed wheel or a checkout wanted")
    there = [path for name in FOLDERS for path in sorted((root / name).rglob("*")) if path.is_file()]
    found = [path for path in there if not _SKIPPED & {*path.parts}]
    return {path.relative_to(root).as_posix(): path for path in (*found, *(root / page for page in PAGES))}


def examples_command(program: str) -> click.Command:
    """Return the command `examples` of a ``program``."""
    epilog = calls(f"{program} examples my-examples", f"{program} examples my-examples --replace")
    folder = click.Argument(["folder"], type=click.Path(path_type=Path, file_okay=False))
    replace = click.Option(["--replace"], is_flag=True, help="Write over files that are there already.")
    return click.command("examples", epilog=epilog, params=[folder, replace])(write_examples)


def write_examples(folder: Path, replace: bool) -> None:
    """Write example scripts, scenes and pages into FOLDER.

    The pictures and the recording that they use are written, too.

    The commands of README.md run in FOLDER without changes.
    """
    files = sources()
    there = sum((folder / name).exists() for name in files)
    if there and not replace:
        raise InputError(f"{folder} has {there} of these {len(files)} files already; --replace would write over them")
    for name, source in files.items():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        with writing(target, replace=replace) as place:
            place.write_bytes(source.read_bytes())
    echo(f"wrote {len(files)} files to {folder}: begin with {folder / 'README.md'}")
