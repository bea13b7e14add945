"""Supersteps: one large grid in blocks on the disk, several time steps of each block at a time, on many processes."""
