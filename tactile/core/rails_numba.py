"""Ends of the range of every taxel, compiled: how often its extremes were read, and how often a little less."""

from cnnsim.support.compiled_loops import kept_njit


@kept_njit(error_model="numpy")
def watch(values, before, jitter, band, ends, hits, steps, rule, saturated):  # type: ignore[no-untyped-def]
    """Take the readings (rows, cols, 3) of a frame and mark the taxels (rows, cols) that are at an end.

    ``ends``, ``hits`` (rows, cols, 3, 2, and 2 for hits: at the end, near it) and ``steps`` (3,) are kept; ``rule``:
    how many hits make an end, and how many times those near it. Readings that are not finite count for nothing.
    """
    least, often = rule
    rows, cols, _ = values.shape
    for i in range(rows):
        for j in range(cols):
            mark = False
            for k in range(3):
                v = values[i, j, k]
                change = abs(v - before[i, j, k])
                before[i, j, k] = v
                if change > 0 and change < steps[k]:
                    steps[k] = change
                for side in range(2):
                    at, end = (v, ends[i, j, k, side]) if side == 0 else (-v, ends[i, j, k, side])
                    count = hits[i, j, k, side]
                    if at > end:
                        count[1] = count[0] + count[1] if at - end < band * jitter[i, j, k] else 0
                        count[0] = 1
                        ends[i, j, k, side] = at
                    elif at == end:
                        count[0] += 1
                        fine = 2 * steps[k] <= jitter[i, j, k]
                        mark = mark or (fine and count[0] >= least and count[0] > often * count[1])
                    elif end - at < band * jitter[i, j, k]:
                        count[1] += 1
            saturated[i, j] = mark
