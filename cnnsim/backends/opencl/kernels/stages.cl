// Sums over the stages of a Runge-Kutta scheme: where a stage, or a step, leads. `rates` has a plane of `count` cells a
// stage, one after the other; `weights` are as many as `stages`. A masked cell keeps x.

static inline int masked(__global const ulong *mask, int has_mask, long cell, int cols)
{
    return has_mask && black(mask, cell / cols, (int)(cell % cols), cols);
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
