"""The OpenCL backend. pyopencl fails without a folder for its cache, so it gets none where that cannot be made."""

import os

from cnnsim.support.cache_folder import user_cache

try:
    user_cache().mkdir(parents=True, exist_ok=True)
    _CAN_KEEP = os.access(user_cache(), os.W_OK)
except OSError:
    _CAN_KEEP = False
if not _CAN_KEEP:
    os.environ.setdefault("PYOPENCL_NO_CACHE", "1")  # read when pyopencl is imported
