// Boundary conditions: which cell a virtual cell outside the grid stands for. The tiled steps (cpu.cl, patch.cl) have ways of
// their own. A boundary works on one axis after the other, so a corner takes both steps.

static inline int wrap(int i, int n)
{
    i %= n;
    return i < 0 ? i + n : i;
}

static inline int clamp_to(int i, int n) { return i < 0 ? 0 : i >= n ? n - 1 : i; }

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
