// Steps of a one-stage scheme on a GPU: up to T a launch, states in registers, outputs in local memory.
//
// A work-group owns a tile of WIDE x HIGH cells, of which the rim of HALO = T * RADIUS belongs to its neighbours and
// is computed again here, so that groups never wait for each other. A work-group has WIDE columns and HIGH / R rows of
// work-items; each holds R cells of a column. The tile's outputs are kept in two buffers, one read while the other is
// written: one barrier a step. At the edge of the grid, each real cell writes the virtual cells that repeat it (for a
// fixed boundary the virtual cells write their constant), at every step.

#define ROW_LENGTH (WIDE + 2 * RADIUS)
#define PLACE(i, j) (((i) + RADIUS) * ROW_LENGTH + (j) + RADIUS)
#define SIZE (ROW_LENGTH * (HIGH + 2 * RADIUS))

// Copy the output of a cell at the rim of the grid, tile place (i, j), grid place (gi, gj), to the virtual cells that it
// stands for.
static inline void stand_in(__local real *y, int i, int j, int gi, int gj, int rows, int cols)
{
    const int up = gi == 0 ? RADIUS : 0, down = gi == rows - 1 ? RADIUS : 0;
    const int west = gj == 0 ? RADIUS : 0, east = gj == cols - 1 ? RADIUS : 0;
    const real v = y[PLACE(i, j)];
    for (int k = max(i - up, -RADIUS); k <= min(i + down, HIGH + RADIUS - 1); k++)
        for (int l = max(j - west, -RADIUS); l <= min(j + east, WIDE + RADIUS - 1); l++) y[PLACE(k, l)] = v;
}

__attribute__((reqd_work_group_size(WIDE, HIGH / R, 1)))
__kernel void steps(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
                    int rows, int cols, int across, int down, int steps, int first)
{
    __local real y[2 * SIZE];
    const int tile = first + get_global_id(0) / WIDE, j = get_local_id(0), i0 = get_local_id(1) * R;
    const int gj = tile % across * (WIDE - 2 * HALO) - HALO + j;
    const int gi0 = tile / across % down * (HIGH - 2 * HALO) - HALO + i0;
    const long top = (long)(tile / across / down) * rows;
    const int real_col = BOUNDARY == BOUNDARY_PERIODIC || (gj >= 0 && gj < cols);
    const int col = BOUNDARY == BOUNDARY_PERIODIC ? wrap(gj, cols) : clamp_to(gj, cols);
    real s[R], drive[R], gain[R];

#pragma unroll
    for (int q = 0; q < R; q++) {
        const int gi = gi0 + q, row = BOUNDARY == BOUNDARY_PERIODIC ? wrap(gi, rows) : clamp_to(gi, rows);
        const long cell = (top + row) * cols + col;
        s[q] = x[cell];
        drive[q] = w[cell];
#ifdef MASK
        gain[q] = black(mask, top + row, col, cols) ? 0 : (real)(GAIN);
#else
        gain[q] = GAIN;
#endif
    }
    // what lies around the tile is read by cells whose states are dropped: it has to hold numbers
    for (int at = get_local_id(1) * WIDE + j; at < 2 * SIZE; at += WIDE * (HIGH / R)) y[at] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);

    for (int t = 0; t < steps; t++) {
        __local real *now = y + (t & 1) * SIZE;
#pragma unroll
        for (int q = 0; q < R; q++) {
            const int real_cell = BOUNDARY == BOUNDARY_PERIODIC || (real_col && gi0 + q >= 0 && gi0 + q < rows);
            if (real_cell) now[PLACE(i0 + q, j)] = CLIP(real, s[q]);
#if BOUNDARY == BOUNDARY_FIXED
            else now[PLACE(i0 + q, j)] = CONSTANT;
#endif
        }
#if BOUNDARY == BOUNDARY_ZERO_FLUX
#pragma unroll 1 // rare; and it reads back what it needs, so that s stays in registers
        for (int q = 0; real_col && q < R; q++) {
            const int gi = gi0 + q;
            if (gi >= 0 && gi < rows && (gi == 0 || gi == rows - 1 || gj == 0 || gj == cols - 1))
                stand_in(now, i0 + q, j, gi, gj, rows, cols);
        }
#endif
        barrier(CLK_LOCAL_MEM_FENCE);
        real d[R];
#pragma unroll
        for (int q = 0; q < R; q++) {
            d[q] = drive[q];
#define TAP(q, k, l, weight) d[q] += (real)(weight) * now[PLACE(i0 + q + (k), j + (l))];
            TAPS(TAP, q)
        }
#pragma unroll
        for (int q = 0; q < R; q++) {
            s[q] += gain[q] * (d[q] - s[q]);
#if LIMITED
            s[q] = CLIP(real, s[q]);
#endif
        }
    }
    const int mine = j >= HALO && j < WIDE - HALO && gj < cols;
#pragma unroll
    for (int q = 0; q < R; q++) {
        const int i = i0 + q, gi = gi0 + q;
        if (mine && i >= HALO && i < HIGH - HALO && gi < rows) out[(top + gi) * cols + gj] = s[q];
    }
}
