// Planes into padded planes and back; see ghosts.cl.

KERNEL void pad(__global const real *from, __global real *to, long at, real outside, int radius, int stride, int rows,
                int cols, int lines)
{
    EACH_UNIT(unit, lines)
    EACH_PART(unit, unit + 1)
    {
        __global real *row = to + at + row_at(line, rows, stride, radius);
        for (int t = begin; t < end; t++) row[t] = from[(long)line * cols + t];
        spread(row, line % rows, begin, end, rows, cols, stride, radius, outside);
    }
}

KERNEL void unpad(__global const real *from, __global real *to, long at, int radius, int stride, int rows, int cols,
                  int lines)
{
    EACH_UNIT(unit, lines)
    EACH_PART(unit, unit + 1)
    {
        __global const real *row = from + at + row_at(line, rows, stride, radius);
        for (int t = begin; t < end; t++) to[(long)line * cols + t] = row[t];
    }
}
