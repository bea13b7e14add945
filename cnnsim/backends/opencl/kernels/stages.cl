// Steps of all stages, or another task with the drives of cells, tile by tile. Comes after tile.cl.
//
// Planes are (n, layers, rows, cols). A tile is `high` rows and `wide` columns of one grid, with all its layers. Its
// work-item, or on a GPU its work-group, goes through the stages one by one: it fills the channels, which are what
// neighbours are looked at in, and from these it finds the states of the next stage. What it works in lies in `scratch`,
// a part for each work-item that stays in its cache, so that of a whole grid no plane is made but the end of the step.
//
// For S stages a tile is computed with S * radius cells more around it, of which each stage spoils `radius`. Where the
// grid ends it ends too, and has its virtual cells set anew for each stage; on a torus that is cut it rolls on. A tile
// that is a whole grid may take many steps: state and drive then lie in the scratch too, with whole vectors of each row.
//
// The host writes FILLS (channel_text.py): how the channels are filled.

#ifdef CPU
#define BAND 1 // rows whose channels are filled and looked at in turn: they stay in the first cache
#else
#define BAND rows
#endif

typedef struct {
    real largest, differs;
} found;

// Numbers 0, 1, ... of a vector; those below m; and which of m cells of a mask are black.
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

static inline sure_vec held(__global const ulong *mask, long line, int j, int cols)
{
    const int words = (cols + 63) / 64, word = j / 64, skip = j % 64;
    const ulong beyond = skip && word + 1 < words ? mask[line * words + word + 1] << (64 - skip) : 0;
    const ulong bits = mask[line * words + word] >> skip | beyond;
#if V > 1
    sure_vec one;
    for (int q = 0; q < V; q++) one[q] = 1 << q;
    return ((sure_vec)(sure)(bits & 0xffff) & one) != 0;
#else
    return bits & 1;
#endif
}

// The larger of two sizes, lane by lane where it counts; what is no number does not.
#define LARGER(most, v, counts) (SIZE(v) > most) & counts ? SIZE(v) : most
#define SIZE(v) ((v) < (vec)0 ? -(v) : (v))

#define PARAMETERS                                                                                       \
    __global const real *x, __global const real *w, __global const ulong *mask, __global real *out,      \
    __global const real *before, __global real *scratch, __global real *partial, __global const real *table, \
    __global const real *gains, __global const real *of_layer, int bare, int rounds, int keeps,          \
    int ahead, int has_mask, int limited, real outside_u, real outside_y, int rows, int cols,            \
    int radius, int stride, int high, int wide, int down, int across, int tall, int count_of_channels,   \
    long share, long first, long tiles SOURCES DRIVE_ARGUMENTS
#define GIVEN                                                                                            \
    x, w, mask, out, before, scratch, partial, table, gains, of_layer, bare, rounds, keeps, ahead, has_mask, \
    limited, outside_u, outside_y, rows, cols, radius, stride, high, wide, down, across, tall,           \
    count_of_channels, share, first, tiles SOURCES_GIVEN DRIVE_GIVEN

// Tasks with the drive of each cell, w plus what neighbours add:
//
//     DRIVE     out = z + drive, where w is the bias, if there is one
//     STEP      k_s = drive of y_s - y_s,  y_s = x + gain (a_s0 k_0 + ...),  out = x + gain (b_0 k_0 + b_1 k_1 + ...)
//     DISCRETE  out = f(drive), where a sign of 0 is the old one; if it is `bare` the drive is w
//     CHECK     the largest |k_0| over the layer's time constant
//
// STEP and DISCRETE are done `rounds` times where state and drive are `kept`. `of_layer` is z of each layer, or 1 over
// its time constant. In the full-range cell every stage and step is limited; a masked cell keeps x. `table` has a_1, a_2,
// ..., nothing and b, each with as many numbers as stages; with `keeps` stages ask for other rates than the last one. Bit
// s of `ahead`: stage s looks at what is at the end of the step. Found are the largest rate, or change, and 1 if what
// DISCRETE writes differs from `before`, which may be `out`; without that nobody asks.
static inline found stages(const int task, const int kept, PARAMETERS)
{
    const int count = task == TASK_STEP ? STAGES : 1, reach = count * radius;
    const long all = (long)(tall + 2 * radius) * stride, size = (long)LAYERS * tall * stride;
    __global real *const channels = scratch + WORKER * share + PAD, *const spare = scratch + (WORKER + 1) * share - V;
    __global real *const starts = channels + count_of_channels * all, *const drives = starts + (kept ? size : 0);
    __global real *const states = drives + (kept ? size : 0), *const sums = states + size, *const rates = sums + size;
    vec most = 0;
    sure_vec other = 0;
    EACH_TILE(each, tiles)
    {
        const long tile = first + each;
        const int r0 = tile / across % down * high, r1 = min(rows, r0 + high);
        const int c0 = tile % across * wide, c1 = min(cols, c0 + wide);
        tile_place at = {rows, cols, LAYERS, radius, stride, tall};
        at.grid = tile / across / down;
        at.rolls_down = BOUNDARY == BOUNDARY_PERIODIC && down > 1;
        at.rolls_across = BOUNDARY == BOUNDARY_PERIODIC && across > 1;
        at.top = at.rolls_down ? r0 - reach : max(0, r0 - reach);
        at.bottom = at.rolls_down ? r1 + reach : min(rows, r1 + reach);
        at.left = at.rolls_across ? c0 - reach : max(0, c0 - reach);
        at.width = (at.rolls_across ? c1 + reach : min(cols, c1 + reach)) - at.left;
        for (int layer = 0; layer < (kept ? LAYERS : 0); layer++) {
            EACH_STRETCH(at.top, at.bottom, 0, at.width)
            {
                const long cell = line_of(&at, layer, i) * cols + shift, here = (layer * tall + i - at.top) * stride;
                for (int t = begin; t < stop; t += V) {
                    *(__global vec *)(starts + here + t) = *whole(x + cell + t, spare, stop - t);
                    *(__global vec *)(drives + here + t) = *whole(w + cell + t, spare, stop - t);
                }
            }
        }
        PHASE
        for (int turn = 0; turn < (kept ? rounds : 1) * count; turn++) {
            const int stage = turn % count, round = turn / count;
            const int last = stage + 1 == count, ends = !kept || round + 1 == rounds;
            const int margin = (count - 1 - stage) * radius;
            const int from = max(at.top, r0 - margin), to = min(at.bottom, r1 + margin);
            const int t0 = last ? c0 - at.left : 0, t1 = last ? c1 - at.left : at.width;
            const int band = kept || stage ? to - from : BAND; // where the next band looks at what this one writes: all
            for (int row = from; row < to; row += band) {
                const int until = min(to, row + band);
                FILLS
                PHASE
                for (int layer = 0; layer < LAYERS; layer++) EACH_STRETCH(row, until, t0, t1)
                {
                    const real gain = gains[layer], weight = table[count * count + stage];
                    const long line = line_of(&at, layer, i), cell = line * cols + shift;
                    const long here = (layer * tall + i - at.top) * stride;
                    __global const real *own = channels + (i - at.top + radius) * stride;
                    __global const real *from_x = kept ? starts + here : x + cell;
                    __global const real *from_w = kept ? drives + here : w + cell;
                    for (int t = begin; t < stop; t += V) {
                        const int m = stop - t, safe = kept ? V : m; // how many numbers are there
                        const int free = at.rolls_across ? m : V; // beside them on a torus another stretch begins
                        vec total = w ? *whole(from_w + t, spare, safe) : (vec)0;
                        if (task == TASK_DRIVE) total += (vec)of_layer[layer];
                        const vec start = task == TASK_DRIVE ? (vec)0 : *whole(from_x + t, spare, safe);
                        const vec state = stage ? *(__global const vec *)(states + here + t) : start;
                        ADD_NEIGHBOURS
                        vec v = total;
                        if (task == TASK_CHECK) {
                            v = (total - start) * of_layer[layer];
                            const sure_vec above = (start >= (vec)1) & (v > (vec)0), below = (start <= (vec)-1) & (v < (vec)0);
                            sure_vec counts = lanes_below(m);
                            if (limited) counts = above | below ? (sure_vec)0 : counts;
                            if (has_mask) counts = held(mask, line, t + shift, cols) ? (sure_vec)0 : counts;
                            most = LARGER(most, v, counts);
                            continue;
                        }
                        if (task == TASK_STEP) {
                            const vec k = total - state;
                            vec sum = stage ? *(__global const vec *)(sums + here + t) : SUM_BEGINS;
                            sum += weight * k;
                            v = SUM_ENDS(sum);
                            if (!last) {
                                store_part(sums + here + t, sum, free, spare);
                                __global const real *next = table + stage * count;
                                vec lead = SUM_BEGINS;
                                for (int s = 0; keeps && s < stage; s++)
                                    lead += next[s] * *(__global const vec *)(rates + s * size + here + t);
                                if (keeps) store_part(rates + stage * size + here + t, k, free, spare);
                                lead += next[stage] * k;
                                v = SUM_ENDS(lead);
                            }
                        }
                        if (task == TASK_DISCRETE) v = OUTPUT_OF_DRIVE(total, start);
                        if (limited && task != TASK_DRIVE) v = CLIP(vec, v);
                        if (has_mask && task != TASK_DRIVE) v = held(mask, line, t + shift, cols) ? start : v;
                        if (task == TASK_DISCRETE && before) {
                            const vec old = *whole(before + cell + t, spare, m);
                            most = LARGER(most, v - start, lanes_below(m));
                            other |= (v != old) & lanes_below(m);
                        }
                        if (!last) store_part(states + here + t, v, free, spare);
                        else if (!ends) *(__global vec *)(starts + here + t) = v;
                        else store_part(out + cell + t, v, m, spare);
                    }
                }
                PHASE
            }
        }
    }
    found all_lanes = {0, 0};
#if V > 1
    for (int q = 0; q < V; q++) {
        all_lanes.largest = max(all_lanes.largest, most[q]);
        all_lanes.differs = other[q] ? 1 : all_lanes.differs;
    }
#else
    all_lanes.largest = most;
    all_lanes.differs = other;
#endif
    return all_lanes;
}

// A kernel for each: what a task has not is then no loop's business, and compilers take half of the time.
#define PLAIN(name, task, kept)                                                                          \
    KERNEL void name(PARAMETERS) { stages(task, kept, GIVEN); }
#define MEASURED(name, task)                                                                             \
    KERNEL void name(PARAMETERS)                                                                         \
    {                                                                                                    \
        const found seen = stages(task, 0, GIVEN);                                                       \
        HAND_IN_PAIR(partial, seen.largest, seen.differs)                                                \
    }
KERNELS
