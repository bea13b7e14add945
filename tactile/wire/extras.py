"""Import of optional libraries for boards and recordings."""

import importlib
from types import ModuleType

from cnnsim.support import InputError
from cnnsim.support.extras import install_line


def need(module: str, what: str) -> ModuleType:
    """Import a module that ``what`` needs.

    Raises:
        InputError: a library is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise InputError(f"{what} needs {error.name}, which is not installed: {install_line('serial')}") from error
