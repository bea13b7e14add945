// The sums of a scheme of several stages: out = wall(x + c0 k0 + c1 k1 + ...), where a held cell keeps x.
//
// WALLS: the full-range cell, whose state stops at -1 and 1. `stages` of the four k are used.

KERNEL void update(__global const real *x, __global const real *k0, __global const real *k1, __global const real *k2,
                     __global const real *k3, __global const ulong *held, __global real *out, real c0, real c1,
                     real c2, real c3, int stages, int has_held, long lines, int cols)
{
    EACH(cell, lines * cols) {
        real s = x[cell];
        if (!has_held || !black(held, cell / cols, (int)(cell % cols), cols)) {
            if (stages > 0) s += c0 * k0[cell];
            if (stages > 1) s += c1 * k1[cell];
            if (stages > 2) s += c2 * k2[cell];
            if (stages > 3) s += c3 * k3[cell];
#ifdef WALLS
            s = CLIP(real, s);
#endif
        }
        out[cell] = s;
    }
}
