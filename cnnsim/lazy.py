"""Lazy names of a package (PEP 562): imported when they are first used, so that Ctrl-C is handled before.

A package's ``__init__`` imports this module, so it imports next to nothing.
"""

TYPE_CHECKING = False  # not from typing, which takes longer to import than this file
if TYPE_CHECKING:
    from collections.abc import Callable


def importer(package: str) -> "Callable[[str], object]":
    """Return the ``__getattr__`` of a package: its public names, its modules, and AttributeError for others.

    The module of a public name is that of the package's imports for type checkers, under ``if TYPE_CHECKING``.
    """

    def named(name: str) -> object:
        from importlib import import_module  # not above: what is imported there delays the answer to Ctrl-C

        this = import_module(package)
        if name in this.__all__ and (module := _modules(this.__file__).get(name)) not in (None, package):
            value = getattr(import_module(module), name)
            setattr(this, name, value)
            return value
        try:
            if not name.startswith("_"):
                return import_module(f"{package}.{name}")
        except ModuleNotFoundError as error:
            if error.name != f"{package}.{name}":
                raise
        raise AttributeError(f"module {package!r} has no attribute {name!r}", name=name, obj=this)

    return named


def _modules(file: "str | None") -> dict[str, str]:
    """Return the module of each name that a file imports by ``from module import name``."""
    import re

    with open(str(file), encoding="utf-8") as source:  # noqa: PTH123 - pathlib takes longer to import
        found = re.findall(r"^ *from ([\w.]+) import (\([^)]*\)|[^\n]*)", source.read(), re.MULTILINE)
    return {name: module for module, names in found for name in re.findall(r"\w+", names)}
