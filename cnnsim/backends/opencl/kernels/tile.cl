// Where a tile of stages.cl lies, and the channels that it works in. Comes after boundary.cl and taps.cl or terms.cl,
// which say what an output is.

#ifdef CPU
#define ONE_BY_ONE _Pragma("clang loop unroll(disable) vectorize(disable)") // seldom: not worth what compiling takes
#else
#define ONE_BY_ONE
#endif

// The m numbers at `from` as the beginning of a whole vector; where there are fewer than V they go to `spare`.
static inline __global const vec *whole(__global const real *from, __global real *spare, int m)
{
    if (m >= V) return (__global const vec *)from;
    ONE_BY_ONE
    for (int q = 0; q < m; q++) spare[q] = from[q];
    return (__global const vec *)spare;
}

// Write the first m numbers of a vector.
static inline void store_part(__global real *to, vec v, int m, __global real *spare)
{
    if (m >= V) {
        *(__global vec *)to = v;
        return;
    }
    *(__global vec *)spare = v;
    ONE_BY_ONE
    for (int q = 0; q < m; q++) to[q] = spare[q];
}

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
// Each stretch of places in rows r0 .. r1 - 1 and columns t0 .. t1 - 1 of a tile that lie side by side in the grid:
// columns `begin` .. `stop` - 1 of row `i`; column t of the tile is column t + shift of the grid.
#define EACH_STRETCH(r0, r1, t0, t1)                                                                     \
    for (int i = r0; i < (r1); i++)                                                                      \
        for (int begin = t0, stop, shift;                                                                \
             begin < (t1) && (shift = grid_column(&at, begin) - begin, stop = min(t1, at.cols - shift), 1); begin = stop)
#else
#define EACH_TILE(tile, count) for (long tile = get_group_id(0); tile < (long)(count); tile += get_num_groups(0))
#define WORKER get_group_id(0)
#define PHASE barrier(CLK_GLOBAL_MEM_FENCE);
#define EACH_STRETCH(r0, r1, t0, t1)                                                                     \
    for (int place = get_local_id(0), across = max(1, (t1) - (t0)), i = 0, begin = 0, stop = 0, shift = 0; \
         place < ((r1) - (r0)) * ((t1) - (t0))                                                           \
         && (i = (r0) + place / across, begin = (t0) + place % across, stop = begin + 1,                 \
             shift = grid_column(&at, begin) - begin, 1);                                                \
         place += GROUP)
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

// Fill a channel's rows r0 .. r1 - 1 with a layer of a plane, or of the tile's own `states` if there is no plane. Rows
// have room behind them for a whole vector.
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
            ONE_BY_ONE
            for (int t = -radius; t < n + radius; t++) to[t] = outside;
            continue;
        }
        EACH_STRETCH(line, line + 1, 0, n)
        {
            __global const real *from = plane ? plane + line_of(&at, layer, p) * at.cols + shift
                                              : states + (layer * at.tall + p - at.top) * at.stride;
            for (int t = begin; t < stop; t += V) {
                const vec v = *whole(from + t, to + t, plane ? stop - t : V);
                *(__global vec *)(to + t) = output ? output_of_vec(v) : v;
            }
        }
        for (int t = 0; beyond && t < n; t++) to[t] = virtual_value(to[t]);
        ONE_BY_ONE
        for (int q = 1; q <= radius; q++) { // beside a cut there is nothing; let it be numbers
            const int west = cell_at(-q, at.cols), east = cell_at(at.cols + q - 1, at.cols);
            to[-q] = !west_rim ? 0 : west == NOTHING ? outside : virtual_value(to[west - at.left]);
            to[n + q - 1] = !east_rim ? 0 : east == NOTHING ? outside : virtual_value(to[east - at.left]);
        }
    }
#else
    const int whole_row = n + 2 * radius;
    for (int place = get_local_id(0); place < (r1 - r0) * whole_row; place += GROUP) {
        const int i = r0 + place / whole_row, t = place % whole_row - radius;
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

// What channels are filled with, in FILLS: the state, or a plane; inputs are there from the first time on.
#define FILL(number, plane, layer, output, outside)                                                      \
    fill_channel(channels + number * all, plane, stage ? states : starts, layer, output, outside,        \
                 row == from ? row - radius : row + radius, until + radius, at);
#define FILL_STATE(number, layer, output) FILL(number, stage || kept ? 0 : x, layer, output, outside_y)
#define FILL_PLANE(number, layer, output, plane) FILL(number, plane, layer, output, outside_y)
#define FILL_INPUT(number, layer, plane)                                                                 \
    if (stage == 0 && round == 0) FILL(number, plane, layer, 0, outside_u)
