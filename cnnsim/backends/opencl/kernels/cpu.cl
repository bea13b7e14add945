// Steps of a one-stage scheme where a work-item is a core's share of work: up to T a launch, rows streamed.
//
// A work-item owns a tile: `width` columns of one grid, `band` rows high. Its rows stream through levels, R at a time;
// level t holds the state after t steps and follows level t - 1 by RADIUS rows, which is all that it needs to see. Each
// level replaces what the one before it left, so that this lies in the first-level cache still: the states in place, and
// the outputs RADIUS rows further up, where those are that no other row of this level reads. What is left of a level's
// outputs are the last 2 RADIUS rows, which the next R rows need before them. Beside its columns a tile holds HALO of its
// neighbours', and it computes rows above and below its band, so that nothing is exchanged within a launch; where the
// grid ends, the virtual cells are imposed anew at every level.
//
// `scratch` holds rows STRIDE apart: `live` + T * RADIUS rows of outputs, and `live` rows each of states, of drives w and,
// with MASK, of gains (GAIN, or 0 in masked cells).
//
// The host defines besides: STACK, how many tiles below each other are a work-item's (with SLEEP those of them that do the
// same go as one, so that the rows around them are computed again once for all); SHIFT, the columns of a tile left of
// its own ones; COPIES where the halo's columns are cells like others (a torus of several tiles) and need no imposing.
// Comes after block.cl and rows.cl.

// Take steps of the rows first_row .. stop_row - 1 of a tile, or of a stack of tiles that do the same. `found` has what is
// noted of each of them (see sleep.cl); `sign` is set if one has a cell that moves (see rounds.cl).
static inline __attribute__((always_inline)) void
step_rows(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
          __local real *scratch, int live, int rows, int cols, long top, int first_col, int own_cols, int first_row,
          int stop_row, int band, int steps, int turn, int *found, __global int *sign)
{
    const int left = SHIFT - first_col, right = SHIFT + cols - first_col, torus = BOUNDARY == BOUNDARY_PERIODIC;
    __local real *const outputs = scratch + T * RADIUS * STRIDE, *const states = outputs + live * STRIDE;
    __local real *const drives = states + live * STRIDE;
    __local real *const gains = drives + live * STRIDE;
    const int levels = turn == AWAKE ? steps : 1, times = turn == AWAKE ? 1 : steps;
#ifdef SLEEP
    const int reach = T * RADIUS, west = min(own_cols, (reach + V - 1) / V * V);
    const int east = west > own_cols - reach ? 0 : (own_cols - reach) / V * V;
#endif
    const int seen = HALO ? levels * RADIUS : 0; // columns beside its own ones that a tile reads
    const int near = max(0, SHIFT - EVEN(seen)), end = near + (SHIFT + own_cols + seen - near + V - 1) / V * V;
    const int begin = torus ? first_row - levels * RADIUS : max(first_row - levels * RADIUS, 0);
    int line = T * RADIUS; // where row `row` lies among the live ones
    // rows before the first are stepped along with it: what memory held before may be numbers that are slow to compute with
    for (int q = 1; q <= 2 * levels * RADIUS; q++) fill_row(outputs + (line - q) * STRIDE, 0);
    for (int q = 1; q < R && q <= line; q++)
        fill_row(states + (line - q) * STRIDE, 0), fill_row(drives + (line - q) * STRIDE, 0);
    for (int row = begin; row < stop_row + levels * RADIUS; row += R, line += R) {
        if (line + R > live) {
            const int back = (line - T * RADIUS) * STRIDE;
            for (int q = -T * RADIUS; q < T * RADIUS; q++) move_row(outputs + q * STRIDE, back);
            for (int q = 0; q < T * RADIUS; q++) {
                move_row(states + q * STRIDE, back), move_row(drives + q * STRIDE, back);
#ifdef MASK
                move_row(gains + q * STRIDE, back);
#endif
            }
            line = T * RADIUS;
        }
        for (int t = 0; t <= levels; t++) {
            const int i = row - t * RADIUS, still = (levels - t) * RADIUS; // rows beyond the band that later levels read
            const int first = torus ? first_row - still : max(first_row - still, 0);
            const int stop = torus ? stop_row + still : min(stop_row + still, rows);
            if (i + R <= first) break; // this level and those after it have not begun
            const int at = (line - t * RADIUS) * STRIDE;
            __local real *const fresh = outputs + at - t * RADIUS * STRIDE;
            if (t == 0) {
                for (int q = 0; q < R; q++) {
                    __local real *xs = states + at + q * STRIDE, *ys = fresh + q * STRIDE;
                    const long there = top + (torus ? wrap(i + q, rows) : i + q);
                    if (i + q < stop)
                        bring(x, w, mask, there, cols, first_col - SHIFT, near, end, xs, drives + (xs - states),
                              gains + (xs - states), ys);
                    else
                        fill_row(xs, 0), fill_row(drives + (xs - states), 0), fill_row(ys, 0);
                    fix_columns(ys, left, right);
                }
            } else if (i < stop) {
                const int coming = row + R + t - 1; // one of the rows that are brought in next
                if (t <= R && coming >= 0 && coming < min(stop_row + levels * RADIUS, rows)) {
                    fetch(x + (top + coming) * cols + first_col - SHIFT, near, end);
                    fetch(w + (top + coming) * cols + first_col - SHIFT, near, end);
                }
#define STEP(start, end, ...)                                                                                          \
    step_block(fresh + RADIUS * STRIDE, states + at, drives + at, gains + at, start, end, __VA_ARGS__)
#ifdef SLEEP
                for (int q = 0; t == 1 && q < R && !*sign; q++) {
                    const int at_q = at + q * STRIDE;
                    if (i + q >= first_row && i + q < stop_row)
                        *sign = moves_on(fresh + (RADIUS + q) * STRIDE, states + at_q, drives + at_q, gains + at_q, SHIFT,
                                         SHIFT + own_cols);
                }
                if (t == levels) {
                    const int loose = STEP(SHIFT, SHIFT + own_cols, times, 1, SHIFT + own_cols, SHIFT + west, SHIFT + east);
                    const int sides = (loose >> R & 1 ? WEST : 0) | (loose >> R & 2 ? EAST : 0);
                    for (int q = 0; loose && q < R; q++) {
                        const int own = i + q - first_row, n = own / band;
                        if ((loose >> q & 1) && own >= 0 && own < stop_row - first_row)
                            found[n] |= sides | place_of(own - n * band, min(band, stop_row - first_row - n * band), reach,
                                                         NORTH, SOUTH);
                    }
                } else
#endif
                    STEP(SHIFT - (HALO ? EVEN(still) : 0), SHIFT + own_cols + (HALO ? still : 0), 1, 0, 0, 0, 0);
                for (int q = 0; t < levels && q < R; q++) fix_columns(fresh + q * STRIDE, left, right);
            }
            if (t < levels) {
                fix_rows(fresh - i * STRIDE, i, rows);
                continue;
            }
            for (int q = max(0, first_row - i); q < R && i + q < stop_row; q++) { // the rows that come out
                __global real *to = out + (top + i + q) * cols + first_col;
                const __local real *from = states + at + q * STRIDE + SHIFT;
                int j = 0;
#ifdef SLEEP
                if (turn == COASTING && differ(from, x + (to - out), own_cols)) found[(i + q - first_row) / band] |= MOVED;
#endif
                for (; j + V <= own_cols; j += V) VEC(__global, to + j) = VEC(const __local, from + j);
                for (; j < own_cols; j++) to[j] = from[j];
            }
        }
    }
}

// Take steps of one group of tiles: a stack of them, or one.
static inline __attribute__((always_inline)) void
step_group(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
           __local real *scratch, int live, int rows, int cols, int width, int band, int across, int down, int steps,
           int group, __global int *sign SLEEP_ARGUMENTS)
{
    const int col = group % across, first_col = col * width;
    const int own_cols = min(width, cols - first_col), stacks = (down + STACK - 1) / STACK;
    const int grid = group / across / stacks, bottom = group / across % stacks * STACK, stop = min(down, bottom + STACK);
    const long top = (long)grid * rows;
#ifdef SLEEP
    const int beyond = counted(rows, down, band, T * RADIUS), beside = counted(cols, across, width, T * RADIUS);
    int turns[STACK];
    for (int q = bottom; q < stop; q++)
        turns[q - bottom] = turn_of(moved, (grid * down + q) * across + col, across, down, beyond, beside, least);
    for (int q = bottom, after; q < stop; q = after) {
        const int turn = turns[q - bottom];
        int found[STACK];
        for (after = q; after < stop && turns[after - bottom] == turn; after++)
            found[after - q] = turn == AWAKE ? MOVED : 0;
        if (turn != ASLEEP)
            step_rows(x, w, mask, out, scratch, live, rows, cols, top, first_col, own_cols, q * band,
                      min(after * band, rows), band, steps, turn, found, sign);
        for (int n = q; n < after; n++) moves[(grid * down + n) * across + col] = found[n - q];
    }
#else
    step_rows(x, w, mask, out, scratch, live, rows, cols, top, first_col, own_cols, bottom * band,
              min(stop * band, rows), band, steps, AWAKE, 0, 0);
#endif
}

__attribute__((reqd_work_group_size(1, 1, 1)))
__kernel void steps(__global real *x, __global const real *w, __global const ulong *mask, __global real *out,
                    __local real *scratch, int live, int rows, int cols, int width, int band, int across, int down,
                    int steps, int first SLEEP_ARGUMENTS ROUND_ARGUMENTS)
{
#ifdef SLEEP
    for (int round, group; (group = claim(book, groups, rounds, each, &round)) >= 0; hand_in(book)) {
        const int back = round % 2; // planes and notes by turns
        step_group(back ? out : x, w, mask, back ? x : out, scratch, live, rows, cols, width, band, across, down, steps,
                   first + group, book + SIGNS + round, back ? moves : moved, back ? moved : moves, least);
    }
    leave(book, groups, each);
#else
    step_group(x, w, mask, out, scratch, live, rows, cols, width, band, across, down, steps, first + get_global_id(0), 0);
#endif
}
