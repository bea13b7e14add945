"""Loads on a cover as arrays (..., n, 5): what the columns x, y [m] and Q, R, F [N] of a row are called."""

X, Y, Q, R, F = range(5)
PLACE = slice(X, Y + 1)
"""x and y."""
SHEAR = slice(Q, R + 1)
"""The tangential components Q and R."""
FORCE = slice(Q, F + 1)
"""Q, R and F."""
COLUMNS = 5
