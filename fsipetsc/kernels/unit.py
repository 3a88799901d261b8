"""A translation unit: constants, elementary functions, printed kernels, and the C loops that call
them.
"""

from collections.abc import Mapping, Sequence
from importlib.resources import files

from fsipetsc.kernels.kernel import Kernel

_HEAD = """#include <math.h>
#include <string.h>
#define NOINLINE __attribute__((noinline))
static inline long most(long a, long b) { return a > b ? a : b; }
static inline long least(long a, long b) { return a < b ? a : b; }
static inline long quotient(long a, long b) { return a / b - (a % b != 0 && (a < 0) != (b < 0)); }
static inline long remainder_of(long a, long b) { return a - b * quotient(a, b); }
/* A kernel's loop over items i. With vectors of eight numbers, those left over are one more vector
   whose other lanes are neither read nor stored: gcc would take them one by one. */
#ifdef __AVX512F__
#define ITEMS(simd, ...) \
  _Pragma(simd) for (long i = 0; i < (n & -8L); ++i) { __VA_ARGS__ } \
  if (n > 0 && n & 7) { \
    const long first_ = n & -8L; \
    _Pragma(simd) for (long lane_ = 0; lane_ < 8; ++lane_) { \
      const long i = first_ + lane_; \
      if (i < n) { __VA_ARGS__ } \
    } \
  }
#else
#define ITEMS(simd, ...) _Pragma(simd) for (long i = 0; i < n; ++i) { __VA_ARGS__ }
#endif
"""


def unit(constants: Mapping[str, int], kernels: Sequence[Kernel], *loops: str) -> str:
    """Return the text of a translation unit. loops: C code that calls the kernels."""
    defined = "".join(f"#define {name} {value}\n" for name, value in constants.items())
    printed = "\n".join(kernel.text() for kernel in kernels)
    return "\n".join([_HEAD + defined, c_source("fsipetsc.kernels", "prelude.h"), printed, *loops])


def c_source(package: str, name: str) -> str:
    """Return the text of a C file in a package."""
    return files(package).joinpath(name).read_text(encoding="utf-8")
