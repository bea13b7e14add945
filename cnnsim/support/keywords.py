"""Keyword arguments of public functions: an unknown one is an error that names the nearest known one."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from cnnsim.support.errors import InputError, nearest

Given = ParamSpec("Given")
Returned = TypeVar("Returned")
Made = TypeVar("Made")


class KeywordError(InputError, TypeError):
    """An unknown or missing keyword argument; a TypeError like Python's own."""


def spelled(options: type[Any] | None = None) -> Callable[[Callable[Given, Returned]], Callable[Given, Returned]]:
    """Make a function raise `KeywordError` for unknown and missing keyword arguments.

    ``options`` is the TypedDict of the function's ``**`` argument.
    """

    def decorate(function: Callable[Given, Returned]) -> Callable[Given, Returned]:
        parameters = inspect.signature(function).parameters.values()
        known = [p.name for p in parameters if p.kind in (p.KEYWORD_ONLY, p.POSITIONAL_OR_KEYWORD) and p.name != "self"]
        known += [] if options is None else [name for name in options.__annotations__ if name not in known]
        names = frozenset(known)
        needed = {p.name for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is p.empty}

        called = function.__qualname__.removesuffix(".__init__")

        @wraps(function)
        def checked(*args: Given.args, **kwargs: Given.kwargs) -> Returned:
            if not names.issuperset(kwargs):
                raise unknown_keyword(called, set(kwargs) - names, known)
            if not needed <= kwargs.keys():
                raise KeywordError(
                    f"{called}: no {', '.join(sorted(needed - kwargs.keys()))} among its keywords; wanted"
                )
            return function(*args, **kwargs)

        return checked

    return decorate


def spelled_class(kind: type[Made]) -> type[Made]:
    """Make a dataclass raise `KeywordError` as `spelled` does."""
    kind.__init__ = spelled()(kind.__init__)  # type: ignore[method-assign]  # of the class itself, not of an instance
    return kind


def unknown_keyword(function: str, given: set[str], known: list[str]) -> KeywordError:
    """Return the error for unknown keywords."""
    found = []
    for name in sorted(given):
        near = nearest(name, known)
        found.append(f"no keyword {name!r}; " + (f"did you mean {near!r}?" if near else f"known: {', '.join(known)}"))
    return KeywordError(f"{function}: {'; '.join(found)}")
