// Steps of networks by any scheme, and other tasks with the drives of cells. Comes after ghosts.cl and taps.cl or terms.cl.
//
// Planes are padded (ghosts.cl) and lie one behind the other in a buffer: states in x, outputs in y, `size` numbers each.
// The state at the start of step n is in plane n % PAST, so that terms find the delayed ones; the states of later stages
// are in the planes behind, alternately. A turn is one stage of a step, or one task. A unit is some lines, and then a launch
// takes one turn; or it is a grid with all its layers, and then a launch may take many turns.
//
//     OUTPUT    y = f(x)
//     DRIVE     w = w + z + drive, where w is the bias
//     STEP      k_s = drive of y_s - y_s,  y_s = x + gain (a_s0 k_0 + ...),  x = x + gain (b_0 k_0 + b_1 k_1 + ...)
//     DISCRETE  x = f(drive), where a sign of 0 is the old one
//     CHECK     the largest |k_0| over the layer's time constant
//
// `of_layer` is z of each layer, or 1 over its time constant; `table` has a_1, a_2, ..., nothing and b, each with as many
// numbers as stages. KEEPS: stages read earlier rates than the last one, which lie behind the sums. Bit s of AHEAD: stage s
// reads delayed values of the end of the step. LIMITED: every stage and step ends within +-1. Masked cells keep x. OUTPUTS:
// outputs differ from states. Measured are the largest rate, or change, and whether a cell is not saturated for good
// (CHECK), or an output differs from that of two steps ago (DISCRETE).

enum { OUTPUT_TASK, DRIVE, STEP, DISCRETE, CHECK };

typedef struct {
    real largest, flag;
} measures;

// Which lanes of a vector are below m, and which cells from column t on a mask holds.
static inline sure_vec lanes_below(int m)
{
#if V > 1
    sure_vec lane;
    for (int q = 0; q < V; q++) lane[q] = q;
    return lane < (sure_vec)(sure)m;
#else
    return m > 0;
#endif
}

static inline sure_vec held(__global const ulong *mask, long line, int t, int cols)
{
    const ulong bits = mask[line * ((cols + 63) / 64) + t / 64] >> (t % 64);
#if V > 1
    sure_vec one;
    for (int q = 0; q < V; q++) one[q] = 1 << q;
    return ((sure_vec)(sure)(bits & 0xffff) & one) != 0;
#else
    return bits & 1;
#endif
}

#define SIZE(v) ((v) < (vec)0 ? -(v) : (v))

#define PARAMETERS                                                                              \
    __global real *x, __global real *y, __global const real *u, __global real *w, __global real *sums, \
    __global const ulong *mask, __global real *partial, __global const real *table,             \
    __global const real *gains, __global const real *of_layer, real outside, int step, int first_turn, int turns, \
    int rows, int cols, int lines, int stride, long size, int height, int first, int units NEIGHBOUR_PARAMETERS
#define ARGUMENTS                                                                               \
    x, y, u, w, sums, mask, partial, table, gains, of_layer, outside, step, first_turn, turns, rows, cols, lines, stride, \
    size, height, first, units NEIGHBOUR_ARGUMENTS

static inline measures do_task(const int task, PARAMETERS)
{
    const int count = task == STEP ? STAGES : 1;
    const long layer_size = (long)(rows + 2 * RADIUS) * stride;
    vec most = 0;
    sure_vec flags = 0;
    EACH_UNIT(unit, units)
    for (int turn = first_turn; turn < first_turn + turns; turn++) {
        const int stage = turn % count, now = step + turn / count, last = stage + 1 == count;
        const long start_at = now % PAST * size, now_at = stage ? (PAST + (stage - 1) % 2) * size : start_at;
        const long next_at = task == OUTPUT_TASK ? start_at : last ? (now + 1) % PAST * size : (PAST + stage % 2) * size;
        const int top = (first + unit) * height;
        EACH_PART(top, min(top + height, lines))
        {
            const int i = line % rows, layer = line / rows % LAYERS;
            const long own = row_at(line, rows, stride, RADIUS), base = own - layer * layer_size;
            const real gain = gains[layer], weight = table[count * count + stage];
            for (int t = begin; t < end; t += V) {
                const long cell = own + t;
                const vec start = AT(const vec, x + start_at + cell);
                vec total = AT(const vec, w + cell), v = start;
                if (task == DRIVE) total += (vec)of_layer[layer];
                if (task != OUTPUT_TASK) { ADD_NEIGHBOURS }
                if (task == DRIVE) {
                    AT(vec, w + cell) = total;
                    continue;
                }
                if (task == CHECK) {
                    v = (total - start) * of_layer[layer];
                    sure_vec counts = lanes_below(cols - t);
#ifdef MASK
                    counts = held(mask, line, t, cols) ? (sure_vec)0 : counts;
#endif
                    const sure_vec above = start >= (vec)1, below = start <= (vec)-1;
                    flags |= counts & ~((above & (total >= (vec)1)) | (below & (total <= (vec)-1)));
#if LIMITED
                    counts &= ~((above & (v > (vec)0)) | (below & (v < (vec)0)));
#endif
                    most = (SIZE(v) > most) & counts ? SIZE(v) : most;
                    continue;
                }
                if (task == STEP) {
                    const vec k = total - (stage ? AT(const vec, x + now_at + cell) : start);
                    vec sum = stage ? AT(const vec, sums + cell) : SUM_BEGINS;
                    sum += weight * k;
                    v = SUM_ENDS(sum);
                    if (!last) {
                        AT(vec, sums + cell) = sum;
                        __global const real *next = table + stage * count;
                        vec lead = SUM_BEGINS;
#if KEEPS
                        for (int s = 0; s < stage; s++) lead += next[s] * AT(const vec, sums + (s + 1) * size + cell);
                        AT(vec, sums + (stage + 1) * size + cell) = k;
#endif
                        lead += next[stage] * k;
                        v = SUM_ENDS(lead);
                    }
                }
                if (task == DISCRETE || (task == OUTPUT_TASK && !OUTPUTS)) {
                    if (task == OUTPUT_TASK) total = start;
                    v = OUTPUT_OF_DRIVE(total, start);
                }
#if LIMITED
                v = task == STEP ? CLIP(vec, v) : v;
#endif
#ifdef MASK
                v = held(mask, line, t, cols) ? start : v;
#endif
                if (task == DISCRETE) {
                    const vec before = AT(const vec, x + (now + PAST - 1) % PAST * size + cell);
                    most = (SIZE(v - start) > most) & lanes_below(cols - t) ? SIZE(v - start) : most;
                    flags |= (v != before) & lanes_below(cols - t);
                }
                AT(vec, x + next_at + cell) = v;
#if OUTPUTS
                AT(vec, y + next_at + cell) = output_of(v);
#endif
            }
            if (task == STEP || task == DISCRETE || task == OUTPUT_TASK) {
                spread(x + next_at + own, i, begin, end, rows, cols, stride, RADIUS, outside);
#if OUTPUTS
                spread(y + next_at + own, i, begin, end, rows, cols, stride, RADIUS, outside);
#endif
            }
        }
        PHASE
    }
    measures found = {0, 0};
#if V > 1
    for (int q = 0; q < V; q++) {
        found.largest = max(found.largest, most[q]);
        found.flag = flags[q] ? 1 : found.flag;
    }
#else
    found.largest = most;
    found.flag = flags != 0;
#endif
    return found;
}

#define PLAIN(name, task) \
    KERNEL void name(PARAMETERS) { do_task(task, ARGUMENTS); }
#define MEASURED(name, task)                                                                    \
    KERNEL void name(PARAMETERS)                                                                \
    {                                                                                           \
        const measures found = do_task(task, ARGUMENTS);                                        \
        HAND_IN_PAIR(partial, found.largest, found.flag)                                        \
    }
KERNELS
