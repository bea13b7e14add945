// What neighbours add to the drives of layers: terms of any kind, see cnnsim/backends/term_table.py. Comes before network.cl.
//
// The host writes CASES(DO), TERMS_n, OUTPUT, TABLES and CHARACTERISTIC, the characteristic's code (term_text.py).

TABLES

#ifdef DOUBLE
static inline vec tanh_of(vec p)
{
#if V > 1
    for (int q = 0; q < V; q++) p[q] = tanh(p[q]);
    return p;
#else
    return tanh(p);
#endif
}
#else
// Within 2e-7: Lambert's fraction at a quarter of the argument, doubled twice; from 9.2 on tanh is 1.
static inline vec tanh_of(vec v)
{
    vec p = v > (vec)9.2f ? (vec)9.2f : v;
    p = (p < (vec)-9.2f ? (vec)-9.2f : p) * 0.25f;
    const vec q = p * p;
    vec t = p * (((q + 378.0f) * q + 17325.0f) * q + 135135.0f)
            / (((28.0f * q + 3150.0f) * q + 62370.0f) * q + 135135.0f);
    t = (t + t) / (1.0f + t * t);
    t = (t + t) / (1.0f + t * t);
    return CLIP(vec, t);
}
#endif

static inline vec output_of(vec v)
{
    vec f = v;
    OUTPUT
    return f;
}

// A quantity at an offset, some steps ago, of a layer; and a plane of weights.
#define PAST_AT(ago) ((ago) ? (now + (AHEAD >> stage & 1) - (ago) + PAST) % PAST * size : now_at)
#define OF_LAYER(number, k, l) (base + (number) * layer_size + t + (k) * stride + (l))
#define READ_x(ago, number, k, l) AT(const vec, x + PAST_AT(ago) + OF_LAYER(number, k, l))
#define READ_y(ago, number, k, l) AT(const vec, y + PAST_AT(ago) + OF_LAYER(number, k, l))
#define READ_u(plane, number, k, l) AT(const vec, u + (plane) * size + OF_LAYER(number, k, l))
#define WEIGHT(plane) AT(const vec, weights + ((plane) * (long)rows + i) * cols + t)

#define CASE(number)                                                                            \
    case number: {                                                                              \
        TERMS_##number                                                                          \
        break;                                                                                  \
    }

#define NEIGHBOUR_PARAMETERS , __global const real *weights
#define NEIGHBOUR_ARGUMENTS , weights
#define ADD_NEIGHBOURS switch (layer) { CASES(CASE) }
#define OUTPUT_OF_DRIVE(total, start)                                                           \
    CHARACTERISTIC == FUNCTION_SIGN ? (total == (vec)0 ? start : output_of(total)) : output_of(total)
#define SUM_BEGINS (vec)0
#define SUM_ENDS(sum) start + gain * sum
