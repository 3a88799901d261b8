#include <math.h>
#include <string.h>
#include <stdint.h>
static inline double log_(double x) {
  int64_t b; memcpy(&b, &x, 8);
  int64_t k = (b + (0x3FF0000000000000LL - 0x3FE6A09E667F3BCDLL)) >> 52;
  int64_t m = b - (k << 52) + 0x3FF0000000000000LL; double f; memcpy(&f, &m, 8); f -= 1.0;
  int64_t p = k | 0x4330000000000000LL; double w; memcpy(&w, &p, 8); w -= 4503599627370496.0 + 1023.0;
  double s = f / (2.0 + f), z = s * s;
  double R = z * (6.666666666666735130e-01 + z * (3.999999999940941908e-01 + z * (2.857142874366239149e-01 + z * (2.222219843214978396e-01 + z * (1.818357216161805012e-01 + z * (1.531383769920937332e-01 + z * 1.479819860510658591e-01))))));
  double h = 0.5 * f * f;
  return w * 6.93147180369123816490e-01 - ((h - (s * (h + R) + w * 1.90821492927058770002e-10)) - f);
}
static inline double maximum_(double a, double b) { return a > b || a != a ? a : b; }
static inline double minimum_(double a, double b) { return a < b || a != a ? a : b; }
#define pow_ pow
#define log1p_ log1p
static inline double sign_(double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : x; }
