"""Repeated readings of every taxel, compiled."""

from cnnsim.support.compiled_loops import kept_njit


@kept_njit(error_model="numpy")
def watch(values, before, run, most, pressed, least, longer, frozen):  # type: ignore[no-untyped-def]  # typed at the call
    """Process the readings (rows, cols, 3) of a frame, mark the ``frozen`` taxels, and return whether there are any.

    State: the readings ``before``, and (rows, cols) the current ``run`` of equal readings and the longest that ended.
    """
    rows, cols, _ = values.shape
    new = False
    for i in range(rows):
        for j in range(cols):
            for k in range(3):
                new = new or values[i, j, k] != before[i, j, k]
    found = False
    for i in range(rows):
        for j in range(cols):
            if new:  # drivers repeat whole frames
                same = True
                for k in range(3):
                    same = same and values[i, j, k] == before[i, j, k]
                    before[i, j, k] = values[i, j, k]
                run[i, j] += 1
                if not same:
                    most[i, j] = max(most[i, j], run[i, j])
                    run[i, j] = 0
                lasts = run[i, j] > max(least, longer * most[i, j])
                frozen[i, j] = lasts and (pressed[i, j] or frozen[i, j])
            found = found or frozen[i, j]
    return found
