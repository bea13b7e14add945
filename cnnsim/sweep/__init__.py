"""Sweeps: many small cases over a grid of choices, run on all cores or on a cluster, one row of a table for each."""
