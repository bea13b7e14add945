// A step of all stages, or another task with the drives of cells, tile by tile. Comes after boundary.cl and taps.cl or
// terms.cl, which say what adds to a drive.
//
// Planes are (n, layers, rows, cols). A tile is `high` rows and `wide` columns of one grid, with all its layers. Its
// work-item, or on a GPU its work-group, goes through the stages one by one: it fills the channels, which are what
// neighbours are looked at in, and from these it finds the states of the next stage. What it works in lies in `scratch`,
// a part for each work-item that stays in its cache, so that of a whole grid no plane is made but the end of the step.
//
// For S stages a tile is computed with S * radius cells more around it, of which each stage spoils `radius`. Where the
// grid ends it ends too, and has its virtual cells set anew for each stage; on a torus that is cut it rolls on.
//
// The host writes FILLS_n (channel_text.py): how the channels of part n are filled.

typedef struct {
    int rows, cols, layers, radius, stride, tall; // tall: the most rows of a tile with what lies around it
    int top, bottom, left, width;                 // the rows and columns of the grid in the tile; right of it nothing
    int rolls_down, rolls_across;
    long grid;
} tile_place;

#ifdef CPU
#define EACH_TILE(tile, count) EACH(tile, count)
#define WORKER get_global_id(0)
#define PHASE
// Each place in rows r0 .. r1 - 1 and columns t0 .. t1 - 1 of a tile, or each vector of which `m` or more are in it:
// row `i` of the grid, column `t` of the tile, which is column `g` of the grid.
#define EACH_PLACE(r0, r1, t0, t1)                                                                       \
    for (int i = r0; i < r1; i++)                                                                        \
        for (int t = t0, stop, g; t < t1; t = stop)                                                      \
            for (g = grid_column(&at, t), stop = min(t1, t + at.cols - g); t < stop; t += V, g += V)
#define LEFT_OVER (stop - t)
#else
#define EACH_TILE(tile, count) for (long tile = get_group_id(0); tile < (long)(count); tile += get_num_groups(0))
#define WORKER get_group_id(0)
#define PHASE barrier(CLK_GLOBAL_MEM_FENCE);
#define EACH_PLACE(r0, r1, t0, t1)                                                                       \
    for (int place = get_local_id(0), across = max(1, (t1) - (t0)), i = 0, t = 0, g = 0;                 \
         place < ((r1) - (r0)) * ((t1) - (t0))                                                           \
         && (i = (r0) + place / across, t = (t0) + place % across, g = grid_column(&at, t), 1);          \
         place += GROUP)
#define LEFT_OVER 1
#endif

static inline int grid_row(const tile_place *at, int i) { return at->rolls_down ? wrap(i, at->rows) : i; }

static inline int grid_column(const tile_place *at, int t)
{
    return at->rolls_across ? wrap(at->left + t, at->cols) : at->left + t;
}

// Where a line of one layer of the tile's grid begins.
static inline long line_of(const tile_place *at, int layer, int i)
{
    return (at->grid * at->layers + layer) * at->rows + grid_row(at, i);
}

// Fill a channel's rows r0 .. r1 - 1 with a layer of a plane, or of the tile's own `states` if there is no plane.
static inline void fill_channel(__global real *channel, __global const real *plane, __global const real *states,
                                int layer, int output, real outside, int r0, int r1, tile_place at)
{
    const int radius = at.radius, n = at.width;
    const int west_rim = !at.rolls_across && at.left == 0, east_rim = !at.rolls_across && at.left + n == at.cols;
#ifdef CPU
    for (int line = r0; line < r1; line++) {
        __global real *to = channel + (line - at.top + radius) * at.stride;
        const int beyond = line < at.top || line >= at.bottom, p = beyond ? cell_at(line, at.rows) : line;
        if (beyond && p == NOTHING) {
            for (int t = -radius; t < n + radius; t++) to[t] = outside;
            continue;
        }
        __global const real *from = plane ? plane + line_of(&at, layer, p) * at.cols
                                          : states + (layer * at.tall + p - at.top) * at.stride;
        EACH_PLACE(line, line + 1, 0, n)
        {
            const vec v = load_part(from + (plane ? g : t), LEFT_OVER);
            store_part(to + t, output ? output_of_vec(v) : v, LEFT_OVER);
        }
        for (int t = 0; beyond && t < n; t++) to[t] = virtual_value(to[t]);
        for (int q = 1; q <= radius; q++) { // beside a cut there is nothing; let it be numbers
            const int west = cell_at(-q, at.cols), east = cell_at(at.cols + q - 1, at.cols);
            to[-q] = !west_rim ? 0 : west == NOTHING ? outside : virtual_value(to[west - at.left]);
            to[n + q - 1] = !east_rim ? 0 : east == NOTHING ? outside : virtual_value(to[east - at.left]);
        }
    }
#else
    const int whole = n + 2 * radius;
    for (int place = get_local_id(0); place < (r1 - r0) * whole; place += GROUP) {
        const int i = r0 + place / whole, t = place % whole - radius;
        const int beyond = i < at.top || i >= at.bottom, p = beyond ? cell_at(i, at.rows) : i;
        const int beside = t < 0 || t >= n, rim = t < 0 ? west_rim : east_rim;
        const int c = beside && rim ? cell_at(at.left + t, at.cols) : 0, s = beside ? c - at.left : t;
        real v = beside && !rim ? 0 : outside;
        if (!(beyond && p == NOTHING) && !(beside && (!rim || c == NOTHING))) {
            v = plane ? plane[line_of(&at, layer, p) * at.cols + grid_column(&at, s)]
                      : states[(layer * at.tall + p - at.top) * at.stride + s];
            v = output ? output_of(v) : v;
            v = beyond ? virtual_value(v) : v;
            v = beside ? virtual_value(v) : v;
        }
        channel[(i - at.top + radius) * at.stride + t] = v;
    }
#endif
}

static inline vec keep(vec v, vec old, __global const ulong *mask, long line, int j, int m, int cols)
{
    real lanes[V], before[V];
    *(vec *)lanes = v;
    *(vec *)before = old;
    for (int q = 0; q < V && q < m; q++)
        if (black(mask, line, j + q, cols)) lanes[q] = before[q];
    return *(const vec *)lanes;
}

// What channels are filled with, in FILLS_n: the state of the stage, or a plane; inputs are there from the first on.
#define FILL_STATE(number, layer, output)                                                                \
    fill_channel(channels + number * all, stage ? 0 : x, states, layer, output, outside_y, from - radius,  \
                 to + radius, at);
#define FILL_PLANE(number, layer, output, plane)                                                         \
    fill_channel(channels + number * all, plane, states, layer, output, outside_y, from - radius, to + radius, at);
#define FILL_INPUT(number, layer, plane)                                                                 \
    if (stage == 0)                                                                                      \
        fill_channel(channels + number * all, plane, states, layer, 0, outside_u, from - radius, to + radius, at);

#define FINISH(v)                                                                                        \
    if (limited) v = CLIP(vec, v);                                                                       \
    if (has_mask) v = keep(v, start, mask, line, g, LEFT_OVER, cols);

// Tasks with the drive of each cell, w plus what `part` adds:
//
//     DRIVE     out = z + drive, where w is the bias, if there is one
//     STEP      k_s = drive of y_s - y_s,  y_s = x + gain (a_s0 k_0 + ...),  out = x + gain (b_0 k_0 + b_1 k_1 + ...)
//     DISCRETE  out = f(drive), where a sign of 0 is the old one
//     CHECK     the largest |k_0| over the layer's time constant
//
// `of_layer` is z of each layer, or 1 over its time constant. In the full-range cell every stage and step is limited; a
// masked cell keeps x. `table` has a_1, a_2, ..., nothing and
// b, each with `stages` numbers; with `keeps` stages ask for other rates than the last one. Bit s of `ahead`: stage s
// looks at what is at the end of the step. `partial` gets two numbers of each worker: the largest rate, or change, and 1
// if what DISCRETE writes differs from `before`, which may be `out`; without that
// nobody asks.
KERNEL void stages(__global const real *x, __global const real *w, __global const ulong *mask, __global real *out,
                   __global const real *before, __global real *scratch, __global real *partial, __global const real *table,
                   __global const real *gains, __global const real *of_layer, int task, int part, int count_of_stages,
                   int keeps, int ahead, int has_mask, int limited, real outside_u, real outside_y, int layers,
                   int rows, int cols, int radius, int stride, int high, int wide, int down, int across, int tall,
                   int count_of_channels, long share, long first, long tiles SOURCES DRIVE_ARGUMENTS)
{
    const int reach = count_of_stages * radius;
    const long all = (long)(tall + 2 * radius) * stride, size = (long)layers * tall * stride;
    __global real *const channels = scratch + WORKER * share + PAD;
    __global real *const states = channels + count_of_channels * all, *const sums = states + size;
    __global real *const rates = sums + size;
    real largest = 0, differs = 0;
    EACH_TILE(each, tiles)
    {
        const long tile = first + each;
        const int r0 = tile / across % down * high, r1 = min(rows, r0 + high);
        const int c0 = tile % across * wide, c1 = min(cols, c0 + wide);
        tile_place at = {rows, cols, layers, radius, stride, tall};
        at.grid = tile / across / down;
        at.rolls_down = BOUNDARY == BOUNDARY_PERIODIC && down > 1;
        at.rolls_across = BOUNDARY == BOUNDARY_PERIODIC && across > 1;
        at.top = at.rolls_down ? r0 - reach : max(0, r0 - reach);
        at.bottom = at.rolls_down ? r1 + reach : min(rows, r1 + reach);
        at.left = at.rolls_across ? c0 - reach : max(0, c0 - reach);
        at.width = (at.rolls_across ? c1 + reach : min(cols, c1 + reach)) - at.left;
        for (int stage = 0; stage < count_of_stages; stage++) {
            const int last = stage + 1 == count_of_stages, margin = (count_of_stages - 1 - stage) * radius;
            const int from = max(at.top, r0 - margin), to = min(at.bottom, r1 + margin);
            const int t0 = last ? c0 - at.left : 0, t1 = last ? c1 - at.left : at.width;
            FILLS
            PHASE
            for (int layer = 0; layer < layers; layer++) {
                const real gain = gains[layer], weight = table[count_of_stages * count_of_stages + stage];
                __global const real *next = table + stage * count_of_stages;
                EACH_PLACE(from, to, t0, t1)
                {
                    const long line = line_of(&at, layer, i), cell = line * cols + g;
                    const long here = (layer * tall + i - at.top) * stride + t;
                    __global const real *own = channels + (i - at.top + radius) * stride;
                    vec total = w ? load_part(w + cell, LEFT_OVER) : (vec)0;
                    if (TASK == TASK_DRIVE) total += (vec)of_layer[layer];
                    ADD_NEIGHBOURS
                    if (TASK == TASK_DRIVE) {
                        store_part(out + cell, total, LEFT_OVER);
                        continue;
                    }
                    const vec start = load_part(x + cell, LEFT_OVER);
                    if (TASK == TASK_STEP) {
                        const vec k = total - (stage ? *(__global const vec *)(states + here) : start);
                        vec sum = stage ? *(__global const vec *)(sums + here) : SUM_BEGINS;
                        sum += weight * k;
                        if (last) {
                            vec v = SUM_ENDS(sum);
                            FINISH(v)
                            store_part(out + cell, v, LEFT_OVER);
                            continue;
                        }
                        store_part(sums + here, sum, LEFT_OVER);
                        vec lead = SUM_BEGINS;
                        for (int s = 0; keeps && s < stage; s++)
                            lead += next[s] * *(__global const vec *)(rates + s * size + here);
                        if (keeps) store_part(rates + stage * size + here, k, LEFT_OVER);
                        lead += next[stage] * k;
                        vec v = SUM_ENDS(lead);
                        FINISH(v)
                        store_part(states + here, v, LEFT_OVER);
                    }
#ifdef CHARACTERISTIC
                    if (TASK == TASK_CHECK) {
                        real lanes[V], old[V];
                        *(vec *)lanes = total - start;
                        *(vec *)old = start;
                        for (int q = 0; q < min(V, LEFT_OVER); q++) {
                            const real v = lanes[q] * of_layer[layer];
                            const int against = limited && ((old[q] >= 1 && v > 0) || (old[q] <= -1 && v < 0));
                            const int held = has_mask && black(mask, line, g + q, cols);
                            if (!against && !held) largest = max(largest, fabs(v));
                        }
                    }
                    if (TASK == TASK_DISCRETE) {
                        const int sign = CHARACTERISTIC == FUNCTION_SIGN;
                        vec v = sign ? (total == (vec)0 ? start : output_of_vec(total)) : output_of_vec(total);
                        if (has_mask) v = keep(v, start, mask, line, g, LEFT_OVER, cols);
                        if (before) {
                            real lanes[V], old[V];
                            *(vec *)lanes = v;
                            *(vec *)old = start;
                            for (int q = 0; q < min(V, LEFT_OVER); q++) {
                                largest = max(largest, fabs(lanes[q] - old[q]));
                                differs = lanes[q] == before[cell + q] ? differs : 1;
                            }
                        }
                        store_part(out + cell, v, LEFT_OVER);
                    }
#endif
                }
            }
            PHASE
        }
    }
    HAND_IN_PAIR(partial, largest, differs)
}
