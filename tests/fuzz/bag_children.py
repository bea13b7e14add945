"""Bags read in children of one process that has loaded the library: within the product's limits, without its start.

Of each line of its input, the path of a bag, it says in a line how the child ended: its exit code (minus the signal
that ended it), the seconds of the processor it took, and what it said. The product starts the program anew for each
bag, which takes most of a second.
"""

import io
import os
import sys
from pathlib import Path

from rosbags import highlevel, typesys  # noqa: F401 - loaded once, for all children

from tactile.sources import bag_process


def judge(path: Path) -> str:
    """Read a bag in a child, and say how that went."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.close(out)
        code, said = 70, io.StringIO()
        sys.stderr = said
        try:
            bag_process.main(path)
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
        except BaseException as error:
            said.write(repr(error))
        finally:
            os.write(into, said.getvalue().encode()[:1000])
            os._exit(code)
    os.close(into)
    with os.fdopen(out, "rb") as pipe:
        said_by_child = pipe.read().decode(errors="replace")
    _, status, used = os.wait4(child, 0)
    return f"{os.waitstatus_to_exitcode(status)} {used.ru_utime + used.ru_stime:.3f} {' '.join(said_by_child.split())}"


if __name__ == "__main__":
    for line in sys.stdin:
        print(judge(Path(line.rstrip("\n"))), flush=True)
