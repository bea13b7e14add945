"""Transients and programs on large grids: Zarr arrays in blocks, several time steps of a block at a time."""
