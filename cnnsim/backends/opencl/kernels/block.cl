// One step of a block of R = 4 rows, STRIDE apart in local memory, for the tiles of cpu.cl. Comes after sleep.cl.

#define VEC(type, at) (*(type vec *)(at))
// Number of columns in whole vectors, so that rows are aligned.
#define EVEN(columns) (((columns) + V - 1) / V * V)
#define R 4 // as many chains of sums as keep a core busy
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3)

// A vector of cells from column j + l on of row q of the block, or of its neighbours' rows.
#define NEIGHBOUR(q, l) VEC(const __local, y + (q) * STRIDE + j + (l))

#if defined SHARED_SUMS || defined SIDES_IN_ROW
// A column's sum, or its cell where no other row is read next to a cell, is carried on from vector to vector and moved
// sideways: a vector of cells to the left or right would be loaded over the end of a cache line.
#ifdef SHARED_SUMS
#define COLUMN(q, l, corner, edge) \
    ((real)(corner) * (NEIGHBOUR(q - 1, l) + NEIGHBOUR(q + 1, l)) + (real)(edge) * NEIGHBOUR(q, l))
#define SIDE(q, l) COLUMN(q, l, CORNER, EDGE)
#define MIDDLE(q, l) COLUMN(q, l, EDGE, CENTRE)
#define CARRY(q) vec before##q = SIDE(q, -V), here##q = SIDE(q, 0), middle##q = MIDDLE(q, 0);
#else
#define CARRY(q) vec before##q = NEIGHBOUR(q, -V), here##q = NEIGHBOUR(q, 0);
#endif
#define WRITE(q)
#define SHOW(q) VEC(__local, y + (q - RADIUS) * STRIDE + j) = CLIP(vec, s##q);
#if V == 16
#define TO_THE_RIGHT(a, b) __builtin_shufflevector(a, b, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30)
#define TO_THE_LEFT(a, b) __builtin_shufflevector(a, b, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16)
#else
#define TO_THE_RIGHT(a, b) __builtin_shufflevector(a, b, 7, 8, 9, 10, 11, 12, 13, 14)
#define TO_THE_LEFT(a, b) __builtin_shufflevector(a, b, 1, 2, 3, 4, 5, 6, 7, 8)
#endif
#else
// Outputs are written one vector late, because the next vector reads the cells to its left.
#define CARRY(q) vec late##q = VEC(__local, y + (q - RADIUS) * STRIDE + j - V);
#define WRITE(q) VEC(__local, y + (q - RADIUS) * STRIDE + j - V) = late##q;
#define SHOW(q) WRITE(q) late##q = CLIP(vec, s##q);
#endif

static inline int any_of(sure_vec some)
{
    sure any = 0;
    for (int v = 0; v < V; v++) any |= some[v];
    return any != 0;
}

// One step of columns start .. end - 1 of a block (or `times` steps with the drives of the first): states in place, outputs
// from those at y to RADIUS rows further up. All rows are read before any is written, so that the compiler may keep in
// registers what two rows read.
// With `mark` it returns in bit q whether a cell of row q before column `stop` was not saturated for good, in bit R whether
// one before column `west` was not, in bit R + 1 one from column `east` on.
static inline __attribute__((always_inline)) int
step_block(__local real *y, __local real *x, const __local real *w, const __local real *gain, int start, int end,
           int times, int mark, int stop, int west, int east)
{
#define LOOSE_ROW(q) sure_vec loose##q = (sure_vec)0;
    sure_vec loose_west = (sure_vec)0, loose_east = (sure_vec)0;
    int j = start;
    EACH_ROW(LOOSE_ROW)
    EACH_ROW(CARRY)
    for (; j < end; j += V) {
#define START(q) vec s##q = VEC(const __local, x + (q) * STRIDE + j), d##q = VEC(const __local, w + (q) * STRIDE + j);
#ifdef SHARED_SUMS
#define DRIVE(q)                                                                                \
    const vec after##q = SIDE(q, V);                                                            \
    d##q += middle##q;                                                                          \
    d##q += TO_THE_RIGHT(before##q, here##q) + TO_THE_LEFT(here##q, after##q);                  \
    before##q = here##q, here##q = after##q, middle##q = MIDDLE(q, V);
#elif defined SIDES_IN_ROW
#define TAP(q, k, l, weight)                                                                    \
    d##q += (real)(weight) * ((l) < 0 ? TO_THE_RIGHT(before##q, here##q) : (l) > 0 ? TO_THE_LEFT(here##q, after##q) \
                              : (k) ? NEIGHBOUR(q + (k), 0) : here##q);
#define DRIVE(q)                                                                                \
    const vec after##q = NEIGHBOUR(q, V);                                                       \
    TAPS(TAP, q)                                                                                \
    before##q = here##q, here##q = after##q;
#else
#define TAP(q, k, l, weight) d##q += (real)(weight) * NEIGHBOUR(q + (k), l);
#define DRIVE(q) TAPS(TAP, q)
#endif
        EACH_ROW(START)
        EACH_ROW(DRIVE)
#ifdef SLEEP
        if (mark) {
            sure_vec own = (sure_vec)-1;
            for (int v = 0; j + V > stop && v < V; v++) own[v] = j + v < stop ? -1 : 0;
#ifdef MASK
#define STAYS(q) (SATURATED(s##q, d##q) | HELD(s##q, d##q, VEC(const __local, gain + (q) * STRIDE + j)))
#else
#define STAYS(q) SATURATED(s##q, d##q)
#endif
            sure_vec some = (sure_vec)0;
#define MARK(q) { const sure_vec moves = own & ~STAYS(q); loose##q |= moves; some |= moves; }
            EACH_ROW(MARK)
            if (j < west) loose_west |= some;
            if (j + V > east) loose_east |= some;
        }
#endif
#ifdef MASK
#define UPDATE(q) s##q += VEC(const __local, gain + (q) * STRIDE + j) * (d##q - s##q);
#else
#define UPDATE(q) s##q += (real)(GAIN) * (d##q - s##q);
#endif
        for (int t = 0; t < times; t++) {
            EACH_ROW(UPDATE)
        }
#if LIMITED
#define KEEP(q) s##q = CLIP(vec, s##q); VEC(__local, x + (q) * STRIDE + j) = s##q;
#else
#define KEEP(q) VEC(__local, x + (q) * STRIDE + j) = s##q;
#endif
        EACH_ROW(KEEP)
        EACH_ROW(SHOW)
    }
    EACH_ROW(WRITE)
    int found = 0;
#define FOUND(q) found |= any_of(loose##q) << q;
    if (mark) { EACH_ROW(FOUND) }
    return found | any_of(loose_west) << R | any_of(loose_east) << (R + 1);
}
