"""Standard deviations from few residuals: Student's, where nobody knows the noise."""

from cnnsim.support.compiled_loops import kept_njit


@kept_njit()
def few(free):  # type: ignore[no-untyped-def]  # numba types it at the call
    """By how much a deviation from so many degrees of freedom is to be taken larger: 68 % lie within one.

    Student's quantile, 1 + 1 / (2 n) + 1 / (4 n^2) + 0.09 / n^4 to 0.3 %; 1 for no degree of freedom.
    """
    if free < 1:
        return 1.0
    t = 1.0 / free
    return 1.0 + t * (0.5 + t * (0.25 + t * t * 0.09))
