"""Sizes of the jumps of a table that inputs are near to, compiled."""

from cnnsim.support.compiled_loops import kept_helper, kept_njit


@kept_helper(error_model="numpy")
def number_near(row, own, centre, edge, low, high):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return how many of a row are from low to high away from an edge, in vectors."""
    found = 0
    for j in range(row.size):
        away = abs(row[j] - centre * own[j] - edge)
        found += (away <= high) & (away >= low)
    return found


@kept_njit(error_model="numpy")
def add_jumps(around, places, weights, edges, how, radius, total):  # type: ignore[no-untyped-def]
    """Add, for each cell, weight times jump of the neighbours at an edge; return whether there is one.

    ``around`` (n, rows + 2 radius, cols + 2 radius); ``places`` (taps, 2) of a neighbour in it; ``edges`` (2, edges)
    where and by how much; ``how``: (nearest, farthest, share of the cell's own value that is taken off).
    """
    low, high, centre = how
    some = False
    cols = total.shape[2]
    for g in range(total.shape[0]):
        for i in range(total.shape[1]):
            own = around[g, i + radius][radius : radius + cols]
            for n in range(places.shape[0]):
                row = around[g, i + places[n, 0]][places[n, 1] : places[n, 1] + cols]
                for e in range(edges.shape[1]):
                    edge, size = edges[0, e], weights[n] * edges[1, e]
                    if not number_near(row, own, centre, edge, low, high):
                        continue
                    some = True
                    for j in range(cols):
                        away = abs(row[j] - centre * own[j] - edge)
                        if low <= away <= high:
                            total[g, i, j] += size
    return some
