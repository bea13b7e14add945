// Planes of layers, (n, layers, rows, cols) with `size` cells a layer: z and bias, how fast and how far they change.
// Comes after stages.cl.

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

// The largest |rate| of the free cells, each layer's over its time constant.
KERNEL void largest_rate(__global const real *rate, __global const real *x, __global const real *over,
                         __global const ulong *mask, __global real *partial, int has_mask, int limited, int cols,
                         int layers, long size, long count)
{
    real most_here = 0;
    EACH(cell, count) {
        const real v = rate[cell] * over[cell / size % layers];
        const int against = limited && ((x[cell] >= 1 && v > 0) || (x[cell] <= -1 && v < 0));
        if (!against && !masked(mask, has_mask, cell, cols)) most_here = max(most_here, fabs(v));
    }
    HAND_IN_LARGEST(partial, most_here)
}

// The largest difference of two planes.
KERNEL void largest_change(__global const real *a, __global const real *b, __global real *partial, long count)
{
    real most_here = 0;
    EACH(cell, count) most_here = max(most_here, fabs(a[cell] - b[cell]));
    HAND_IN_LARGEST(partial, most_here)
}
