// Steps of a one-stage scheme on a CPU: up to T a launch, rows streamed through levels. Comes after block.cl and rows.cl.
//
// A work-item owns a tile: `width` columns of one grid, `band` rows high. Its rows stream through levels, R at a time;
// level t holds the state after t steps and follows level t - 1 by RADIUS rows, which is all that it reads. Each level
// replaces what the one before it left, which is in the first-level cache: the states in place, and the outputs RADIUS
// rows further up, in rows that this level reads no more. Of a level's outputs the last 2 RADIUS rows remain, which the
// next R rows need. In addition to its columns a tile holds HALO of its neighbours', and it computes rows above and below its
// band, so that nothing is exchanged within a launch; where the grid ends, the virtual cells are set at every level.
//
// `scratch` holds rows STRIDE apart: `live` + T * RADIUS rows of outputs, and `live` rows each of states, of drives w and,
// with MASK, of gains (GAIN, or 0 in masked cells). The grid's first column of the tile is at SHIFT. COPIES: the halo's
// columns are cells like others (a torus of several tiles), not virtual.

__attribute__((reqd_work_group_size(1, 1, 1)))
__kernel void steps(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
                    __local real *scratch, int live, int rows, int cols, int width, int band, int across, int down,
                    int steps, int first
#ifdef SLEEP
                    , __global const uchar *moved, __global uchar *moves, int beyond, int beside, int least
#endif
                    )
{
    const int tile = first + get_global_id(0), torus = BOUNDARY == BOUNDARY_PERIODIC;
    const int first_col = tile % across * width, own_cols = min(width, cols - first_col);
    const int first_row = tile / across % down * band, stop_row = min(rows, first_row + band);
    const long top = (long)(tile / across / down) * rows;
#ifdef SLEEP
    const int turn = turn_of(moved, tile, across, down, beyond, beside, least);
    moves[tile] = turn == AWAKE ? MOVED : 0;
    if (turn == ASLEEP) return;
    const int levels = turn == AWAKE ? steps : 1, times = turn == AWAKE ? 1 : steps;
#else
    const int levels = steps, times = 1;
#endif
    const int reach = T * RADIUS; // cells of its neighbours that a tile reads in the longest launch
    const int left = SHIFT - first_col, right = SHIFT + cols - first_col;
    __local real *const outputs = scratch + T * RADIUS * STRIDE, *const states = outputs + live * STRIDE;
    __local real *const drives = states + live * STRIDE, *const gains = drives + live * STRIDE;
    const int seen = HALO ? levels * RADIUS : 0; // columns left and right of its own that a tile reads
    const int near = max(0, SHIFT - EVEN(seen)), end = near + EVEN(SHIFT + own_cols + seen - near);
    const int begin = torus ? first_row - levels * RADIUS : max(first_row - levels * RADIUS, 0);
    int line = T * RADIUS; // where row `row` lies among the live ones
    // rows before the first are stepped along with it, and memory may hold denormal numbers, which are slow
    for (int q = 1; q <= 2 * levels * RADIUS; q++) fill_row(outputs + (line - q) * STRIDE, 0);
    for (int q = 1; q < R && q <= line; q++)
        fill_row(states + (line - q) * STRIDE, 0), fill_row(drives + (line - q) * STRIDE, 0);
    for (int row = begin; row < stop_row + levels * RADIUS; row += R, line += R) {
        if (line + R > live) {
            const int back = (line - T * RADIUS) * STRIDE;
            for (int q = -T * RADIUS; q < T * RADIUS; q++) copy_row(outputs + q * STRIDE, outputs + q * STRIDE + back);
            for (int at = 0; at < T * RADIUS * STRIDE; at += STRIDE) {
                copy_row(states + at, states + at + back), copy_row(drives + at, drives + at + back);
#ifdef MASK
                copy_row(gains + at, gains + at + back);
#endif
            }
            line = T * RADIUS;
        }
        for (int t = 0; t <= levels; t++) {
            const int i = row - t * RADIUS, still = (levels - t) * RADIUS; // rows beyond the band that later levels read
            const int start = torus ? first_row - still : max(first_row - still, 0);
            const int stop = torus ? stop_row + still : min(stop_row + still, rows);
            if (i + R <= start) break; // this level and those after it have not begun
            const int at = (line - t * RADIUS) * STRIDE;
            __local real *const fresh = outputs + at - t * RADIUS * STRIDE;
            if (t == 0) {
                for (int q = 0; q < R; q++) {
                    __local real *xs = states + at + q * STRIDE, *ys = fresh + q * STRIDE;
                    const long there = top + (torus ? wrap(i + q, rows) : i + q);
                    if (i + q < stop)
                        load_row(x, w, mask, there, cols, first_col - SHIFT, near, end, xs, drives + (xs - states),
                                 gains + (xs - states), ys);
                    else
                        fill_row(xs, 0), fill_row(drives + (xs - states), 0), fill_row(ys, 0);
                    fix_columns(ys, left, right);
                }
            } else if (i < stop) {
                const int around = HALO ? still : 0;
                const int loose = step_block(fresh + RADIUS * STRIDE, states + at, drives + at, gains + at,
                                             SHIFT - EVEN(around), SHIFT + own_cols + around, times, t == levels,
                                             SHIFT + own_cols, SHIFT + reach, SHIFT + own_cols - reach);
#ifdef SLEEP
                const int sides = (loose >> R & 1 ? WEST : 0) | (loose >> R & 2 ? EAST : 0);
                for (int q = i; loose && q < i + R; q++)
                    if (loose >> (q - i) & 1 && q >= first_row && q < stop_row)
                        moves[tile] |= LOOSE | sides | (q < first_row + reach ? NORTH : 0)
                                       | (q >= stop_row - reach ? SOUTH : 0);
#endif
                for (int q = 0; t < levels && q < R; q++) fix_columns(fresh + q * STRIDE, left, right);
            }
            if (t < levels) {
                fix_rows(fresh - i * STRIDE, i, rows);
                continue;
            }
            for (int q = max(0, first_row - i); q < R && i + q < stop_row; q++) { // the rows that are done
                const long cell = (top + i + q) * cols + first_col;
                const __local real *from = states + at + q * STRIDE + SHIFT;
#ifdef SLEEP
                if (turn == COASTING && differ(from, x + cell, own_cols)) moves[tile] |= MOVED;
#endif
                int j = 0;
                for (; j + V <= own_cols; j += V) VEC(__global, out + cell + j) = VEC(const __local, from + j);
                for (; j < own_cols; j++) out[cell + j] = from[j];
            }
        }
    }
}
