"""Limits of files and of the numbers in them, and the one-line errors for what exceeds them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cnnsim.support.command_files import note_read
from cnnsim.support.errors import InputError

TEXT, FOREIGN = 2**20, 2**18
"""Bytes of a TOML file, and of a template file of another system (which takes 100 bytes a template)."""
TEMPLATES = 10_000
"""Templates of one file of another system."""
TABLE = 2**31
"""Bytes of a text recording, which is read as a whole."""
UNPACKED, PACKING = 64 * 2**20, 200
"""Bytes that any packed file may unpack to, and the ratio that a larger one may have; recordings have about 10."""
PAGES = 2**28
"""Pixels of all pictures of a file together that any file may hold; a larger one as many as `PACKING` allows."""
LABELS = 2**26
"""Bytes of a table of labels or weights, and of a line of a text recording."""
CHUNK, RECORD = 2**26, 2**28
"""Bytes of the largest chunk of an MCAP recording that is unpacked, and of its longest record."""
TAXELS = 1 << 20
"""Taxels of an array: 1024 x 1024, more than a wire format carries; a frame of them is 25 MB."""
READING = 1e30
"""Largest modulus of a reading, in any unit: its fourth power still is a finite number."""
RATE, FRAMES = 1e6, 1e9
"""Frames a second, and of a whole scene."""
PLANES, STEPS = 1000, 10_000
"""Planes and registers of a program; its steps, including those of branches and loops."""
NUMBER = 2**53
"""Largest modulus of a whole number in a program file: floats hold all whole numbers up to it."""
REGISTER = 2**63 - 1
"""Largest modulus of the number in a register of a program."""
REPEATS = 10**6
"""Rounds of a `repeat` step."""
WINDOW = 10**6
"""Frames in the window of a texture feature."""
LINE = 300
"""Characters of the message of a library that are quoted."""


def check_most(value: float, most: float, what: str) -> None:
    """Raise an InputError if a number exceeds its limit."""
    if not value <= most:
        raise InputError(f"{what}: {str(value)[:40]}; {most:.7g} at most wanted")


def check_plain(path: Path, what: str) -> None:
    """Raise an InputError for a folder, a device or a pipe, which could block; a missing file is accepted.

    The file is an input of the running command, see `cnnsim.support.command_files`.
    """
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: {'a folder' if path.is_dir() else 'no plain file'}; a {what} wanted")
    note_read(path)


def check_file(path: Path, what: str, most: int) -> None:
    """Raise an InputError if a path is no plain file or has more than ``most`` bytes.

    Raises:
        OSError: there is no such file.
    """
    size = path.stat().st_size
    check_plain(path, what)
    if size > most:
        raise InputError(f"{path}: {size} bytes; {most} at most wanted for a {what}")


def check_unpacked(path: Path, unpacked: int, least: int = UNPACKED) -> None:
    """Raise an InputError for a packed file that would unpack to more than ``least`` and than `PACKING` allow."""
    packed = path.stat().st_size
    if unpacked > max(least, PACKING * packed):
        raise InputError(f"{path}: {packed} bytes that unpack to {unpacked}; {PACKING} times as many at most wanted")


@contextmanager
def one_line(path: Path, what: str) -> Iterator[None]:
    """Turn any exception of a library that reads a file into an InputError of one line."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: cannot be read as {what}: {reason(error)}") from error


def reason(said: object) -> str:
    """Return an exception's message as one line of at most `LINE` characters, or its class if it has no message."""
    if isinstance(said, UnicodeDecodeError):  # its own message speaks of bytes and a codec
        line = said.object.count(b"\n", 0, said.start) + 1
        return f"no UTF-8 text (line {line})"
    if isinstance(said, OSError):  # without the file's name, which the caller gives
        said = said.strerror or said
    text = " ".join(str(said).split()) or type(said).__name__
    return text if len(text) <= LINE else text[:LINE] + " ..."
