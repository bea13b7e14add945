// One step of a block of R rows, STRIDE apart in local memory, for the tiles of cpu.cl; what stays saturated is marked for
// sleep.cl. Comes before cpu.cl.

#define VEC(type, at) (*(type vec *)(at))
// So many columns, in whole vectors: rows begin where vectors lie well.
#define EVEN(columns) (((columns) + V - 1) / V * V)

#if R == 1
#define EACH_ROW(DO) DO(0)
#else // 4: as many chains of sums as keep a core busy
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3)
#endif

// A vector of cells from column j + l on of row q of the block, or of its neighbours' rows.
#define NEIGHBOUR(q, l) VEC(const __local, y + (q) * STRIDE + j + (l))

#define TAP(q, k, l, weight) d##q += (real)(weight) * NEIGHBOUR(q + (k), l);

// Vectors over the end of a cache line take as long as two to load. The widest ones, which nearly all lie so, are made of
// two that do not, which are carried on from vector to vector: of sums where these are shared, of a row's own cells where
// no other row is read beside a cell.
#if V == 16 && (defined SHARED_SUMS || defined SIDES_IN_ROW)
#define CARRIED
#define TO_THE_RIGHT(a, b) __builtin_shufflevector(a, b, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30)
#define TO_THE_LEFT(a, b) __builtin_shufflevector(a, b, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16)
#ifdef SHARED_SUMS
#define SIDE(q, l) ((real)(CORNER) * (NEIGHBOUR(q - 1, l) + NEIGHBOUR(q + 1, l)) + (real)(EDGE) * NEIGHBOUR(q, l))
#define MIDDLE(q, l) ((real)(EDGE) * (NEIGHBOUR(q - 1, l) + NEIGHBOUR(q + 1, l)) + (real)(CENTRE) * NEIGHBOUR(q, l))
#else
#define CARRIED_TAP(q, k, l, weight)                                                                          \
    d##q += (real)(weight) * ((l) < 0 ? TO_THE_RIGHT(before##q, here##q) : (l) > 0 ? TO_THE_LEFT(here##q, after##q) \
                              : (k) ? NEIGHBOUR(q + (k), 0) : here##q);
#endif
#endif

static inline int any_of(sure_vec some)
{
    sure any = 0;
    for (int v = 0; v < V; v++) any |= some[v];
    return any != 0;
}

// One step of a block's columns start .. end - 1 (or so many, with the drive of the first): states in place, outputs from
// those at y to RADIUS rows further up. All rows are read before any is written, so that the compiler may keep in registers
// what two of them read; and outputs are written one vector late, because the next vector reads the cells to its left.
// With `mark` it returns in bit q whether a cell of row q before column `stop` was not saturated for good, in bit R whether
// one before column `west` was not, and in bit R + 1 whether one from column `east` on was not.
static inline __attribute__((always_inline)) int
step_block(__local real *y, __local real *x, const __local real *w, const __local real *gain, int start, int end,
           int times, int mark, int stop, int west, int east)
{
#define NONE(q) sure_vec loose##q = (sure_vec)0;
    EACH_ROW(NONE)
    sure_vec loose_west = (sure_vec)0, loose_east = (sure_vec)0;
    int j = start;
#if defined CARRIED && defined SIDES_IN_ROW
#define BEGIN(q) vec before##q = NEIGHBOUR(q, -V), here##q = NEIGHBOUR(q, 0);
#elif defined CARRIED
#define BEGIN(q) vec before##q = SIDE(q, -V), side##q = SIDE(q, 0), middle##q = MIDDLE(q, 0);
#else
#define BEGIN(q) vec late##q = VEC(__local, y + (q - RADIUS) * STRIDE + j - V);
#endif
    EACH_ROW(BEGIN)
    for (; j < end; j += V) {
#define START(q) vec s##q = VEC(const __local, x + (q) * STRIDE + j), d##q = VEC(const __local, w + (q) * STRIDE + j);
        EACH_ROW(START)
#if defined CARRIED && defined SIDES_IN_ROW
#define DRIVE(q)                                                                                              \
    const vec after##q = NEIGHBOUR(q, V);                                                                         \
    TAPS(CARRIED_TAP, q)                                                                                          \
    before##q = here##q, here##q = after##q;
#elif defined CARRIED
#define DRIVE(q)                                                                                              \
    const vec after##q = SIDE(q, V);                                                                              \
    d##q += middle##q;                                                                                            \
    d##q += TO_THE_RIGHT(before##q, side##q) + TO_THE_LEFT(side##q, after##q);                                        \
    before##q = side##q, side##q = after##q, middle##q = MIDDLE(q, V);
#elif defined SHARED_SUMS
#define SIDES(q) (NEIGHBOUR(q, -1) + NEIGHBOUR(q, 1))
#define DRIVE(q)                                                                                              \
    d##q += (real)(CENTRE) * NEIGHBOUR(q, 0);                                                                     \
    d##q += (real)(EDGE) * (SIDES(q) + (NEIGHBOUR(q - 1, 0) + NEIGHBOUR(q + 1, 0)));                                  \
    d##q += (real)(CORNER) * (SIDES(q - 1) + SIDES(q + 1));
#else
#define DRIVE(q) TAPS(TAP, q)
#endif
        EACH_ROW(DRIVE)
#ifdef SLEEP
        if (mark) {
            sure_vec own = (sure_vec)-1;
            for (int v = 0; j + V > stop && v < V; v++) own[v] = j + v < stop ? -1 : 0;
#ifdef MASK
#define STAYS(q) (SATURATED(vec, s##q, d##q) | HELD(vec, s##q, d##q, VEC(const __local, gain + (q) * STRIDE + j)))
#else
#define STAYS(q) SATURATED(vec, s##q, d##q)
#endif
            sure_vec some = (sure_vec)0;
#define MARK(q) { const sure_vec moves = own & ~STAYS(q); loose##q |= moves; some |= moves; }
            EACH_ROW(MARK)
            if (j < west) loose_west |= some;
            if (j >= east) loose_east |= some;
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
#ifdef CARRIED // reads no cell to the left
#define SHOW(q) VEC(__local, y + (q - RADIUS) * STRIDE + j) = CLIP(vec, s##q);
#else
#define WRITE(q) VEC(__local, y + (q - RADIUS) * STRIDE + j - V) = late##q;
#define SHOW(q) WRITE(q) late##q = CLIP(vec, s##q);
#endif
        EACH_ROW(SHOW)
    }
#ifndef CARRIED
    EACH_ROW(WRITE)
#endif
    int found = 0;
#define FOUND(bit, loose) found |= any_of(loose) ? 1 << (bit) : 0;
#define FOUND_ROW(q) FOUND(q, loose##q)
    if (mark) {
        EACH_ROW(FOUND_ROW)
        if (found) {
            FOUND(R, loose_west)
            FOUND(R + 1, loose_east)
        }
    }
    return found;
}
