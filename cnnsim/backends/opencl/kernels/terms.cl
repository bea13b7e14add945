// What neighbours add to the drives of layers: terms of any kind over channels, see cnnsim/backends/term_table.py. Comes
// before tile.cl.
//
// The host writes the terms (term_text.py): CASES(DO), TERMS_n, OUTPUT(T), TABLES, and CHARACTERISTIC, the output
// characteristic's code; what the channels are filled from (channel_text.py): SOURCES, FILLS; and which KERNELS there are.

TABLES

#ifdef DOUBLE
#define TANH(T, f) { T p = f; f = TANH_OF_##T; }
#define TANH_OF_real tanh(p)
#if V > 1
static inline vec tanh_of_lanes(vec p)
{
    for (int q = 0; q < V; q++) p[q] = tanh(p[q]);
    return p;
}
#define TANH_OF_vec tanh_of_lanes(p)
#else
#define TANH_OF_vec tanh(p)
#endif
#else
// Within 2e-7: Lambert's fraction at a quarter of the argument, doubled twice; from 9.2 on tanh is 1.
#define TANH(T, f)                                                                              \
    {                                                                                           \
        T p = f > (T)9.2f ? (T)9.2f : f;                                                        \
        p = (p < (T)-9.2f ? (T)-9.2f : p) * 0.25f;                                              \
        const T q = p * p;                                                                      \
        T t = p * (((q + 378.0f) * q + 17325.0f) * q + 135135.0f)                               \
            / (((28.0f * q + 3150.0f) * q + 62370.0f) * q + 135135.0f);                         \
        t = (t + t) / (1.0f + t * t);                                                           \
        t = (t + t) / (1.0f + t * t);                                                           \
        f = CLIP(T, t);                                                                         \
    }
#endif

static inline real output_of(real v)
{
    real f = v;
    OUTPUT(real)
    return f;
}

#if V > 1
static inline vec output_of_vec(vec v)
{
    vec f = v;
    OUTPUT(vec)
    return f;
}
#else
#define output_of_vec output_of
#endif

#define NEIGHBOUR(channel, k, l) (*(__global const vec *)(own + (channel) * all + t + (k) * stride + (l)))
#define WEIGHT(plane) (*(__global const vec *)(weights + ((plane) * (long)rows + grid_row(&at, i)) * cols + t + shift))

#define CASE(number)                                                                            \
    case number: {                                                                              \
        TERMS_##number                                                                          \
        break;                                                                                  \
    }

#define DRIVE_ARGUMENTS , __global const real *weights
#define DRIVE_GIVEN , weights
#define ADD_NEIGHBOURS switch (bare ? NOTHING : layer) { CASES(CASE) }
#define OUTPUT_OF_DRIVE(total, start)                                                           \
    CHARACTERISTIC == FUNCTION_SIGN ? (total == (vec)0 ? start : output_of_vec(total)) : output_of_vec(total)
#define SUM_BEGINS (vec)0
#define SUM_ENDS(sum) start + gain * sum
