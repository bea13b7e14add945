// A routine of a program in one launch: a work-group takes one grid, with its planes in local memory, through all
// instructions; see `cnnsim.operations.routine`. Comes after boundary.cl and closed.cl.
//
// An instruction is a row of COLUMNS whole numbers in `code`: op, to, p, q, by; first and end of its triples; boundary, a
// flag; and of steps: first and end of the feedback's triples, steps, steps between two checks; the radius of both kinds of
// taps. A triple in `table` is
// (k, l, number of a weight) of a tap or (k, l, negated) of a literal, or the first of it is the slot of a plane. The slots
// `scratch` and scratch + 1 are for steps. `out` begins with a word a grid: not 0 if a result is not finite or too
// large, or a transient ends otherwise than saturated; then the steps have to be run one by one.

#ifdef CPU
#define EACH_LOCAL(i, count) for (int i = 0; i < (count); i++)
#define MEET
#else
#define EACH_LOCAL(i, count) for (int i = get_local_id(0); i < (count); i += get_local_size(0))
#define MEET barrier(CLK_LOCAL_MEM_FENCE);
#endif
#define LAM(slot) (lam + (slot) * cells)
#define LLM(slot) (llm + (slot) * cells)
#define MOST 1073741824 // the largest number in a register whose product fits a register

static void cellwise(int which, __local real *lam, __global const int *slots, __global const real *numbers, int cells);

// Where the cell i of n is that a cell outside stands for; NOTHING where it holds a constant.
static inline int place_of(int i, int n, int boundary)
{
    if (i >= 0 && i < n) return i;
    return boundary == BOUNDARY_FIXED ? NOTHING : boundary == BOUNDARY_PERIODIC ? wrap(i, n) : clamp_to(i, n);
}

static inline int neighbour_of(int cell, int k, int l, int rows, int cols, int boundary)
{
    const int p = place_of(cell / cols + k, rows, boundary), q = place_of(cell % cols + l, cols, boundary);
    return p == NOTHING || q == NOTHING ? NOTHING : p * cols + q;
}

// Add the taps first .. end - 1 of a plane to a sum.
static inline real add_taps(real total, const __local real *plane, int cell, __global const int *table,
                            __global const real *numbers, int first, int end, int radius, real outside, int boundary, int rows,
                            int cols)
{
    const int i = cell / cols, j = cell - i * cols;
    if (i >= radius && i < rows - radius && j >= radius && j < cols - radius) {
        for (int tap = first; tap < end; tap++)
            total += numbers[table[3 * tap + 2]] * plane[cell + table[3 * tap] * cols + table[3 * tap + 1]];
        return total;
    }
    for (int tap = first; tap < end; tap++) {
        const int at = neighbour_of(cell, table[3 * tap], table[3 * tap + 1], rows, cols, boundary);
        total += numbers[table[3 * tap + 2]] * (at == NOTHING ? outside : plane[at]);
    }
    return total;
}

// A plane of slot q that comes from or goes to global memory.
#define WORDS ((cols + 63) / 64)
static inline void load(__global const void *from, int analog, int slot, int grid, __local real *lam, __local uchar *llm,
                        int rows, int cols)
{
    const int cells = rows * cols;
    EACH_LOCAL(i, cells)
    {
        if (analog) LAM(slot)[i] = ((__global const real *)from)[(long)grid * cells + i];
        else LLM(slot)[i] = black((__global const ulong *)from, (long)grid * rows + i / cols, i % cols, cols);
    }
}

#define INPUTS(DO) DO(0) DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7) DO(8) DO(9) DO(10) DO(11) DO(12) DO(13) DO(14) DO(15)
#define PARAMETER(n) __global const void *in##n,
#define LOAD_FROM(n) case n: from = in##n; break;

#ifdef CPU
__attribute__((reqd_work_group_size(1, 1, 1)))
#endif
__kernel void routine(INPUTS(PARAMETER) __global const long *given, __global char *out, __global const int *code,
                      int count, __global const int *table, __global const real *numbers, __local real *lam,
                      __local uchar *llm, __local long *wire, int rows, int cols, int grids, int first_grid, int scratch)
{
    __local int tally[2];
    const int grid = first_grid + get_group_id(0), cells = rows * cols, boss = get_local_id(0) == 0;
    int failed = 0;
    if (boss) tally[0] = tally[1] = 0;
    MEET
    for (int at = 0; at < count; at++) {
        __global const int *row = code + at * COLUMNS;
        const int op = row[0], to = row[1], p = row[2], q = row[3], by = row[4], first = row[5], end = row[6];
        const int boundary = row[7], flag = row[8];
        int votes = 0;
        if (op == OP_LOGIC) {
            EACH_LOCAL(i, cells) LLM(to)[i] = by >> (2 * LLM(p)[i] + LLM(q)[i]) & 1;
        } else if (op == OP_NEIGHBOURHOOD) {
            EACH_LOCAL(i, cells)
            {
                int result = flag;
                for (int n = first; n < end; n++) {
                    const int cell = neighbour_of(i, table[3 * n], table[3 * n + 1], rows, cols, boundary);
                    const int is = (cell == NOTHING ? by : LLM(p)[cell]) != table[3 * n + 2];
                    result = flag ? result & is : result | is;
                }
                LLM(to)[i] = result;
            }
        } else if (op == OP_BLACK_ABOVE) {
            EACH_LOCAL(i, cells) LLM(to)[i] = LAM(p)[i] > 0;
        } else if (op == OP_SHADE || op == OP_SHADE_BY) {
            const int shade = op == OP_SHADE ? by : wire[p] > 0;
            EACH_LOCAL(i, cells) LLM(to)[i] = shade;
        } else if (op == OP_VALUES) {
            EACH_LOCAL(i, cells) LAM(to)[i] = LLM(p)[i] ? 1 : -1;
        } else if (op == OP_CONSTANT || op == OP_CONSTANT_BY) {
            const real value = op == OP_CONSTANT ? numbers[by] : (real)wire[p];
            EACH_LOCAL(i, cells) LAM(to)[i] = value;
        } else if (op == OP_SETTLE) {
            EACH_LOCAL(i, cells)
            {
                const real s = add_taps(numbers[by], LAM(q), i, table, numbers, first, end, row[13], numbers[by + 2], boundary, rows, cols);
                const real x = real_end(LAM(p)[i], s, numbers[by + 1], 0);
                failed |= x * 0 != 0;
                LAM(to)[i] = x;
            }
        } else if (op == OP_CLIP) {
            EACH_LOCAL(i, cells) LAM(to)[i] = CLIP(real, LAM(p)[i]);
        } else if (op == OP_COUNT || op == OP_ANY || op == OP_ALL) {
            EACH_LOCAL(i, cells) votes += LLM(p)[i];
            if (votes) atomic_add(&tally[0], votes);
        } else if (op == OP_CELLWISE) {
            cellwise(by, lam, table + 3 * first, numbers + q, cells);
        } else if (op == OP_STEPS) {
            EACH_LOCAL(i, cells)
            {
                LAM(scratch)[i] = add_taps(numbers[by], LAM(q), i, table, numbers, first, end, row[13], numbers[by + 1], boundary, rows, cols);
                LAM(to)[i] = LAM(p)[i];
            }
        } else if (op == OP_LOAD_LAM || op == OP_LOAD_LLM) {
            __global const void *from = in0;
            switch (p) { INPUTS(LOAD_FROM) }
            load(from, op == OP_LOAD_LAM, to, grid, lam, llm, rows, cols);
        } else if (op == OP_STORE_LAM) {
            EACH_LOCAL(i, cells) ((__global real *)(out + by))[(long)grid * cells + i] = LAM(p)[i];
        } else if (op == OP_STORE_LLM) {
            EACH_LOCAL(i, rows * WORDS)
            {
                const int begin = i % WORDS * 64, stop = min(64, cols - begin);
                ulong word = 0;
                for (int j = 0; j < stop; j++) word |= (ulong)LLM(p)[i / WORDS * cols + begin + j] << j;
                ((__global ulong *)(out + by))[(long)grid * rows * WORDS + i] = word;
            }
        } else if (boss) {
            if (op == OP_NUMBER) wire[to] = by;
            else if (op == OP_LOAD_WIRE) wire[to] = given[p * grids + grid];
            else if (op == OP_STORE_WIRE) ((__global long *)(out + by))[grid] = wire[p];
            else {
                const long a = wire[p], b = wire[q];
                failed |= max(abs(a), abs(b)) > MOST;
                wire[to] = op == OP_ADD ? a + b : op == OP_SUBTRACT ? a - b : op == OP_MULTIPLY ? a * b : a < b;
            }
        }
        MEET
        const int steps = row[11], every = row[12];
        for (int step = 0, looked = -1, go = op == OP_STEPS && (steps || every); go;) {
            const int looks = every && looked != step && (step % every == 0 || step == steps);
            EACH_LOCAL(i, cells) LAM(scratch + 1)[i] = CLIP(real, LAM(to)[i]);
            if (boss) tally[0] = tally[1] = 0;
            MEET
            int moves = 0, loose = 0;
            EACH_LOCAL(i, looks || step < steps ? cells : 0)
            {
                const real start = LAM(to)[i];
                const real d = add_taps(LAM(scratch)[i], LAM(scratch + 1), i, table, numbers, row[9], row[10], row[14],
                                        numbers[by + 2], boundary, rows, cols);
                const real rate = d < start ? start - d : d - start;
                moves |= !(rate <= (real)SETTLED_RATE);
                loose |= !((start >= 1 && d >= 1) || (start <= -1 && d <= -1));
                if (!looks) LAM(to)[i] = start + numbers[by + 3] * (d - start);
            }
            if (looks && moves) atomic_or(&tally[0], 1);
            if (looks && loose) atomic_or(&tally[1], 1);
            MEET
            const int over = looks ? !tally[0] || !tally[1] || step == steps : !every && step + 1 >= steps;
            failed |= looks && over && tally[1];
            step += !looks, looked = looks ? step : looked, go = !over;
            MEET
        }
        if (op == OP_STEPS) EACH_LOCAL(i, cells) failed |= LAM(to)[i] * 0 != 0;
        if (boss && (op == OP_COUNT || op == OP_ANY || op == OP_ALL))
            wire[to] = op == OP_COUNT ? tally[0] : op == OP_ANY ? tally[0] > 0 : tally[0] == cells;
        if (boss) tally[0] = tally[1] = 0;
        MEET
    }
    if (failed) atomic_or(&tally[0], 1);
    MEET
    if (boss) ((__global int *)out)[grid] = tally[0];
}
