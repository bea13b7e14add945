"""Uniform part of a load, compiled: the pressing that drift or creep may have made in a release."""

from cnnsim.support.compiled_loops import kept_njit

UNLIKE = 0.15
"""Relative spread of the pressing below which a pattern counts as uniform (regularises the fit)."""


@kept_njit(error_model="numpy")
def flat(fast, held, use, a, most):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the pressing that is uniform over all taxels and not part of the grip, at most ``most`` each.

    The pressing p of the taxels in ``use`` (rows, cols), from the mean ``fast`` (rows, cols, 3), is fitted by c + b h
    in least squares. h is their recent load ``held`` (rows, cols), which moves towards p by the factor ``a``. In a
    release b falls to 0, and the rest of p is drift or creep. c is 0 where h is uniform.
    """
    rows, cols = use.shape
    count = 0
    p = h = hh = ph = 0.0
    for i in range(rows):
        for j in range(cols):
            held[i, j] += a * (fast[i, j, 2] - held[i, j])
            if use[i, j]:
                count += 1
                p += fast[i, j, 2]
                h += held[i, j]
                hh += held[i, j] ** 2
                ph += fast[i, j, 2] * held[i, j]
    if not h > 0:
        return 0.0
    p, h = p / count, h / count
    little = (UNLIKE * h) ** 2
    b = (ph / count - p * h + little * p / h) / (hh / count - h * h + little)
    return count * min(max(p - b * h, 0.0), most)
