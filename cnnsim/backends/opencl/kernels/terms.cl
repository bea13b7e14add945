// The drives of layers: terms of any kind over channels, see cnnsim/backends/term_table.py. Comes after boundary.cl.
//
// Planes are (n, layers, rows, cols). A channel is (n, rows + 2 radius, stride): with its virtual cells, and with space
// behind them for a whole vector, so that neighbours are loads like any others. All channels lie one after the other.
//
// The host writes the terms (cnnsim/backends/opencl/term_text.py): CASES(DO), TERMS_n, OUTPUT(T), TABLES, and
// CHARACTERISTIC, the output characteristic's code.

TABLES

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

static inline real output_of(real v)
{
    real f = v;
    OUTPUT(real)
    return f;
}

#if V > 1
static inline vec output_of_vec(vec v)
{
    vec f = v;
    OUTPUT(vec)
    return f;
}
#else
#define output_of_vec output_of
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

// One layer of a state into a channel, through the characteristic if it is to be `output`; `count` rows of the channel,
// or cells.
KERNEL void fill_channel(__global const real *state, __global real *channels, int channel, int layer, int layers,
                         int output, real outside, int radius, int stride, int rows, int cols, long all, long count)
{
    const int tall = rows + 2 * radius, wide = cols + 2 * radius;
    channels += channel * all;
#ifdef CPU
    EACH(line, count) {
        const int i = (int)(line % tall) - radius, p = cell_at(i, rows);
        __global real *to = channels + line * stride + radius;
        if (p == NOTHING) {
            for (int j = -radius; j < cols + radius; j++) to[j] = outside;
            continue;
        }
        __global const real *from = state + ((line / tall * layers + layer) * rows + p) * cols;
        for (int j = 0; j < cols; j += V) {
            const vec v = load_part(from + j, cols - j);
            store_part(to + j, output ? output_of_vec(v) : v, cols - j);
        }
        for (int j = 0; p != i && j < cols; j++) to[j] = virtual_value(to[j]);
        for (int j = 1; j <= radius; j++) {
            const int west = cell_at(-j, cols), east = cell_at(cols + j - 1, cols);
            to[-j] = west == NOTHING ? outside : virtual_value(to[west]);
            to[cols + j - 1] = east == NOTHING ? outside : virtual_value(to[east]);
        }
    }
#else
    EACH(cell, count) {
        const long line = cell / wide;
        const int i = (int)(line % tall) - radius, p = cell_at(i, rows);
        const int j = (int)(cell % wide) - radius, q = cell_at(j, cols);
        real v = outside;
        if (p != NOTHING && q != NOTHING) {
            v = state[((line / tall * layers + layer) * rows + p) * cols + q];
            v = value_at(output ? output_of(v) : v, i, p, j, q);
        }
        channels[line * stride + radius + j] = v;
    }
#endif
}

#define NEIGHBOUR(channel, k, l) (*(__global const vec *)(own + (channel) * all + j + (k) * stride + (l)))
#define WEIGHT(plane) (*(__global const vec *)(weights + (plane) * (long)rows * cols + j))

#define CASE(number)                                                                            \
    case number: {                                                                              \
        TERMS_##number                                                                          \
        break;                                                                                  \
    }

static inline vec keep(vec v, vec old, __global const ulong *mask, long line, int j, int cols)
{
    real lanes[V], before[V];
    *(vec *)lanes = v;
    *(vec *)before = old;
    for (int q = 0; q < V && j + q < cols; q++)
        if (black(mask, line, j + q, cols)) lanes[q] = before[q];
    return *(const vec *)lanes;
}

// w plus all terms of part `part`: the drive; or less x the rate; or a step x + gain (drive - x), perhaps limited; or
// the output that it makes, where a sign of 0 is the old one. The last two leave masked cells alone. `count` rows, or
// cells, from number `first` on; that of number 0 goes to number `at` of `out`.
KERNEL void add_terms(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
                      long at, __global const real *channels, __global const real *planes, __global const real *gains,
                      int task, int part, int has_mask, int limited, int layers, int radius, int stride, int rows,
                      int cols, long all, long count, long first)
{
    const int tall = rows + 2 * radius;
#ifdef CPU
    EACH(each, count) {
        const long line = first + each;
        const int from = 0, to = cols;
#else
    EACH(each, count) {
        const long cell = first + each, line = cell / cols;
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
            if (task != TASK_DRIVE) {
                const vec s = load_part(x + line * cols + j, cols - j);
                if (task == TASK_RATE) total -= s;
                if (task == TASK_STEP) {
                    total = s + gain * (total - s);
                    if (limited) total = CLIP(vec, total);
                }
                if (task == TASK_DISCRETE) {
                    const int sign = CHARACTERISTIC == FUNCTION_SIGN;
                    total = sign ? (total == (vec)0 ? s : output_of_vec(total)) : output_of_vec(total);
                }
                if (has_mask && task != TASK_RATE) total = keep(total, s, mask, line, j, cols);
            }
            store_part(out + at + line * cols + j, total, cols - j);
        }
    }
}
