"""Fingerprint of a compiled loop: of its code, of every function that is compiled into it, and of their constants.

Numba takes a kept loop for good while the file of its own text is as it was, though a function that it inlines, or a
constant it took from another file, has changed: after an update its answers would be those of before.
"""

from collections.abc import Iterator
from enum import EnumMeta
from functools import cache
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

_WRAPPED = "py_func", "_pyfunc", "_function", "_defn"
"""Where compiled functions, callbacks, threaded loops and intrinsics keep their text."""
_FOREIGN = "numpy", "numba"
"""What these define is told by their versions."""


def fingerprint(function: FunctionType) -> str:
    """Return a digest that changes with the code, the callees and the constants of a function, not with its file."""
    found, waiting = {function}, [function]
    while waiting:
        _, callees = _own(waiting.pop())
        new = callees - found
        found |= new
        waiting += new
    return sha256("".join(sorted(_own(each)[0] for each in found)).encode()).hexdigest()


def stable(value: Any) -> str:
    """Return what `repr` says, with the elements of a set in an order that is the same in every process."""
    return f"{sorted(map(repr, value))}" if isinstance(value, (set, frozenset)) else repr(value)


@cache
def _own(function: FunctionType) -> tuple[str, set[FunctionType]]:
    """Return a digest of a function's own text and constants, and the functions that it calls."""
    cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
    callees: set[FunctionType] = set()
    said = [f"{function.__module__} {function.__qualname__} {function.__defaults__} {function.__kwdefaults__}"]
    for code in _codes(function.__code__):
        said.append(f"{code.co_code.hex()} {code.co_names} {code.co_varnames} {code.co_freevars}")
        said += (each.co_name if isinstance(each, CodeType) else stable(each) for each in code.co_consts)
        for name in (*code.co_names, *code.co_freevars):
            if name in cells:
                said += _value(cells[name].cell_contents, code, callees)
            elif name in function.__globals__:
                said += _value(function.__globals__[name], code, callees)
    return sha256("\n".join(said).encode()).hexdigest(), callees


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)


def _value(value: Any, code: CodeType, callees: set[FunctionType]) -> Iterator[str]:
    """Say what a name stands for where compiled code reads it, but for functions, which are called."""
    if isinstance(value, (bool, int, float, complex, str, bytes, np.generic, np.dtype, type(None))):
        yield repr(value)
    elif isinstance(value, ModuleType):
        if value.__name__.partition(".")[0] not in _FOREIGN:
            for name in code.co_names:
                yield from _value(getattr(value, name, None), code, callees)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    elif isinstance(value, EnumMeta):
        yield f"{list(value)}"
    elif isinstance(value, (tuple, list)):
        for each in value:
            yield from _value(each, code, callees)
    elif text := _text(value):
        callees.add(text)
        options = getattr(value, "targetoptions", None) or {}
        yield f"{text.__qualname__} {sorted((key, stable(option)) for key, option in options.items())}"
    else:
        yield f"{type(value).__name__} {getattr(value, '__name__', '')}"


def _text(value: Any) -> FunctionType | None:
    if isinstance(value, FunctionType):
        return None if value.__module__.partition(".")[0] in _FOREIGN else value
    kept = (getattr(value, name, None) for name in _WRAPPED)
    return next((text for text in kept if isinstance(text, FunctionType)), None)
