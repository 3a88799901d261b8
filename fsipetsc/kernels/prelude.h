/* Elementary functions of printed kernels, as plain arithmetic without branches and tables, so that
   compilers make vector code of loops that take them (gcc needs -fno-tree-pre for some). What is
   fused says fma: all compilers and processors give the same bits, with -ffp-contract=off and
   without -ffast-math. Of libm only fma, sqrt and trunc are taken, which have one right result.
   For 0, infinity, nan, negative and subnormal numbers they give what numpy gives (a nan may have
   another sign), but sin and cos give nan where |x| > 2^40. Errors are the largest among millions
   of numbers of the whole range, in units in the last place (ulp).

   Some coefficients are those of FDLIBM, the library of Sun Microsystems, 1993; the others are those
   of the best polynomials, found by the algorithm of Remez in 60 digits. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define NOINLINE __attribute__((noinline))
#define INLINE static inline __attribute__((always_inline))

/* Constants in two or three parts. The last three bits of pi/4 are 0, so thrice it is exact. */
static const double LN2_ = 0.6931471805599453, LN2_LOW_ = 2.3190468138462996e-17;
static const double LOG2_E_ = 1.4426950408889634;
static const double QUARTER_PI_ = 0.7853981633974483, QUARTER_PI_LOW_ = 3.061616997868383e-17;
static const double HALF_PI_ = 1.5707963267948966, HALF_PI_LOW_ = 6.123233995736766e-17;
static const double HALF_PI_LOWEST_ = -1.4973849048591698e-33, TWO_BY_PI_ = 0.6366197723675814;
/* 1.5 2^52. x + ROUND_ has x, rounded, as its last bits, and x + ROUND_ - ROUND_ is x rounded. */
static const double ROUND_ = 6755399441055744.0;
/* A number as a sum: low is below the last place of high, or near it. */
struct sum_ { double high, low; };
/* a + b without error, for |a| >= |b| or a = 0; a b without error. */
INLINE struct sum_ exact_sum_(double a, double b) {
  const double high = a + b;
  return (struct sum_){high, b - (high - a)};
}
INLINE struct sum_ exact_product_(double a, double b) {
  const double high = a * b;
  return (struct sum_){high, fma(a, b, -high)};
}
/* (n + n_low) / (d + d_low): a quotient and what its remainder adds to it. */
INLINE struct sum_ quotient_(double n, double n_low, double d, double d_low) {
  const double inverse = 1.0 / d;
  const double high = n * inverse;
  const double remainder = fma(-high, d, n) + fma(-high, d_low, n_low);
  return (struct sum_){high, remainder * inverse};
}
/* a + b x + c x^2 + d x^3 */
INLINE double cubic_(double x, double a, double b, double c, double d) {
  return fma(fma(fma(d, x, c), x, b), x, a);
}
/* A number's bits, and the number of these bits. */
union word_ { double number; uint64_t bits; };
INLINE uint64_t bits_(double x) { return (union word_){.number = x}.bits; }
INLINE double number_(uint64_t bits) { return (union word_){.bits = bits}.number; }
/* 2^(k + more) with rounded = k + ROUND_. */
INLINE double power_of_2_(double rounded, int more) {
  return number_((bits_(rounded) + (uint64_t)(1023 + more)) << 52);
}
/* x between two bounds; nan stays. */
INLINE double bounded_(double x, double least, double most) {
  return x < least ? least : (x > most ? most : x);
}

/* The larger and the smaller number, nan if one is nan; of two zeros the second. */
INLINE double maximum_(double a, double b) {
  const double larger = a > b ? a : b;
  return a != a ? a : larger;
}
INLINE double minimum_(double a, double b) {
  const double smaller = a < b ? a : b;
  return a != a ? a : smaller;
}
INLINE double sign_(double x) { return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : x + 0.0); }

/* e^(x + tail) = 2^k (1 + r + rest): k is x / ln 2, rounded, r = x - k ln 2 is exact, and with
   s = r + tail, rest = e^s - 1 - r = tail + s^2 q(s), to 2^-61. */
struct exponential_ { double k_rounded, r, rest; };
INLINE struct exponential_ exponential_(double x, double tail) {
  const double rounded = fma(x, LOG2_E_, ROUND_);
  const double k = rounded - ROUND_;
  const double r = fma(-k, LN2_, x);
  const double low = fma(-k, LN2_LOW_, tail);
  const double s = r + low;
  const double z = s * s;
  double even = fma(z, 2.0924563681111986e-09, 2.7557242356578675e-07);
  even = cubic_(z, 0.0416666666666667, 0.0013888888888866568, 2.480158736105145e-05, even);
  double odd = fma(z, 2.5109147519163957e-08, 2.755724391131056e-06);
  odd = cubic_(z, 0.16666666666666677, 0.008333333333321532, 0.0001984126988640145, odd);
  return (struct exponential_){rounded, r, fma(z, fma(s, odd, fma(z, even, 0.5)), low)};
}
/* e^(x + tail). Of the two powers both are normal if the result is not. */
INLINE double long_exp_(double x, double tail) {
  const struct exponential_ e = exponential_(bounded_(x, -746.0, 711.0), tail);
  const double k = e.k_rounded - ROUND_;
  const double half_rounded = fma(k, 0.5, ROUND_);
  const double other_rounded = (k - (half_rounded - ROUND_)) + ROUND_;
  const double value = 1.0 + (e.r + e.rest);
  return value * power_of_2_(half_rounded, 0) * power_of_2_(other_rounded, 0);
}
/* 2^more (e^x - 1) for -45 <= x < 710.6, the largest terms first. */
INLINE struct sum_ scaled_expm1_(double x, int more) {
  const struct exponential_ e = exponential_(x, 0.0);
  const double power = power_of_2_(e.k_rounded, more);
  const struct sum_ most = exact_sum_(power - power_of_2_(ROUND_, more), power * e.r);
  return exact_sum_(most.high, fma(power, e.rest, most.low));
}
/* e^x. Error: 0.9 ulp. */
INLINE double exp_(double x) { return long_exp_(x, 0.0); }
/* e^x - 1. Error: 1.2 ulp. */
INLINE double expm1_(double x) {
  const struct sum_ half = scaled_expm1_(bounded_(x, -45.0, 710.0), -1);
  return fabs(x) < 1e-17 ? x : 2.0 * (half.high + half.low);
}
/* n / (n + 2) with n = e^(2 |x|) - 1. Error: 1.1 ulp. */
INLINE double tanh_(double x) {
  const struct sum_ n = scaled_expm1_(bounded_(2.0 * fabs(x), 0.0, 40.0), 0);
  const struct sum_ d = exact_sum_(2.0, n.high);
  const struct sum_ q = quotient_(n.high, n.low, d.high, d.low + n.low);
  return copysign(q.high + q.low, x);
}

/* x = 2^k (1 + f) with 1 + f between sqrt(1/2) and sqrt(2). Subnormal x are taken times 2^54. k is
   -inf for 0, inf for inf, else nan. */
struct reduced_ { double k, f; };
INLINE struct reduced_ reduced_(double x) {
  const uint64_t one = 0x3FF0000000000000u, sqrt_half = 0x3FE6A09E667F3BCDu;
  const double least = 2.2250738585072014e-308;
  const uint64_t bits = bits_(x < least ? 18014398509481984.0 * x : x);
  const uint64_t exponent = (bits + (one - sqrt_half)) >> 52;
  const double f = number_(bits - (exponent << 52) + one) - 1.0;
  const double k = number_(exponent | 0x4330000000000000u) - (4503599627370496.0 + 1023.0);
  const double of_small = x > 0.0 ? 54.0 : (x == 0.0 ? INFINITY : NAN);
  const double of_large = x < INFINITY ? 0.0 : -x;
  return (struct reduced_){k - (x < least ? of_small : of_large), f};
}

/* ln(1 + f) = f - high + low with high = f^2 / 2 and low = s (high + R(s^2)), s = f / (2 + f):
   FDLIBM's e_log.c, its coefficients. */
INLINE struct sum_ log_part_(double f) {
  const double high = 0.5 * f * f;
  const double s = f / (2.0 + f);
  const double z = s * s;
  double R = fma(z, 0.14798198605106586, 0.15313837699209373);
  R = cubic_(z, 0.2857142874366239, 0.22222198432149784, 0.1818357216161805, R);
  R = fma(z, fma(z, R, 0.3999999999940942), 0.6666666666666735);
  return (struct sum_){high, s * fma(z, R, high)};
}
/* k ln 2 + ln(1 + f) */
INLINE double log_of_parts_(struct reduced_ r) {
  const struct sum_ part = log_part_(r.f);
  return fma(r.k, LN2_, r.f - (part.high - fma(r.k, LN2_LOW_, part.low)));
}
/* ln x. Error: 0.9 ulp. */
INLINE double log_(double x) { return log_of_parts_(reduced_(x)); }
/* ln(1 + x): what 1 + x lost in rounding is added to f. Error: 1.4 ulp. */
INLINE double log1p_(double x) {
  const double u = 1.0 + x;
  const double part = u - 1.0;
  const double lost = (1.0 - (u - part)) + (x - part);
  struct reduced_ r = reduced_(u);
  r.f += u < 1e17 ? lost * power_of_2_(ROUND_ - r.k, 0) : 0.0;
  return fabs(x) < 1e-17 ? x : log_of_parts_(r);
}
/* ln x = k ln 2 + 2 s + s z (2/3 + z Q(z)) with z = s^2 and s = f / (2 + f), to 65 bits. */
INLINE struct sum_ long_log_(double x) {
  const struct reduced_ r = reduced_(x);
  const struct sum_ d = exact_sum_(2.0, r.f);
  const struct sum_ s = quotient_(r.f, 0.0, d.high, d.low);
  const struct sum_ z = exact_product_(s.high, s.high);
  const double z_low = fma(2.0 * s.high, s.low, z.low);
  double Q = fma(z.high, 0.1319774413753808, 0.13256669495035897);
  Q = cubic_(z.high, 0.2222222252134563, 0.18181784237698814, 0.15386763502778142, Q);
  Q = fma(z.high, fma(z.high, Q, 0.2857142857009195), 0.4000000000000227);
  const struct sum_ P = exact_sum_(0.6666666666666666, z.high * Q);
  const double P_low = P.low + 3.700743415417188e-17;
  const struct sum_ cube = exact_product_(s.high, z.high);
  const double cube_low = cube.low + fma(s.high, z_low, s.low * z.high);
  const struct sum_ term = exact_product_(cube.high, P.high);
  const double term_low = term.low + fma(cube.high, P_low, cube_low * P.high);
  const struct sum_ whole = exact_product_(r.k, LN2_);
  const struct sum_ most = exact_sum_(whole.high, 2.0 * s.high);
  const struct sum_ all = exact_sum_(most.high, term.high);
  const double low = fma(r.k, LN2_LOW_, fma(2.0, s.low, whole.low)) + term_low;
  return (struct sum_){all.high, all.low + (most.low + low)};
}
/* x^y = e^(y ln |x|), for negative x with the sign that whole y give it. Error: 1.1 ulp. */
INLINE double pow_(double x, double y) {
  const double size = fabs(x);
  const struct sum_ l = long_log_(size);
  const double times = bounded_(y, -1e21, 1e21);
  const struct sum_ product = exact_product_(times, l.high);
  const double tail = fabs(product.high) < 800.0 ? fma(times, l.low, product.low) : 0.0;
  const double value = long_exp_(product.high, tail);
  const double sign = 0.5 * y == trunc(0.5 * y) ? 1.0 : x;
  const double with_sign = copysign(value, y == trunc(y) ? sign : 1.0);
  const double known = (x < 0.0) & (size < INFINITY) & (y != trunc(y)) ? NAN : with_sign;
  return y == 0.0 ? 1.0 : (x == 1.0 ? 1.0 : known);
}

/* sin and cos of x - k pi/2 = r + low, |r| < 0.79: FDLIBM's k_sin.c, k_cos.c, their coefficients.
   pi/2 has three parts. x - k times the first is exact, the product with the second is, too. */
struct circular_ { uint64_t k; struct sum_ sin, cos; };
INLINE struct circular_ circular_(double x) {
  const double k_rounded = fma(x, TWO_BY_PI_, ROUND_);
  const double k = k_rounded - ROUND_;
  const double first = fma(-k, HALF_PI_, x);
  const struct sum_ second = exact_product_(k, HALF_PI_LOW_);
  const double r = first - second.high;
  const double part = r - first;
  const double lost = (first - (r - part)) - (second.high + part);
  const double low = lost - fma(k, HALF_PI_LOWEST_, second.low);
  const double z = r * r;
  double S = fma(z, 1.58969099521155e-10, -2.5050760253406863e-08);
  S = cubic_(z, 0.00833333333332249, -0.0001984126982985795, 2.7557313707070068e-06, S);
  S = fma(z, S, -0.16666666666666632);
  double C = fma(z, -1.1359647557788195e-11, 2.087572321298175e-09);
  C = cubic_(z, -0.001388888888887411, 2.480158728947673e-05, -2.7557314351390663e-07, C);
  C = fma(z, C, 0.0416666666666666);
  const double most = 1.0 - 0.5 * z;
  const struct sum_ sin = exact_sum_(r, fma(z * r, S, low * most));
  const double rest = fma(z * z, C, -r * low);
  const struct sum_ cos = exact_sum_(most, ((1.0 - most) - 0.5 * z) + rest);
  return (struct circular_){bits_(k_rounded), sin, cos};
}

/* A function of the angle x, with the other sign in the second half of a turn. */
INLINE double turned_(double x, double value, uint64_t quarters) {
  const double with_sign = number_(bits_(value) ^ ((quarters & 2) << 62));
  return fabs(x) <= 1099511627776.0 ? with_sign : NAN;
}
/* Where |x| <= 2^40, else nan. Errors: 0.8 ulp. */
INLINE double sin_(double x) {
  const struct circular_ c = circular_(x);
  return fabs(x) < 1e-9 ? x : turned_(x, c.k & 1 ? c.cos.high : c.sin.high, c.k);
}
INLINE double cos_(double x) {
  const struct circular_ c = circular_(x);
  return turned_(x, c.k & 1 ? c.sin.high : c.cos.high, c.k + 1);
}
/* arctan(a / b) = eighths pi/4 + arctan t, 0 <= a <= b: t = a / b or, behind pi/8,
   (a - b) / (a + b). arctan t = t - t^3 P(t^2): FDLIBM's s_atan.c, its coefficients, |t| < 7/16. */
INLINE struct sum_ arctan_part_(double a, double b, int steep) {
  const struct sum_ difference = exact_sum_(-b, a);
  const struct sum_ sum = exact_sum_(b, a);
  const struct sum_ n = {steep ? difference.high : a, steep ? difference.low : 0.0};
  const struct sum_ d = {steep ? sum.high : b, steep ? sum.low : 0.0};
  const struct sum_ t = quotient_(n.high, n.low, d.high, d.low);
  const double z = t.high * t.high;
  double P = fma(z, 0.016285820115365782, -0.036531572744216916);
  P = cubic_(z, 0.06661073137387531, -0.058335701337905735, 0.049768779946159324, P);
  P = cubic_(z, -0.11111110405462356, 0.09090887133436507, -0.0769187620504483, P);
  P = cubic_(z, 0.3333333333333293, -0.19999999999876483, 0.14285714272503466, P);
  return (struct sum_){t.high, fma(-t.high * z, P, t.low)};
}
/* The angle of the point (x, y). Error: 1.5 ulp. */
INLINE double arctan2_(double y, double x) {
  const int beyond = fabs(y) > fabs(x);
  const double larger = beyond ? fabs(y) : fabs(x);
  const double smaller = beyond ? fabs(x) : fabs(y);
  const double factor = larger < 1e-270 ? 0x1p120 : (larger > 1e300 ? 0x1p-4 : 1.0);
  const double of_infinity = smaller == INFINITY ? 1.0 : 0.0 * smaller;
  const double a = larger == INFINITY ? of_infinity : smaller * factor;
  const double b = larger == 0.0 ? 1.0 : (larger == INFINITY ? 1.0 : larger * factor);
  const int steep = a > 0.4142135623730951 * b;
  const struct sum_ angle = arctan_part_(a, b, steep);
  const double first = steep ? 1.0 : 0.0;
  const double upper = beyond ? 2.0 - first : first;
  const double side = copysign(1.0, x);
  const double eighths = side < 0.0 ? 4.0 - upper : upper;
  const double sign = beyond ? -side : side;
  const double low = fma(eighths, QUARTER_PI_LOW_, sign * angle.low);
  return copysign(eighths * QUARTER_PI_ + fma(sign, angle.high, low), y);
}

/* --- whole numbers and loops */
static inline long most(long a, long b) { return a > b ? a : b; }
static inline long least(long a, long b) { return a < b ? a : b; }
static inline long quotient(long a, long b) { return a / b - (a % b != 0 && (a < 0) != (b < 0)); }
static inline long remainder_of(long a, long b) { return a - b * quotient(a, b); }
/* Calls of procedures, once, and again while nothing is bad and more rounds are allowed. */
struct call { void (*procedure)(const void *, double *, double *); const void *of; double *y, *f; };
void run_calls(const struct call *calls, long count, const double *bad, const double *allowed) {
  do
    for (const struct call *c = calls; c < calls + count; ++c) c->procedure(c->of, c->y, c->f);
  while (*bad == 0.0 && *allowed != 0.0);
}
/* A kernel's loop over n >= 0 items i. gcc takes those left over from vectors in half a vector, and
   then one by one. Of few items they are many, and one more vector, in part, is faster. */
#define PRAGMA(text) _Pragma(#text)
#define ITEMS(simd, ...) PRAGMA(simd) for (long i = 0; i < n; ++i) { __VA_ARGS__ }
#if defined(__AVX512F__) && defined(__OPTIMIZE__)
#define FEW_ITEMS(simd, ...) \
  const long whole = n & -8L; \
  PRAGMA(simd) for (long i = 0; i < whole; ++i) { __VA_ARGS__ } \
  if (whole < n) { \
    PRAGMA(simd) for (long i = whole; i < whole + 8; ++i) { if (i < n) { __VA_ARGS__ } } \
  }
#else
#define FEW_ITEMS ITEMS
#endif
