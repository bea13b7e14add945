// The closed form of uncoupled cells: `cnnsim.cell.uncoupled_state`, one cell at a time. WALLS: the full-range cell.

#ifdef WALLS
#define WALLED 1
#else
#define WALLED 0
#endif

// Go from |x| <= 1 for the time t, into the saturation ahead (or up to the wall) if it is reached.
static inline real through_linear(real x, real s, real a, real t)
{
    real rate = (a - 1) * x + s;
    if (rate == 0) return x;
    const real ahead = rate < 0 ? -1 : 1;
    x *= ahead;
    s *= ahead;
    rate *= ahead;
    if (a - 1 + s > 0) {
        const real until_one = a == 1 ? (1 - x) / rate : log1p((a - 1) * (1 - x) / rate) / (a - 1);
        if (until_one <= t) return ahead * (WALLED ? 1 : (a + s) + (1 - a - s) * exp(-(t - until_one)));
    }
    const real moved = a == 1 ? rate * t : rate * expm1((a - 1) * t) / (a - 1);
    return ahead * (x + moved);
}

static inline real cell_at(real x, real s, real a, real t)
{
    if (WALLED || fabs(x) <= 1) return through_linear(x, s, a, t);
    const real side = x < 0 ? -1 : 1, size = x * side, push = s * side, target = a + push;
    if (target < 1) {
        const real until_one = log((size - target) / (1 - target));
        if (until_one < t) return side * through_linear(1, push, a, t - until_one);
    }
    return side * (target + (size - target) * exp(-t));
}

// The state a cell comes to: no exponentials, only comparisons.
static inline real cell_at_rest(real x, real s, real a)
{
    if (!WALLED && fabs(x) > 1) {
        const real side = x < 0 ? -1 : 1;
        if (a + s * side >= 1) return a * side + s;
        x = side;
    }
    const real rate = (a - 1) * x + s;
    if (rate == 0) return x;
    const real ahead = rate < 0 ? -1 : 1;
    if (a - 1 + s * ahead > 0) return WALLED ? ahead : a * ahead + s;
    return s / (1 - a);
}

KERNEL void closed_form(__global const real *restrict x, __global const real *restrict w,
                          __global const ulong *restrict held, __global real *restrict out, real a, real t, int rest,
                          int has_held, long lines, int cols)
{
    EACH(cell, lines * cols) {
        const real from = x[cell];
        const real flaw = from - from; // NaN if x is NaN or infinite: no comparison below may hide that
        if (has_held && black(held, cell / cols, (int)(cell % cols), cols))
            out[cell] = from;
        else
            out[cell] = flaw + (rest ? cell_at_rest(from, w[cell], a) : cell_at(from, w[cell], a, t));
    }
}
