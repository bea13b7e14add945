// Taxel inverse for stress, `tactile.inverse.taxel.invert_stress` for one cell: s_xz, s_yz, s_zz; depth, floor
// in; dx, dy, force, validity out. Without branches, so that compilers vectorise it.

const int reachable = fabs(z) > far;
const real over_z = 1 / (reachable ? z : 1), across = x * over_z, along = y * over_z;
const real t = across * across + along * along;
real load = (t + 1) * (t + 1) * sqrt(t + 1) * -z;
load = load * ((real)2.09439510239319549 * depth * depth * largest); // 2 pi / 3

const int possible = finite & reachable & (load - load == 0);
const int loaded = !finite | (largest > floor), answered = possible & loaded;
dx = answered ? -depth * across : 0;
dy = answered ? -depth * along : 0;
force = answered ? load : 0;
validity = loaded ? (possible ? (t < 2 ? 1 : 2) : 4) : 0; // INSIDE, OUTSIDE; INVALID, NO_LOAD
