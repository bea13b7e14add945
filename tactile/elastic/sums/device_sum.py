"""The sums over loads on an OpenCL device, in float32 or float64: for scenes of many frames."""

from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, Q, X, Y
from tactile.elastic.disc_table import DiscTable
from tactile.elastic.halfspace import check_loads, point_scale
from tactile.elastic.medium import Medium

if TYPE_CHECKING:
    from cnnsim.backends.opencl.device.context import DeviceContext

Precision = Literal["float32", "float64"]


class DeviceSum:
    """Sums on the device that cnnsim takes: ``direct.direct_sum`` and ``disc_loops.add_discs``, the same arguments.

    Raises:
        InputError: pyopencl is not installed, there is no device, or one without float64 where that is wanted.
    """

    def __init__(self, dtype: Precision) -> None:
        try:
            from cnnsim.backends.opencl.device.context import device_context  # only where called for
            from cnnsim.backends.opencl.device.devices import choose_device, family_of, has_float64, title
        except ImportError as error:
            from cnnsim.support.extras import install_line

            raise InputError(f"a scene on OpenCL needs pyopencl: {install_line('opencl')}") from error
        device = choose_device()
        if dtype == "float64" and not has_float64(device):
            raise InputError(f"{title(device)} has no float64; dtype = 'float32' wanted")
        self.dtype = np.dtype(dtype)
        self._context: DeviceContext = device_context(device, family_of(device), self.dtype)
        self._text = files("tactile.elastic.sums").joinpath("device_sum.cl").read_text(encoding="utf-8")

    def add_points(self, out: Floats, positions: Floats, depth: float, loads: Floats, medium: Medium) -> None:
        """Add to ``out`` (frames, taxels, 3) what taxels (taxels, 2) [m] feel of point loads (frames, n, 5)."""
        scale, trace = point_scale(depth, medium)
        rows = check_loads(loads) * (1 / depth, 1 / depth, scale, scale, scale)
        self._run("add_points", out, positions / depth, rows, rows.shape[1], self.dtype.type(trace))

    def add_discs(
        self, out: Floats, positions: Floats, depth: float, loads: Floats, radii: Floats, table: DiscTable,
        medium: Medium,
    ) -> None:  # fmt: skip
        """Add what they feel of loads over circles: as ``disc_loops.add_discs``."""
        size = radii / depth
        rows = np.zeros((*loads.shape[:2], 8))
        rows[..., : loads.shape[-1]] = loads
        unit = 1 / depth**2 if medium.quantity == "stress" else 1 / (medium.modulus * depth**2)
        rows[..., [X, Y, COLUMNS]] /= depth
        rows[..., Q : COLUMNS + 1] *= (unit / (1 + size**2))[..., None]
        rows[..., 6], rows[..., 7] = table.knots(size), 1 + size**2
        _, trace = medium.reading
        factor = (1.0 if medium.quantity == "stress" else 1 + medium.nu) / (2 * np.pi)
        real = self.dtype.type
        numbers = self._context.table(np.ascontiguousarray(table.numbers, self.dtype))
        self._run(
            "add_discs", out, positions / depth, rows, rows.shape[1], numbers,
            np.int32(table.numbers.shape[0]), np.int32(table.numbers.shape[1]), real(table.per_rho), real(table.ends),
            np.int32(table.endless), real(factor), real(2 * trace),
        )  # fmt: skip

    def _run(self, name: str, out: Floats, at: Floats, rows: Floats, loads: int, *arguments: Any) -> None:
        import pyopencl as cl  # only where called for

        context = self._context
        frames, taxels = out.shape[:2]
        if not frames * taxels * loads:
            return
        given, sums = np.ascontiguousarray(rows, self.dtype), np.ascontiguousarray(out, self.dtype)
        with context.lock:
            kernel = context.kernel(name, "", {}, self._text)
            flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
            sent = [cl.Buffer(context.context, flags, hostbuf=part) for part in (given,)]
            felt = cl.Buffer(context.context, cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR, hostbuf=sums)
            places = context.table(np.ascontiguousarray(at, self.dtype))
            context.launch(
                kernel, frames * taxels, places, *sent, felt, np.int32(taxels), np.int32(loads), *arguments,
                np.int64(frames * taxels),
            )  # fmt: skip
            cl.enqueue_copy(context.queue, sums, felt)
        out[:] = sums


@cache
def device_sum(dtype: Precision) -> DeviceSum:
    """The sums of one precision, set up once."""
    return DeviceSum(dtype)
