"""What an option is, the options of all cases, section by section, and those of PETSc here."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from fsipetsc.errors import InputError, call

#: how the program is called, in examples that can be copied
PROGRAM = "python -m fsipetsc"
REQUIRED = ...
"""Default of an option that the case or the user must give."""
INT_MAX = 2**31 - 1
_BOOLS = dict.fromkeys(("", "true", "yes", "1", "on"), True)
_BOOLS |= dict.fromkeys(("false", "no", "0", "off"), False)
#: kind -> what is expected, in a message
_NOUNS = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false, or no value for true",
    "ints": "whole numbers with commas and no spaces between them",
    "floats": "numbers with commas and no spaces between them",
}
#: check -> what is expected of a number
_BOUNDS = {"positive": " above 0", "nonnegative": " not below 0"}


def above_one(value: float) -> str | None:
    """Check a ratio of specific heats or a Mach number."""
    return None if value > 1 else "a number above 1"


@dataclass(frozen=True)
class Option:
    """One option of a case or of the program.

    Args:
        name: name without the dash, as in "solid_kappa".
        kind: int, float, str, bool, "ints" or "floats"; the last two are lists with commas.
        default: a value, None (not set) or `REQUIRED`.
        unit: as in "kg/m3"; "" or "-" if there is none.
        help: one line that `-help` prints.
        choices: the only values that are allowed.
        check: "positive", "nonnegative", or a function of the value. It returns None or True if the
            value is fine; else it returns what is expected, as in "a number below 1", or False.

    Raises:
        TypeError: one of these is not as described.
    """

    name: str
    kind: type | str
    default: Any
    unit: str
    help: str
    choices: tuple[Any, ...] | None = None
    check: str | Callable[[Any], str | bool | None] | None = None

    def __post_init__(self) -> None:
        kind = self.kind.__name__ if isinstance(self.kind, type) else self.kind
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "unit", "" if self.unit == "-" else self.unit)
        checks = self.check in (None, *_BOUNDS) or callable(self.check)
        for good, expected in (
            (re.fullmatch(r"[A-Za-z]\w*", self.name), "a name of letters, digits and _"),
            (kind in _NOUNS, f"a kind that is one of {', '.join(_NOUNS)}"),
            (checks, "a check that is 'positive', 'nonnegative' or a function"),
        ):
            if not good:
                raise TypeError(f"option {self.name!r}: expected {expected}")

    def parse(self, text: str) -> Any:
        """Return the value that a text from the options database stands for. InputError."""
        if text == "" and self.kind != "bool":
            raise InputError(f"-{self.name} needs a value: {self.expected()}")
        return self.checked(text.strip(), f"bad value {text[:80]!r} for -{self.name}")

    def checked(self, value: Any, said: str) -> Any:
        """Return a value as this option's type. InputError that begins with ``said``."""
        try:
            found = _as_kind(str(self.kind), value)
        except (ValueError, TypeError, OverflowError):
            raise InputError(f"{said}: expected {self.expected()}") from None
        if objection := self._objection(found):
            raise InputError(f"{said}: expected {objection}")
        return found

    def expected(self) -> str:
        """Return what is valid, as the end of a sentence."""
        if self.choices is not None:
            return "one of " + ", ".join(map(str, self.choices))
        unit = f" [{self.unit}]" if self.unit else ""
        return _NOUNS[str(self.kind)] + _BOUNDS.get(str(self.check), "") + unit

    def _objection(self, value: Any) -> str | None:
        """Return what would be valid if the value is not allowed, else None."""
        if self.choices is not None and value not in self.choices:
            return self.expected()
        if callable(self.check):
            verdict = call(self.check, (value,), f"check of -{self.name}")
            if isinstance(verdict, str):
                return verdict
            return None if verdict is None or verdict else "a value within its range"
        least = min(value, default=1) if isinstance(value, tuple) else value
        fine = self.check is None or least > 0 or (self.check == "nonnegative" and least == 0)
        return None if fine else self.expected()


def floats(text: str, name: str, unit: str) -> tuple[float, ...]:
    """Return the numbers of a list such as 0.1,0.25. InputError that names the option."""
    found: tuple[float, ...] = Option(name, "floats", None, unit, "").parse(text)
    return found


def _as_kind(kind: str, value: Any) -> Any:
    """Return a text or a Python value as one of a kind; ValueError, TypeError, OverflowError."""
    if kind in ("ints", "floats"):
        items = value.split(",") if isinstance(value, str) else value
        return tuple(_as_kind(kind[:-1], item) for item in items)
    if kind == "str" and value is not None:
        return str(value)
    if isinstance(value, str):
        if "_" in value:  # Python would skip it in a number
            raise ValueError
        text = value.strip().lower()
        value = _BOOLS.get(text) if kind == "bool" else int(text) if kind == "int" else float(text)
    if (kind == "bool") != isinstance(value, bool) or not isfinite(value):
        raise ValueError
    if kind == "int" and (int(value) != value or abs(value) > INT_MAX):
        raise ValueError
    return {"bool": bool, "int": int, "float": float}[kind](value)


# the table


def _increasing(times: Sequence[float]) -> str | None:
    rising = all(a < b for a, b in zip(times, times[1:]))
    fits = rising and min(times, default=0) >= 0
    return None if fits else "times that are not negative and increase"


def _file_name(name: str) -> str | None:
    return None if Path(name).name and "\0" not in name else "the name of a file"


def _between(least: float, most: float) -> Callable[[float], str | None]:
    return lambda value: None if least <= value <= most else f"a number from {least} to {most}"


COUPLINGS = ("projection", "energy", "traditional", "conservative")
PARTITIONS = ("auto", "physics", "balanced")
DISCRETISATION = (
    Option("fsi_order", int, 4, "", "interior order of the SBP operators", (2, 4, 6, 8)),
    Option("fsi_h", float, REQUIRED, "m",
        "grid spacing; interfaces, in 2-D ends of panels, must fall on grid points",
        check="positive"),
    Option("fsi_cfl", float, 0.8, "", "Courant number of the time step; -ts_dt replaces it",
        check="positive"),
    Option("fsi_coupling", str, "conservative", "",
        "coupling of gas and solid; all but conservative: the paper's method, in 1-D", COUPLINGS),
    Option("fsi_mapping", str, "auto", "",
        "grids of gases: rigid with the paper's couplings, stretched with conservative; "
        "auto: what the coupling needs", ("auto", "rigid", "stretched")),
    Option("fsi_viscous", str, "wide", "",
        "second derivatives: D twice, or, with the paper's couplings, a narrow stencil",
        ("wide", "narrow")),
    Option("fsi_convection", str, "auto", "",
        "form of convection; entropy: a flux that conserves it; auto: that for perfect and "
        "stiffened gases, divergence for laws of your own and in the paper's method",
        ("auto", "divergence", "entropy")),
    Option("fsi_dissipation", float, 0.0, "",
        "dissipation, times its usual size; 0: 1 where blocks are joined, else none; -1: none",
        check=_between(-1, 3)),
    Option("fsi_shock", float, 0.0, "",
        "dissipation where a sensor sees a shock, times its usual size; 0: none",
        check=_between(0, 2)),
)  # fmt: skip
OUTPUT = (
    Option("fsi_output", str, None, "",
        "result file (HDF5); an earlier result is never destroyed silently", check=_file_name),
    Option("fsi_output_dt", float, None, "s", "interval at which profiles are saved",
        check="positive"),
    Option("fsi_output_times", "floats", None, "s", "times at which profiles are saved: t0,t1,…",
        check=_increasing),
    Option("fsi_probes", str, None, "m",
        "of blocks: places whose nearest nodes are recorded at each step: X,Y;X,Y;…"),
)  # fmt: skip
CHECKPOINTS = (
    Option("fsi_checkpoint", str, None, "",
        "file of checkpoints; NAME.checkpoint.h5 beside the result NAME.h5 if not given"),
    Option("fsi_checkpoint_steps", int, None, "steps", "steps from one checkpoint to the next",
        check="positive"),
    Option("fsi_checkpoint_wall", float, None, "s", "wall time from one checkpoint to the next",
        check="positive"),
    Option("fsi_restart", str, None, "",
        "go on from a checkpoint; auto: from the run's own, if there is one"),
)  # fmt: skip
RUN = (
    Option("fsi_check", float, None, "",
        "stop if mass, momentum, energy or entropy departs from its law by this fraction; "
        "without a value: check the case, and do not run it",
        check="positive"),
    Option("fsi_partition", str, "auto", "", "which ranks own which layers", PARTITIONS),
    Option("fsi_norm", str, "L2", "",
        "norm of the errors against an exact solution; L1 where it jumps", ("L1", "L2")),
    Option("fsi_quiet", bool, False, "", "print nothing but errors"),
    Option("fsi_progress", bool, False, "",
        "print progress from 2 s on, not 10 s, if the output is not a terminal"),
    Option("fsi_debug", bool, False, "", "keep the C text of the kernels, and print where it is"),
)  # fmt: skip
#: those that belong to one run of the program, not to what is computed: no checkpoint has them
OF_A_RUN = {"fsi_quiet", "fsi_progress", "fsi_debug", "fsi_restart"}
COMMON: tuple[Option, ...] = DISCRETISATION + OUTPUT + CHECKPOINTS + RUN

_RK_TYPES = ("1fe", "2a", "2b", "3", "3bs", "4", "5f", "5dp", "5bs", "6vr", "7vr", "8vr")
#: PETSc's options for which this program has defaults of its own, or which it must know
PETSC_OPTIONS: tuple[Option, ...] = (
    Option("ts_max_time", float, REQUIRED, "s", "time at which the run ends", check="nonnegative"),
    Option("ts_max_steps", int, INT_MAX, "", "number of steps after which the run ends",
        check="nonnegative"),
    Option("ts_dt", float, None, "s",
        "fixed time step, instead of -fsi_cfl; -ts_time_step is the same", check="positive"),
    Option("ts_type", str, "fused", "", "time integrator; fused: rk of type 4 in one piece",
        ("fused", "rk", "ssp", "euler")),
    Option("ts_rk_type", str, "4", "", "Runge–Kutta method", _RK_TYPES),
    Option("ts_adapt_type", str, "none", "", "steps have the length of -fsi_cfl or -ts_dt",
        ("none",)),
    Option("ts_ssp_type", str, "rks2", "", "method of ssp", ("rks2", "rks3", "rk104")),
)  # fmt: skip
#: other spellings: of another release of PETSc, or deprecated there
ALIASES = {"ts_time_step": "ts_dt", "ts_final_time": "ts_max_time"}

#: options that PETSc follows when it starts or when it ends -> meaning
AT_START = {
    "log_view": "print PETSc's log at the end: times of set-up, loop and output; :FILE writes it",
    "memory_view": "print the memory that was used, at the end",
    "info": "print what PETSc does",
    "malloc_debug": "check the memory that PETSc allocates",
    "malloc_dump": "list memory of PETSc's that was not freed, at the end",
    "options_left": "list options that PETSc did not use, at the end",
}
#: options that PETSc's time integrator follows -> meaning
IN_LOOP = {
    "ts_monitor": "print every step: number, dt, t",
    "ts_view": "print PETSc's method when it ends; with -ts_type rk, ssp or euler",
}
#: all options that PETSc follows and no table of a case has -> meaning
PASSED_ON = {
    "options_file": "read options from a file, one '-name value' a line; FILE.yaml is YAML",
    "options_file_yaml": "the same in YAML, whatever the file's name",
    **IN_LOOP,
    **AT_START,
}
#: beginnings of PETSc's names, which no option of a case may have
PETSCS = ("ts_", "ksp_", "pc_", "snes_", "mat_", "vec_", "dm_", "log_", "malloc_", "options_")
