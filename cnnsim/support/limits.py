"""Bounds of what files may hold and numbers may say, in one place, and what tells of a file beyond them in one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cnnsim.support.errors import InputError

TEXT, FOREIGN = 2**20, 2**18
"""Bytes of a file that people write by hand: of TOML, and of template files of other systems (100 bytes a template)."""
TEMPLATES = 10_000
"""Templates of one file of another system."""
TABLE = 2**31
"""Bytes of a text recording, which is read as a whole."""
UNPACKED, PACKING = 64 * 2**20, 200
"""Bytes that any file may unpack to, and how many times its own size a larger one may; real readings pack 10 times."""
CHUNK, RECORD = 2**26, 2**28
"""Bytes of the largest chunk of an MCAP recording that is unpacked, and of its longest record."""
TAXELS = 1 << 20
"""Taxels of an array: 1024 x 1024, more than a wire format carries; a frame of them is 25 MB."""
READING = 1e30
"""Size of the largest reading of a taxel, in any unit: beyond it squares of squares are no numbers any more."""
RATE, FRAMES = 1e6, 1e9
"""Frames a second, and of a whole scene."""
PLANES, STEPS = 1000, 10_000
"""Planes and registers of a program; its steps, those of its branches and loops among them."""
NUMBER = 2**53
"""Size of a whole number that a program names: beyond it floats, which parameters are, leave some out."""
REGISTER = 2**63 - 1
"""Size of the largest whole number that a register of a program holds."""
REPEATS = 10**6
"""How often a program repeats steps."""
WINDOW = 10**6
"""Frames that a texture figure averages."""
LINE = 300
"""Characters of what a library says that are told."""


def check_most(value: float, most: float, what: str) -> None:
    """Refuse a number beyond its bound.

    Raises:
        InputError: with both.
    """
    if not value <= most:
        raise InputError(f"{what}: {str(value)[:40]}; {most:.7g} at most wanted")


def check_plain(path: Path, what: str) -> None:
    """Refuse what is there but no file, such as a folder, a device or a pipe: that would be waited for without end.

    Raises:
        InputError: so it is.
    """
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: no plain file; a {what} wanted")


def check_file(path: Path, what: str, most: int) -> None:
    """Refuse a file that is none, such as a folder or a pipe, or is too large.

    Raises:
        InputError: so it is.
        OSError: it is not there.
    """
    size = path.stat().st_size
    check_plain(path, what)
    if size > most:
        raise InputError(f"{path}: {size} bytes; {most} at most wanted for a {what}")


def check_unpacked(path: Path, unpacked: int) -> None:
    """Refuse a packed file that is out of all proportion to what it unpacks to.

    Raises:
        InputError: with both sizes.
    """
    packed = path.stat().st_size
    if unpacked > max(UNPACKED, PACKING * packed):
        raise InputError(f"{path}: {packed} bytes that unpack to {unpacked}; {PACKING} times as many at most wanted")


@contextmanager
def one_line(path: Path, what: str) -> Iterator[None]:
    """Turn whatever a library raises on a file into one line: files are data, and no file is a mistake of ours.

    Raises:
        InputError: as those inside, or what a library said.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: cannot be read as {what}: {reason(error)}") from error


def reason(said: object) -> str:
    """Return what a library said as one line of bounded length, the name of its kind where it said nothing."""
    if isinstance(said, UnicodeDecodeError):  # which speaks of bytes and a codec
        line = said.object.count(b"\n", 0, said.start) + 1
        return f"no UTF-8 text (line {line})"
    if isinstance(said, OSError):  # with the file's name, which the message has
        said = said.strerror or said
    text = " ".join(str(said).split()) or type(said).__name__
    return text if len(text) <= LINE else text[:LINE] + " ..."
