"""Priority of a reader: raised where that is allowed, left alone where it is not."""

import os
import subprocess
import sys

import pytest

from tactile.serial.priority import NICE, raise_priority

CODE = "import os; from tactile.serial.priority import raise_priority as up; print(up(), os.getpriority(0, 0))"


@pytest.mark.skipif(sys.platform != "linux", reason="of Linux alone is known what the value means")
def test_it_is_raised_where_that_is_allowed() -> None:
    """In a session of its own, whose group the value is for as well."""
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, check=True, start_new_session=True
    )
    raised, nice = done.stdout.split()
    assert (raised, int(nice)) in (("True", NICE), ("False", os.getpriority(os.PRIO_PROCESS, 0)))


def test_where_it_is_not_allowed_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: int) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "setpriority", refuse)
    assert raise_priority() is False
