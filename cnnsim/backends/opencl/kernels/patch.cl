// Steps of a one-stage scheme on a GPU, and the check whether the network has settled: states in registers. Comes after boundary.cl.
//
// A work-item owns a patch of PR x PC cells: states, drives and a bit a masked cell in registers. LANES x WARPS of them make the
// tile of a work-group. A grid that fits a tile is one group's (halo 0), for all steps of a launch. Larger grids are cut into
// tiles that overlap by a halo of RADIUS cells a step, which are computed again, so groups never wait for each other.
//
// Outputs go from patch to patch through local memory: two buffers, one barrier a step (float64: one buffer, two barriers).
// SHUFFLES: of a patch only the first and last RADIUS rows go there; the columns left and right come from registers of the
// work-items next to it. Virtual cells are set in the rows that a work-item has read.
//
// Checks are before step `phase` of the launch and then before each `every`-th. `record` begins with a word a check, as ints: bit 0 if a cell moves faster than SETTLED_RATE, bit 1 if a cell is not saturated
// for good. A launch looks at the words before word `check`, and does nothing if the network has settled there. Behind them, from
// number `rates` on, are the largest rate of each group in its last check, and 1 if a cell of it is not saturated.

#ifdef ON_GPU
#define UNROLL _Pragma("unroll")
#else
#define UNROLL _Pragma("nounroll") // it is only tested there, and unrolled loops take long to build
#endif
#define ITEMS (LANES * WARPS)
#define WIDE (LANES * PC)
#define HIGH (WARPS * PR)
#define SPAN (PC + 2 * RADIUS)
#ifdef DOUBLE
#define BUFFERS 1
#else
#define BUFFERS 2
#endif

// ALONE: the network is this grid. AGAIN: take the steps until the check in which all grids have settled. LAST: check the end.
enum { ALONE = 1, AGAIN = 2, LAST = 4, SATURATION_ENDS = 8 };

#ifdef SHUFFLES
#define LINES (2 * WARPS)
#define PITCH (WIDE + 8)
#define LINE(i) (clamp_to(i, HIGH) / PR * 2 + (clamp_to(i, HIGH) % PR != 0))
#define IS_SHARED(r) ((r) == 0 || (r) == PR - 1)
#define COLUMN0 4
#if SHUFFLES == 1 // NVIDIA
static inline real from_left(real v)
{
    int r;
    asm volatile("shfl.sync.up.b32 %0, %1, 0x1, 0x0, 0xffffffff;" : "=r"(r) : "r"(as_int(v)));
    return as_float(r);
}
static inline real from_right(real v)
{
    int r;
    asm volatile("shfl.sync.down.b32 %0, %1, 0x1, 0x1f, 0xffffffff;" : "=r"(r) : "r"(as_int(v)));
    return as_float(r);
}
#define SIDES(to) to[0] = from_left(to[PC]), to[PC + 1] = from_right(to[1]);
#else // the same through local memory, for tests
#define SIDES(to)                                                                               \
    spare[2 * me] = to[1], spare[2 * me + 1] = to[PC];                                          \
    barrier(CLK_LOCAL_MEM_FENCE);                                                               \
    to[0] = spare[max(2 * me - 1, 0)], to[PC + 1] = spare[min(2 * me + 2, 2 * ITEMS - 1)];      \
    barrier(CLK_LOCAL_MEM_FENCE);
#endif
#else
#define LINES (HIGH + 2 * RADIUS)
#define PITCH (WIDE + 2 * RADIUS)
#define LINE(i) ((i) + RADIUS)
#define IS_SHARED(r) 1
#define COLUMN0 RADIUS
#endif

// Set the virtual cells of a row of SPAN outputs from row i, column j of the grid on.
static inline void set_virtual(real *to, int i, int j, int rows, int cols)
{
#if BOUNDARY == BOUNDARY_FIXED
    for (int q = 0; q < SPAN; q++)
        if (i < 0 || i >= rows || j + q < 0 || j + q >= cols) to[q] = CONSTANT;
#elif BOUNDARY == BOUNDARY_ZERO_FLUX
    for (int q = SPAN - 2; q >= 0; q--) to[q] = j + q < 0 ? to[q + 1] : to[q];
    for (int q = 1; q < SPAN; q++) to[q] = j + q >= cols ? to[q - 1] : to[q];
#endif
}

#define HAS_SETTLED(word) (!((word) & 1) || (flags & SATURATION_ENDS && !((word) & 2)))
#define EACH_CELL UNROLL for (int r = 0; r < PR; r++) UNROLL for (int c = 0; c < PC; c++)

__attribute__((reqd_work_group_size(ITEMS, 1, 1)))
__kernel void steps(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
                    __global real *record, int rows, int cols, int across, int down, int halo, int side, int steps, int first,
                    int every, int phase, int check, int flags, int rates)
{
    __local real y[BUFFERS * LINES * PITCH], most[ITEMS];
    __local int loose[ITEMS];
#if defined SHUFFLES && SHUFFLES != 1
    __local real spare[2 * ITEMS];
#endif
    __global int *words = (__global int *)record;
    int over = 0; // no early return, no barrier in a branch: PoCL would build several copies of what comes after
    for (int c = 0; !(flags & AGAIN) && c < check; c++) over |= HAS_SETTLED(words[c]);
    if (flags & AGAIN) {
        int c = 0;
        while (phase + c * every < steps && !HAS_SETTLED(words[c])) c++;
        over = phase + c * every >= steps;
        steps = phase + c * every;
    }
    const int none = over;
    over |= !steps && !(every && flags & LAST);
    const int me = get_local_id(0), lane = me % LANES, warp = me / LANES, tile = first + get_group_id(0);
    const int up = tile / across % down * (HIGH - 2 * halo) - halo, left = tile % across * (WIDE - 2 * side) - side;
    const int i0 = warp * PR, j0 = lane * PC, gi0 = up + i0, gj0 = left + j0, torus = BOUNDARY == BOUNDARY_PERIODIC;
    const long top = (long)(tile / across / down) * rows;
    const int rim = !torus && (up < RADIUS || up + HIGH + RADIUS > rows || left < RADIUS || left + WIDE + RADIUS > cols);
    const int round_tile = torus && halo == 0 && RADIUS;
    real s[PR][PC], u[PR][PC];
    ulong held = 0, mine = 0;

    EACH_CELL {
        const int gi = gi0 + r, gj = gj0 + c, real_cell = torus || (gi >= 0 && gi < rows && gj >= 0 && gj < cols);
        const int row = torus ? wrap(gi, rows) : clamp_to(gi, rows), col = torus ? wrap(gj, cols) : clamp_to(gj, cols);
        const long cell = (top + row) * cols + col;
        s[r][c] = real_cell ? x[cell] : 0;
        u[r][c] = real_cell ? w[cell] : 0;
#ifdef MASK
        held |= (ulong)(black(mask, top + row, col, cols) != 0) << (r * PC + c);
#endif
        const int own = i0 + r >= halo && i0 + r < HIGH - halo && j0 + c >= side && j0 + c < WIDE - side;
        mine |= (ulong)(own && gi < rows && gj < cols) << (r * PC + c);
    }
    for (int at = me; at < BUFFERS * LINES * PITCH; at += ITEMS) y[at] = 0;
    int around[SPAN]; // columns of a torus in one tile
    for (int q = 0; q < SPAN; q++) around[q] = COLUMN0 + (round_tile ? wrap(j0 + q - RADIUS, cols) : j0 + q - RADIUS);
    barrier(CLK_LOCAL_MEM_FENCE);

    __local real *now = y;
#define LOOKS (every && looked != t && (t < steps ? !(flags & AGAIN) && t >= phase && (t - phase) % every == 0 : (flags & LAST) != 0))
    for (int t = 0, looked = -1; !over;) {
        const int looks = LOOKS;
        const int hold = looks && (flags & ALONE || t == steps);
        EACH_CELL if (IS_SHARED(r)) now[LINE(i0 + r) * PITCH + COLUMN0 + j0 + c] = CLIP(real, s[r][c]);
        barrier(CLK_LOCAL_MEM_FENCE);
        real fastest = 0, near[2 * RADIUS + 1][SPAN];
        int moves = 0;
#ifdef SHUFFLES
#define FETCH(to, r)                                                                            \
    if ((r) >= 0 && (r) < PR) {                                                                 \
        UNROLL for (int c = 0; c < PC; c++) to[c + 1] = CLIP(real, s[(r) < 0 ? 0 : (r) < PR ? (r) : 0][c]); \
        SIDES(to)                                                                               \
    } else                                                                                      \
        READ_ROW(to, r)                                                                         \
    if (rim) set_virtual(to, gi0 + (r), gj0 - RADIUS, rows, cols);
#else
#define FETCH(to, r)                                                                            \
    READ_ROW(to, r)                                                                             \
    if (rim) set_virtual(to, gi0 + (r), gj0 - RADIUS, rows, cols);
#endif
#define READ_ROW(to, r)                                                                         \
    {                                                                                           \
        const __local real *row = now + LINE(round_tile ? wrap(i0 + (r), rows) : i0 + (r)) * PITCH; \
        UNROLL for (int q = 0; q < SPAN; q++) to[q] = row[around[q]];                \
    }
        UNROLL for (int k = 0; k < 2 * RADIUS; k++) { FETCH(near[k], k - RADIUS) }
        UNROLL for (int r = 0; r < PR; r++) {
            FETCH(near[2 * RADIUS], r + RADIUS)
#if BOUNDARY == BOUNDARY_ZERO_FLUX
            if (rim) {
                for (int k = RADIUS - 1; k >= 0; k--)
                    for (int q = 0; q < SPAN; q++) near[k][q] = gi0 + r + k < RADIUS ? near[k + 1][q] : near[k][q];
                for (int k = RADIUS + 1; k <= 2 * RADIUS; k++)
                    for (int q = 0; q < SPAN; q++) near[k][q] = gi0 + r + k - RADIUS >= rows ? near[k - 1][q] : near[k][q];
            }
#endif
            UNROLL for (int c = 0; c < PC; c++) {
                real d = u[r][c];
#define TAP(c, k, l, weight) d += (real)(weight) * near[(k) + RADIUS][(c) + (l) + RADIUS];
                TAPS(TAP, c)
                const real start = s[r][c], gain = held >> (r * PC + c) & 1 ? (real)0 : (real)(GAIN);
                real end = start + gain * (d - start);
#if LIMITED
                end = CLIP(real, end);
#endif
                if (looks && (mine & ~held) >> (r * PC + c) & 1) {
                    real rate = d - start;
#if LIMITED
                    rate = (start >= 1 && rate > 0) || (start <= -1 && rate < 0) ? (real)0 : rate;
#endif
                    rate = rate < 0 ? -rate : rate;
                    fastest = rate > fastest || rate != rate ? rate : fastest; // NaN stays
                    moves |= !((start >= 1 && d >= 1) || (start <= -1 && d <= -1));
                }
                s[r][c] = hold ? start : end;
            }
            UNROLL for (int k = 0; k < 2 * RADIUS; k++)
                UNROLL for (int q = 0; q < SPAN; q++) near[k][q] = near[k + 1][q];
        }
        if (BUFFERS == 1) barrier(CLK_LOCAL_MEM_FENCE);
        now = y + (BUFFERS == 2 && now == y ? LINES * PITCH : 0);
        most[me] = fastest, loose[me] = moves;
        for (int half_way = looks ? ITEMS : 0; half_way; half_way /= 2) {
            barrier(CLK_LOCAL_MEM_FENCE);
            if (me < half_way / 2) {
                const real other = most[me + half_way / 2];
                most[me] = other > most[me] || other != other ? other : most[me];
                loose[me] |= loose[me + half_way / 2];
            }
        }
        const int word = (most[0] <= (real)SETTLED_RATE ? 0 : 1) | loose[0] << 1;
        if (looks && me == 0) {
            if (word) atomic_or(&words[check + max(0, (t - phase + every - 1) / every)], word);
            record[rates + 2 * tile] = most[0], record[rates + 2 * tile + 1] = loose[0];
        }
        looked = looks ? t : looked;
        t += !hold;
        over = (looks && flags & ALONE && HAS_SETTLED(word)) || (t == steps && !LOOKS);
    }
    EACH_CELL if (!none && mine >> (r * PC + c) & 1) out[(top + gi0 + r) * cols + gj0 + c] = s[r][c];
}
