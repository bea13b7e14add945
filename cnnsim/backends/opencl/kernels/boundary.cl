// Boundary conditions: which cell stands at a place outside the grid, and with what value. Nothing else has to know a
// boundary; the tiled steps (cpu.cl, gpu.cl) have quicker ways for some of them, see tiles.py.
//
// A boundary works on one axis after the other, so a corner takes both steps.

static inline int wrap(int i, int n)
{
    i %= n;
    return i < 0 ? i + n : i;
}

static inline int clamp_to(int i, int n) { return i < 0 ? 0 : i >= n ? n - 1 : i; }

#ifdef BOUNDARY
// The real row or column that stands at place i of n; NOTHING where virtual cells hold a constant.
static inline int cell_at(int i, int n)
{
#if BOUNDARY == BOUNDARY_FIXED
    return i < 0 || i >= n ? NOTHING : i;
#elif BOUNDARY == BOUNDARY_PERIODIC
    return wrap(i, n);
#elif BOUNDARY == BOUNDARY_ZERO_FLUX
    return clamp_to(i, n);
#endif
}

// What a virtual cell makes of the value of the cell that stands there.
static inline real virtual_value(real v) { return v; }

// The same for 64 cells that are black or white.
static inline ulong virtual_bits(ulong black)
{
    return (virtual_value(1) > 0 ? black : 0) | (virtual_value(-1) > 0 ? ~black : 0);
}

// The value `v` of the cell that stands at place (i, j), found at (p, q), as it counts there.
static inline real value_at(real v, int i, int p, int j, int q)
{
    v = p == i ? v : virtual_value(v);
    return q == j ? v : virtual_value(v);
}
#endif
