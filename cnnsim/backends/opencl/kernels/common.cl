// The number type, vectors, the clipped output, and which work-item does which cells: the beginning of every program.
//
// The host defines REAL (float or double), V (numbers in a vector), CPU where a work-item is a core's share of work,
// and the codes of cnnsim/backends/codes.py: BOUNDARY_..., TASK_..., FUNCTION_..., NOTHING.

#ifdef DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL FP_CONTRACT OFF // every product rounded, as in the reference: the same bits
typedef long sure; // what comparing two vectors gives
#else
typedef int sure;
#endif

typedef REAL real;
#if V > 1
// Not OpenCL's own float16: one that may lie anywhere, so that a plain dereference loads it.
typedef real vec __attribute__((ext_vector_type(V), aligned(sizeof(real))));
typedef sure sure_vec __attribute__((ext_vector_type(V)));
#else
typedef real vec;
typedef int sure_vec;
#endif
typedef int sure_real;

// A number's bits, or those of a vector's numbers.
#ifdef DOUBLE
#define BITS_real(x) as_long(x)
#else
#define BITS_real(x) as_int(x)
#endif
#define BITS_vec(x) __builtin_astype(x, sure_vec)

// The output characteristic; NaN stays NaN. (OpenCL's clamp need not keep it, and is slow in some PoCL builds.) One bound
// after the other: compilers see a maximum and a minimum then, two instructions, and make four of one choice in another.
#define CLIP(type, x) clip_##type(x)
#define CLIP_OF(type)                               \
    static inline type clip_##type(type x)          \
    {                                               \
        const type v = x < (type)-1 ? (type)-1 : x; \
        return v > (type)1 ? (type)1 : v;           \
    }
CLIP_OF(real)
#if V > 1
CLIP_OF(vec)
#else
#define clip_vec clip_real
#endif

#ifdef CPU
#define KERNEL __attribute__((reqd_work_group_size(1, 1, 1))) __kernel
// Work-item p of n does one stretch of the cells 0 .. count - 1.
#define SHARE(count, p, n) ((long)(count) * (p) / (n))
#define EACH(i, count)                                                                          \
    for (long i = SHARE(count, get_global_id(0), get_global_size(0)),                           \
              i##_stop = SHARE(count, get_global_id(0) + 1, get_global_size(0)); i < i##_stop; i++)
// Its part of a sum goes out as it is; the host adds up the few there are.
#define HAND_IN(type, partial, total) partial[get_global_id(0)] = total;
#else
#define KERNEL __attribute__((reqd_work_group_size(GROUP, 1, 1))) __kernel
#define EACH(i, count) for (long i = get_global_id(0); i < (long)(count); i += get_global_size(0))
// The parts of a work-group of GROUP are added up first.
#define HAND_IN(type, partial, total)                                                           \
    __local type parts[GROUP];                                                                  \
    parts[get_local_id(0)] = total;                                                             \
    for (int half_way = GROUP / 2; half_way; half_way /= 2) {                                   \
        barrier(CLK_LOCAL_MEM_FENCE);                                                           \
        if (get_local_id(0) < half_way) parts[get_local_id(0)] += parts[get_local_id(0) + half_way]; \
    }                                                                                           \
    if (get_local_id(0) == 0) partial[get_group_id(0)] = parts[0];
#endif

// The same for the largest of some numbers, and whether one of some flags is set: two numbers a part.
#ifdef CPU
#define HAND_IN_PAIR(partial, largest, flag)                                                    \
    partial[2 * get_global_id(0)] = largest;                                                    \
    partial[2 * get_global_id(0) + 1] = flag;
#else
#define HAND_IN_PAIR(partial, largest, flag)                                                    \
    __local real most[GROUP], flags[GROUP];                                                     \
    const int me = get_local_id(0);                                                             \
    most[me] = largest;                                                                         \
    flags[me] = flag;                                                                           \
    for (int half_way = GROUP / 2; half_way; half_way /= 2) {                                   \
        barrier(CLK_LOCAL_MEM_FENCE);                                                           \
        if (me < half_way) {                                                                    \
            const real other = most[me + half_way];                                             \
            most[me] = (other > most[me]) | (other != other) ? other : most[me]; /* NaN stays */ \
            flags[me] = flags[me] + flags[me + half_way] > 0;                                   \
        }                                                                                       \
    }                                                                                           \
    if (me == 0) {                                                                              \
        partial[2 * get_group_id(0)] = most[0];                                                 \
        partial[2 * get_group_id(0) + 1] = flags[0];                                            \
    }
#endif

// Whether a cell of an LLM plane is black; a row of `cols` cells begins a new 64-bit word.
static inline int black(__global const ulong *plane, long line, int j, int cols)
{
    return plane[line * ((cols + 63) / 64) + j / 64] >> (j % 64) & 1;
}
