// Planes of the general road: sums, looks. Its terms are in opencl_terms.cl. Planes are (n, layers, rows, cols).

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

// z of each layer plus the bias map.
KERNEL void base(__global const real *z, __global const real *bias, __global real *out, int has_bias, int layers,
                 long size, long count)
{
    EACH(cell, count) out[cell] = z[cell / size % layers] + (has_bias ? bias[cell] : (real)0);
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

// The largest difference of two planes.
KERNEL void change(__global const real *a, __global const real *b, __global real *partial, long count)
{
    real most_here = 0;
    EACH(cell, count) most_here = max(most_here, fabs(a[cell] - b[cell]));
    HAND_IN_LARGEST(partial, most_here)
}
