// The drives of the general road: terms of any kind over channels, see cnnsim/backends/wiring.py. Comes after
// opencl_general.cl.
//
// Planes are (n, layers, rows, cols). A channel is (n, rows + 2 radius, stride): with its virtual cells, and with room
// behind them for a whole vector, so that neighbours are loads like any others. All channels lie one after the other.
//
// The host writes the terms (cnnsim/backends/opencl_terms.py): CASES(DO), TERMS_n, SHAPE(T), SIGN, TABLES. BOUNDARY is 0 for
// zero-flux, 1 for fixed, 2 for periodic.

TABLES

enum { DRIVE, SLOPE, STEP, DISCRETE };

#ifdef DOUBLE
#define TANH(T, f) { T p = f; f = TANH_OF_##T; }
#define TANH_OF_real tanh(p)
#if V > 1
static inline vec tanh_of_lanes(vec p)
{
    for (int q = 0; q < V; q++) p[q] = tanh(p[q]);
    return p;
}
#define TANH_OF_vec tanh_of_lanes(p)
#else
#define TANH_OF_vec tanh(p)
#endif
#else
// Within 2e-7: Lambert's fraction at a quarter of the argument, doubled twice; from 9.2 on tanh is 1.
#define TANH(T, f)                                                                              \
    {                                                                                           \
        T p = f > (T)9.2f ? (T)9.2f : f;                                                        \
        p = (p < (T)-9.2f ? (T)-9.2f : p) * 0.25f;                                              \
        const T q = p * p;                                                                      \
        T t = p * (((q + 378.0f) * q + 17325.0f) * q + 135135.0f)                               \
            / (((28.0f * q + 3150.0f) * q + 62370.0f) * q + 135135.0f);                         \
        t = (t + t) / (1.0f + t * t);                                                           \
        t = (t + t) / (1.0f + t * t);                                                           \
        f = CLIP(T, t);                                                                         \
    }
#endif

static inline real shape_of(real v)
{
    real f = v;
    SHAPE(real)
    return f;
}

#if V > 1
static inline vec shape_of_vec(vec v)
{
    vec f = v;
    SHAPE(vec)
    return f;
}
#else
#define shape_of_vec shape_of
#endif

// The first m numbers of a vector; beyond them nothing is read or written.
static inline vec load_part(__global const real *from, int m)
{
    if (m >= V) return *(__global const vec *)from;
    real lanes[V];
    for (int q = 0; q < V; q++) lanes[q] = q < m ? from[q] : 0;
    return *(const vec *)lanes;
}

static inline void store_part(__global real *to, vec v, int m)
{
    if (m >= V) {
        *(__global vec *)to = v;
        return;
    }
    real lanes[V];
    *(vec *)lanes = v;
    for (int q = 0; q < m; q++) to[q] = lanes[q];
}

// Which row or column a place stands for; -1 if it is a fixed virtual one.
static inline int stands_for(int i, int n)
{
#if BOUNDARY == 1
    return i < 0 || i >= n ? -1 : i;
#elif BOUNDARY == 2
    return wrap(i, n);
#else
    return clamp_to(i, n);
#endif
}

// One layer of a state into a channel, through the characteristic if asked for; `count` rows of the channel, or cells.
KERNEL void follow(__global const real *state, __global real *channels, int channel, int layer, int layers, int through,
                   real outside, int radius, int stride, int rows, int cols, long all, long count)
{
    const int tall = rows + 2 * radius, wide = cols + 2 * radius;
    channels += channel * all;
#ifdef CPU
    EACH(line, count) {
        const int i = stands_for((int)(line % tall) - radius, rows);
        __global real *to = channels + line * stride + radius;
        if (i < 0) {
            for (int j = -radius; j < cols + radius; j++) to[j] = outside;
            continue;
        }
        __global const real *from = state + ((line / tall * layers + layer) * rows + i) * cols;
        for (int j = 0; j < cols; j += V) {
            const vec v = load_part(from + j, cols - j);
            store_part(to + j, through ? shape_of_vec(v) : v, cols - j);
        }
        for (int q = 1; q <= radius; q++) {
            const int left = stands_for(-q, cols), right = stands_for(cols + q - 1, cols);
            to[-q] = left < 0 ? outside : to[left];
            to[cols + q - 1] = right < 0 ? outside : to[right];
        }
    }
#else
    EACH(cell, count) {
        const long line = cell / wide;
        const int at = (int)(cell % wide);
        const int i = stands_for((int)(line % tall) - radius, rows), j = stands_for(at - radius, cols);
        real v = outside;
        if (i >= 0 && j >= 0) {
            v = state[((line / tall * layers + layer) * rows + i) * cols + j];
            if (through) v = shape_of(v);
        }
        channels[line * stride + at] = v;
    }
#endif
}

#define HEARD(channel, k, l) (*(__global const vec *)(own + (channel) * all + j + (k) * stride + (l)))
#define WEIGHT(plane) (*(__global const vec *)(weights + (plane) * (long)rows * cols + j))

#define CASE(number)                                                                            \
    case number: {                                                                              \
        TERMS_##number                                                                          \
        break;                                                                                  \
    }

static inline vec keep(vec v, vec old, __global const ulong *held, long line, int j, int cols)
{
    real lanes[V], before[V];
    *(vec *)lanes = v;
    *(vec *)before = old;
    for (int q = 0; q < V && j + q < cols; q++)
        if (black(held, line, j + q, cols)) lanes[q] = before[q];
    return *(const vec *)lanes;
}

// w plus all terms of part `part`: the drive; or less x the slope; or a step x + gain (drive - x), with walls; or the
// output that it makes, where a sign of 0 is the old one. The last two leave held cells alone. `count` rows, or cells.
KERNEL void advance(__global const real *x, __global const real *w, __global const ulong *held, __global real *out,
                    __global const real *channels, __global const real *planes, __global const real *gains, int task,
                    int part, int has_held, int wall, int layers, int radius, int stride, int rows, int cols, long all,
                    long count)
{
    const int tall = rows + 2 * radius;
#ifdef CPU
    EACH(line, count) {
        const int from = 0, to = cols;
#else
    EACH(cell, count) {
        const long line = cell / cols;
        const int from = (int)(cell % cols), to = from + 1;
#endif
        const int i = (int)(line % rows), layer = (int)(line / rows % layers);
        const long grid = line / rows / layers;
        const real gain = gains[layer];
        __global const real *own = channels + (grid * tall + i + radius) * stride + radius;
        __global const real *weights = planes + (long)i * cols;
        for (int j = from; j < to; j += V) {
            vec total = load_part(w + line * cols + j, cols - j);
            switch (part * layers + layer) { CASES(CASE) }
            if (task != DRIVE) {
                const vec s = load_part(x + line * cols + j, cols - j);
                if (task == SLOPE) total -= s;
                if (task == STEP) {
                    total = s + gain * (total - s);
                    if (wall) total = CLIP(vec, total);
                }
                if (task == DISCRETE) total = SIGN ? (total == (vec)0 ? s : shape_of_vec(total)) : shape_of_vec(total);
                if (has_held && task != SLOPE) total = keep(total, s, held, line, j, cols);
            }
            store_part(out + line * cols + j, total, cols - j);
        }
    }
}
