// One step of a block of R rows, STRIDE apart in local memory, for the tiles of cpu.cl; what stays saturated is marked for
// sleep.cl. Comes before cpu.cl.

#define BLOCK (R * STRIDE)
#define VEC(type, at) (*(type vec *)(at))
// So many columns, in whole halves of the widest vectors, at which vectors lie well.
#define EVEN(columns) (((columns) + 7) / 8 * 8)
#define MODULO_3(b) (((b) + 6 * T) % 3)

#if R == 1
#define EACH_ROW(DO) DO(0)
#elif R == 2
#define EACH_ROW(DO) DO(0) DO(1)
#elif R == 3
#define EACH_ROW(DO) DO(0) DO(1) DO(2)
#elif R == 4
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3)
#else
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3) DO(4)
#endif

// Row q of the block (-R .. 2 R - 1: its neighbours' rows too), a vector of cells from column j + l on.
#define ROW(q) ((q) < 0 ? above + ((q) + R) * STRIDE : (q) < R ? here + (q) * STRIDE : below + ((q) - R) * STRIDE)
#define NEIGHBOUR(q, l) VEC(const __local, ROW(q) + j + (l))

static inline int any_of(sure_vec some)
{
    sure any = 0;
    for (int v = 0; v < V; v++) any |= some[v];
    return any != 0;
}

// One step of a block's columns start .. end - 1 (or so many, with the drive of the first): states in place, outputs to
// `fresh`. All rows are read before any is written, so that the compiler may keep in registers what two of them read.
// With `mark` it returns in bit q whether a cell of row q before column `stop` was not saturated for good, in bit R whether
// one before column `west` was not, and in bit R + 1 whether one from column `east` on was not.
static inline __attribute__((always_inline)) int
step_block(const __local real *above, const __local real *here, const __local real *below, __local real *x,
           const __local real *w, const __local real *gain, __local real *fresh, int start, int end, int times,
           int mark, int stop, int west, int east)
{
#define NONE(q) sure_vec loose##q = (sure_vec)0;
    EACH_ROW(NONE)
    sure_vec loose_west = (sure_vec)0, loose_east = (sure_vec)0;
    for (int j = start; j < end; j += V) {
#define START(q) vec s##q = VEC(const __local, x + (q) * STRIDE + j), d##q = VEC(const __local, w + (q) * STRIDE + j);
        EACH_ROW(START)
#ifdef SHARED_SUMS
#define SIDES(q) (NEIGHBOUR(q, -1) + NEIGHBOUR(q, 1))
#define DRIVE(q)                                                                                              \
    d##q += (real)(CENTRE) * NEIGHBOUR(q, 0);                                                                     \
    d##q += (real)(EDGE) * (SIDES(q) + (NEIGHBOUR(q - 1, 0) + NEIGHBOUR(q + 1, 0)));                                  \
    d##q += (real)(CORNER) * (SIDES(q - 1) + SIDES(q + 1));
#else
#define TAP(q, k, l, weight) d##q += (real)(weight) * NEIGHBOUR(q + (k), l);
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
#define SHOW(q) VEC(__local, fresh + (q) * STRIDE + j) = CLIP(vec, s##q);
        EACH_ROW(SHOW)
    }
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
