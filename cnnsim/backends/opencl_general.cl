// The general road: terms of any kind over channels, see cnnsim/backends/wiring.py.
//
// Planes are (n, layers, rows, cols), a channel is (n, rows, cols), all channels one after the other. BOUNDARY is 0 for
// zero-flux, 1 for fixed, 2 for periodic. Functions of one variable are numbers: kind, places, where places and values
// begin among the numbers.

enum { IDENTITY, LINEAR, STEP_RIGHT, STEP_LEFT, CLIPPED, SIGN, TANH };

#ifdef CPU
#define HAND_IN_LARGEST(partial, mine) partial[get_global_id(0)] = mine;
#else
#define HAND_IN_LARGEST(partial, mine)                                                          \
    __local real most[GROUP];                                                                   \
    most[get_local_id(0)] = mine;                                                               \
    for (int half_way = GROUP / 2; half_way; half_way /= 2) {                                   \
        barrier(CLK_LOCAL_MEM_FENCE);                                                           \
        if (get_local_id(0) < half_way)                                                         \
            most[get_local_id(0)] = max(most[get_local_id(0)], most[get_local_id(0) + half_way]); \
    }                                                                                           \
    if (get_local_id(0) == 0) partial[get_group_id(0)] = most[0];
#endif

static inline real function_of(real v, int kind, int places, int at, int values, __global const real *numbers)
{
    if (kind == IDENTITY) return v;
    if (kind == CLIPPED) {
        const real scaled = v * numbers[at];
        return CLIP(real, scaled);
    }
    if (kind == SIGN) return v > 0 ? (real)1 : v < 0 ? (real)-1 : v;
    if (kind == TANH) return tanh(v * numbers[at]);
    int i = 0;
    if (kind == STEP_LEFT) {
        while (i < places && v >= numbers[at + i]) i++;
        return numbers[values + i];
    }
    while (i < places && v > numbers[at + i]) i++;
    if (kind == STEP_RIGHT) return numbers[values + i];
    if (i == 0) return numbers[values];
    if (i == places) return numbers[values + places - 1];
    const real rise = (numbers[values + i] - numbers[values + i - 1]) / (numbers[at + i] - numbers[at + i - 1]);
    return numbers[values + i - 1] + rise * (v - numbers[at + i - 1]);
}

// z of each layer plus the bias map.
KERNEL void base(__global const real *z, __global const real *bias, __global real *out, int has_bias, int layers,
                 long size, long count)
{
    EACH(cell, count) out[cell] = z[cell / size % layers] + (has_bias ? bias[cell] : (real)0);
}

// One layer of a state into a channel, through a function.
KERNEL void follow(__global const real *state, __global real *channels, __global const real *numbers, int kind,
                   int places, int at, int values, int channel, int layer, int layers, long size, long count)
{
    EACH(cell, count) {
        const real v = state[(cell / size * layers + layer) * size + cell % size];
        channels[channel * count + cell] = function_of(v, kind, places, at, values, numbers);
    }
}

static inline real look_at(__global const real *channel, int i, int j, int rows, int cols, real outside)
{
#if BOUNDARY == 1
    if (i < 0 || i >= rows || j < 0 || j >= cols) return outside;
#elif BOUNDARY == 2
    i = wrap(i, rows);
    j = wrap(j, cols);
#else
    i = clamp_to(i, rows);
    j = clamp_to(j, cols);
#endif
    return channel[(long)i * cols + j];
}

// w plus all terms, less `stage` where it is asked for: the drive, or the slope.
KERNEL void drives(__global const real *w, __global const real *stage, __global real *out,
                   __global const real *channels, __global const int *links, __global const int *taps,
                   __global const real *weights, __global const real *planes, __global const real *numbers,
                   __global const real *constants, int terms, int slope, int layers, int rows, int cols, long count)
{
    const long size = (long)rows * cols, all = count / layers;
    EACH(cell, count) {
        const long within = cell % size, grid = cell / size / layers;
        const int layer = (int)(cell / size % layers), i = (int)(within / cols), j = (int)(within % cols);
        real total = w[cell];
        for (int t = 0; t < terms; t++) {
            __global const int *link = links + 11 * t;
            if (link[0] != layer) continue;
            __global const real *of = channels + link[1] * all + grid * size;
            __global const real *times = channels + max(link[3], 0) * all + grid * size;
            const real here = link[2] < 0 ? 0 : channels[link[2] * all + grid * size + within];
            const real factor_here = link[4] < 0 ? 0 : channels[link[4] * all + grid * size + within];
            for (int tap = link[5]; tap < link[6]; tap++) {
                const int k = i + taps[3 * tap], l = j + taps[3 * tap + 1], plane = taps[3 * tap + 2];
                const real v = look_at(of, k, l, rows, cols, constants[link[1]]) - here;
                real f = function_of(v, link[7], link[8], link[9], link[10], numbers);
                if (link[3] >= 0) f *= look_at(times, k, l, rows, cols, constants[link[3]]) - factor_here;
                total += (plane < 0 ? weights[tap] : planes[plane * size + within]) * f;
            }
        }
        out[cell] = slope ? total - stage[cell] : total;
    }
}

static inline int is_held(__global const ulong *held, int has_held, long cell, int cols)
{
    return has_held && black(held, cell / cols, (int)(cell % cols), cols);
}

// x + gain of the layer * (c0 k0 + c1 k1 + ...), stopped at the walls; a held cell keeps x.
KERNEL void combine(__global const real *x, __global const real *k0, __global const real *k1, __global const real *k2,
                    __global const real *k3, __global const real *gains, __global const ulong *held,
                    __global real *out, real c0, real c1, real c2, real c3, int stages, int has_held, int wall,
                    int layers, long size, int cols, long count)
{
    EACH(cell, count) {
        real v = x[cell];
        if (!is_held(held, has_held, cell, cols)) {
            real total = 0;
            if (stages > 0) total += c0 * k0[cell];
            if (stages > 1) total += c1 * k1[cell];
            if (stages > 2) total += c2 * k2[cell];
            if (stages > 3) total += c3 * k3[cell];
            v += gains[cell / size % layers] * total;
            if (wall) v = CLIP(real, v);
        }
        out[cell] = v;
    }
}

// The largest |slope| of the free cells, each layer's times its rate.
KERNEL void steepest(__global const real *slope, __global const real *x, __global const real *rates,
                     __global const ulong *held, __global real *partial, int has_held, int wall, int layers, long size,
                     int cols, long count)
{
    real most_here = 0;
    EACH(cell, count) {
        const real v = slope[cell] * rates[cell / size % layers];
        const int against = wall && ((x[cell] >= 1 && v > 0) || (x[cell] <= -1 && v < 0));
        if (!against && !is_held(held, has_held, cell, cols)) most_here = max(most_here, fabs(v));
    }
    HAND_IN_LARGEST(partial, most_here)
}

// y(k + 1) = f(drive), the old output where a sign's drive is 0 or the cell is held; and the largest change.
KERNEL void discrete(__global const real *drive, __global const real *y, __global real *out,
                     __global const real *numbers, __global const ulong *held, __global real *partial, int kind,
                     int places, int at, int values, int has_held, int cols, long count)
{
    real most_here = 0;
    EACH(cell, count) {
        const int keeps = (kind == SIGN && drive[cell] == 0) || is_held(held, has_held, cell, cols);
        const real now = keeps ? y[cell] : function_of(drive[cell], kind, places, at, values, numbers);
        most_here = max(most_here, fabs(now - y[cell]));
        out[cell] = now;
    }
    HAND_IN_LARGEST(partial, most_here)
}
