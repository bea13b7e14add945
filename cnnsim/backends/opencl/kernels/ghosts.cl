// Padded planes: rows STRIDE apart that begin PAD numbers in, with RADIUS virtual cells ("ghosts") on each side. Comes after
// boundary.cl.
//
// Real cells lie in whole vectors: what lies behind the last column is computed along with it and never used.

#ifdef CPU
// A work-item takes its share of the units of `height` lines; parts of a line are the whole line.
#define EACH_UNIT(unit, units) EACH(unit, units)
#define EACH_PART(top, stop)                                                                    \
    for (int line = top, begin = 0, end = cols; line < (stop); line++)
#define PHASE
#else
// A work-group takes one unit after the other; parts of a line are its cells.
#define EACH_UNIT(unit, units) for (long unit = get_group_id(0); unit < (units); unit += get_num_groups(0))
#define EACH_PART(top, stop)                                                                    \
    for (int place = get_local_id(0), line, begin, end;                                         \
         place < ((stop) - (top)) * cols                                                        \
         && (line = (top) + place / cols, begin = place % cols, end = begin + 1, 1); place += GROUP)
#define PHASE barrier(CLK_GLOBAL_MEM_FENCE);
#endif

#define AT(type, place) (*(__global type *)(place))

// Where row i of a plane's line begins; `tall` rows a grid, the virtual ones included.
static inline long row_at(int line, int rows, int stride, int radius)
{
    return ((long)(line / rows) * (rows + 2 * radius) + line % rows + radius) * stride + PAD;
}

// The real row or column that writes place i of n.
static inline int writer_of(int i, int n) { return BOUNDARY == BOUNDARY_FIXED ? clamp_to(i, n) : cell_at(i, n); }

// Write columns begin .. end - 1 of row i, which lies at `row`, to the virtual cells that they write.
static inline void spread(__global real *row, int i, int begin, int end, int rows, int cols, int stride, int radius,
                          real outside)
{
    if (i >= radius && i < rows - radius && begin >= radius && end <= cols - radius) return;
    for (int r = 0; r <= 2 * radius; r++) { // the row itself and the virtual rows
        const int p = r == 0 ? i : r <= radius ? -r : rows + r - radius - 1;
        if (r && writer_of(p, rows) != i) continue;
        __global real *to = row + (long)(p - i) * stride;
        for (int t = begin; r && t < end; t++) to[t] = BOUNDARY == BOUNDARY_FIXED ? outside : row[t];
        for (int q = 0; q < 2 * radius; q++) {
            const int t = q < radius ? q - radius : cols + q - radius, from = writer_of(t, cols);
            if (from >= begin && from < end) to[t] = BOUNDARY == BOUNDARY_FIXED ? outside : row[from];
        }
    }
}
