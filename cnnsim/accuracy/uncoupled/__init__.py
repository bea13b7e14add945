"""Cells that no neighbour's state reaches: exact ends, and what the last digit of an input decides of them."""
