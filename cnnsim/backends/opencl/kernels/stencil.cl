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
    return VALUE(real, grid[(long)p * cols + q]);
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

// Masked cells keep what they were; with a mask all cells are taken one by one.
#ifdef MASK
#define KEEP_real(v, old) if (black(mask, line, j, cols)) v = old;
#else
#define KEEP_real(v, old)
#endif
#define KEEP_vec(v, old)

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
// Nine taps of radius 1 with their weights in registers: half of the time of a loop over `taps`.
#define ADD_NINE_real ADD_real(u, total)
#define ADD_NINE_vec                                   \
    _Pragma("unroll") for (int n = 0; n < 9; n++)      \
        total += at[n] * *(__global const vec *)(u + cell + (long)(n / 3 - 1) * cols + n % 3 - 1);

#define DO_CLOSED(type)                                \
    type total = (type)z;                              \
    if (has_bias) total += LOAD(type, bias);           \
    if (nine) { ADD_NINE_##type } else { ADD_##type(u, total) } \
    const type from = LOAD(type, x);                   \
    type to = type##_end(from, total, a, t);     \
    KEEP_##type(to, from)                              \
    flaw_##type += to * (type)0;                       \
    STORE(type, out) = to;

// The end of uncoupled cells at time t or at rest, driven by z + bias + B*u; as a plane of its own the drive would go
// through memory twice. A part of `partial` is 0 if all these ends are finite numbers, else NaN.
KERNEL void closed_form(__global const real *x, __global const real *u, __global const real *bias,
                        __global const ulong *mask, __global real *out, __global real *partial, real z, int has_bias,
                        real a, real t, ARGUMENTS)
{
    real flaw_real = 0;
#if V > 1
    vec flaw_vec = (vec)0;
#endif
    const int nine = taps > 1 && radius == 1;
    real at[9] = {0};
    for (int tap = 0; nine && tap < taps; tap++) at[3 * places[tap].x + places[tap].y + 4] = weights[tap];
    EACH_CELL(DO_CLOSED)
#if V > 1
    for (int v = 0; v < V; v++) flaw_real += flaw_vec[v];
#endif
    HAND_IN(real, partial, flaw_real)
}

#else // SETTLED
// Check lines from line `first` on. Each work-item (on a GPU each work-group) gives two numbers: the largest |dx/dt| of
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
