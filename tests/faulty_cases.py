"""Faults of case files: a case that is right, and changes that make it wrong with what the message must say."""

# ruff: noqa: E501

from __future__ import annotations

RIGHT = '''
import sys
import numpy as np; from numba import njit
from fsipetsc.boundaries import Dirichlet, Open, Wall, absorbing, clamped, free
from fsipetsc.options import Option
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
OPTIONS = (Option("own_speed", float, 0.0, "m/s", "a speed"),)
DEFAULTS = {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 1.0, "ts_max_steps": 4, "ts_dt": 1e-5}
def build(opt):
    gas = Fluid(mu=0.1, kappa=0.1, gamma=1.4, R=287.0)
    rod = Solid(K=1e6, kappa_e=0.5, m0=10.0, alpha=500.0)
    def g_initial(X):
        return [np.full(X.shape, 1.2), 0 * X, np.full(X.shape, 300.0)]
    def s_initial(X):
        return [0 * X, np.full(X.shape, -103320.0), np.full(X.shape, 300.0), X]
    def g_exact(X, t):
        return g_initial(X)
    def s_exact(X, t):
        return s_initial(X)
    def g_forcing(X, t):
        return [0 * X, 0.0, np.zeros(X.shape)]
    def s_forcing(X, t):
        return 0 * X, 0 * X, 0 * X, 0 * X
    def values(t):
        return 1.2, 0.0, 300.0
    def jumps(k, t):
        return 0.0, 0.0, 0.0, 0.0
    return Problem(
        layers=(
            FluidLayer("air", gas, (0.0, 1.0), g_initial, g_forcing, g_exact),
            SolidLayer("rod", rod, (1.0, 2.0), s_initial, s_forcing, s_exact),
        ),
        left=Dirichlet(0.0, values, 2),
        right=free(-103320.0),
        jumps=jumps,
        notes=("a note",),
    )
'''

_OPTIONS = 'OPTIONS = (Option("own_speed", float, 0.0, "m/s", "a speed"),)'
_GAS, _ROD = "mu=0.1, kappa=0.1, gamma=1.4, R=287.0", "K=1e6, kappa_e=0.5, m0=10.0, alpha=500.0"
_G = "return [np.full(X.shape, 1.2), 0 * X, np.full(X.shape, 300.0)]"
_S = "return [0 * X, np.full(X.shape, -103320.0), np.full(X.shape, 300.0), X]"
_F = "return [0 * X, 0.0, np.zeros(X.shape)]"
_E = "return g_initial(X)"
_V, _J = "return 1.2, 0.0, 300.0", "return 0.0, 0.0, 0.0, 0.0"
_LAYER = 'FluidLayer("air", gas, (0.0, 1.0), g_initial, g_forcing, g_exact)'
_LEFT = "Dirichlet(0.0, values, 2)"
_INITIAL = ("initial of layer 'air'", "expected")
_LATER = "if t > 1.5e-5: "

#: name -> (text of RIGHT, what stands there instead, words of the message); LINE: the line of the text must be named
FAULTS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    # the file
    "syntax": ("def build(opt):", "def build(opt:", ("line 11",)),
    "exit at the top": ("import sys\n", "import sys; sys.exit(0)\n", ("line 2", "sys.exit()")),
    "own kind of exception": (
        "import sys\n",
        "class Odd(BaseException): pass\nraise Odd('odd')\n",
        ("line 3", "Odd: odd"),
    ),
    "no build": ("def build(opt):", "def make(opt):", ("build(opt)",)),
    "build is no function": ("def build(opt):", "build = 3\ndef make(opt):", ("build must be a function",)),
    "OPTIONS is one Option": (_OPTIONS, _OPTIONS.replace(",)", ")"), ("line 9", "tuple")),
    "OPTIONS of texts": (_OPTIONS, "OPTIONS = ('speed',)", ("line 9", "number 1 is 'speed'")),
    "misspelt check": (_OPTIONS, _OPTIONS.replace('"a speed"', '"a speed", check="positve"'), ("line 9", "'positve'", "positive")),
    "choices is a text": (_OPTIONS, _OPTIONS.replace('"a speed"', '"a speed", "abc"'), ("line 9", "choices", "tuple")),
    "kind of option": (_OPTIONS, _OPTIONS.replace("float,", "complex,"), ("line 9", "kind")),
    "check fails": (_OPTIONS, _OPTIONS.replace('"a speed"', '"a speed", check=lambda v: 1 / v'), ("faulty.py, line 9: check of -own_speed: ZeroDivisionError",)),
    "default of a wrong kind": (_OPTIONS, _OPTIONS.replace("0.0", "'fast'"), ("own_speed", "a number")),
    "DEFAULTS with a wrong key": ('"fsi_order": 2', '"fsi_ordr": 2', ("line 10", "fsi_ordr", "-fsi_order")),
    "DEFAULTS with a key that is no text": ('"fsi_order": 2', "7: 2", ("line 10", "7", "names of options")),
    "DEFAULTS with None": ('"fsi_h": 0.1', '"fsi_h": None', ("line 10", "fsi_h", "above 0")),
    "DEFAULTS is a list": ("DEFAULTS = {", "DEFAULTS = [0]\nX = {", ("line 10", "dict")),
    # build
    "no return": ("return Problem(", "Problem(", ("LINE def build", "nothing", "Problem")),
    "returns a dict": ("return Problem(", "return dict(", ("LINE def build", "dict", "Problem")),
    "build is a generator": ("return Problem(", "yield Problem(", ("LINE def build", "generator", "Problem")),
    "build without argument": ("def build(opt):", "def build():", ("LINE def build", "TypeError")),
    "unknown key": ("gas = Fluid", "opt['own_sped']; gas = Fluid", ("LINE gas =", "opt['own_sped']", "did you mean -own_speed?")),
    "an exception that cannot be told": ("gas = Fluid", "C = type('C', (Exception,), {'__str__': lambda self: 1 / 0}); raise C; gas = Fluid", ("LINE gas =", "build: C\n")),
    "an exception that tells much": ("gas = Fluid", "raise ValueError('much ' * 1000); gas = Fluid", ("LINE gas =", "much …")),
    "exit in build": ("gas = Fluid", "sys.exit(); gas = Fluid", ("LINE gas =", "sys.exit()")),
    "BaseException in build": ("gas = Fluid", "raise GeneratorExit('x'); gas = Fluid", ("LINE gas =", "GeneratorExit")),
    # materials
    "gamma of one": (_GAS, _GAS.replace("1.4", "1"), ("LINE gas =", "gamma is 1", "above 1")),
    "gamma below 0": (_GAS, _GAS.replace("1.4", "-1.4"), ("LINE gas =", "gamma is -1.4")),
    "gamma is a text": (_GAS, _GAS.replace("1.4", "'1.4'"), ("LINE gas =", "gamma is '1.4'", "a number")),
    "R is None": (_GAS, _GAS.replace("287.0", "None"), ("LINE gas =", "R is None")),
    "mu is a function": (_GAS, _GAS.replace("mu=0.1", "mu=lambda T: T"), ("LINE gas =", "mu is a function")),
    "kappa below 0": (_GAS, _GAS.replace("kappa=0.1", "kappa=-1"), ("LINE gas =", "kappa is -1", "not below 0")),
    "mu is complex": (_GAS, _GAS.replace("mu=0.1", "mu=1j"), ("LINE gas =", "mu is 1j")),
    "kappa is an array": (_GAS, _GAS.replace("kappa=0.1", "kappa=np.ones(3)"), ("LINE gas =", "kappa is an array")),
    "K below 0": (_ROD, _ROD.replace("1e6", "-1e6"), ("LINE rod =", "K is -1e+06", "above 0")),
    "density of 0": (_ROD, _ROD.replace("10.0", "0"), ("LINE rod =", "m0 is 0")),
    "alpha nan": (_ROD, _ROD.replace("500.0", "np.nan"), ("LINE rod =", "alpha is nan")),
    "force inf": (_ROD, _ROD + ", force=np.inf", ("LINE rod =", "force is inf")),
    "Grueneisen below 0": (_ROD, _ROD + ", gruneisen=-1", ("LINE rod =", "gruneisen is -1")),
    "missing property": (_ROD, "K=1e6", ("LINE rod =", "TypeError", "m0")),
    # layers
    "Solid for a Fluid": ('"air", gas', '"air", rod', ("'air'", "material is a Solid", "Fluid")),
    "nan extent": ("(0.0, 1.0), g", "(np.nan, 1.0), g", ("'air'", "X[0] is nan")),
    "infinite extent": ("(1.0, 2.0)", "(1.0, np.inf)", ("'rod'", "X[1] is inf")),
    "reversed extent": ("(0.0, 1.0), g", "(1.0, 0.0), g", ("'air'", "left below right")),
    "extent of one number": ("(0.0, 1.0), g", "1.0, g", ("'air'", "X is 1.0", "two numbers")),
    "a gap": ("(1.0, 2.0)", "(1.1, 2.1)", ("LINE return Problem(", "'air'", "'rod'", "do not meet", "1.1")),
    "initial is an array": ("(0.0, 1.0), g_initial", "(0.0, 1.0), np.ones(11)", ("'air'", "initial is an array", "function")),
    "exact is a number": ("g_exact)", "1.0)", ("'air'", "exact is 1.0")),
    "name is a number": ('"air", gas', "1, gas", ("name is 1", "text")),
    "name of two lines": ('"air", gas', r'"a\nr", gas', ("name is 'a\\nr'", "one line")),
    "name with a bar": ('"air", gas', '"air | rod", gas', ("name is 'air | rod'", "without |")),
    "two layers of one name": ('"air", gas', '"rod", gas', ("LINE return Problem(", "two layers are named 'rod'", "a name for each")),
    # the problem
    "no layer": ("layers=(", "layers=() and (", ("LINE return Problem(", "one at least", "got []")),
    "two gases in turn": (_LAYER, f'FluidLayer("left", gas, (-1.0, 0.0), g_initial), {_LAYER}', ("LINE return Problem(", "alternate", "got ['fluid', 'fluid', 'solid']")),
    "a mapping that is none": (_LAYER, _LAYER.replace("g_exact)", "g_exact, mapping='rigd')"), ("LINE FluidLayer(", "'air'", "mapping is 'rigd'", "'rigid' or 'stretched'")),
    "layers is a layer": ("layers=(", "layers=" + _LAYER + " or (", ("layers is a FluidLayer", "tuple")),
    "a text among the layers": (_LAYER, "'air'", ("layers[0] is 'air'",)),
    "left is None": ("Dirichlet(0.0, values, 2)", "None", ("left is None", "Wall")),
    "right is a number": ("free(-103320.0)", "-103320.0", ("right is -103320.0",)),
    "solid end for a gas": ("Dirichlet(0.0, values, 2)", "free(0.0)", ("'air'", "Wall, Open or Dirichlet")),
    "wall for a solid": ("free(-103320.0)", "Wall(2.0)", ("'rod'", "a Wall", "clamped")),
    "a stress that is nan": ("free(-103320.0)", "free(lambda t: np.nan)", ("LINE right=", "right end at t = 0", "value is nan")),
    "a velocity that is nothing": ("free(-103320.0)", "clamped(lambda t: None)", ("LINE right=", "right end at t = 0", "value is None")),
    "T and a heat flux": ("free(-103320.0)", "free(-103320.0, T=300.0, heat_flux=1.0)", ("LINE right=", "free: T and heat_flux", "one of them")),
    "a cold end": ("free(-103320.0)", "free(-103320.0, T=-300)", ("LINE right=", "free: T is -300", "above 0")),
    "a wall that cools down too far": (_LEFT, "Wall(0.0, T=lambda t: -300.0)", ("LINE left=", "T of the left end at t = 0", "above 0")),
    "a heat flux is a text": (_LEFT, "Wall(0.0, heat_flux='much')", ("LINE left=", "Wall: heat_flux is 'much'")),
    "a wall at rest with a velocity": (_LEFT, "Wall(0.0, velocity=lambda t: 1.0)", ("LINE left=", "Wall: velocity is given", "a function x(t)")),
    "a wall that is nowhere": (_LEFT, "Wall(lambda t: np.sqrt(1.5e-5 - t))", ("LINE left=", "x of the left end at t = ", "x is nan")),
    "a velocity of a wall raises": (_LEFT, "Wall(lambda t: 0.0, velocity=lambda t: 1 / 0.0)", ("LINE left=", "velocity of the left end at t = ", "ZeroDivisionError")),
    "a wall that moves and a rigid grid": (f"{_LAYER},\n            SolidLayer(\"rod\", rod, (1.0, 2.0), s_initial, s_forcing, s_exact),\n        ),\n        left={_LEFT}", f"{_LAYER[:-1]}, mapping='rigid'),\n            SolidLayer('rod', rod, (1.0, 2.0), s_initial),\n        ),\n        left=Wall(lambda t: 0.0)", ("LINE return Problem(", "'air'", "mapping='rigid'", "stays where it is")),
    "free needs a number": ("free(-103320.0)", "free('much')", ("free: stress is 'much'",)),
    "wall at a text": ("Dirichlet(0.0, values, 2)", "Wall('left')", ("Wall: x is 'left'",)),
    "open to no pressure": ("Dirichlet(0.0, values, 2)", "Open(0.0, -1e5, 300.0)", ("Open: p0 is -100000",)),
    "values are numbers": ("Dirichlet(0.0, values, 2)", "Dirichlet(0.0, (1, 0, 300), 2)", ("values is (1, 0, 300)", "function")),
    "wall beyond the interface": ("Dirichlet(0.0, values, 2)", "Wall(1.5)", ("LINE FluidLayer(", "'air'", "x = 1.5")),
    "units": ("jumps=jumps,", "units='cgs',", ("units is 'cgs'", "'SI' or 'none'")),
    "notes is a text": ('notes=("a note",)', 'notes="a note"', ("notes is 'a note'", "tuple")),
    "jumps is a tuple": ("jumps=jumps,", "jumps=(0, 0, 0, 0),", ("jumps is (0, 0, 0, 0)", "function")),
    # what the functions return
    "two initial fields": (_G, "return [1.2 + 0 * X, 0 * X]", ("LINE def g_initial", *_INITIAL, "2 values", "(rho, u, T)")),
    "three of a solid": (_S, _S.replace("0 * X, ", ""), ("LINE def s_initial", "'rod'", "3 values", "(u, sigma, T, x)")),
    "initial returns nothing": (_G, "pass", ("LINE def g_initial", *_INITIAL, "nothing")),
    "initial is a generator": (_G, _G.replace("return", "yield"), ("LINE def g_initial", *_INITIAL, "generator")),
    "initial returns a text": (_G, "return 'abc'", (*_INITIAL, "'abc'")),
    "a field is a text": (_G, "return 'a', 'b', 'c'", (*_INITIAL, "rho is 'a'", "real numbers")),
    "a field is None": (_G, "return 1.2, None, 300.0", (*_INITIAL, "u is None")),
    "complex": (_G, "return 1.2 + 0 * X, 0j * X, 300 + 0 * X", (*_INITIAL, "u is complex")),
    "masked": (_G, "return np.ma.masked_less(X, 0.5), 0 * X, 300 + 0 * X", (*_INITIAL, "rho")),
    "a wrong shape": (_G, "return 1.2 + 0 * X, np.zeros(3), 300 + 0 * X", (*_INITIAL, "u has the shape (3,)", "as X has")),
    "a column": (_G, "return 1.2 + 0 * X, 0 * X[:, None], 300 + 0 * X", (*_INITIAL, "u has the shape")),
    "rows of different lengths": (_G, "return [[1, 2], [3]], 0 * X, 300 + 0 * X", (*_INITIAL, "rho")),
    "nan": (_G, "return 1.2 + 0 * X, np.where(X > 0.44, np.nan, 0), 300 + 0 * X", (*_INITIAL, "u is nan at X = 0.5")),
    "T of 0": (_G, _G.replace("300.0", "0.0"), (*_INITIAL, "T = 0", "above 0")),
    "rho below 0": (_G, _G.replace("1.2", "-1.2"), (*_INITIAL, "rho = -1.2", "above 0")),
    "cold solid": (_S, _S.replace("300.0", "-300.0"), ("initial of layer 'rod'", "T = -300")),
    "x falls": (_S, _S.replace(", X]", ", 3 - X]"), ("initial of layer 'rod'", "x does not rise")),
    "initial raises": (_G, "return 1 / 0", ("LINE return 1 / 0", "ZeroDivisionError")),
    "raises in numpy": (_G, "return np.linalg.inv(X)", ("LINE return np.linalg", "LinAlgError")),
    "raises after another one": (
        _G,
        "import collections; return collections.ChainMap().pop(X.size)",
        ("LINE import collections", "KeyError"),
    ),
    "initial ends the program": (_G, "sys.exit(5)", ("LINE sys.exit(5)", "sys.exit()")),
    "initial raises an odd exception": (_G, "raise GeneratorExit('x')", ("LINE raise Gen", "GeneratorExit")),
    "exact of a wrong length": (_E, "return g_initial(X)[:2]", ("LINE def g_exact", "exact of layer 'air'", "2 values")),
    "exact without t": ("def g_exact(X, t)", "def g_exact(X)", ("exact of layer 'air'", "TypeError")),
    "two forcings": (_F, "return 0 * X, 0 * X", ("LINE def g_forcing", "forcing of layer 'air'", "(rho, rho u, e)")),
    "two Dirichlet values": (_V, "return 1.2, 0.0", ("LINE def values", "left end", "(rho, u, T)")),
    "one Dirichlet value": (_V, "return 1.2", ("LINE def values", "left end", "returns 1.2")),
    "cold Dirichlet value": (_V, "return 1.2, 0.0, -300.0", ("LINE def values", "T = -300")),
    "an array of Dirichlet values": (_V, "return 1.2, np.zeros(4), 300.0", ("LINE def values", "u has the shape (4,)", "one number")),
    "three jumps": (_J, "return 0.0, 0.0, 0.0", ("LINE def jumps", "interface 0", "g_flux")),
    "a jump that is nan": (_J, "return 0.0, np.nan, 0.0, 0.0", ("LINE def jumps", "g_stress is nan")),
    # compiled functions
    "compiled: an exception": (_G, "return compiled(X)\n    @njit\n    def compiled(X):\n        if X[0] < 9: raise ValueError('no data')\n        return X, X, X", ("LINE if X[0] < 9", *_INITIAL[:1], "ValueError: no data")),
    "compiled: no such name": ("def g_initial(X):", "@njit\n    def g_initial(X):\n        return missing * X\n    def unused(X):", ("LINE @njit", *_INITIAL[:1], "numba cannot compile it: NameError: name 'missing'")),
    "compiled: no such attribute": ("def g_initial(X):", "@njit\n    def g_initial(X):\n        return X.missing\n    def unused(X):", ("LINE return X.missing", *_INITIAL[:1], "numba cannot compile it: Unknown attribute 'missing'")),
    "compiled: one value": ("def g_initial(X):", "@njit\n    def g_initial(X):\n        return X\n    def unused(X):", ("LINE @njit", *_INITIAL)),
    "compiled: nan later": ("def g_forcing(X, t):", "@njit\n    def g_forcing(X, t):\n        return 0 * X, 0 * X, np.full(X.shape, np.sqrt(1.5e-5 - t))\n    def unused(X):", ("LINE @njit", "forcing of layer 'air'", "e is nan", "X =", "faulty.h5")),
    # what happens later
    "a wall is lost later": (_LEFT, "Wall(lambda t: 0.0 if t < 1.5e-5 else None, velocity=lambda t: 0.0)", ("LINE left=", "x of the left end at t = ", "x is None", "faulty.h5")),
    "a wall of a wrong temperature later": (_LEFT, "Wall(0.0, T=lambda t: 300.0 if t < 1.5e-5 else 0.0)", ("LINE left=", "T of the left end at t = ", "T = 0", "faulty.h5")),
    "a stress fails later": ("free(-103320.0)", "free(lambda t: -103320.0 if t < 1.5e-5 else 1 / 0)", ("LINE right=", "value of the right end at t = ", "ZeroDivisionError", "faulty.h5")),
    "forcing fails later": (_F, f"{_LATER}return 1 / 0\n        {_F}", ("LINE if t > ", "at t = ", "ZeroDivisionError", "faulty.h5")),
    "forcing is nan later": (_F, "return 0 * X, 0, np.sqrt(1.5e-5 - t)", ("forcing of layer 'air'", "e is nan", "X =", "faulty.h5")),
    "values fail later": (_V, f"{_LATER}return 1.2\n        {_V}", ("LINE def values", "at t = ", "faulty.h5")),
    "jumps end the program later": (_J, f"{_LATER}sys.exit()\n        {_J}", ("LINE if t > ", "sys.exit()", "faulty.h5")),
    "exact fails at the end": (_E, f"{_LATER}return 7\n        {_E}", ("LINE def g_exact", "exact of layer 'air'", "faulty.h5")),
}
#: faults of FAULTS that show only when the run is under way: its result is kept
LATER = [name for name in FAULTS if "faulty.h5" in FAULTS[name][2]]

#: name -> (text of RIGHT, what stands there instead on rank 1 alone, words of the message)
ALONE: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "exit at the top": ("OPTIONS = (", "if ALONE: sys.exit(0)\nOPTIONS = (", ("line 9", "sys.exit()")),
    "build raises": ("    gas = ", "    if ALONE: 1 / 0\n    gas = ", ("LINE if ALONE", "ZeroDivisionError")),
    "exit in build": ("    gas = ", "    if ALONE: sys.exit()\n    gas = ", ("LINE if ALONE", "sys.exit()")),
    "odd exception in build": ("    gas = ", "    if ALONE: raise GeneratorExit\n    gas = ", ("LINE if ALONE", "GeneratorExit")),
    "exit in initial": (_S, f"if ALONE: sys.exit()\n        {_S}", ("LINE if ALONE", "rod", "sys.exit()")),
    "values at the start": (_V, "return None if ALONE else (1.2, 0.0, 300.0)", ("left end", "nothing")),
    "forcing later": (_F, f"if t > 1.5e-5: sys.exit()\n        {_F}", ("LINE if t > ", "sys.exit()", "faulty.h5")),
    "values later": (_V, f"if ALONE and t > 1.5e-5: 1 / 0\n        {_V}", ("LINE if ALONE", "ZeroDivisionError", "faulty.h5")),
    "jumps later": (_J, f"if ALONE and t > 1.5e-5: sys.exit()\n        {_J}", ("LINE if ALONE", "sys.exit()", "faulty.h5")),
    "exact at the end": (_E, f"if t > 0: sys.exit()\n        {_E}", ("LINE if t > 0", "sys.exit()", "faulty.h5")),
}
#: of FAULTS, those in which a function raises what nobody has foreseen
RAISING = {
    *("check fails", "an exception that cannot be told", "an exception that tells much", "exit in build"),
    *("BaseException in build", "missing property", "a velocity of a wall raises", "initial raises", "raises in numpy"),
    *("initial ends the program", "initial raises an odd exception", "compiled: an exception", "a stress fails later"),
    *("forcing fails later", "jumps end the program later", "raises after another one"),
}


def alone(name: str) -> tuple[str, list[str]]:
    """As ``faulty``, of ALONE."""
    right = RIGHT.replace("import sys", "import sys; from mpi4py import MPI; ALONE = MPI.COMM_WORLD.rank == 1")
    return _changed(right, name, *ALONE[name])


def faulty(name: str) -> tuple[str, list[str]]:
    """(text of the case file, words of its message) of a fault."""
    return _changed(RIGHT, name, *FAULTS[name])


def _changed(right: str, name: str, old: str, new: str, words: tuple[str, ...]) -> tuple[str, list[str]]:
    assert right.count(old) == 1, f"{name}: {old!r} stands {right.count(old)} times in the case"
    text = right.replace(old, new)
    lines = text.splitlines()
    return text, [_line(lines, word.removeprefix("LINE ")) if word.startswith("LINE ") else word for word in words]


def _line(lines: list[str], start: str) -> str:
    (number,) = [i for i, line in enumerate(lines, 1) if start in line]
    return f", line {number}: "
