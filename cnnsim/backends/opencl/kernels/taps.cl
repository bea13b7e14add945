// What neighbours add to the drive of a linear template: its taps over the outputs, which are the only channel. They are
// arguments: a build for each template would cost more than it saves. Comes before tile.cl.

#define LAYERS 1
#define SOURCES
#define SOURCES_GIVEN
#define DRIVE_ARGUMENTS , __global const int *offsets, __global const real *weights, int taps
#define DRIVE_GIVEN , offsets, weights, taps
#define ADD_NEIGHBOURS                                                                                   \
    for (int tap = 0; tap < taps; tap++)                                                                 \
        total += weights[tap] * *(__global const vec *)(own + t + offsets[tap]);
#define FILLS FILL_STATE(0, 0, 1)
#define OUTPUT_OF_DRIVE(total, start) total
#define KERNELS PLAIN(do_step, TASK_STEP, 0) PLAIN(do_steps, TASK_STEP, 1)

// Weights of rates have the gain in them, and states that lead on are added up from x.
#define SUM_BEGINS start
#define SUM_ENDS(sum) sum

static inline real output_of(real v) { return CLIP(real, v); }
static inline vec output_of_vec(vec v) { return CLIP(vec, v); }
