// What taxels feel of loads, one frame and taxel a step: `direct_numba` for loads at points, `disc_loops` for circles.

// Loads at points: rows (x, y, Q, R, F) in depths, their forces times the scale.
KERNEL void add_points(__global const real *at, __global const real *rows, __global real *out, const int taxels,
                       const int loads, const real trace, const long count)
{
    EACH(i, count)
    {
        const long n = i / taxels, k = i - n * taxels;
        real a = 0, b = 0, c = 0;
        __global const real *row = rows + n * loads * 5;
        for (int m = 0; m < loads; m++, row += 5) {
            const real x = at[2 * k] - row[0], y = at[2 * k + 1] - row[1];
            const real near = 1 / (1 + x * x + y * y);
            const real weight = (row[2] * x + row[3] * y + row[4]) * near * sqrt(near), along = -3 * weight * near;
            a += along * x;
            b += along * y;
            c += weight * trace + along;
        }
        out[3 * i] += a;
        out[3 * i + 1] += b;
        out[3 * i + 2] += c;
    }
}

static inline void shares(const real t, real *w)
{
    const real s = 1 - t;
    w[0] = s * s * s / 6;
    w[3] = t * t * t / 6;
    w[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    w[2] = 1 - w[0] - w[1] - w[3];
}

// Loads over circles: rows (x, y, Q, R, F, M, knot, 1 + (a/z)^2), forces divided by the last; a table of splines.
KERNEL void add_discs(__global const real *at, __global const real *rows, __global real *out, const int taxels,
                      const int loads, __global const real *table, const int radii, const int distances,
                      const real per_rho, const real ends, const int endless, const real factor, const real trace,
                      const long count)
{
    EACH(i, count)
    {
        const long n = i / taxels, k = i - n * taxels;
        __global const real *row = rows + n * loads * 8;
        for (int m = 0; m < loads; m++, row += 8) {
            const real q = row[2], r = row[3], f = row[4], turn = row[5];
            if (q == 0 && r == 0 && f == 0 && turn == 0) continue;
            const real x = at[2 * k] - row[0], y = at[2 * k + 1] - row[1];
            const real square = x * x + y * y, rho = sqrt(square);
            if (rho >= ends) {
                if (endless) {
                    const real near = 1 / (1 + square);
                    const real weight = (q * x + r * y + f) * near * sqrt(near) * factor * row[7];
                    out[3 * i] -= 3 * weight * near * x;
                    out[3 * i + 1] -= 3 * weight * near * y;
                    out[3 * i + 2] += weight * (trace - 3 * near);
                }
                continue;
            }
            const real root = sqrt(1 + square), place = log(rho + root) * per_rho;
            real w[4], v[4], g[6] = {0, 0, 0, 0, 0, 0};
            const int first = min((int)place, distances - 4);
            shares(place - first, w);
            const int lines = radii == 1 ? 1 : 4;
            const int low = radii == 1 ? 0 : min((int)row[6], radii - 4);
            if (radii == 1) v[0] = 1;
            else shares(row[6] - low, v);
            for (int j = 0; j < lines; j++) {
                __global const real *line = table + ((long)(low + j) * distances + first) * 6;
                for (int p = 0; p < 4; p++)
                    for (int c = 0; c < 6; c++) g[c] += v[j] * w[p] * line[6 * p + c];
            }
            const real along = q * x + r * y, over = 1 / root, odd = g[4] * over * over;
            out[3 * i] += q * g[3] - (2 * along * x - square * q) * odd + (turn * g[5] * y - f * g[2] * x) * over;
            out[3 * i + 1] += r * g[3] - (2 * along * y - square * r) * odd - (turn * g[5] * x + f * g[2] * y) * over;
            out[3 * i + 2] += f * g[0] - along * g[1] * over;
        }
    }
}
