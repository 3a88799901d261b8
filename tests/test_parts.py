"""Functions that only compiled code calls are parts of others, and no machine code by themselves."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

pytest.importorskip("numba")

from llvmlite import binding
from numba import njit

from fsipetsc.operators.formulas import Formulas, each, with_chosen
from fsipetsc.operators.kernels import FORMULA, OPTIONS
from fsipetsc.operators.parts import Whole
from fsipetsc.operators.variants import Variants


@njit(**FORMULA)
def a_half(x):
    return 0.5 * x


@njit(**FORMULA)
def a_third(x):
    return x / 3


LAWS = Formulas(of=a_half), Formulas(of=a_third)


@njit(**OPTIONS)
def countdown(n):
    return n if n <= 0 else countdown(n - 2)


@njit(**OPTIONS)
def inner(law, s, i):
    return law.of(s[i]) + countdown(s.size)


@njit(**OPTIONS)
def outer(s, i):
    both = each(members.inner, LAWS, s, i)
    return with_chosen(members.inner, LAWS, i, s, i) + both[0] + both[1]


members = Formulas(inner=inner)
PARTS = a_half, a_third, countdown, inner, outer


@njit(error_model="numpy")
def entry(s, i):
    return outer(s, i)


@njit(error_model="numpy")
def other_entry(s):
    return outer(s, 0) - outer(s, 1)


def machine_code(function):
    """Whether the code of a compiled function, each of its versions, is in memory to be called."""
    found = {c.library.get_pointer_to_function(c.fndesc.llvm_func_name) != 0 for c in function.overloads.values()}
    assert len(found) == 1, "none or all of one or more versions"
    return found.pop()


def test_a_whole_takes_in_each_part_once(monkeypatch):
    """Those too that several others need; none of them is left for itself."""
    linked = Counter()
    link_in = binding.ModuleRef.link_in

    def counted(self, other, preserve=False):
        linked[other.name] += 1
        link_in(self, other, preserve)

    whole = njit(pipeline_class=Whole, error_model="numpy")(lambda s, i: outer(s, i) + countdown(i) + inner(LAWS[0], s, i))
    s = np.array([6.0, 12.0, 18.0])
    expected = entry(s, 0) + 2.0  # and all parts are there
    with monkeypatch.context() as patched:
        patched.setattr(binding.ModuleRef, "link_in", counted)
        assert whole(s, 0) == expected
    # each part by its name: those of two laws, and what ``each`` and ``with_chosen`` are made into
    assert {name: linked[name] for name in ("inner", "made", "a_half", "a_third", "countdown", "outer")} == {
        **{"inner": 2, "made": 2},
        **dict.fromkeys(("a_half", "a_third", "countdown", "outer"), 1),
    }
    (compiled,) = whole.overloads.values()
    defined = [f.name for f in compiled.library._final_module.functions if not f.is_declaration]
    assert not [name for name in defined if "a_half" in name or "inner" in name]


def test_parts_are_in_their_callers_alone():
    """Those that Python calls find them, several of them, and one that calls itself."""
    s = np.array([6.0, 12.0, 18.0])
    assert entry(s, 0) == 3.0 + 3.0 + 2.0 - 3.0 and entry(s, 1) == 4.0 + 6.0 + 4.0 - 3.0
    assert other_entry(s) == (3.0 + 3.0 + 2.0 - 3.0) - (4.0 + 6.0 + 4.0 - 3.0)
    assert machine_code(entry) and machine_code(other_entry)
    assert not any(machine_code(function) for function in PARTS)


@njit(**OPTIONS)
def kept(s):
    t = s
    return t[0]


def test_nobody_counts_who_refers_to_an_array():
    assert njit(lambda s: kept(s))(np.ones(1)) == 1.0
    (compiled,) = kept.overloads.values()
    assert "NRT_" not in compiled.library.get_llvm_str()


def test_so_are_those_of_variants():
    other = Variants(((LAWS, LAWS[::-1]),), "none").of(entry)
    s = np.array([6.0, 12.0, 18.0])
    assert other is not entry and other(s, 0) == 2.0 + 2.0 + 3.0 - 3.0
    own = other.py_func.__globals__["outer"]
    assert own is not outer and machine_code(other) and not machine_code(own)
