// Which tiles may be left out of a launch of steps.
//
// A tile is asleep if in the last launch, of as many steps, no bit changed in it nor in those cells around it that a
// launch reads. Then none changes now either; and since launches write to two planes by turns, the plane that this one
// writes to has these very states already. Of each tile is kept where it changed: anywhere, and near each of its sides.

#ifdef SLEEP
#define SLEEP_ARGUMENTS , __global const uchar *moved, __global uchar *moves, int fresh // fresh: step all tiles
#else
#define SLEEP_ARGUMENTS
#endif

enum { ANYWHERE = 1, NORTH = 2, SOUTH = 4, WEST = 8, EAST = 16 };

// Where cell (i, j) of a tile of rows x cols lies, if it has changed; `reach` cells beyond its sides read it.
static inline int place_of(int i, int j, int rows, int cols, int reach)
{
    return ANYWHERE | (i < reach ? NORTH : 0) | (i >= rows - reach ? SOUTH : 0) | (j < reach ? WEST : 0)
           | (j >= cols - reach ? EAST : 0);
}

static inline int asleep(__global const uchar *moved, int tile, int across, int down)
{
    const int p = tile % across, q = tile / across % down;
    __global const uchar *grid = moved + (tile - q * across - p);
#if BOUNDARY == BOUNDARY_PERIODIC
    // the last tile of a row or column may be narrower than what a launch reads: two tiles count on each side
    for (int k = -2; k <= 2; k++)
        for (int l = -2; l <= 2; l++)
            if (grid[wrap(q + k, down) * across + wrap(p + l, across)]) return 0;
#else
    for (int k = -1; k <= 1; k++)
        for (int l = -1; l <= 1; l++) {
            const int i = q + k, j = p + l;
            if (i < 0 || i >= down || j < 0 || j >= across) continue;
            const int there = grid[i * across + j];
            if (k == 0 && l == 0 ? there : (k >= 0 || (there & SOUTH)) && (k <= 0 || (there & NORTH))
                                          && (l >= 0 || (there & EAST)) && (l <= 0 || (there & WEST)))
                return 0;
        }
#endif
    return 1;
}
