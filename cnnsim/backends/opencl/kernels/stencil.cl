// Single sums over a template's taps: B*u + z (CONTROL), with the end of uncoupled cells (CLOSED, after closed.cl),
// and whether the network has settled (SETTLED). They run once, or once in many steps, so the taps are arguments: a build
// for each template would cost more than it saves. One of the three is built at a time. Comes after boundary.cl.
//
// B's taps weigh the input as it is, A's the clipped state. `outside` is what a fixed virtual cell holds.

#if defined(CONTROL) || defined(CLOSED)
#define VALUE(type, v) (v)
#else
#define VALUE(type, v) CLIP(type, v)
#endif

// The value of one grid at a place that may be a virtual cell.
static inline real neighbour_at(__global const real *grid, int i, int j, int rows, int cols, real outside)
{
    const int p = cell_at(i, rows), q = cell_at(j, cols);
    if (p == NOTHING || q == NOTHING) return outside;
    const real v = grid[(long)p * cols + q];
    return value_at(VALUE(real, v), i, p, j, q);
}

// What every kernel of this file takes: the first line, the taps, the value of fixed virtual cells, how many lines, and
// the shape of a grid.
#define ARGUMENTS                                                                                       \
    long first, __global const int2 *places, __global const real *weights, int taps, int radius, real outside,     \
    long lines, int rows, int cols

#define LOAD(type, plane) (*(__global const type *)((plane) + cell))
#define STORE(type, plane) (*(__global type *)((plane) + cell))

// Both add the taps to `total` in order; the second for vectors of cells `radius` or more away from the rim.
#define ADD_real(plane, total)                                                                          \
    for (int tap = 0; tap < taps; tap++)                                                                \
        total += weights[tap] * neighbour_at((plane) + (line - i) * cols, i + places[tap].x, j + places[tap].y, rows,  \
                                             cols, outside);
#define ADD_vec(plane, total)                                                                           \
    for (int tap = 0; tap < taps; tap++) {                                                              \
        const vec v = *(__global const vec *)((plane) + cell + (long)places[tap].x * cols + places[tap].y); \
        total += weights[tap] * VALUE(vec, v);                                                          \
    }

// Do DO(type) for each cell or vector of cells; i, j, line and `cell` say where it is.
#ifdef CPU
#ifdef MASK
#define INNER 0 // masks are read cell by cell
#else
#define INNER (i >= radius && i < rows - radius)
#endif
#define EACH_CELL(DO)                                                                                   \
    EACH(each, lines) {                                                                                 \
        const long line = first + each;                                                                 \
        const int i = (int)(line % rows);                                                               \
        CELLS_OF_LINE(DO)                                                                               \
    }
#define CELLS_OF_LINE(DO)                                                                               \
    {                                                                                                   \
        const int inner = INNER;                                                                        \
        int j = 0;                                                                                      \
        for (; j < (inner ? min(radius, cols) : cols); j++) { const long cell = line * cols + j; DO(real) } \
        for (; inner && j + V <= cols - radius; j += V) { const long cell = line * cols + j; DO(vec) }  \
        for (; j < cols; j++) { const long cell = line * cols + j; DO(real) }                           \
    }
#else
#define EACH_CELL(DO)                                                                                   \
    EACH(each, lines * cols) {                                                                          \
        const long cell = first * cols + each;                                                          \
        const long line = cell / cols;                                                                  \
        const int i = (int)(line % rows), j = (int)(cell % cols);                                       \
        DO(real)                                                                                        \
    }
#endif

// Masked cells of a line, from column j on, keep what they were.
#define KEEP_real(v, old) if (black(mask, line, j, cols)) v = old;
#define KEEP_vec(v, old) for (int q = 0; q < V; q++) if (black(mask, line, j + q, cols)) v[q] = old[q];

#if defined(CONTROL)
// w = z + bias + B*u, of which the bias may be missing.
KERNEL void control(__global const real *u, __global const real *bias, __global real *w, real z,
                      int has_bias, ARGUMENTS)
{
#define DO_CONTROL(type)                              \
    type total = (type)z;                             \
    if (has_bias) total += LOAD(type, bias);          \
    ADD_##type(u, total)                              \
    STORE(type, w) = total;
    EACH_CELL(DO_CONTROL)
}

#elif defined(CLOSED)
#if V > 1
// Rows that are driven at once: each row of the input is loaded for three of them.
#define ROWS 4

// Add the taps of three rows to the drives of ROWS vectors below each other, of which the first has the input at `u`.
typedef struct { real west, here, east; } row_taps;

static inline void add_nine(__global const real *u, int cols, row_taps above, row_taps beside, row_taps below,
                            vec *drive)
{
#define ADD_ROW(to, w) to += (w).west * west; to += (w).here * here; to += (w).east * east;
    _Pragma("unroll") for (int r = -1; r <= ROWS; r++) {
        __global const real *row = u + (long)r * cols;
        const vec here = *(__global const vec *)row;
        const vec west = *(__global const vec *)(row - 1), east = *(__global const vec *)(row + 1);
        _Pragma("unroll") for (int q = 0; q < ROWS; q++) {
            if (r == q - 1) { ADD_ROW(drive[q], above) }
            if (r == q) { ADD_ROW(drive[q], beside) }
            if (r == q + 1) { ADD_ROW(drive[q], below) }
        }
    }
}
#endif

// The end of uncoupled cells at time t or at rest, driven by z + bias + B*u; as a plane of its own the drive would go
// through memory twice. A part of `partial` is 0 if all these ends are finite numbers, else NaN.
KERNEL void closed_form(__global const real *x, __global const real *u, __global const real *bias,
                        __global const ulong *mask, __global real *out, __global real *partial, real z, int has_bias,
                        int has_mask, real a, real t, int rest, ARGUMENTS)
{
    real flaw_real = 0;
#define DO_END(type, drive)                            \
    const type from = LOAD(type, x);                   \
    type to = type##_end(from, drive, a, t, rest);     \
    if (has_mask) { KEEP_##type(to, from) }            \
    flaw_##type += to * (type)0;                       \
    STORE(type, out) = to;
#define DO_CLOSED(type)                                \
    type total = (type)z;                              \
    if (has_bias) total += LOAD(type, bias);           \
    ADD_##type(u, total)                               \
    DO_END(type, total)
#if V > 1
    vec flaw_vec = (vec)0;
    const int nine = taps > 1 && radius == 1 && cols >= V + 2;
    real w[9] = {0};
    for (int tap = 0; nine && tap < taps; tap++) w[3 * places[tap].x + places[tap].y + 4] = weights[tap];
    const row_taps above = {w[0], w[1], w[2]}, beside = {w[3], w[4], w[5]}, below = {w[6], w[7], w[8]};
    EACH(each, lines) {
        const long top = first + each;
        const int from_row = (int)(top % rows);
        if (!nine || from_row == 0 || from_row + ROWS >= rows || each + ROWS > each_stop) {
            const long line = top;
            const int i = from_row;
            CELLS_OF_LINE(DO_CLOSED)
            continue;
        }
        // the first and the last vector of a row lie anywhere, over cells of those beside them
        const int last = cols - 1 - V;
        for (int j = 1; j <= last; j = j == last ? cols : min(j + V - j % V, last)) {
            vec drive[ROWS];
            _Pragma("unroll") for (int q = 0; q < ROWS; q++) {
                const long cell = (top + q) * cols + j;
                drive[q] = (vec)z;
                if (has_bias) drive[q] += LOAD(vec, bias);
            }
            add_nine(u + top * cols + j, cols, above, beside, below, drive);
            _Pragma("unroll") for (int q = 0; q < ROWS; q++) {
                const long line = top + q, cell = line * cols + j;
                DO_END(vec, drive[q])
            }
        }
        for (int rim = 0; rim < 2 * ROWS; rim++) {
            const int i = from_row + rim / 2, j = rim % 2 * (cols - 1);
            const long line = top + rim / 2, cell = line * cols + j;
            DO_CLOSED(real)
        }
        each += ROWS - 1;
    }
    for (int v = 0; v < V; v++) flaw_real += flaw_vec[v];
#else
    EACH_CELL(DO_CLOSED)
#endif
    HAND_IN(real, partial, flaw_real)
}

#else // SETTLED
// Two numbers a work-item (or, on a GPU, a work-group) for so many lines from line `first` on: the largest |dx/dt| of
// its free cells, and 1 if one of them is not saturated for good.
KERNEL void check_settled(__global const real *x, __global const real *w, __global const ulong *mask,
                          __global real *partial, ARGUMENTS)
{
    real most_real = 0;
    sure_real unsaturated_real = 0;
#if V > 1
    vec most_vec = (vec)0;
    sure_vec unsaturated_vec = (sure_vec)0;
#endif
#if LIMITED
#define STOPPED(type) rate = ((s >= (type)1) & (rate > (type)0)) | ((s <= (type)-1) & (rate < (type)0)) ? (type)0 : rate;
#else
#define STOPPED(type)
#endif
#ifdef MASK
#define FREE !black(mask, line, j, cols)
#else
#define FREE 1
#endif
#define DO_CHECK(type)                                                                                   \
    if (FREE) {                                                                                          \
        const type s = LOAD(type, x);                                                                    \
        type drive = LOAD(type, w);                                                                      \
        ADD_##type(x, drive)                                                                             \
        type rate = drive - s;                                                                           \
        STOPPED(type)                                                                                    \
        rate = rate < (type)0 ? -rate : rate;                                                            \
        most_##type = (rate > most_##type) | (rate != rate) ? rate : most_##type; /* NaN stays */       \
        unsaturated_##type |= !(((s >= (type)1) & (drive >= (type)1)) | ((s <= (type)-1) & (drive <= (type)-1))); \
    }
    EACH_CELL(DO_CHECK)
#if V > 1
    for (int v = 0; v < V; v++) {
        most_real = (most_vec[v] > most_real) | (most_vec[v] != most_vec[v]) ? most_vec[v] : most_real;
        unsaturated_real |= unsaturated_vec[v] != 0;
    }
#endif
    HAND_IN_PAIR(partial, most_real, unsaturated_real)
}
#endif
