// Taxel inverse for strain, `tactile.inverse.taxel.invert_strain` for one cell: u_xz, u_yz, u_zz; depth, modulus, floor,
// pressing in; dx, dy, force, validity out. Without branches, so that compilers vectorise it.

const real a2 = x * x + y * y, b = fabs(z), m = 3 * b + sqrt(9 * b * b + 8 * a2);
const int straight = a2 <= far * far * b * b;
const real sign = (pressing == 0) & straight & (z > 0) ? -1 : pressing < 0 ? -1 : 1;
const int inside = sign * z < 0;
const real n = inside ? 4 : m, d = inside ? m : 2 * (straight ? 1 : a2);
const real n2 = a2 * n * n, d2 = d * d, p = n2 + d2, q = n2 + 4 * d2;
const real over_dq = 1 / (d * q), over_d = q * over_dq; // one division for both
const real reach = n * over_d, t = a2 * reach * reach;
real load = (3 * a2 * reach + fabs(t - 2) * b) * (p * sqrt(p) * over_dq);
load = sign * load * ((real)4.18879020478639098 * modulus * depth * depth * largest); // 4 pi / 3
const real length = sign * depth * reach;

const int possible = finite & (inside | !straight) & (load - load == 0);
const int loaded = !finite | (largest > floor), answered = possible & loaded;
const real region = (pressing == 0) & !straight ? 3 : inside ? 1 : 2; // AMBIGUOUS, INSIDE, OUTSIDE
dx = answered ? length * x : 0;
dy = answered ? length * y : 0;
force = answered ? load : 0;
validity = loaded ? (possible ? region : 4) : 0; // INVALID, NO_LOAD
