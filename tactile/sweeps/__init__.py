"""Kinds of sweep of the tactile layer, see `cnnsim.sweep`."""
