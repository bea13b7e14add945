// Rows of a tile of cpu.cl: brought in, with the virtual cells around them imposed, and compared. Comes after block.cl.

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
