"""End points of the range of every taxel, compiled: counts of extreme readings and of readings near them."""

from cnnsim.support.compiled_loops import kept_njit


@kept_njit(error_model="numpy")
def watch(  # type: ignore[no-untyped-def]  # typed at the call
    values, before, jitter, band, ends, hits, steps, least, often, saturated,
):  # fmt: skip
    """Process the readings (rows, cols, 3) of a frame, mark the saturated taxels (rows, cols), return whether any is.

    ``ends``, ``hits`` (rows, cols, 3, 2, and 2 for counts at the end point and near it) and ``steps`` (3,) are state;
    ``least`` count at an end point, and ``often``, its least ratio to the count near it. Non-finite readings are
    ignored.
    """
    rows, cols, _ = values.shape
    found = False
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
            found = found or mark
    return found
