"""OpenCL programs: put together from .cl files and definitions, built once, kept."""

import warnings
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from threading import RLock
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.device import Family
from cnnsim.backends.opencl.pocl import has_wide_vectors
from cnnsim.network.boundary import Boundary
from cnnsim.network.template import Tap
from cnnsim.support.errors import InputError

Defines = Mapping[str, str | int]

GROUP = 256
"""Work-items of a group in the kernels that go over cells one by one on a GPU."""

LANES = 8
"""Numbers in a vector on a CPU, at least the largest radius."""

WIDE_LANES = 16
"""float32 in a vector where registers are that wide: half as fast again. Where they are not, it is 5 % slower."""

SPARE = 2
"""Buffers kept for the next transient: its drive, and one of the two states between which steps go."""


class BuildError(InputError):
    """OpenCL text that the device's compiler refuses; the message has its log."""


class Workshop:
    """One device with its context, its queue and its built programs, for one dtype and one family of kernels.

    Its kernels keep the arguments they were given last, so whoever launches holds the ``lock`` from the first argument
    to the last launch: setting arguments is the one OpenCL call that threads may not make at once (OpenCL 1.2, app. A).
    """

    def __init__(self, device: cl.Device, family: Family, dtype: np.dtype[Any]) -> None:
        self.device, self.family, self.dtype = device, family, dtype
        self.lock = RLock()
        self.context, self.queue = _context_and_queue(device)
        wide = dtype == np.float32 and has_wide_vectors(device)
        self.lanes = (WIDE_LANES if wide else LANES) if family == "cpu" else 1
        self.cores = device.max_compute_units
        self.partial = cl.Buffer(self.context, cl.mem_flags.READ_WRITE, 2 * 8 * self.most_parts)
        self._spare: list[cl.Buffer] = []
        self._tables: dict[bytes, cl.Buffer] = {}
        self._programs: dict[tuple[str, ...], cl.Program] = {}
        self._kernels: dict[tuple[str, ...], cl.Kernel] = {}

    @property
    def most_parts(self) -> int:
        """The most parts that a sum over a plane comes back in."""
        return 4 * self.cores if self.family == "cpu" else 4 * GROUP

    def buffer(self, size: int) -> cl.Buffer:
        """Return a buffer of ``size`` bytes on the device."""
        for spare in self._spare:
            if spare.size == size:
                self._spare.remove(spare)
                return spare
        self._spare.clear()
        return cl.Buffer(self.context, cl.mem_flags.READ_WRITE, size)

    def recycle(self, *buffers: cl.Buffer) -> None:
        """Take back buffers that nobody else knows: new memory costs more than a few steps of the time loop."""
        self._spare = [*self._spare, *buffers][-SPARE:]

    def tap_buffers(self, taps: tuple[Tap, ...]) -> tuple[cl.Buffer, cl.Buffer]:
        """Return the places (k, l) and the weights of taps on the device, in order; at least one entry."""
        places = np.array([(tap.k, tap.l) for tap in taps] or [(0, 0)], np.int32)
        weights = np.array([tap.weight for tap in taps] or [0.0], self.dtype)
        return self.table(places), self.table(weights)

    def table(self, numbers: np.ndarray[Any, Any]) -> cl.Buffer:
        """Return a few numbers on the device, to be read only; the same numbers are brought there once."""
        key = numbers.tobytes()
        if key not in self._tables:
            flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
            self._tables[key] = cl.Buffer(self.context, flags, hostbuf=numbers)
        return self._tables[key]

    def kernel(self, name: str, stem: str, defines: Defines, extra: str = "", twin: int = 0) -> cl.Kernel:
        """Return a kernel of opencl_<stem>.cl (of several, one after the other, and ``extra``) with these definitions.

        A kernel keeps its arguments, so those who need it with two sets of arguments ask for its ``twin`` as well.
        """
        lines = "".join(f"#define {key} {value}\n" for key, value in {**self._basics(), **defines}.items())
        key = (stem, lines, extra, f"{name} {twin}")
        if key not in self._kernels:
            if key[:-1] not in self._programs:
                text = lines + "".join(map(source, ["common", *stem.split()])) + extra
                self._programs[key[:-1]] = self._build(text, stem or name)
            self._kernels[key] = cl.Kernel(self._programs[key[:-1]], name)
        return self._kernels[key]

    def run(self, kernel: cl.Kernel, work: int, *arguments: Any) -> int:
        """Run a kernel that deals out ``work`` cells or words itself; return how many parts its sums have."""
        if self.family == "cpu":
            parts = max(1, min(self.most_parts, work // 4096))
            shape: tuple[tuple[int], tuple[int]] = (parts,), (1,)
        else:
            parts = max(1, min(self.most_parts, -(-work // GROUP)))
            shape = (parts * GROUP,), (GROUP,)
        kernel.set_args(*arguments)
        cl.enqueue_nd_range_kernel(self.queue, kernel, *shape)
        return parts

    def parts(self, count: int, dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
        """Read ``count`` numbers that a kernel left in ``partial``."""
        numbers = np.empty(count, dtype)
        cl.enqueue_copy(self.queue, numbers, self.partial)
        return numbers

    def _basics(self) -> dict[str, str | int]:
        kind = {"DOUBLE": ""} if self.dtype == np.float64 else {}
        here = {"CPU": ""} if self.family == "cpu" else {"GROUP": GROUP}
        return {"REAL": "double" if kind else "float", "V": self.lanes, **kind, **here}

    def _build(self, text: str, what: str) -> cl.Program:
        # -w: what a compiler remarks on is no business of those who run it
        options = ["-w"]
        if self.device.single_fp_config & cl.device_fp_config.CORRECTLY_ROUNDED_DIVIDE_SQRT:
            options.append("-cl-fp32-correctly-rounded-divide-sqrt")
        try:
            with warnings.catch_warnings():
                # pyopencl warns of every build log that is not empty, and drivers write a line when all is well
                warnings.simplefilter("ignore", cl.CompilerWarning)
                return cl.Program(self.context, text).build(options=options, devices=[self.device])
        except cl.RuntimeError as error:
            raise BuildError(f"{self.device.name}: the OpenCL text of {what!r} does not build:\n{error}") from error


@cache
def _context_and_queue(device: cl.Device) -> tuple[cl.Context, cl.CommandQueue]:
    """Return one context and queue a device, so that planes may go between backends on it."""
    context = cl.Context([device])
    return context, cl.CommandQueue(context)


@cache
def workshop(device: cl.Device, family: Family, dtype: np.dtype[Any]) -> Workshop:
    """Return the workshop of a device: one for all backends that want the same."""
    return Workshop(device, family, dtype)


@cache
def source(stem: str) -> str:
    """Return the text of opencl_<stem>.cl."""
    return files("cnnsim.backends.opencl").joinpath("kernels", f"{stem}.cl").read_text(encoding="utf-8")


def literal(value: float, dtype: np.dtype[Any]) -> str:
    """Write a number so that the compiler reads exactly that number of this dtype."""
    digits = repr(float(value)) if dtype == np.float64 else str(np.float32(value))
    if "e" not in digits and "." not in digits:
        digits += ".0"
    return f"({digits})" if dtype == np.float64 else f"({digits}f)"


def radius_of(taps: Iterable[Tap]) -> int:
    """Return how far taps reach."""
    return max((max(abs(tap.k), abs(tap.l)) for tap in taps), default=0)


def boundary_defines(boundary: Boundary) -> dict[str, str | int]:
    """Return the definition that says what lies around the grid."""
    return {"BOUNDARY": {"zero-flux": 0, "fixed": 1, "periodic": 2}[boundary.kind]}


def tap_defines(taps: tuple[Tap, ...], boundary: Boundary, constant: float, dtype: np.dtype[Any]) -> Defines:
    """Return the definitions that say which neighbours count how much, and what lies around the grid."""
    return {
        "TAPS(DO, a)": " ".join(f"DO(a, {k}, {l}, {literal(weight, dtype)})" for k, l, weight in taps),
        "RADIUS": radius_of(taps),
        "CONSTANT": literal(constant if boundary.kind == "fixed" else 0.0, dtype),
        **boundary_defines(boundary),
    }
