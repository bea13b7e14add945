"""Columns of loads on a cover as arrays (..., n, 5): x, y [m] and Q, R, F [N]."""

X, Y, Q, R, F = range(5)
PLACE = slice(X, Y + 1)
"""x and y."""
SHEAR = slice(Q, R + 1)
"""The tangential components Q and R."""
FORCE = slice(Q, F + 1)
"""Q, R and F."""
COLUMNS = 5
