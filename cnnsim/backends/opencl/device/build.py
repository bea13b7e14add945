"""OpenCL programs: put together from .cl files and definitions, and built."""

import re
import warnings
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from enum import IntEnum
from functools import cache
from importlib.resources import files
from threading import Thread
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.codes import NOTHING, BoundaryCode, FunctionCode, TaskCode, boundary_code
from cnnsim.backends.opencl.device import pocl
from cnnsim.network import Boundary, Tap, reach
from cnnsim.planning.plan import Plan
from cnnsim.support import InputError
from cnnsim.support.interrupts import foreign_call

Defines = Mapping[str, str | int]


class BuildError(InputError):
    """OpenCL text that the device's compiler rejects; the message has the compiler's log."""


def build(context: cl.Context, device: cl.Device, text: str, what: str) -> cl.Program:
    """Build a program; ``what`` names it in messages.

    Raises:
        BuildError: the device's compiler rejects the program.
        InputError: the compiler rejects every program for a known reason (see `pocl.remark`).
    """
    # -w: compiler warnings do not help users
    options = ["-w"]
    if device.single_fp_config & cl.device_fp_config.CORRECTLY_ROUNDED_DIVIDE_SQRT:
        options.append("-cl-fp32-correctly-rounded-divide-sqrt")
    try:
        with warnings.catch_warnings():
            # pyopencl warns of every build log that is not empty; some drivers write a log without any fault
            warnings.simplefilter("ignore", cl.CompilerWarning)
            return _in_thread(lambda: cl.Program(context, text).build(options=options, devices=[device]))
    except cl.RuntimeError as error:
        if remark := pocl.remark(device):
            raise InputError(f"{device.name}: {remark}") from error
        driver = f"{device.name.strip()}, driver {device.platform.name.strip()} {device.driver_version}"
        raise BuildError(
            f"{driver}: the OpenCL text of {what!r} does not build{_line(text, str(error))}\n{error}"
        ) from error


def _line(text: str, log: str) -> str:
    """Return the line of a text in which a compiler's log has its first error, or nothing."""
    found = re.search(r":(\d+):\d+: ", log)
    lines = text.splitlines()
    return f" at {lines[int(found[1]) - 1].strip()!r}:" if found and int(found[1]) <= len(lines) else ":"


def _in_thread(work: Callable[[], cl.Program]) -> cl.Program:
    """Do work that takes seconds outside of Python in a thread, so that the main thread can handle signals."""
    done: Future[cl.Program] = Future()

    def run() -> None:
        try:
            with foreign_call():
                made = work()
            done.set_result(made)
        except BaseException as error:
            done.set_exception(error)

    Thread(target=run, daemon=True).start()
    return done.result()


@cache
def source(stem: str) -> str:
    """Return the text of kernels/<stem>.cl."""
    return files("cnnsim.backends.opencl").joinpath("kernels", f"{stem}.cl").read_text(encoding="utf-8")


def define_lines(defines: Defines) -> str:
    """Return definitions as text."""
    return "".join(f"#define {key} {value}\n" for key, value in defines.items())


def code_defines() -> Defines:
    """Return the definitions of all codes: BOUNDARY_..., FUNCTION_..., TASK_... and NOTHING."""
    enums: dict[str, type[IntEnum]] = {"BOUNDARY": BoundaryCode, "FUNCTION": FunctionCode, "TASK": TaskCode}
    codes = {f"{prefix}_{code.name}": int(code) for prefix, enum in enums.items() for code in enum}
    return {"NOTHING": f"({NOTHING})", **codes}


def boundary_defines(boundary: Boundary) -> dict[str, str | int]:
    """Return the definition of the boundary condition."""
    return {"BOUNDARY": int(boundary_code(boundary))}


def cell_defines(plan: Plan, mask: cl.Buffer | None) -> dict[str, str | int]:
    """Return the definitions that say whether states are kept within +-1, and whether there is a mask."""
    return {"LIMITED": int(plan.cell == "full-range"), **({} if mask is None else {"MASK": ""})}


def tap_defines(taps: tuple[Tap, ...], boundary: Boundary, constant: float, dtype: np.dtype[Any]) -> Defines:
    """Return the definitions of the taps and of the boundary condition."""
    return {
        "TAPS(DO, a)": " ".join(f"DO(a, {k}, {l}, {literal(weight, dtype)})" for k, l, weight in taps),
        "RADIUS": reach((tap.k, tap.l) for tap in taps),
        "CONSTANT": literal(constant, dtype),
        **boundary_defines(boundary),
    }


def literal(value: float, dtype: np.dtype[Any]) -> str:
    """Write a number so that the compiler reads exactly that number of this dtype."""
    digits = repr(float(value)) if dtype == np.float64 else str(np.float32(value))
    if "e" not in digits and "." not in digits:
        digits += ".0"
    return f"({digits})" if dtype == np.float64 else f"({digits}f)"
