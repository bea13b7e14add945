"""Values of a frame as the text of JSON, compiled: a hundred times faster than through Python's numbers."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit

DIGITS = 9
"""Digits of a number: enough for the bits of float32."""
TINY = 1e-290
"""Smaller values are written as 0: the next power of ten is no number."""
POWERS = np.array([float(f"1e{n}") for n in range(309)])
NULL, MINUS, POINT, ZERO, E, COMMA, SPACE, OPEN, SHUT = (*b"null"[:1], *b"-.0e, []")


@kept_helper(error_model="numpy")
def _digits(m, count, point, out, at):  # type: ignore[no-untyped-def]  # typed at the call
    """Write the ``count`` digits of ``m``, with a point after ``point`` of them if it is within; return the end."""
    end = at + count + (0 < point < count)
    for n in range(end - 1, at - 1, -1):
        if n == at + point and point > 0:
            out[n] = POINT
        else:
            rest = m // np.uint64(10)
            out[n] = ZERO + m - rest * np.uint64(10)
            m = rest
    return end


@kept_helper(error_model="numpy")
def _number(value, out, at):  # type: ignore[no-untyped-def]  # typed at the call
    """Write a value as %.9g does, null if it is not finite; return the end."""
    if not math.isfinite(value):
        for n, letter in enumerate((110, 117, 108, 108)):
            out[at + n] = letter
        return at + 4
    size = abs(value)
    if math.copysign(1.0, value) < 0:
        out[at] = MINUS
        at += 1
    if size < TINY:
        out[at] = ZERO
        return at + 1
    e = math.floor(math.log10(size))
    shift = DIGITS - 1 - e
    m = np.uint64(np.rint(size * POWERS[shift] if shift >= 0 else size / POWERS[-shift]))
    if m >= np.uint64(10**DIGITS):
        m, e = m // np.uint64(10), e + 1
    count = DIGITS
    while count > max(e + 1, 1) if e < DIGITS else count > 1:
        rest = m // np.uint64(10)
        if rest * np.uint64(10) != m:
            break
        m, count = rest, count - 1
    if 0 <= e < DIGITS:
        return _digits(m, count, e + 1, out, at)
    if -5 < e < 0:
        return _digits(m, count - e, 1, out, at)
    at = _digits(m, count, 1, out, at)
    out[at], out[at + 1] = E, MINUS if e < 0 else 43
    return _digits(np.uint64(abs(e)), 2 if abs(e) < 100 else 3, 0, out, at + 2)


@kept_njit(error_model="numpy")
def write(values, valid, out):  # type: ignore[no-untyped-def]  # typed at the call
    """Write values (rows, cols, 3) as nested lists, null where not ``valid`` or not finite; return the length.

    ``out``: bytes, 18 for every number, 3 for every taxel and 4 for every row.
    """
    rows, cols, axes = values.shape
    at = 0
    for i in range(rows):
        for j in range(cols):
            for k in range(axes):
                if i + j + k:
                    out[at], out[at + 1] = COMMA, SPACE
                    at += 2
                for opened in (j + k == 0 and i == 0, j + k == 0, k == 0):
                    if opened:
                        out[at] = OPEN
                        at += 1
                at = _number(values[i, j, k] if valid[i, j] else math.nan, out, at)
            out[at] = SHUT
            at += 1
        out[at] = SHUT
        at += 1
    out[at] = SHUT
    return at + 1
