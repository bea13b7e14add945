"""What taxels bear alike beside the pattern of a grip, compiled: the part of a load that drift may have made."""

from cnnsim.support.compiled_loops import kept_njit

UNLIKE = 0.15
"""Part of the mean pressing by which taxels differ in a pattern that is known; a flatter one tells nothing apart."""


@kept_njit(error_model="numpy")
def flat(fast, held, use, a, most):  # type: ignore[no-untyped-def]  # typed at the call
    """Return how much of the pressing of all taxels is alike on all of them and not of the grip, at most ``most`` each.

    The pressing p of the taxels in ``use`` (rows, cols), the mean ``fast`` (rows, cols, 3), is fitted by c + b h, least
    squares: h is what they bore of late, ``held`` (rows, cols), which is moved towards p by its part ``a``. In a grip
    that is let go b falls to 0, and what is left of p is drift or creep. Where h is the same everywhere c is 0.
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
