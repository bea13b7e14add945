"""The OpenCL device: found, named, its memory and programs, and what PoCL needs."""
