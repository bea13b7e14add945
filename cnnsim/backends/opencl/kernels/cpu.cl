// Steps of a one-stage scheme where a work-item is a core's share of work: up to T a launch, rows streamed.
//
// A work-item owns a tile: `width` columns of one grid, `band` rows high. Blocks of R rows enter at level 0 and come
// out at the last level, `steps` steps older; each level lags one block behind the level before it, because the last
// row of a block has neighbours in RADIUS <= R rows below it. Beside its columns a tile holds HALO of its neighbours',
// and it computes rows above and below its band, so that nothing is exchanged within a launch; where the grid ends,
// the virtual cells are imposed anew at every level.
//
// `scratch` holds rows STRIDE apart in blocks of R: the outputs of T levels, three blocks each; a block for outputs
// that are not read again; T + 1 blocks of states, as many of drives w and, with MASK, of gains (GAIN, or 0 in masked
// cells).
//
// The host defines besides: STACK, how many tiles below each other are a work-item's (with SLEEP those of them that do the
// same go as one, so that the rows around them are computed again once for all); SHIFT, the columns of a tile left of
// its own ones; COPIES where the halo's columns are cells like others (a torus of several tiles) and need no imposing.
// Comes after block.cl and rows.cl.

// Take steps of the rows first_row .. stop_row - 1 of a tile, or of a stack of tiles that do the same. `found` has what is
// noted of each of them (see sleep.cl).
static inline __attribute__((always_inline)) void
step_rows(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
          __local real *scratch, int rows, int cols, long top, int first_col, int own_cols, int first_row, int stop_row,
          int band, int steps, int turn, int *found)
{
    const int left = SHIFT - first_col, right = SHIFT + cols - first_col;
    __local real *const states = scratch + (3 * T + 1) * BLOCK, *const drives = states + (T + 1) * BLOCK;
    __local real *const gains = drives + (T + 1) * BLOCK;
    const int levels = turn == AWAKE ? steps : 1, times = turn == AWAKE ? 1 : steps;
#ifdef SLEEP
    const int reach = T * RADIUS, west = min(own_cols, (reach + V - 1) / V * V);
    const int east = west > own_cols - reach ? 0 : (own_cols - reach) / V * V;
#endif
    const int seen = HALO ? levels * RADIUS : 0; // columns beside its own ones that a tile reads
    const int near = max(0, SHIFT - EVEN(seen)), end = near + (SHIFT + own_cols + seen - near + V - 1) / V * V;
    const int b_last = (stop_row + R - 1) / R - 1 + levels;
    int slot = 0; // of block b in the rings of T + 1 blocks
    for (int b = floor_div(first_row - levels * RADIUS, R); b <= b_last; b++) {
        if (b * R < stop_row + levels * RADIUS) {
            if (BOUNDARY == BOUNDARY_PERIODIC || (b >= 0 && b * R < rows))
                for (int q = 0; q < R; q++) {
                    const int i = BOUNDARY == BOUNDARY_PERIODIC ? wrap(b * R + q, rows) : min(b * R + q, rows - 1);
                    const int at = slot * BLOCK + q * STRIDE;
                    __local real *ys = scratch + MODULO_3(b) * BLOCK + q * STRIDE;
                    bring(x, w, mask, top + i, cols, first_col - SHIFT, near, end, states + at, drives + at, gains + at, ys);
                    fix_columns(ys, left, right);
                }
            fix_rows(scratch, b, rows);
        }
        int at = slot;
        for (int t = 1; t <= levels; t++) {
            const int c = b - t, still = (levels - t) * RADIUS; // rows beyond the band that later levels read
            at = at ? at - 1 : T;
            if (c * R + R <= first_row - still || c * R >= stop_row + still) continue;
            const __local real *old = scratch + (t - 1) * 3 * BLOCK;
            __local real *level = scratch + t * 3 * BLOCK, *fresh = level + (t < levels ? MODULO_3(c) * BLOCK : 0);
            if (BOUNDARY == BOUNDARY_PERIODIC || (c >= 0 && c * R < rows)) {
#define STEP(start, end, ...)                                                                                          \
    step_block(old + MODULO_3(c - 1) * BLOCK, old + MODULO_3(c) * BLOCK, old + MODULO_3(c + 1) * BLOCK,                  \
               states + at * BLOCK, drives + at * BLOCK, gains + at * BLOCK, fresh, start, end, __VA_ARGS__)
#ifdef SLEEP
                if (t == levels) {
                    const int loose = STEP(SHIFT, SHIFT + own_cols, times, 1, SHIFT + own_cols, SHIFT + west, SHIFT + east);
                    const int sides = (loose >> R & 1 ? WEST : 0) | (loose >> R & 2 ? EAST : 0);
                    for (int q = 0; loose && q < R; q++) {
                        const int i = c * R + q - first_row, n = i / band;
                        if ((loose >> q & 1) && i >= 0 && i < stop_row - first_row)
                            found[n] |= sides | place_of(i - n * band, min(band, stop_row - first_row - n * band), reach,
                                                         NORTH, SOUTH);
                    }
                } else
#endif
                    STEP(SHIFT - (HALO ? EVEN(still) : 0), SHIFT + own_cols + (HALO ? still : 0), 1, 0, 0, 0, 0);
                for (int q = 0; t < levels && q < R; q++) fix_columns(fresh + q * STRIDE, left, right);
            }
            if (t < levels) fix_rows(level, c, rows);
        }
        const int c = b - levels; // the block that comes out; `at` is its place in the rings
        for (int q = 0; q < R && c * R >= first_row && c * R + q < stop_row; q++) {
            __global real *to = out + (top + c * R + q) * cols + first_col;
            const __local real *from = states + at * BLOCK + q * STRIDE + SHIFT;
            int j = 0;
#ifdef SLEEP
            if (turn == COASTING && differ(from, x + (to - out), own_cols))
                found[(c * R + q - first_row) / band] |= MOVED;
#endif
            for (; j + V <= own_cols; j += V) VEC(__global, to + j) = VEC(const __local, from + j);
            for (; j < own_cols; j++) to[j] = from[j];
        }
        slot = slot == T ? 0 : slot + 1;
    }
}

__attribute__((reqd_work_group_size(1, 1, 1)))
__kernel void steps(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
                    __local real *scratch, int rows, int cols, int width, int band, int across, int down, int steps,
                    int first SLEEP_ARGUMENTS GATE_ARGUMENTS)
{
#ifdef SLEEP
    if (!goes_on(halt, checked, parts, get_global_id(0) == 0)) return;
#endif
    const int group = first + get_global_id(0), col = group % across, first_col = col * width;
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
            step_rows(x, w, mask, out, scratch, rows, cols, top, first_col, own_cols, q * band, min(after * band, rows),
                      band, steps, turn, found);
        for (int n = q; n < after; n++) moves[(grid * down + n) * across + col] = found[n - q];
    }
#else
    step_rows(x, w, mask, out, scratch, rows, cols, top, first_col, own_cols, bottom * band, min(stop * band, rows), band,
              steps, AWAKE, 0);
#endif
}
