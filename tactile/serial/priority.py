"""Raising the priority of a reader over programs that merely compute, where the system allows it.

Linux shares the processors out twice where it groups tasks by session: between the sessions, then within each. So both
get the nice value. A nice value is no claim to run always: whoever else computes still gets a part, as under a
real-time class, which a pipeline that is behind would take everything with, he would not.

Source: ``nice(2)``, ``sched(7)`` on autogroups.
"""

import os
from contextlib import suppress
from pathlib import Path

NICE = -10
"""The weight of nine others."""
GROUP = Path("/proc/self/autogroup")


def raise_priority() -> bool:
    """Ask for this thread and those that it will start; return whether the system allows it."""
    try:
        os.setpriority(os.PRIO_PROCESS, 0, min(NICE, os.getpriority(os.PRIO_PROCESS, 0)))
    except (OSError, AttributeError):  # not allowed; not on this system
        return False
    with suppress(OSError):  # the system does not group tasks by session
        GROUP.write_text(str(NICE), encoding="ascii")
    return True
