"""Optional dependencies: import, and the pip command that installs an extra, from a checkout, a wheel or an index."""

import importlib
import json
import re
from pathlib import Path
from shlex import quote
from types import ModuleType
from urllib.parse import unquote, urlsplit

from cnnsim.support.errors import InputError

PACKAGE = "cellular-wave-touch"


def install_line(extra: str) -> str:
    """Return the pip command that installs an extra of the checkout or wheel that this package was installed from.

    For a package from an index the command names the libraries.
    """
    from importlib import metadata  # slow to import, and only needed when a library is missing

    try:
        found = metadata.distribution(PACKAGE)
    except metadata.PackageNotFoundError:
        return _from(Path(__file__).parents[2], extra, editable=True)
    origin = json.loads(found.read_text("direct_url.json") or "{}")
    url = urlsplit(origin.get("url", ""))
    if url.scheme == "file":
        return _from(Path(unquote(url.path)), extra, editable=origin.get("dir_info", {}).get("editable", False))
    wanted = [line.split(";")[0].strip() for line in found.requires or () if re.search(rf"extra == .{extra}\b", line)]
    return "pip install " + " ".join(map(quote, wanted))


def need(module: str, what: str, extra: str | None = "serial") -> ModuleType:
    """Import a module that ``what`` needs; ``extra`` is None for a library of no extra.

    Raises:
        InputError: a library of the extra is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        line = f"pip install {error.name}" if extra is None else install_line(extra)
        raise InputError(f"{what} needs {error.name}, which is not installed: {line}") from error


def _from(place: Path, extra: str, *, editable: bool) -> str:
    return f"pip install {'-e ' if editable else ''}{quote(f'{place}[{extra}]')}"
