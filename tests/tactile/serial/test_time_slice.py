"""Short time slices, where the kernel has them."""

import ctypes
import platform
import threading

import pytest

from tactile.serial.time_slice import ATTRIBUTES, SLICE, ask_for_short_slices


def test_short_slices_are_asked_for_where_the_kernel_has_them() -> None:
    """In a thread of its own, since it stays so; what the kernel says afterwards tells."""
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        pytest.skip("the number of the call that asks back is that of x86_64 Linux")
    said: list[tuple[bool, int, int]] = []

    def ask() -> None:
        agreed, answer = ask_for_short_slices(), ctypes.create_string_buffer(ATTRIBUTES.size)
        failed = ctypes.CDLL(None).syscall(315, 0, answer, ATTRIBUTES.size, 0)
        said.append((agreed, failed, ATTRIBUTES.unpack(answer.raw)[5]))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    ((agreed, failed, slice_),) = said
    if failed:
        pytest.skip("this kernel does not know the call")
    assert agreed
    if tuple(int(part) for part in platform.release().split(".")[:2]) >= (6, 12):
        assert slice_ == SLICE
