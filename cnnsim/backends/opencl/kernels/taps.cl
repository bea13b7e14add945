// What neighbours add to the drive of a linear template: its taps over the outputs, which are the only channel. They are
// arguments: a build for each template would cost more than it saves. Comes before stages.cl.

#define SOURCES
#define DRIVE_ARGUMENTS , __global const int *offsets, __global const real *weights, int taps
#define ADD_NEIGHBOURS                                                                                   \
    for (int tap = 0; tap < taps; tap++)                                                                 \
        total += weights[tap] * *(__global const vec *)(own + t + offsets[tap]);
#define FILLS FILL_STATE(0, 0, 1)

// Weights of rates have the gain in them, and states that lead on are added up from x.
#define TASK TASK_STEP // alone
#define SUM_BEGINS start
#define SUM_ENDS(sum) sum

static inline real output_of(real v) { return CLIP(real, v); }
static inline vec output_of_vec(vec v) { return CLIP(vec, v); }
