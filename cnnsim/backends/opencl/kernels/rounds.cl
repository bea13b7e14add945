// Rounds of sleeping tiles, many in one launch on a CPU: where few are awake, another launch takes as long as they do.
// A round is what a launch does elsewhere, so many steps of all tiles. Comes after block.cl.
//
// Work-items claim groups of tiles one by one. A round begins when all groups of the one before are done; who finds
// none to claim looks again, PATIENCE times, and leaves then. Nobody waits with a group in its hands, so whoever is left
// does all that is left, if need be one after the other.
//
// Each `each` rounds the network is looked at before it is stepped. If no cell is found there that moves for certain,
// no other round begins, and the host looks (see settled.py); but not at the first round, before which it has looked.

#if defined(SLEEP) && defined(CPU)
#define ROUND_ARGUMENTS , __global int *book, int groups, int rounds, int each

// What work-items tell each other, all 0 before and after a launch but for WENT_ON, the rounds that count. From SIGNS
// on: in which round a cell was found that moves.
enum { CLAIMED, DONE, LEFT, WENT_ON, SIGNS };

// Whether a round that is done began with a look that found nothing.
static inline int is_still(const __global int *book, int round, int each)
{
    return round > 0 && round % each == 0 && !book[SIGNS + round];
}

// Claim a group of the `round` that is under way; -1 if there is none any more.
static int claim(__global int *book, int groups, int rounds, int each, int *round)
{
    for (int look = 0; look < PATIENCE; look++) {
        *round = __atomic_load_n(book + DONE, __ATOMIC_ACQUIRE) / groups;
        if (*round == rounds || is_still(book, *round - 1, each)) return -1;
        int next = __atomic_load_n(book + CLAIMED, __ATOMIC_RELAXED);
        if (next < (*round + 1) * groups
            && __atomic_compare_exchange_n(book + CLAIMED, &next, next + 1, 0, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
            return next - *round * groups;
    }
    return -1;
}

static void hand_in(__global int *book) { __atomic_fetch_add(book + DONE, 1, __ATOMIC_ACQ_REL); }

// Leave the launch; the last one clears the book.
static void leave(__global int *book, int groups, int each)
{
    if (__atomic_fetch_add(book + LEFT, 1, __ATOMIC_ACQ_REL) + 1 < (int)get_global_size(0)) return;
    const int done = book[DONE] / groups;
    book[WENT_ON] = done - is_still(book, done - 1, each);
    for (int round = 0; round < done; round++) book[SIGNS + round] = 0;
    book[CLAIMED] = book[DONE] = book[LEFT] = 0;
}

// Whether a cell of one row's columns start .. stop - 1 moves for certain, however sums are rounded: as in
// check_settled of stencil.cl, but well beyond the limits.
static int moves_on(const __local real *y, const __local real *x, const __local real *w, const __local real *gain,
                    int start, int stop)
{
    sure_vec some = (sure_vec)0;
    for (int j = start; j < stop; j += V) {
        const vec s0 = VEC(const __local, x + j);
        vec d0 = VEC(const __local, w + j);
        TAPS(TAP, 0)
        const vec rate = d0 < s0 ? s0 - d0 : d0 - s0;
        sure_vec moves = ~(rate <= (vec)(2 * (real)REST)); // NaN does
#if SATURATION_ENDS
        moves &= ~(((s0 >= (vec)1) & (d0 >= (vec)0.99f)) | ((s0 <= (vec)-1) & (d0 <= (vec)-0.99f)));
#endif
#ifdef MASK
        moves &= VEC(const __local, gain + j) != (vec)0;
#endif
        for (int v = 0; j + V > stop && v < V; v++) moves[v] &= j + v < stop ? -1 : 0;
        some |= moves;
    }
    return any_of(some);
}
#else
#define ROUND_ARGUMENTS
#endif
