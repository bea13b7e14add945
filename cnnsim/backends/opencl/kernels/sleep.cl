// Sleeping tiles: which tiles need no steps in a launch, and which only steps with constant drives.
//
// A cell is saturated for good if |x| >= 1 and its drive d = A*y + w pulls it outwards: while its neighbours' outputs
// stay, so does its own, to the bit. A launch marks a tile LOOSE if another cell was in it before the last step, and NORTH
// .. EAST if one was in the cells at that side that its neighbours read in a launch. Tiles are at least as long as that, so
// where neither a tile is LOOSE nor those around it at the sides that it reads all its drives are constant: it is COASTING, each cell towards its own drive. If a launch in which it
// coasted changed no bit (MOVED is not set), neither will the next one: it is ASLEEP. The launches write to two planes
// alternately, and the plane that this launch writes to has the same states already.

enum { ASLEEP, COASTING, AWAKE }; // as in linear_steps.py
enum { MOVED = 1, LOOSE = 2, NORTH = 4, SOUTH = 8, WEST = 16, EAST = 32 };

// Numbers up to which 1 - x is exact: with the drive beyond 1 no rounding brings the state back inside.
#define EXACT 16777216
// NaN is neither: of two numbers of which one is NaN, LESS is the second, MORE the first.
#define LESS(s, d) (s < d ? s : d)
#define MORE(s, d) (d > s ? d : s)
#define SATURATED(s, d)                                                \
    (((LESS(s, d) >= (vec)1) & (MORE(s, d) <= (vec)EXACT))             \
     | ((MORE(s, d) <= (vec)-1) & (LESS(s, d) >= (vec)-EXACT)))
// A masked cell stays as well.
#define HELD(s, d, gain)                                               \
    ((gain == (vec)0) & (s <= (vec)EXACT) & (s >= (vec)-EXACT) & (d <= (vec)EXACT) & (d >= (vec)-EXACT))

// What a tile does in a launch, at least `least`; depends on `beyond` tiles above and below, `beside` left and right.
static inline int turn_of(__global const uchar *moved, int tile, int across, int down, int beyond, int beside, int least)
{
    if (least == AWAKE) return AWAKE;
    const int p = tile % across, q = tile / across % down;
    __global const uchar *grid = moved + (tile - q * across - p);
    for (int k = q - beyond; k <= q + beyond; k++)
        for (int l = p - beside; l <= p + beside; l++) {
            const int i = BOUNDARY == BOUNDARY_PERIODIC ? wrap(k, down) : k;
            const int j = BOUNDARY == BOUNDARY_PERIODIC ? wrap(l, across) : l;
            if (i < 0 || i >= down || j < 0 || j >= across) continue;
            const int rows = k == q || beyond > 1 ? LOOSE : k < q ? SOUTH : NORTH;
            const int cols = l == p || beside > 1 ? LOOSE : l < p ? EAST : WEST;
            if ((grid[i * across + j] & rows) && (grid[i * across + j] & cols)) return AWAKE;
        }
    return moved[tile] & MOVED ? COASTING : least;
}
