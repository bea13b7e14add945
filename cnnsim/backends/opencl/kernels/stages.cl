// Sums over the stages of a Runge-Kutta scheme: where a stage, or a step, leads. `rates` has a plane of `count` cells a
// stage, one after the other; `weights` are as many as `stages`. A masked cell keeps x.

static inline int masked(__global const ulong *mask, int has_mask, long cell, int cols)
{
    return has_mask && black(mask, cell / cols, (int)(cell % cols), cols);
}

// x + c0 k0 + c1 k1 + ..., limited in the full-range cell.
KERNEL void linear_stage(__global const real *x, __global const real *rates, __global const real *weights, int stages,
                         __global const ulong *mask, __global real *out, int has_mask, int limited, int cols,
                         long count)
{
#define LINEAR_STAGE(type)                                                                                     \
    {                                                                                                          \
        type s = *(__global const type *)(x + cell);                                                           \
        for (int i = 0; i < stages; i++) s += weights[i] * *(__global const type *)(rates + i * count + cell); \
        *(__global type *)(out + cell) = limited ? CLIP(type, s) : s;                                          \
    }
#if V > 1
    if (!has_mask) {
        const long stop = SHARE(count, get_global_id(0) + 1, get_global_size(0));
        long cell = SHARE(count, get_global_id(0), get_global_size(0));
        for (; cell + V <= stop; cell += V) LINEAR_STAGE(vec)
        for (; cell < stop; cell++) LINEAR_STAGE(real)
        return;
    }
#endif
    EACH(cell, count) {
        if (masked(mask, has_mask, cell, cols)) out[cell] = x[cell];
        else LINEAR_STAGE(real)
    }
}

// x + gain of the layer * (c0 k0 + c1 k1 + ...), limited in the full-range cell. Layers are `size` cells each.
KERNEL void layers_stage(__global const real *x, __global const real *rates, __global const real *weights, int stages,
                         __global const ulong *mask, __global real *out, int has_mask, int limited, int cols,
                         __global const real *gains, int layers, long size, long count)
{
    EACH(cell, count) {
        real v = x[cell];
        if (!masked(mask, has_mask, cell, cols)) {
            real total = 0;
            for (int i = 0; i < stages; i++) total += weights[i] * rates[i * count + cell];
            v += gains[cell / size % layers] * total;
            if (limited) v = CLIP(real, v);
        }
        out[cell] = v;
    }
}
