// What neighbours add to the drive of a linear template: the taps of A over the outputs. They are arguments: a build for
// each template would cost more than it saves. Comes before network.cl.

#define LAYERS 1
#define NEIGHBOUR_PARAMETERS , __global const int *offsets, __global const real *weights, int taps
#define NEIGHBOUR_ARGUMENTS , offsets, weights, taps
#define ADD_NEIGHBOURS                                                                          \
    for (int tap = 0; tap < taps; tap++) total += weights[tap] * AT(const vec, y + now_at + cell + offsets[tap]);
#define OUTPUT_OF_DRIVE(total, start) total

// Weights of rates have the gain in them, and states that lead on are added up from x.
#define SUM_BEGINS start
#define SUM_ENDS(sum) sum

static inline vec output_of(vec v) { return CLIP(vec, v); }
