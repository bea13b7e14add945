// Rows of a tile of cpu.cl: loaded, moved, surrounded by virtual cells, compared. Comes after block.cl.

// Set the virtual cells at both ends of one row of outputs; the grid's columns are left .. right - 1 of the buffer.
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

static void fill_row(__local real *to, real value)
{
    for (int j = 0; j + V <= STRIDE; j += V) VEC(__local, to + j) = (vec)value;
}

static void copy_row(__local real *to, const __local real *from)
{
    for (int j = 0; j + V <= STRIDE; j += V) VEC(__local, to + j) = VEC(const __local, from + j);
}

// Set the virtual rows that touch the R rows from row i on of a level; the outputs of row 0 begin at y. A torus has none.
static void fix_rows(__local real *y, int i, int rows)
{
#if BOUNDARY != BOUNDARY_PERIODIC
    for (int q = 1; q <= RADIUS; q++) {
        for (int last = 0; last < 2; last++) {
            const int end = last ? rows - 1 : 0, beyond = last ? end + q : -q, written = last ? beyond : end;
            if (written < i || written >= i + R) continue; // done with the later one of both
#if BOUNDARY == BOUNDARY_FIXED
            fill_row(y + beyond * STRIDE, CONSTANT);
#else
            copy_row(y + beyond * STRIDE, y + end * STRIDE);
#endif
        }
    }
#endif
}

// Load one row's columns first .. stop - 1 of the buffer: states, drives, gains and outputs; `start` is the grid's column
// at the buffer's column 0.
static void load_row(__global const real *x, __global const real *w, __global const ulong *mask, long line, int cols,
                     int start, int first, int stop, __local real *xs, __local real *ws, __local real *gains,
                     __local real *ys)
{
    x += line * cols + start;
    w += line * cols + start;
    if (first >= V) VEC(__local, ys + first - V) = (vec)0; // read with the others; memory may hold denormal numbers
    VEC(__local, ys + stop) = (vec)0;
    int j = first;
#if BOUNDARY != BOUNDARY_PERIODIC
    for (; start + j < 0; j++) xs[j] = ws[j] = ys[j] = 0; // virtual cells, which are set later
#endif
    for (; start + j >= 0 && j + V <= stop && start + j + V <= cols; j += V) {
        const vec s = VEC(const __global, x + j);
        VEC(__local, xs + j) = s;
        VEC(__local, ys + j) = CLIP(vec, s);
        VEC(__local, ws + j) = VEC(const __global, w + j);
    }
    for (; j < stop; j++) {
        const int c = (BOUNDARY == BOUNDARY_PERIODIC ? wrap(start + j, cols) : clamp_to(start + j, cols)) - start;
        xs[j] = x[c];
        ys[j] = CLIP(real, x[c]);
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
    return other != 0 || any_of(some);
}
