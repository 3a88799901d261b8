"""The table of options: -help, checking, the options stored with a result and the docs use it.

PETSc reads the command line, PETSC_OPTIONS and options files. The options that it has found are
checked here. The program gets typed values, and PETSc gets those options that it is to follow.
"""

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from itertools import pairwise, permutations
from math import isfinite
from pathlib import Path
from typing import Any

from fsipetsc.checks import NONNEGATIVE, POSITIVE, within
from fsipetsc.errors import FileError, InputError, call, petsc_words

#: how the program is called, in examples that can be copied
PROGRAM = "python -m fsipetsc"
#: default of an option that the case or the user must give
REQUIRED = ...
INT_MAX = 2**31 - 1
_BOOLS = dict.fromkeys(("", "true", "yes", "1", "on"), True)
_BOOLS |= dict.fromkeys(("false", "no", "0", "off"), False)
#: kind -> what is expected, in a message
_KINDS = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false, or no value for true",
    "ints": "whole numbers with commas and no spaces between them",
    "floats": "numbers with commas and no spaces between them",
}
#: check -> what is expected of a number, as in fsipetsc.checks; else it says so itself
_BOUNDS: Mapping[Any, str] = {"positive": POSITIVE, "nonnegative": NONNEGATIVE}


@dataclass(frozen=True)
class Option:
    """One option of a case or of the program.

    Args:
        name: name without the dash, as in "solid_kappa".
        kind: int, float, str, bool, "ints" or "floats"; the last two are lists with commas.
        default: a value, None (not set) or `REQUIRED`.
        unit: as in "kg/m3"; "" or "-" if there is none.
        help: one line that `-help` prints.
        choices: the only values that are allowed, in a list the only items.
        check: "positive", "nonnegative", "above 1" or the like, or a function of the value that
            returns None or True if it is fine, else False, or what is expected, "a number below 1".
    """

    name: str
    kind: type | str
    default: Any
    unit: str
    help: str
    choices: tuple[Any, ...] | None = None
    check: str | Callable[[Any], str | bool | None] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", getattr(self.kind, "__name__", self.kind))
        object.__setattr__(self, "unit", "" if self.unit == "-" else self.unit)
        object.__setattr__(self, "check", _BOUNDS.get(self.check, self.check))
        said = f"option {self.name!r}: expected a"
        if self.kind not in _KINDS:
            raise TypeError(f"{said} kind of {', '.join(_KINDS)}")
        if isinstance(self.check, str) and not self.check.startswith(("above ", "not below ")):
            raise TypeError(f"{said} check of {', '.join(_BOUNDS)}, above 1 …")

    def parse(self, text: str) -> Any:
        if text == "" and self.kind != "bool":
            raise InputError(f"-{self.name} needs a value: {self._expected()}")
        return self.checked(text.strip(), f"bad value {text[:80]!r} for -{self.name}")

    def checked(self, value: Any, said: str) -> Any:
        """Return a value as this option's type. InputError that begins with ``said``."""
        try:
            found = _typed(str(self.kind), value)
        except (ValueError, TypeError, OverflowError, KeyError):
            raise InputError(f"{said}: expected {self._expected()}") from None
        items = found if isinstance(found, tuple) else (found,)
        good: Any = self.choices is None or {*items} <= {*self.choices}
        if callable(self.check):
            good = call(self.check, (found,), f"check of -{self.name}")
        elif self.check:
            good = all(within(item, str(self.check)) for item in items)
        if good not in (None, True):
            raise InputError(f"{said}: expected {good or self._expected()}")
        return found

    def _expected(self) -> str:
        if self.choices is not None:
            some = "some" if self.kind in ("ints", "floats") else "one"
            return f"{some} of {', '.join(map(str, self.choices))}"
        bound = "" if callable(self.check) else self.check or ""
        bound = f"each {bound}" if bound and self.kind in ("ints", "floats") else bound
        unit = f"[{self.unit}]" if self.unit else ""
        return " ".join(filter(None, (_KINDS[str(self.kind)], bound, unit)))


def _typed(kind: str, value: Any) -> Any:
    """A text or a Python value as one of a kind; one of Python's errors if it is none."""
    if kind in ("ints", "floats"):
        items = value.split(",") if isinstance(value, str) else value
        return tuple(_typed(kind[:-1], item) for item in items)
    if kind == "str" and value is not None:
        return str(value)
    of = {"bool": bool, "int": int, "float": float}[kind]
    if isinstance(value, str):
        if "_" in value:  # Python would skip it in a number
            raise ValueError
        value = _BOOLS[value.strip().lower()] if of is bool else of(value)
    if (of is bool) != isinstance(value, bool) or not isfinite(value):
        raise ValueError
    if of is int and (int(value) != value or abs(value) > INT_MAX):
        raise ValueError
    return of(value)


def shown(value: Any) -> str:
    """Return the value of an option as it is printed."""
    if isinstance(value, (list, tuple)):
        return ",".join(map(shown, value))
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.10g}"
    return {REQUIRED: "required", None: "none", INT_MAX: "no limit"}.get(value, str(value))


DISCRETISATION = (
    Option("fsi_order", int, 4, "", "interior order of the SBP operators", (2, 4, 6, 8)),
    Option("fsi_h", float, REQUIRED, "m",
        "grid spacing; interfaces and ends of panels must fall on grid points", check="positive"),
    Option("fsi_cfl", float, 0.8, "", "Courant number; -ts_dt replaces it", check="positive"),
    Option("fsi_coupling", str, "conservative", "",
        "coupling of gas and solid; all but conservative: the paper's method, in 1-D",
        ("projection", "energy", "traditional", "conservative")),
    Option("fsi_mapping", str, "auto", "",
        "grids of gases; auto: rigid with the paper's couplings, stretched with conservative",
        ("auto", "rigid", "stretched")),
    Option("fsi_viscous", str, "wide", "",
        "second derivatives: D twice, or in the paper's method narrow ones", ("wide", "narrow")),
    Option("fsi_convection", str, "auto", "",
        "form of convection; auto: entropy, not for laws of your own and in the paper's method",
        ("auto", "divergence", "entropy")),
    Option("fsi_dissipation", float, 0.0, "",
        "factor of the usual dissipation; 0: 1 if blocks are joined, else none; -1: none",
        check=lambda size: -1 <= size <= 3 or "a number from -1 to 3"),
    Option("fsi_shock", float, 0.0, "",
        "dissipation where a sensor sees a shock, times its usual size", check="nonnegative"),
)  # fmt: skip
OUTPUT = (
    Option("fsi_output", str, None, "",
        "result file (HDF5); an earlier result is never destroyed silently",
        check=lambda name: bool(Path(name).name and Path(name).suffix not in (".parts", ".py"))
        or "the name of a file that does not end in .parts or .py"),
    Option("fsi_output_dt", float, None, "s", "interval of saved profiles", check="positive"),
    Option("fsi_output_times", "floats", None, "s", "times of saved profiles",
        check=lambda times: (times[0] >= 0 and [*times] == sorted({*times}))
        or "times that are not negative and increase"),
    Option("fsi_probes", str, None, "m", "places of nodes to record at each step: X,Y;X,Y;…"),
)  # fmt: skip
CHECKPOINTS = (
    Option("fsi_checkpoint", str, None, "", "file of checkpoints; else NAME.checkpoint.h5"),
    Option("fsi_checkpoint_steps", int, None, "", "steps between checkpoints", check="positive"),
    Option("fsi_checkpoint_wall", float, None, "s", "wall time between them", check="positive"),
    Option("fsi_restart", str, None, "", "go on from a checkpoint; auto: the run's own, if any"),
)  # fmt: skip
RUN = (
    Option("fsi_check", bool, False, "", "check the case, and do not run it"),
    Option("fsi_partition", str, "auto", "", "which ranks own which layers",
        ("auto", "physics", "balanced")),
    Option("fsi_norm", str, "L2", "", "norm of errors; L1 where solutions jump", ("L1", "L2")),
    Option("fsi_quiet", bool, False, "", "print nothing but errors"),
    Option("fsi_progress", bool, False, "", "print progress every 5 s, as on a terminal"),
    Option("fsi_debug", bool, False, "", "keep the C text of the kernels, and print where it is"),
)  # fmt: skip
#: those that belong to one run of the program, not to what is computed: no checkpoint has them
OF_A_RUN = {"fsi_quiet", "fsi_progress", "fsi_debug", "fsi_check", "fsi_restart"}
COMMON: tuple[Option, ...] = DISCRETISATION + OUTPUT + CHECKPOINTS + RUN

#: PETSc's options for which this program has defaults of its own, or which it must know
PETSC_OPTIONS: tuple[Option, ...] = (
    Option("ts_max_time", float, REQUIRED, "s", "time at which the run ends", check="nonnegative"),
    Option("ts_max_steps", int, INT_MAX, "", "steps until the run ends", check="nonnegative"),
    Option("ts_dt", float, None, "s", "fixed time step, as -ts_time_step", check="positive"),
    Option("ts_type", str, "fused", "", "time integrator; fused: rk of type 4 in one piece",
        ("fused", "rk", "ssp", "euler")),
    Option("ts_rk_type", str, "4", "", "Runge–Kutta method",
        ("1fe", "2a", "2b", "3", "3bs", "4", "5f", "5dp", "5bs", "6vr", "7vr", "8vr")),
    Option("ts_adapt_type", str, "none", "", "steps are as -fsi_cfl or -ts_dt say", ("none",)),
    Option("ts_ssp_type", str, "rks2", "", "method of ssp", ("rks2", "rks3", "rk104")),
)  # fmt: skip
#: what no option of a case may be called; how names of the program and of PETSc begin
TAKEN = "h", "help", "version"
RESERVED = "fsi_ ts_ ksp_ pc_ snes_ tao_ mat_ vec_ dm_ log_ malloc_ options_ prefix_".split()
#: other spellings: of another release of PETSc, or deprecated there
ALIASES = {"ts_time_step": "ts_dt", "ts_final_time": "ts_max_time"}

#: all options that PETSc follows and no table of a case has -> meaning
PASSED_ON = {
    "options_file": "read options from a file, one '-name value' a line; FILE.yaml is YAML",
    "options_file_yaml": "the same in YAML, whatever the file's name",
    "ts_monitor": "print every step: number, dt, t",
    "ts_view": "print PETSc's method when it ends; with -ts_type rk, ssp or euler",
    "log_view": "print PETSc's log at the end; :FILE writes it",
    "options_left": "list options that PETSc did not use, at the end",
}
#: those of its time integrator; those that it follows when it ends
IN_LOOP, AT_END = ("ts_monitor", "ts_view"), ("log_view", "options_left")


def groups(
    case: Any, extra: Sequence[Option] = (), inherited: Mapping[str, Any] = {}
) -> dict[str, tuple[Option, ...]]:
    """Heading -> options of a case, their defaults those in force; extra: those of a command;
    inherited: values of a checkpoint. InputError if the case's OPTIONS or DEFAULTS do not fit.
    """
    sections = {
        f"Case {case.NAME}": tuple(case.OPTIONS),
        "This command": tuple(extra),
        "Discretisation": DISCRETISATION,
        "Output": OUTPUT,
        "Checkpoints": CHECKPOINTS,
        "Run": RUN,
        "Time integration (PETSc)": PETSC_OPTIONS,
    }
    known = [option.name for options in sections.values() for option in options]
    own = [option.name.lower() for option in (*case.OPTIONS, *extra)]
    for name in own[: len(case.OPTIONS)]:
        wrong = own.count(name) > 1 or name in TAKEN or name.startswith(tuple(RESERVED))
        if wrong or not is_option(f"-{name}") or not name.isidentifier():
            others = f"not {', '.join(TAKEN)}, and begins with none of {', '.join(RESERVED)}"
            wanted = f"a name of its own of letters, digits and _, which is {others}"
            raise InputError(f"case {case.NAME}: option -{name}: expected {wanted}")
    for name in [name for name in case.DEFAULTS if name not in known][:1]:
        hint = _nearest(str(name), known)
        raise InputError(f"case {case.NAME}: DEFAULTS has {name!r}, which is no option{hint}")
    values = {"fsi_output": f"{case.NAME}.h5", **case.DEFAULTS, **inherited}

    def in_force(option: Option) -> Option:
        value = values.get(option.name, option.default)
        if value is not REQUIRED and (value, option.default) != (None, None):
            said = f"case {case.NAME}: bad default {value!r} of -{option.name}"
            value = option.checked(value, said)
        return replace(option, default=value)

    return {title: tuple(map(in_force, found)) for title, found in sections.items() if found}


def defaults(case: Any) -> dict[str, Any]:
    """Return name -> default in force for every option of a case; REQUIRED if it must be given."""
    return read_table(groups(case), {})


def is_option(word: str) -> bool:
    """PETSc's rule: a dash, or two, and a letter. -10, -.5 and -inf are values."""
    return re.match(r"--?(?!(inf|infinity|nan)$)[a-z]", word, re.IGNORECASE) is not None


def given_options(words: Sequence[str]) -> dict[str, str]:
    """Name in lower case -> text of the options given, as PETSc reads PETSC_OPTIONS, these words,
    and the files that they name; its database is empty afterwards. InputError, FileError.
    """
    from petsc4py import PETSc

    for before, word in pairwise(["", *words]):
        if not is_option(word) and not is_option(before):
            raise InputError(f"unexpected argument {word[:80]!r}: a value comes after its option")
    put({})
    try:
        quoted = (word if is_option(word) else f'"{word}"' for word in words)
        text = " ".join([*os.environ.get("PETSC_OPTIONS", "").split(), *quoted])
        PETSc.Options().insertString(text)
        given = {name.lower(): text for name, text in present().items()}
    except PETSc.Error as error:
        said = petsc_words(error).split(": ", 1)[-1].split("; ")[-1]
        kind = FileError if said.startswith("Unable to open") else InputError
        raise kind(f"options: {said}") from None
    finally:
        put({})
    return {ALIASES.get(name, name): text for name, text in given.items() if name != "help"}


def present() -> dict[str, str]:
    """Return name -> text of all options in PETSc's database; "" if there is no value."""
    from petsc4py import PETSc

    database = PETSc.Options()
    listed = database.getAll()  # may cut a text at a blank, as getString does after 1023 letters
    return {k: max(listed[k] or "", database.getString(k, ""), key=len) for k in listed}


def put(options: Mapping[str, str]) -> None:
    """Make PETSc's database hold these options alone."""
    from petsc4py import PETSc

    database = PETSc.Options()
    for name in database.getAll():
        database.delValue(name)
    for name, value in options.items():
        database.setValue(name, value)


def read_options(
    case: Any,
    given: Mapping[str, str],
    extra: Sequence[Option] = (),
    inherited: Mapping[str, Any] = {},
) -> dict[str, Any]:
    """Name -> typed value of every option in force; PETSc gets its own of them. InputError."""
    from petsc4py import PETSc

    values = read_table(groups(case, extra, inherited), given)
    for option in [name for name, value in values.items() if value is REQUIRED]:
        raise InputError(f"-{option} must be given: the case has no default for it")
    for method in ("rk", "ssp"):  # who names one of PETSc's methods wants it, not the fused one
        if f"ts_{method}_type" in given and "ts_type" not in given:
            values["ts_type"] = method
    # who names times does not want the interval that the case suggests, and the other way round
    for this, instead in permutations(("fsi_output_times", "fsi_output_dt")):
        if this in given and instead not in given:
            values[instead] = None
    told = {option.name: values[option.name] for option in PETSC_OPTIONS}
    told |= {name: given.get(name) for name in IN_LOOP}
    if PETSc.Sys.getVersion() >= (3, 25):
        told["ts_time_step"] = told.pop("ts_dt")
    for name, value in told.items():
        if value is not None:
            PETSc.Options().setValue(name, str(value))
    return values


def read_table(tables: Mapping[str, Sequence[Option]], given: Mapping[str, str]) -> dict[str, Any]:
    """Return name -> typed value of options of ``groups``. InputError."""
    options = {option.name.lower(): option for found in tables.values() for option in found}
    if unknown := sorted(given.keys() - options.keys() - PASSED_ON.keys()):
        known = [*(option.name for option in options.values()), *PASSED_ON]
        listed = ", ".join(f"-{name}{_nearest(name, known)}" for name in unknown)
        raise InputError(f"unknown option{'s' * (len(unknown) > 1)} {listed}")
    return {
        option.name: option.parse(given[name]) if name in given else option.default
        for name, option in options.items()
    }


def _nearest(name: str, names: Iterable[str]) -> str:
    """Return a hint in brackets for a name that is none of the names."""
    spelt = {known.lower(): known for known in names}
    best = get_close_matches(name.lower(), spelt, 1)
    return f" (did you mean -{spelt[best[0]]}?)" if best else " (-help lists the options there are)"
