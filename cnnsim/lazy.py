"""Names of a package that are imported when they are first asked for (PEP 562), so that Ctrl-C is answered before.

Next to nothing is imported here, as a package's ``__init__`` imports it.
"""

TYPE_CHECKING = False  # as in typing, which takes longer to import than all that stands here
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


def importer(package: str, modules: "Mapping[str, tuple[str, ...]]") -> "Callable[[str], object]":
    """Return the ``__getattr__`` of a package: names from their ``modules``, folders, and AttributeError for others."""

    def named(name: str) -> object:
        from importlib import import_module  # not above: what is imported there delays the answer to Ctrl-C

        for module, names in modules.items():
            if name in names:
                value = getattr(import_module(module), name)
                setattr(import_module(package), name, value)
                return value
        try:
            if not name.startswith("_"):
                return import_module(f"{package}.{name}")
        except ModuleNotFoundError as error:
            if error.name != f"{package}.{name}":
                raise
        raise AttributeError(f"module {package!r} has no attribute {name!r}", name=name, obj=import_module(package))

    return named
