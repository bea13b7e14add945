// ANDs (`conjunction`) and ORs of neighbours on LLM planes, 64 cells at a time; see `cnnsim.operations.bitwise`.
//
// A literal is (k, l, negated): the neighbour at (row + k, col + l). `outside` is what fixed virtual cells are. Comes
// after boundary.cl.

// One cell of a row, which may be a virtual one.
static inline ulong cell_of(__global const ulong *row, int j, int cols, int outside)
{
    const int q = cell_at(j, cols);
    if (q == NOTHING) return outside;
    return row[q / 64] >> (q % 64) & 1;
}

// The cells l to the right of those of word c; only the few virtual ones among them are looked at one by one.
static inline ulong shifted(__global const ulong *row, int c, int l, int words, int cols, int outside)
{
    ulong seen = row[c];
    if (l > 0) {
        seen = seen >> l | (c + 1 < words ? row[c + 1] << (64 - l) : 0);
        for (int j = cols; j < cols + l; j++) {
            const int bit = j - 64 * c - l;
            if (bit >= 0 && bit < 64) seen |= cell_of(row, j, cols, outside) << bit;
        }
    } else if (l < 0) {
        seen = seen << -l | (c > 0 ? row[c - 1] >> (64 + l) : 0);
        for (int j = l; c == 0 && j < 0; j++) seen |= cell_of(row, j, cols, outside) << (j - l);
    }
    return seen;
}

// What a rule makes of word c of row i.
static inline ulong word_at(__global const ulong *grid, __global const int *literals, int count, int conjunction,
                            int outside, int i, int c, int rows, int words, int cols)
{
    ulong result = conjunction ? ~(ulong)0 : 0;
    for (int n = 0; n < count; n++) {
        const int p = cell_at(i + literals[3 * n], rows);
        ulong seen = outside ? ~(ulong)0 : 0;
        if (p != NOTHING) seen = shifted(grid + (long)p * words, c, literals[3 * n + 1], words, cols, outside);
        if (literals[3 * n + 2]) seen = ~seen;
        result = conjunction ? result & seen : result | seen;
    }
    return result;
}

#ifdef CPU
#define MANY 8
typedef ulong ulongs __attribute__((ext_vector_type(MANY), aligned(8)));
#define WORDS(at) (*(__global const ulongs *)(at))

// The same for MANY words at `here` that have no virtual neighbours.
static inline ulongs words_at(__global const ulong *here, __global const int *literals, int count, int conjunction,
                              int words)
{
    ulongs result = conjunction ? ~(ulongs)0 : (ulongs)0;
    for (int n = 0; n < count; n++) {
        __global const ulong *at = here + (long)literals[3 * n] * words;
        const int l = literals[3 * n + 1];
        ulongs seen = WORDS(at);
        if (l > 0) seen = seen >> (ulong)l | WORDS(at + 1) << (ulong)(64 - l);
        if (l < 0) seen = seen << (ulong)-l | WORDS(at - 1) >> (ulong)(64 + l);
        if (literals[3 * n + 2]) seen = ~seen;
        result = conjunction ? result & seen : result | seen;
    }
    return result;
}
#endif

KERNEL void neighbourhood(__global const ulong *restrict plane, __global ulong *restrict out,
                          __global const int *literals, int count, int conjunction, int outside, int radius, long lines,
                          int rows, int cols)
{
    const int words = (cols + 63) / 64, rest = cols % 64;
    const ulong end = rest ? ((ulong)1 << rest) - 1 : ~(ulong)0;
#define ONE_WORD(c)                                                                                     \
    {                                                                                                   \
        const ulong word = word_at(grid, literals, count, conjunction, outside, i, c, rows, words, cols);     \
        to[c] = (c) == words - 1 ? word & end : word;                                                   \
    }
#ifdef CPU
    EACH(line, lines) {
        const int i = (int)(line % rows);
        __global const ulong *grid = plane + (line - i) * words;
        __global ulong *to = out + line * words;
        int c = 0;
        if (i >= radius && i < rows - radius && words >= MANY + 3) {
            ONE_WORD(0)
            for (c = 1; c < words - 2; c += MANY) { // the last ones once more, where the words are no multiple
                const int first = min(c, words - 2 - MANY);
                *(__global ulongs *)(to + first) =
                    words_at(grid + (long)i * words + first, literals, count, conjunction, words);
            }
            c = words - 2;
        }
        for (; c < words; c++) ONE_WORD(c)
    }
#else
    EACH(at, lines * words) {
        const int c = (int)(at % words), i = (int)(at / words % rows);
        __global const ulong *grid = plane + at - c - (long)i * words;
        __global ulong *to = out + at - c;
        ONE_WORD(c)
    }
#endif
}
