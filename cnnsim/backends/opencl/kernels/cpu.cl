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
// its own ones; COPIES where the halo's columns are
// cells like others (a torus of several tiles) and need no imposing.

#define BLOCK (R * STRIDE)
#define VEC(type, at) (*(type vec *)(at))
// So many columns, in whole halves of the widest vectors, at which vectors lie well.
#define EVEN(columns) (((columns) + 7) / 8 * 8)
#define MODULO_3(b) (((b) + 6 * T) % 3)

#if R == 1
#define EACH_ROW(DO) DO(0)
#elif R == 2
#define EACH_ROW(DO) DO(0) DO(1)
#elif R == 3
#define EACH_ROW(DO) DO(0) DO(1) DO(2)
#elif R == 4
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3)
#else
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3) DO(4)
#endif

// Row q of the block (-R .. 2 R - 1: its neighbours' rows too), a vector of cells from column j + l on.
#define ROW(q) ((q) < 0 ? above + ((q) + R) * STRIDE : (q) < R ? here + (q) * STRIDE : below + ((q) - R) * STRIDE)
#define NEIGHBOUR(q, l) VEC(const __local, ROW(q) + j + (l))

// One step of a block's columns start .. end - 1 (or so many, with the drive of the first): states in place, outputs to
// `fresh`. All rows are read before any is written, so that the compiler may keep in registers what two of them read.
// With `mark` it returns in bit q whether a cell of row q before column `stop` was not saturated for good.
static inline __attribute__((always_inline)) int
step_block(const __local real *above, const __local real *here, const __local real *below, __local real *x,
           const __local real *w, const __local real *gain, __local real *fresh, int start, int end, int times,
           int mark, int stop)
{
#define NONE(q) sure_vec loose##q = (sure_vec)0;
    EACH_ROW(NONE)
    for (int j = start; j < end; j += V) {
#define START(q) vec s##q = VEC(const __local, x + (q) * STRIDE + j), d##q = VEC(const __local, w + (q) * STRIDE + j);
        EACH_ROW(START)
#ifdef SHARED_SUMS
#define SIDES(q) (NEIGHBOUR(q, -1) + NEIGHBOUR(q, 1))
#define DRIVE(q)                                                                                              \
    d##q += (real)(CENTRE) * NEIGHBOUR(q, 0);                                                                     \
    d##q += (real)(EDGE) * (SIDES(q) + (NEIGHBOUR(q - 1, 0) + NEIGHBOUR(q + 1, 0)));                                  \
    d##q += (real)(CORNER) * (SIDES(q - 1) + SIDES(q + 1));
#else
#define TAP(q, k, l, weight) d##q += (real)(weight) * NEIGHBOUR(q + (k), l);
#define DRIVE(q) TAPS(TAP, q)
#endif
        EACH_ROW(DRIVE)
#ifdef SLEEP
        if (mark) {
            sure_vec own = (sure_vec)-1;
            for (int v = 0; j + V > stop && v < V; v++) own[v] = j + v < stop ? -1 : 0;
#ifdef MASK
#define STAYS(q) (SATURATED(vec, s##q, d##q) | HELD(vec, s##q, d##q, VEC(const __local, gain + (q) * STRIDE + j)))
#else
#define STAYS(q) SATURATED(vec, s##q, d##q)
#endif
#define MARK(q) loose##q |= own & ~STAYS(q);
            EACH_ROW(MARK)
        }
#endif
#ifdef MASK
#define UPDATE(q) s##q += VEC(const __local, gain + (q) * STRIDE + j) * (d##q - s##q);
#else
#define UPDATE(q) s##q += (real)(GAIN) * (d##q - s##q);
#endif
        for (int t = 0; t < times; t++) {
            EACH_ROW(UPDATE)
        }
#if LIMITED
#define KEEP(q) s##q = CLIP(vec, s##q); VEC(__local, x + (q) * STRIDE + j) = s##q;
#else
#define KEEP(q) VEC(__local, x + (q) * STRIDE + j) = s##q;
#endif
        EACH_ROW(KEEP)
#define SHOW(q) VEC(__local, fresh + (q) * STRIDE + j) = CLIP(vec, s##q);
        EACH_ROW(SHOW)
    }
    int found = 0;
#define FOUND(q)                                                  \
    {                                                             \
        sure any = 0;                                             \
        for (int v = 0; v < V; v++) any |= loose##q[v];           \
        found |= any ? 1 << (q) : 0;                              \
    }
    if (mark) {
        EACH_ROW(FOUND)
    }
    return found;
}

// Impose the virtual cells beside one row of outputs; the grid's columns are left .. right - 1 of the buffer.
static void fix_columns(__local real *row, int left, int right)
{
#ifndef COPIES
    for (int q = 1; q <= RADIUS; q++) {
#if BOUNDARY == BOUNDARY_FIXED
        const real before = CONSTANT, after = CONSTANT;
#elif BOUNDARY == BOUNDARY_PERIODIC
        const real before = row[left + wrap(-q, right - left)], after = row[left + (q - 1) % (right - left)];
#else
        const real before = row[max(left, 0)], after = row[min(right, STRIDE) - 1];
#endif
        if (left - q >= 0) row[left - q] = before;
        if (right + q - 1 < STRIDE) row[right + q - 1] = after;
    }
#endif
}

static void fill_row(__local real *to, const __local real *from)
{
    for (int j = 0; j + V <= STRIDE; j += V)
#if BOUNDARY == BOUNDARY_FIXED
        VEC(__local, to + j) = (vec)CONSTANT;
#else
        VEC(__local, to + j) = VEC(const __local, from + j);
#endif
}

// Impose the virtual rows that touch block b of a level, whose outputs begin at y. A torus has none.
static void fix_rows(__local real *y, int b, int rows)
{
#if BOUNDARY != BOUNDARY_PERIODIC
    __local real *here = y + MODULO_3(b) * BLOCK, *before = y + MODULO_3(b - 1) * BLOCK;
    const int last = rows - 1 - b * R; // the grid's last row, counted in this block
    if (b == 0)
        for (int q = 0; q < R; q++) fill_row(before + q * STRIDE, here);
    if (0 <= last && last < R)
        for (int q = last + 1; q < R; q++) fill_row(here + q * STRIDE, here + last * STRIDE);
    if (-R <= last && last < 0)
        for (int q = 0; q < R; q++) fill_row(here + q * STRIDE, before + (last + R) * STRIDE);
#endif
}

// Bring in one row's columns first .. stop - 1 of the buffer: its states, its drives, its gains and its outputs at level
// 0; `start` is the grid's column at the buffer's column 0.
static void bring(__global const real *x, __global const real *w, __global const ulong *mask, long line, int cols,
                  int start, int first, int stop, __local real *xs, __local real *ws, __local real *gains,
                  __local real *ys)
{
    x += line * cols + start;
    w += line * cols + start;
    int j = first;
#if BOUNDARY != BOUNDARY_PERIODIC
    for (; start + j < 0; j++) xs[j] = ws[j] = ys[j] = 0; // for virtual cells, which are imposed
#endif
    for (; start + j >= 0 && j + V <= stop && start + j + V <= cols; j += V) {
        const vec s = VEC(const __global, x + j);
        VEC(__local, xs + j) = s;
        VEC(__local, ys + j) = CLIP(vec, s);
        VEC(__local, ws + j) = VEC(const __global, w + j);
    }
    for (; j < stop; j++) {
        const int c = (BOUNDARY == BOUNDARY_PERIODIC ? wrap(start + j, cols) : clamp_to(start + j, cols)) - start;
        const real s = x[c];
        xs[j] = s;
        ys[j] = CLIP(real, s);
        ws[j] = w[c];
    }
#ifdef MASK
    for (j = first; j < stop; j++) {
        const int c = BOUNDARY == BOUNDARY_PERIODIC ? wrap(start + j, cols) : clamp_to(start + j, cols);
        gains[j] = black(mask, line, c, cols) ? 0 : (real)(GAIN);
    }
#endif
}

// Whether any bit differs in two rows.
static int differ(const __local real *a, __global const real *b, int cols)
{
    sure_vec some = (sure_vec)0;
    long other = 0;
    int j = 0;
    for (; j + V <= cols; j += V) some |= BITS_vec(VEC(const __local, a + j)) ^ BITS_vec(VEC(const __global, b + j));
    for (; j < cols; j++) other |= BITS_real(a[j]) ^ BITS_real(b[j]);
    for (int v = 0; v < V; v++) other |= some[v];
    return other != 0;
}

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
    const int zones[] = {0, west, max(west, (own_cols - reach) / V * V), own_cols};
    const int places[] = {west > own_cols - reach ? WEST | EAST : WEST, 0, EAST};
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
#define STEP(start, end, times, mark)                                                                                   \
    step_block(old + MODULO_3(c - 1) * BLOCK, old + MODULO_3(c) * BLOCK, old + MODULO_3(c + 1) * BLOCK,                  \
               states + at * BLOCK, drives + at * BLOCK, gains + at * BLOCK, fresh, start, end, times, mark,            \
               SHIFT + own_cols)
#ifdef SLEEP
                for (int zone = 0; t == levels && zone < 3; zone++) {
                    const int loose = STEP(SHIFT + zones[zone], SHIFT + zones[zone + 1], times, 1);
                    for (int q = 0; q < R; q++) {
                        const int i = c * R + q - first_row, n = i / band;
                        if ((loose >> q & 1) && i >= 0 && i < stop_row - first_row)
                            found[n] |= places[zone] | place_of(i - n * band, min(band, stop_row - first_row - n * band),
                                                                reach, NORTH, SOUTH);
                    }
                }
                if (t < levels)
#endif
                    STEP(SHIFT - (HALO ? EVEN(still) : 0), SHIFT + own_cols + (HALO ? still : 0), 1, 0);
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
                    int first SLEEP_ARGUMENTS)
{
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
