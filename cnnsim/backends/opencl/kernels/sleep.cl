// Which tiles may be left out of a launch of steps, and which need not look at their neighbours more than once.
//
// A cell is saturated for good if |x| >= 1 and its drive d = A*y + w pulls it outwards: while its neighbours' outputs
// stay, so does its own, to the bit (see cnnsim/backends/cpu/tiles/settled.py). A launch notes where cells were not,
// before its last step. What these change travels RADIUS cells a step, so a tile that has none within as many cells as the
// longest launch reads keeps all its drives: it coasts, each cell towards its own drive. If a launch in which it
// coasted changed no bit in it, the next one does not either, and it is asleep: since launches write to two planes by
// turns, the plane that this one writes to has these very states already.

// `least`: what a tile does at least in a launch; none is asleep in one of another length than the launch before.
enum { ASLEEP, COASTING, AWAKE };

#ifdef SLEEP
#define SLEEP_ARGUMENTS , __global uchar *moved, __global uchar *moves, int least // AWAKE: step all tiles
#else
#define SLEEP_ARGUMENTS
#endif

enum { MOVED = 1, ANYWHERE = 2, NORTH = 4, SOUTH = 8, WEST = 16, EAST = 32 };

// Numbers up to which 1 - x is exact: with the drive beyond 1 no rounding brings the state back inside.
#define FAR 16777216
// NaN is neither: of two numbers of which one is NaN, LESS is the second, MORE the first.
#define LESS(s, d) (s < d ? s : d)
#define MORE(s, d) (d > s ? d : s)
#define SATURATED(type, s, d)                                                                          \
    (((LESS(s, d) >= (type)1) & (MORE(s, d) <= (type)FAR))                                             \
     | ((MORE(s, d) <= (type)-1) & (LESS(s, d) >= (type)-FAR)))

// A masked cell stays too.
#define HELD(type, s, d, gain) \
    ((gain == (type)0) & (s <= (type)FAR) & (s >= (type)-FAR) & (d <= (type)FAR) & (d >= (type)-FAR))

// Where row or column i of n lies, if a cell in it is not saturated: `reach` cells beyond the sides read it.
static inline int place_of(int i, int n, int reach, int before, int after)
{
    return ANYWHERE | (i < reach ? before : 0) | (i >= n - reach ? after : 0);
}

// What a tile does in this launch, with the tiles that are at most so many beyond or beside it; if these are more than
// its neighbours, because tiles are narrower than what a launch reads, all their cells count.
static inline int turn_of(__global const uchar *moved, int tile, int across, int down, int beyond, int beside,
                          int least)
{
    if (least == AWAKE) return AWAKE;
    const int p = tile % across, q = tile / across % down;
    __global const uchar *grid = moved + (tile - q * across - p);
    for (int k = -beyond; k <= beyond; k++)
        for (int l = -beside; l <= beside; l++) {
            int i = q + k, j = p + l;
#if BOUNDARY == BOUNDARY_PERIODIC
            i = wrap(i, down), j = wrap(j, across);
#else
            if (i < 0 || i >= down || j < 0 || j >= across) continue;
#endif
            const int there = grid[i * across + j] & ~MOVED;
            const int rows = k == 0 || beyond > 1 ? ANYWHERE : k < 0 ? SOUTH : NORTH;
            const int cols = l == 0 || beside > 1 ? ANYWHERE : l < 0 ? EAST : WEST;
            if ((there & rows) && (there & cols)) return AWAKE;
        }
    return moved[tile] & MOVED ? COASTING : least;
}

// How many tiles count on each side of one, where so many of this length make a line of so many cells.
static inline int counted(int cells, int tiles, int length, int reach)
{
    const int last_is_narrow = BOUNDARY == BOUNDARY_PERIODIC && cells - (tiles - 1) * length < reach;
    return (reach + length - 1) / length + last_is_narrow;
}
