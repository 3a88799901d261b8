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
"""


def unit(constants: Mapping[str, int], kernels: Sequence[Kernel], *loops: str) -> str:
    """The text. loops: C code that calls the kernels."""
    defined = "".join(f"#define {name} {value}\n" for name, value in constants.items())
    printed = "\n".join(kernel.text() for kernel in kernels)
    return "\n".join([_HEAD + defined, c_source("fsipetsc.kernels", "prelude.h"), printed, *loops])


def c_source(package: str, name: str) -> str:
    """The text of a file of C code in a package."""
    return files(package).joinpath(name).read_text(encoding="utf-8")
