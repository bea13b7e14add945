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
// Rows that are driven at once: each row of the input is loaded for three of them. Thirty-two registers hold the taps and
// four rows, sixteen the taps and one.
#define ROWS (V > 8 ? 4 : 1)

// Add the taps of three rows to the drives of ROWS vectors below each other, of which the first has the input at `u`.
typedef struct { real west, here, east; } row_taps;
typedef struct { row_taps above, beside, below; } nine_taps;

static inline void add_nine(__global const real *u, int cols, nine_taps w, vec *drive)
{
#define ADD_ROW(to, w) to += (w).west * west; to += (w).here * here; to += (w).east * east;
    _Pragma("unroll") for (int r = -1; r <= ROWS; r++) {
        __global const real *row = u + (long)r * cols;
        const vec here = *(__global const vec *)row;
        const vec west = *(__global const vec *)(row - 1), east = *(__global const vec *)(row + 1);
        _Pragma("unroll") for (int q = 0; q < ROWS; q++) {
            if (r == q - 1) { ADD_ROW(drive[q], w.above) }
            if (r == q) { ADD_ROW(drive[q], w.beside) }
            if (r == q + 1) { ADD_ROW(drive[q], w.below) }
        }
    }
}

// The cells of ROWS rows but for the first and the last of each. The first and the last vector lie anywhere, over cells of
// those beside them. (No `min`: PoCL calls it, and all that lies in registers goes to memory and back.)
#define INNER_CELLS                                                                                     \
    for (int j = 1, next; j <= cols - 1 - V; j = next) {                                                \
        next = j + V - j % V;                                                                           \
        if (next > cols - 1 - V) next = j == cols - 1 - V ? cols : cols - 1 - V;                        \
        vec drive[ROWS];                                                                                \
        _Pragma("unroll") for (int q = 0; q < ROWS; q++) {                                              \
            const long cell = (top + q) * cols + j;                                                     \
            drive[q] = (vec)z;                                                                          \
            if (has_bias) drive[q] += LOAD(vec, bias);                                                  \
        }                                                                                               \
        add_nine(u + top * cols + j, cols, w, drive);                                                   \
        _Pragma("unroll") for (int q = 0; q < ROWS; q++) {                                              \
            const long line = top + q, cell = line * cols + j;                                          \
            DO_END(vec, drive[q])                                                                       \
        }                                                                                               \
    }

// Do them at rest, without a bias or a mask, as most are, and return a flaw. Not within the other loop, which wants so many
// registers that this one would keep its taps in memory.
static __attribute__((noinline)) vec inner_rest(__global const real *x, __global const real *u, __global real *out,
                                                long top, int cols, const nine_taps *taps, real z, real a)
{
    const nine_taps w = *taps;
    const int rest = 1, has_bias = 0, has_mask = 0, t = 0;
    __global const real *bias = 0;
    __global const ulong *mask = 0;
    vec flaw_vec = (vec)0;
    INNER_CELLS
    return flaw_vec;
}
#endif

// The end of uncoupled cells at time t or at rest, driven by z + bias + B*u; as a plane of its own the drive would go
// through memory twice. A part of `partial` is 0 if all these ends are finite numbers, else NaN.
KERNEL void closed_form(__global const real *x, __global const real *u, __global const real *bias,
                        __global const ulong *mask, __global real *out, __global real *partial, real z, int has_bias,
                        int has_mask, real a, real t, int rest, ARGUMENTS)
{
    real flaw_real = 0;
#if V > 1
    vec flaw_vec = (vec)0;
    const int nine = taps > 1 && radius == 1 && cols >= V + 2;
    real at[9] = {0};
    for (int tap = 0; nine && tap < taps; tap++) at[3 * places[tap].x + places[tap].y + 4] = weights[tap];
    const nine_taps w = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}, {at[6], at[7], at[8]}};
    EACH(each, lines) {
        const long top = first + each;
        const int from_row = (int)(top % rows);
        if (!nine || from_row == 0 || from_row + ROWS >= rows || each + ROWS > each_stop) {
            const long line = top;
            const int i = from_row;
            CELLS_OF_LINE(DO_CLOSED)
            continue;
        }
        if (rest && !has_bias && !has_mask) flaw_vec += inner_rest(x, u, out, top, cols, &w, z, a);
        else INNER_CELLS
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
