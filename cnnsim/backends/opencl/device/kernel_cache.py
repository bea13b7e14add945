"""The folder of PoCL's cache of kernels."""

import os
from functools import cache

from cnnsim.support.cache_folder import first_usable, user_cache

VARIABLE = "POCL_CACHE_DIR"


@cache
def prepare_cache() -> None:
    """Name a folder for PoCL that only this user can write, unless POCL_CACHE_DIR does.

    PoCL reads the variable when it is loaded.
    """
    if VARIABLE not in os.environ:
        os.environ[VARIABLE] = str(first_usable([user_cache() / "cellular-wave-touch" / "pocl"], "OpenCL kernels"))
