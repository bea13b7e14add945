// The closed form of uncoupled cells: `cnnsim.network.cell.uncoupled_state`, one cell at a time. LIMITED is 1 for the
// full-range cell. The kernel is `closed_form` in stencil.cl.

// Go from |x| <= 1 for the time t, into the saturation ahead (or up to the limit) if it is reached.
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
        if (until_one <= t) return ahead * (LIMITED ? 1 : (a + s) + (1 - a - s) * exp(-(t - until_one)));
    }
    const real moved = a == 1 ? rate * t : rate * expm1((a - 1) * t) / (a - 1);
    return ahead * (x + moved);
}

static inline real state_at(real x, real s, real a, real t)
{
    if (LIMITED || fabs(x) <= 1) return through_linear(x, s, a, t);
    const real side = x < 0 ? -1 : 1, size = x * side, push = s * side, target = a + push;
    if (target < 1) {
        const real until_one = log((size - target) / (1 - target));
        if (until_one < t) return side * through_linear(1, push, a, t - until_one);
    }
    return side * (target + (size - target) * exp(-t));
}

// The state a cell comes to: no exponentials, only comparisons, and no branches, so that vectors of cells can do it.
#define AT_REST(type)                                                                                   \
    static inline type type##_at_rest(type x, type s, real a)                                           \
    {                                                                                                   \
        const type one = (type)1, side = x < (type)0 ? -one : one;                                      \
        const type start = FAR(x, one) ? side : x, rate = (a - 1) * start + s;                          \
        const type ahead = rate < (type)0 ? -one : one;                                                 \
        const type moved = (a - 1) + s * ahead > (type)0 ? (LIMITED ? ahead : a * ahead + s) : s / (1 - a); \
        const type there = rate == (type)0 ? start : moved;                                             \
        return FAR(x, one) & (a + s * side >= one) ? a * side + s : there;                              \
    }
#if LIMITED
#define FAR(x, one) ((x) != (x)) // no cell is
#else
#define FAR(x, one) (((x) > (one)) | ((x) < -(one)))
#endif
AT_REST(real)
#if V > 1
AT_REST(vec)

// The same, with fewer comparisons where all cells begin inside and drive themselves on, as most do: where a >= 1 a cell
// whose rate is not 0 comes to the saturation ahead.
static inline vec at_rest(vec x, vec s, real a)
{
#if !LIMITED && defined(__has_builtin)
#if __has_builtin(__builtin_reduce_or)
    if (a >= 1 && !__builtin_reduce_or(FAR(x, (vec)1))) {
        const vec rate = (a - 1) * x + s, ahead = rate < (vec)0 ? -(vec)1 : (vec)1;
        return rate == (vec)0 ? x : a * ahead + s;
    }
#endif
#endif
    return vec_at_rest(x, s, a);
}
#endif

// The end of a cell, or of a vector of cells: at rest (REST), or at time t. An infinite state or NaN makes NaN, which no
// comparison above may hide.
static inline real real_end(real x, real s, real a, real t)
{
    return (REST ? real_at_rest(x, s, a) : state_at(x, s, a, t)) + (x - x);
}
#if V > 1
static inline vec vec_end(vec x, vec s, real a, real t)
{
    if (REST) return at_rest(x, s, a) + x * (vec)0;
    vec end;
    for (int v = 0; v < V; v++) end[v] = real_end(x[v], s[v], a, t);
    return end;
}
#endif
