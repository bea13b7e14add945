// TaxelSignals of one taxel scaled by the largest of them, `tactile.inverse.taxel._scaled` for one cell: in_xz, in_yz, in_zz
// in; x, y, z (the signals over the largest of them), largest, finite out.

#ifdef DOUBLE
const real tiny = DBL_MIN;
#else
const real tiny = FLT_MIN;
#endif
const real far = (real)1e-6; // FAR

// without a load a fixed direction avoids 0/0
const int finite = (in_xz - in_xz == 0) & (in_yz - in_yz == 0) & (in_zz - in_zz == 0);
real x = finite ? in_xz : 0, y = finite ? in_yz : 0, z = finite ? in_zz : 0;
real largest = fabs(x) > fabs(y) ? fabs(x) : fabs(y);
largest = largest > fabs(z) ? largest : fabs(z);
const int some = largest >= tiny;
const real over = 1 / (some ? largest : 1);
largest = some ? largest : 0;
x *= over;
y *= over;
z = some ? z * over : -1;
