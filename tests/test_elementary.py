"""The elementary functions of printed kernels: errors, special values, the same bits everywhere."""

import ctypes
import platform
import shutil
import sys
from importlib.util import find_spec
from itertools import product

import numpy as np
import pytest

from fsipetsc.equations import elementary
from fsipetsc.kernels import build
from fsipetsc.kernels.procedure import unit

LONG = np.longdouble
#: the most that a function may be wrong, in units in the last place, and what the reference may be
MOST, SLACK = 2.0, 0.01 if np.finfo(LONG).nmant > 60 else 1.0
INF, NAN, TINY, LEAST, LARGEST = np.inf, np.nan, 5e-324, 2.2250738585072014e-308, sys.float_info.max
WANTED = 4000
RANDOM = np.random.default_rng(1)


def between(a, b):
    return RANDOM.uniform(a, b, WANTED)


def sizes(a, b):
    """Of both signs, as many for each power of 2 between 2^a and 2^b."""
    return np.exp2(between(a, b)) * RANDOM.choice([-1.0, 1.0], WANTED)


EVERY, SMALL, BELOW_1 = sizes(-1074, 1023.99), sizes(-60, 2), sizes(-1074, 0)
POSITIVE = np.concatenate([abs(EVERY), between(0.5, 2.0), 1.0 + sizes(-52, -3)])
ANGLES = [BELOW_1, between(-9, 9), between(-1e5, 1e5), sizes(17, 40)]
# the numbers next to multiples of pi/2
QUARTERS = RANDOM.integers(1, 60000, WANTED) * (LONG("3.14159265358979323846264338327950288") / 2)
ANGLES = np.concatenate([*ANGLES, QUARTERS.astype(float)])
HYPERBOLIC = np.concatenate([BELOW_1, between(-3, 3), between(-710.4, 710.4)])
ARGUMENTS = {
    "exp": (np.concatenate([between(-745.1, 709.7), between(-745, -708), between(-2, 2), SMALL]),),
    "expm1": (np.concatenate([between(-50, 709.7), between(-3, 3), BELOW_1]),),
    "log": (POSITIVE,),
    "log1p": (np.concatenate([POSITIVE, BELOW_1, between(-0.99, 3), -1 + abs(sizes(-52, -1))]),),
    "sin": (ANGLES,),
    "cos": (ANGLES,),
    "tanh": (np.concatenate([HYPERBOLIC, between(-22, 22)]),),
    "sign": (EVERY,),
}
BASES = np.concatenate([abs(EVERY), between(0.5, 2.0), 1.0 + sizes(-52, -3), between(0, 100)])
RESULTS = np.concatenate([between(-745, 709.7) for _ in range(4)])  # the logarithms of powers
PAIRS = {
    "pow": (BASES, RESULTS / np.log(BASES)),
    "arctan2": (
        np.concatenate([EVERY, between(-3, 3), sizes(-1074, -1000), sizes(-1074, -10)]),
        np.concatenate([EVERY[::-1], between(-3, 3), sizes(-1074, -1000), sizes(-10, 10)]),
    ),
    "maximum": (EVERY, EVERY[::-1]),
    "minimum": (EVERY, EVERY[::-1]),
}
FUNCTIONS = {**ARGUMENTS, **PAIRS}
SPECIAL = np.array(
    [
        *(0.0, INF, TINY, LEAST, LEAST / 3.0, LARGEST, 1e300, 1.0, 0.5, 2.0, 3.0, 3.5, 27.0),
        *(1e-300, 1.0 + 2.0**-52, 1.0 - 2.0**-53, 10.0, 1023.0, 1024.0, 1074.0, 1075.0, 709.78),
        *(709.79, 710.47586, 710.4759, 745.1, 745.2, 1e5, 2.0**40, 2.0**52 + 1.0, 2.0**53, 1e22),
    ]
)
SPECIAL = np.concatenate([SPECIAL, -SPECIAL, [NAN]])
#: the same numbers, and all pairs of them
SPECIALS = {1: (SPECIAL,), 2: tuple(np.array(list(product(SPECIAL, SPECIAL))).T)}

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def made(command="", flags=""):
    """(name, arrays) -> array: the functions as this compiler makes them."""
    text = ""
    for name, given in FUNCTIONS.items():
        names = "xy"[: len(given)]
        pointers = "".join(f"const double *restrict {x}, " for x in names)
        text += f"""void all_{name}({pointers}double *restrict result, long n) {{
          #pragma omp simd
          for (long i = 0; i < n; ++i)
            result[i] = {name}_({", ".join(f"{x}[i]" for x in names)});
        }}
        """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CC", command)
        patch.setenv("CFLAGS", flags)
        text = unit(text)
        name = build.name_of(text)
        library = build.loaded(name, build.made({name: text}))

    def call(name, *given):
        arrays = *(np.ascontiguousarray(x, float) for x in given), np.empty(given[0].size)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
        library[f"all_{name}"](*pointers, ctypes.c_long(arrays[-1].size))
        return arrays[-1]

    return call


@pytest.fixture(scope="module")
def fast():
    return made()


def reference(name, given):
    """What numpy has for it, of numbers with 64 bits where there are such."""
    function = getattr(np, {"pow": "power"}.get(name, name))
    with np.errstate(all="ignore"):
        return function(*(numbers.astype(LONG) for numbers in given))


def errors(found, exact):
    """In units in the last place; inf where one is infinite or nan and the other is not."""
    with np.errstate(all="ignore"):
        rounded = exact.astype(float)
        size = np.spacing(np.abs(np.where(np.isfinite(rounded), rounded, 1.0)))
        error = np.abs((found - exact) / size).astype(float)
    same = (found == rounded) | (np.isnan(found) & np.isnan(rounded))
    return np.where(same, 0.0, np.where(np.isfinite(error), error, INF))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_no_error_above_2_units(fast, name):
    given = FUNCTIONS[name]
    error = errors(fast(name, *given), reference(name, given))
    worst = error.argmax()
    assert error[worst] <= MOST + SLACK, [numbers[worst].hex() for numbers in given]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_special_numbers_give_what_numpy_gives(fast, name):
    given = SPECIALS[len(FUNCTIONS[name])]
    found, exact = fast(name, *given), reference(name, given)
    if name in ("sin", "cos"):
        assert np.isnan(found[abs(given[0]) > 2.0**40]).all()
        exact[abs(given[0]) > 2.0**40] = NAN
    wrong = errors(found, exact) > MOST + SLACK
    if name not in ("maximum", "minimum"):  # numpy says nothing of the sign of a zero
        wrong |= (np.signbit(found) != np.signbit(exact)) & ~np.isnan(found)
    assert not wrong.any(), [(*each, f) for *each, f in zip(*given, found)][wrong.argmax()]


X86 = platform.machine() in ("x86_64", "AMD64")
CLANG = "clang" if shutil.which("clang") else f"{sys.executable} -m ziglang cc"
OTHERS = {"plain": ("", "-O1 -march=x86-64" if X86 else "-O1"), "clang": (CLANG, "")}


@pytest.mark.parametrize("other", OTHERS)
def test_same_bits(fast, other):
    if other == "clang" and not (shutil.which("clang") or find_spec("ziglang")):
        pytest.skip("no clang")
    library = made(*OTHERS[other])
    bits = RANDOM.integers(0, 2**64, (2, 20 * WANTED), dtype=np.uint64).view(float)
    for name, usual in FUNCTIONS.items():
        for given in (usual, SPECIALS[len(usual)], tuple(bits)):
            given = given[: len(usual)]
            one, two = fast(name, *given), library(name, *given)
            different = one.view(np.int64) != two.view(np.int64)
            different &= ~(np.isnan(one) & np.isnan(two))
            assert not different.any(), (name, [x[different.argmax()].hex() for x in given])


def test_functions_of_cases_are_right():
    x, a = np.concatenate([between(-700, 700), between(-1, 1)]), np.exp(between(-300, 300))
    for found, wanted in (
        (elementary.exp(x), np.exp(x.astype(LONG))),
        (elementary.log(a), np.log(a.astype(LONG))),
        (elementary.power(a[:9] ** 0.01, 0.7), (a[:9] ** 0.01).astype(LONG) ** LONG(0.7)),
    ):
        assert np.max(abs(found - wanted) / np.spacing(abs(wanted).astype(float))) < MOST + SLACK
    assert np.max(abs(elementary.tanh(x) - np.tanh(x))) < 3e-16
    assert np.array_equal(elementary.exp(np.array([0.0, -1e3, 1e3, NAN])), [1, 0, INF, NAN], True)
    assert np.array_equal(elementary.log([1.0, 0.0, INF, -1.0]), [0, -INF, INF, NAN], True)
