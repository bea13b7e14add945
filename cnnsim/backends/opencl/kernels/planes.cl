// Planes as a whole: the output characteristic, LAM to LLM and back, logic, counting, looking for NaN.
//
// A LAM plane is (lines, cols) numbers, lines = n * rows; an LLM plane (lines, words) 64-bit words, bit 1 for black,
// the bits behind the last column 0.

KERNEL void clipped(__global const real *restrict x, __global real *restrict y, long count)
{
    EACH(i, count) y[i] = CLIP(real, x[i]);
}

KERNEL void to_llm(__global const real *restrict x, __global ulong *restrict out, long lines, int cols)
{
    const int words = (cols + 63) / 64;
    EACH(i, lines * words) {
        const int from = (int)(i % words) * 64, cells = min(64, cols - from);
        __global const real *cell = x + i / words * cols + from;
        ulong word = 0;
        for (int j = 0; j < cells; j++) word |= (ulong)(cell[j] > 0) << j;
        out[i] = word;
    }
}

KERNEL void to_lam(__global const ulong *restrict p, __global real *restrict out, long lines, int cols)
{
    const int words = (cols + 63) / 64;
#ifdef CPU
    EACH(i, lines * words) {
        const int from = (int)(i % words) * 64, cells = min(64, cols - from);
        __global real *cell = out + i / words * cols + from;
        const ulong word = p[i];
        for (int j = 0; j < cells; j++) cell[j] = word >> j & 1 ? 1 : -1;
    }
#else
    EACH(i, lines * cols) out[i] = black(p, i / cols, (int)(i % cols), cols) ? 1 : -1;
#endif
}

// Bit 2p + q of `function` is the result for (p, q).
KERNEL void logic(__global const ulong *restrict p, __global const ulong *restrict q, __global ulong *restrict out,
                    int function, long lines, int cols)
{
    const int words = (cols + 63) / 64, rest = cols % 64;
    const ulong end = rest ? ((ulong)1 << rest) - 1 : ~(ulong)0;
    const ulong f0 = -(ulong)(function & 1), f1 = -(ulong)(function >> 1 & 1);
    const ulong f2 = -(ulong)(function >> 2 & 1), f3 = -(ulong)(function >> 3 & 1);
#define RESULT(a, b) ((~(a) & ((f0 & ~(b)) | (f1 & (b)))) | ((a) & ((f2 & ~(b)) | (f3 & (b)))))
#ifdef CPU
    EACH(line, lines) { // a division for each word would take longer than all else
        const long first = line * words;
        for (int c = 0; c < words; c++) out[first + c] = RESULT(p[first + c], q[first + c]);
        out[first + words - 1] &= end;
    }
#else
    EACH(i, lines * words) {
        const ulong word = RESULT(p[i], q[i]);
        out[i] = i % words == words - 1 ? word & end : word;
    }
#endif
}

// The black cells of all grids, counted in parts.
KERNEL void count_black(__global const ulong *restrict p, __global ulong *restrict partial, long words)
{
    ulong total = 0;
    EACH(i, words) total += popcount(p[i]);
    HAND_IN(ulong, partial, total)
}

// The black cells of each grid.
KERNEL void count_each(__global const ulong *restrict p, __global ulong *restrict totals, long grids, int words)
{
    EACH(grid, grids) {
        ulong total = 0;
        for (int i = 0; i < words; i++) total += popcount(p[grid * words + i]);
        totals[grid] = total;
    }
}

// 0 for each part with only finite numbers, else NaN: x * 0 is 0 exactly for finite x.
KERNEL void finite(__global const real *restrict x, __global real *restrict partial, long count)
{
    real total = 0;
#if V > 1
    const long first = SHARE(count, get_global_id(0), get_global_size(0));
    const long stop = SHARE(count, get_global_id(0) + 1, get_global_size(0));
    vec sum = (vec)0;
    long i = first;
    for (; i + V <= stop; i += V) sum += *(__global const vec *)(x + i) * (vec)0;
    for (int j = 0; j < V; j++) total += sum[j];
    for (; i < stop; i++) total += x[i] * 0;
#else
    EACH(i, count) total += x[i] * 0;
#endif
    HAND_IN(real, partial, total)
}
