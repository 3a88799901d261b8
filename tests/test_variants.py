"""Compiled functions once more with other laws: what they are known by, and what is kept of them on disk."""

from __future__ import annotations

import types

import numpy as np
import pytest
from helpers import REPOSITORY, run

pytest.importorskip("numba")

from numba import njit

from fsipetsc.operators import variants
from fsipetsc.operators.formulas import Formulas


def function(source: str, **scope):
    """A function f as a case file would define it."""
    scope |= {"__name__": "case"}
    exec(source, scope)
    return scope["f"]


POWER = np.array([1.0, 0.5])
SOURCES = {
    "line": "def f(T):\n    return A * T",
    "constant": "def f(T):\n    return 2.0 * A * T",
    "operator": "def f(T):\n    return A / T",
    "function": "def f(T):\n    return g(T)",
}


def test_a_digest_knows_all_that_a_law_consists_of():
    def digest(source, **scope):
        return variants.digest(Formulas(relative=njit(function(source, **scope))))

    plain = digest(SOURCES["line"], A=1.0)
    assert digest("\n\n# moved\n" + SOURCES["line"], A=1.0, B=3.0) == plain, "what is not used does not count"
    others = [digest(SOURCES["line"], A=value) for value in (2.0, 1, (1.0, 2.0), POWER, 2 * POWER, POWER[:1])]
    others += [digest(SOURCES["constant"], A=1.0), digest(SOURCES["operator"], A=1.0)]
    helpers = [function(SOURCES["line"], A=value) for value in (1.0, 2.0)]
    others += [digest(SOURCES["function"], g=njit(helper)) for helper in helpers]
    module = [types.ModuleType("mine"), types.ModuleType("mine")]
    for which, helper in zip(module, helpers, strict=True):
        which.g = njit(helper)
    others += [digest("def f(T):\n    return m.g(T)", m=which) for which in module]
    closed = "def outer(a):\n    def f(T):\n        return a * T\n    return f\nf = outer({})"
    others += [digest(closed.format(a)) for a in (1.0, 2.0)]
    assert len({plain, *others}) == len(others) + 1
    assert digest(SOURCES["function"], g=njit(helpers[0])) == digest(
        SOURCES["function"], g=njit(function(SOURCES["line"], A=1.0))
    )


#: for a function that is not to become a part of who calls it
TOO_LONG = "    T = max(T, math.sin(T))\n" * 60


def test_a_law_that_changes_is_compiled_anew_and_one_that_does_not_is_not(tmp_path):
    """The same file with another number, and the first one again; and both in one process, which others have compiled: each is
    itself, though the linker might know them by the same name.
    """
    (tmp_path / "program.py").write_text(
        "import sys\n"
        f"sys.path[:0] = [{str(REPOSITORY)!r}, {str(REPOSITORY / 'tests')!r}]\n"
        "from fsipetsc.operators import variants, kernels\n"
        "from fsipetsc.physics.own_laws import transport_law\n"
        "from toy import LAWS, entry\n"
        "def law(factor):\n"
        "    def relative(T):\n        return factor, factor * T\n"
        "    return transport_law(relative)\n"
        "entry(3.0)\n"
        "for factor in map(float, sys.argv[1:]):\n"
        "    laws = (law(factor),)\n"
        "    found = variants.Variants(((LAWS, laws),), 'laws-' + variants.digest(laws))\n"
        "    own = found.of(entry)\n"
        "    print(entry(3.0), own(3.0), sum(own.stats.cache_hits.values()), own is found.of(entry))\n"
    )
    (tmp_path / "toy.py").write_text(
        "import math\n"
        "from numba import njit\n"
        "from fsipetsc.operators.kernels import ENTRY, OPTIONS\n"
        "from fsipetsc.physics.constant_transport import constant_transport\n"
        "LAWS = (constant_transport,)\n"
        "@njit(**OPTIONS)\n"
        "def inner(T):\n"
        f"{TOO_LONG}"
        "    return LAWS[0].relative(LAWS[0].constants(T), T)[1]\n"
        "@njit(**ENTRY)\n"
        "def entry(T):\n    return inner(T) - inner(2.0 * T) + inner(2.0 * T) + 1.0\n"
    )

    def answer(*factors):
        env = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
        done = run(tmp_path / "program.py", *factors, env=env, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    assert answer() == []  # from here on each process compiles a variant and nothing else
    assert answer(2.0) == ["2.0", "7.0", "0", "True"]
    assert answer(2.0) == ["2.0", "7.0", "1", "True"]
    assert answer(5.0) == ["2.0", "16.0", "0", "True"]
    assert answer(2.0, 5.0) == ["2.0", "7.0", "1", "True", "2.0", "16.0", "1", "True"]
