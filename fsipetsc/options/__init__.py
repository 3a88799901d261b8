"""The table of options: -help, checking, the options stored with a result and the documentation all come from it.

Every option is read here, once, whatever way it came in (fsipetsc.options.sources): command line, -options_file, YAML,
PETSC_OPTIONS. The rest of the program gets a dict of typed values; PETSc's database gets what PETSc is to follow.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from math import isqrt
from typing import Any

from fsipetsc.errors import InputError
from fsipetsc.options.option import INT_MAX, REQUIRED, Option, brief
from fsipetsc.options.petsc_names import AT_START, IN_LOOP, IN_SOURCES, is_family_name, why_refused
from fsipetsc.options.sources import Given

__all__ = [
    *("COMMON", "PETSC_OPTIONS", "REQUIRED", "InForce", "Option", "check_petsc", "defaults", "groups", "publish"),
    *("read_options", "read_table", "spelt", "table"),
]


def _increasing(times: Sequence[float]) -> str | None:
    rising = all(a < b for a, b in zip(times, times[1:]))
    return None if rising and min(times, default=0) >= 0 else "times that are not negative and increase"


def _around_one(clip: Sequence[float]) -> str | None:
    return None if len(clip) == 2 and 0 < clip[0] < 1 < clip[1] else "two numbers, one between 0 and 1 and one above 1"


def _between(least: float, most: float) -> Callable[[float], str | None]:
    return lambda value: None if least <= value <= most else f"a number from {least} to {most}"


def _fraction(part: float) -> str | None:
    return None if 0 < part <= 1 else "a number above 0 and not above 1"


def _file_name(name: str) -> str | None:
    last = os.path.basename(name)
    fits = last not in ("", ".", "..") and len(os.fsencode(last)) <= LONGEST_NAME and "\0" not in name
    return None if fits else f"a file name of at most {LONGEST_NAME} bytes"


#: bytes of a file's name: MPI's input and output makes longer ones of it, and Open MPI 4 crashes on more than 255
LONGEST_NAME = 150

DISCRETISATION = (
    Option("fsi_order", int, 4, "", "interior order of the SBP operators", (2, 4, 6, 8)),
    Option(
        *("fsi_h", float, REQUIRED, "m", "grid spacing; interfaces, in 2-D ends of panels, must fall on grid points"),
        check="positive",
    ),
    Option("fsi_cfl", float, 0.8, "", "Courant number of the time step; -ts_dt replaces it", check="positive"),
    Option(
        *("fsi_coupling", str, "conservative", "", "treatment of the interfaces; in 2-D conservative alone"),
        choices=("projection", "energy", "traditional", "conservative"),
    ),
    Option(
        *("fsi_mapping", str, "auto", ""),
        help="grids of outer gases: rigid (embedded boundary), stretched; auto: that at walls, and in 2-D",
        choices=("auto", "rigid", "stretched"),
    ),
    Option(
        *("fsi_viscous", str, "wide", "", "second derivatives: D twice, or in 1-D such that reach half as far"),
        choices=("wide", "narrow"),
    ),
    Option(
        *("fsi_convection", str, "auto", "", "form of the gas's convection; entropy: two-point, which keeps it; auto: in 2-D"),
        choices=("auto", "divergence", "entropy"),
    ),
    Option(
        *("fsi_dissipation", float, 0.0, "", "dissipation by differences of half the order, times its usual size; 0: none"),
        check=_between(0, 3),
    ),
    Option(
        *("fsi_shock", float, 0.0, "", "dissipation where a sensor sees a shock, times its usual size; 0: none"),
        check=_between(0, 2),
    ),
    Option(
        *("fsi_spare", int, 16, "points", "in 1-D: free points kept beyond each embedded boundary before storage is enlarged"),
        check="nonnegative",
    ),
)
OUTPUT = (
    Option(
        *("fsi_output", str, None, "", "result file (HDF5); an earlier result is never destroyed silently"),
        check=_file_name,
    ),
    Option("fsi_output_dt", float, None, "s", "interval at which profiles are saved", check="positive"),
    Option("fsi_output_times", "floats", None, "s", "times at which profiles are saved: t0,t1,…", check=_increasing),
    Option("fsi_points", "floats", None, "m", "in 2-D: X of points of interfaces that are recorded at each step: X0,X1,…"),
)
CHECKPOINTS = (
    Option(
        *("fsi_checkpoint", str, None, "", "file of checkpoints; NAME.checkpoint.h5 beside the result NAME.h5 if not given"),
        check=_file_name,
    ),
    Option("fsi_checkpoint_steps", int, None, "steps", "steps from one checkpoint to the next", check="positive"),
    Option("fsi_checkpoint_wall", float, None, "s", "wall time from one checkpoint to the next", check="positive"),
    Option(
        *("fsi_restart", str, None, "", "go on from a checkpoint; auto: from the newest good one, if there is one"),
        check=_file_name,
    ),
    Option("fsi_wall_limit", float, None, "s", "wall time in which the run is to write a checkpoint and end", check="positive"),
)
RUN = (
    Option(
        *("fsi_check", float, None, "", "stop when mass, momentum, energy or entropy drifts by this fraction against its law"),
        check="positive",
    ),
    Option("fsi_entropy", bool, False, "", "record the entropy, too; -fsi_check does so anyway, and 2-D always"),
    Option(
        *("fsi_burst", int, 64, "steps", "most steps between looks at signals and progress; 1 with -ts_monitor…, -log_…"),
        check="positive",
    ),
    Option("fsi_partition", str, "auto", "", "which ranks own which layers", ("auto", "physics", "balanced")),
    Option("fsi_shared_memory", bool, True, "", "in 1-D: up to 16 ranks, all on one node, exchange by memory, not messages"),
    Option("fsi_norm", str, "L2", "", "norm of the errors against an exact solution; L1 where it jumps", ("L1", "L2")),
    Option("fsi_quiet", bool, False, "", "print nothing but errors"),
    Option("fsi_progress", bool, False, "", "show progress even when the output is not a terminal"),
    Option("fsi_debug", bool, False, "", "show the Python traceback of an error"),
)
COMMON: tuple[Option, ...] = DISCRETISATION + OUTPUT + CHECKPOINTS + RUN

_RK_TYPES = ("1fe", "2a", "2b", "3", "3bs", "4", "5f", "5dp", "5bs", "6vr", "7vr", "8vr")
#: Runge-Kutta methods with an embedded one, which step-size control needs
_EMBEDDED = ("2a", "3bs", "5f", "5dp", "5bs", "6vr", "7vr", "8vr")

#: PETSc's options for which this program has defaults of its own, or which it must know
PETSC_OPTIONS: tuple[Option, ...] = (
    Option("ts_max_time", float, REQUIRED, "s", "time at which the run ends", check="nonnegative"),
    Option("ts_max_steps", int, INT_MAX, "", "number of steps after which the run ends", check="nonnegative"),
    Option(
        "ts_dt", float, None, "s", "fixed time step, instead of -fsi_cfl; -ts_time_step is the same", check="positive"
    ),
    Option("ts_type", str, "fused", "", "time integrator; fused: rk of type 4 in one piece", ("fused", "rk", "ssp", "euler")),
    Option("ts_rk_type", str, "4", "", "Runge–Kutta method", _RK_TYPES),
    Option("ts_adapt_type", str, "none", "", "step-size control by an error estimate", ("none", "basic")),
    Option("ts_rtol", float, 1e-4, "", "relative tolerance of step-size control", check="nonnegative"),
    Option("ts_atol", float, 1e-4, "", "absolute tolerance of step-size control", check="nonnegative"),
    Option("ts_adapt_dt_min", float, None, "s", "step-size control: a run that needs less fails", check="positive"),
    Option("ts_adapt_dt_max", float, None, "s", "step-size control: no step is longer", check="positive"),
    Option("ts_adapt_clip", "floats", (0.1, 10.0), "", "step-size control: least and largest change", check=_around_one),
    Option("ts_adapt_safety", float, 0.9, "", "step-size control: part of the step that seems possible", check=_fraction),
    Option("ts_adapt_reject_safety", float, 0.5, "", "… and part of that after a refused step", check=_fraction),
    Option("ts_ssp_type", str, "rks2", "", "method of ssp", ("rks2", "rks3", "rk104")),
    Option("ts_ssp_nstages", int, None, "stages", "of rks2 (2 or more), of rks3 (4, 9, 16, …)", check=lambda n: n > 1),
)
#: those that are nothing without step-size control
_OF_CONTROL = (
    *("ts_rtol", "ts_atol", "ts_adapt_dt_min", "ts_adapt_dt_max", "ts_adapt_clip", "ts_adapt_safety"),
    "ts_adapt_reject_safety",
)
#: other spellings: of another release of PETSc, or deprecated there
_ALIASES = {"ts_time_step": "ts_dt", "ts_final_time": "ts_max_time"}


def groups(case: Any, extra: Sequence[Option] = ()) -> dict[str, tuple[Option, ...]]:
    """Heading -> options of a case, their defaults those in force for it; extra: options of a command.

    Raises InputError if the case's OPTIONS or DEFAULTS do not fit.
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
    _check_own_names(case)
    overrides = {"fsi_output": f"{case.NAME}.h5", **case.DEFAULTS}
    known = {option.name for options in sections.values() for option in options}
    for name in case.DEFAULTS:
        if not isinstance(name, str):
            raise InputError(f"case {case.NAME}: DEFAULTS has {name!r}: expected names of options")
        if name not in known:
            raise InputError(f"case {case.NAME}: DEFAULTS has '{name}', which is no option{_nearest(name, known)}")
    return {
        title: tuple(_with_default(option, overrides, case.NAME) for option in options)
        for title, options in sections.items()
        if options
    }


def table(case: Any, extra: Sequence[Option] = ()) -> dict[str, Option]:
    """Name in lower case -> option with the default in force, for every option of a case."""
    return {option.name.lower(): option for options in groups(case, extra).values() for option in options}


def defaults(case: Any, extra: Sequence[Option] = ()) -> dict[str, Any]:
    """Name -> default in force for every option of a case; REQUIRED where the user must give it."""
    return {option.name: option.default for option in table(case, extra).values()}


def _check_own_names(case: Any) -> None:
    taken = {option.name.lower() for option in COMMON + PETSC_OPTIONS}
    for option in case.OPTIONS:
        name = option.name.lower()
        if name in taken or name in _ALIASES or is_family_name(name):
            raise InputError(f"case {case.NAME}: its option -{option.name} exists already; give it another name")
        taken.add(name)


def _with_default(option: Option, overrides: Mapping[str, Any], case_name: str) -> Option:
    value = overrides.get(option.name, option.default)
    try:
        if value is None and option.default is not None:
            raise ValueError  # None is for what need not be set
        return replace(option, default=option.convert(value))
    except (ValueError, TypeError, OverflowError):
        message = f"case {case_name}: bad default {value!r} of -{option.name}: expected {option.expected()}"
        raise InputError(message) from None


class InForce(dict[str, Any]):
    """Name -> value of the options in force, as a case's build gets them. InputError for a name that there is not."""

    def __missing__(self, name: object) -> Any:
        raise InputError(f"opt[{name!r}]: there is no such option{_nearest(str(name), self)}")


def read_options(
    case: Any, given: Mapping[str, Given], extra: Sequence[Option] = (), inherited: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Name -> typed value of every option in force; PETSc must be initialised, and gets those that it is to follow.

    given: what the user gave (fsipetsc.process.launch.start_petsc). inherited: values, as JSON has them, that stand for the
    defaults, those of a checkpoint. Not collective; the same on all ranks. Raises
    InputError for an unknown name, a missing or bad value and for options that contradict each other.
    """
    options = table(case, extra)
    values, chosen = _read({name: _inheriting(option, inherited or {}) for name, option in options.items()}, given)
    _check_together(values, chosen)
    from petsc4py import PETSc

    for option in IN_LOOP:
        PETSc.Options().delValue(option.name)
        if option.name in given:
            PETSc.Options().setValue(option.name, given[option.name].text)
    if "ts_view" in given and (values["ts_type"] == "fused" or values["ts_adapt_type"] != "none"):
        shown = "the fused method" if values["ts_type"] == "fused" else "the step-size control"
        raise InputError(
            f"-ts_view shows PETSc's methods, and {shown} is the program's own: it works with -ts_type rk, ssp or euler and "
            "-ts_adapt_type none"
        )
    if "ts_monitor" in given or "log_view" in given:
        values["fsi_burst"] = 1  # something of PETSc's is to see every step
    publish(values)
    return values


def _inheriting(option: Option, inherited: Mapping[str, Any]) -> Option:
    """The option with the value that is inherited for a default, if there is one."""
    if option.name not in inherited:
        return option
    try:
        return replace(option, default=option.convert(inherited[option.name]))
    except (ValueError, TypeError, OverflowError):
        value = inherited[option.name]
        raise InputError(f"the checkpoint has {value!r} for -{option.name}: expected {option.expected()}") from None


def spelt(given: Mapping[str, Given], name: str) -> Given | None:
    """What the user gave for an option, under one of its names."""
    names = [name.lower(), *(alias for alias, meant in _ALIASES.items() if meant == name)]
    return next((given[spelling] for spelling in names if spelling in given), None)


def read_table(sections: Mapping[str, Sequence[Option]], given: Mapping[str, Given]) -> dict[str, Any]:
    """Name -> typed value of the options of a command that runs no case.

    sections: heading -> options, as for ``groups``. InputError for an unknown name or a bad value.
    """
    return _read({option.name.lower(): option for options in sections.values() for option in options}, given)[0]


def check_petsc(given: Mapping[str, Given]) -> None:
    """Raise InputError for an option of PETSc's that does not work here, and for a bad value of one that PETSc reads."""
    for option in AT_START + IN_LOOP:
        if option.name in given:
            _value(option, given[option.name])
    known = {option.name for option in _PASSED_ON + PETSC_OPTIONS} | set(_ALIASES)
    for name, one in given.items():
        if name not in known:
            nearest = get_close_matches(name, known, 1, 0.85)
            reason = why_refused(name)
            if reason and not nearest:
                raise InputError(f"-{brief(one.name)} cannot be used here{one.where}: {reason}")


#: what this table does not read
_PASSED_ON = AT_START + IN_LOOP + IN_SOURCES


def _read(options: Mapping[str, Option], given: Mapping[str, Given]) -> tuple[dict[str, Any], dict[str, str]]:
    """(name -> value, name -> how the user spelt it); options: name in lower case -> option."""
    _check_names(given, options)
    values = {option.name: option.default for option in options.values()}
    chosen: dict[str, str] = {}
    for lower, one in given.items():
        option = options.get(_ALIASES.get(lower, lower))
        if option is None:
            continue
        value = _value(option, one)
        if option.name in chosen and values[option.name] != value:
            raise InputError(f"-{chosen[option.name]} and -{one.name} mean the same; give one of them")
        values[option.name], chosen[option.name] = value, one.name
    return values, chosen


def _value(option: Option, one: Given) -> Any:
    """The value of an option as it was given; InputError says where."""
    try:
        return option.parse(one.text)
    except InputError as error:
        raise InputError(f"{error}{one.where}") from None


def _check_names(given: Mapping[str, Given], options: Mapping[str, Option]) -> None:
    passed = {option.name for option in _PASSED_ON}
    aliases = {alias for alias, name in _ALIASES.items() if name in options}
    spelt = {option.name for option in options.values()} | passed | aliases
    unknown = [
        f"-{brief(one.name)}{one.where}{_nearest(one.name, spelt)}"
        for lower, one in sorted(given.items())
        if lower not in options and lower not in passed | aliases
    ]
    if unknown:
        raise InputError(f"unknown option{'s' * (len(unknown) > 1)} " + ", ".join(unknown))


def _petsc_version() -> tuple[int, int]:
    from petsc4py import PETSc

    return tuple(PETSc.Sys.getVersion()[:2])


def _nearest(name: str, names: Iterable[str]) -> str:
    """A hint in brackets for a name that is none of the names."""
    if "=" in name:
        return " (write '-name value', without =)"
    spelt = {known.lower(): known for known in names}
    best = get_close_matches(name.lower(), sorted(spelt), 1, 0.6)
    return f" (did you mean -{spelt[best[0]]}?)" if best else " (-help lists the options there are)"


def _check_together(values: dict[str, Any], given: Mapping[str, str]) -> None:
    """Options that depend on each other; settles in place what one of them leaves open."""
    for option, value in values.items():
        if value is REQUIRED:
            raise InputError(f"-{option} must be given: the case has no default for it")
    if "ts_rk_type" in given and "ts_type" not in given:
        values["ts_type"] = "rk"  # who names one of PETSc's methods wants it, not the fused one
    if values["ts_adapt_type"] == "basic" and not (values["ts_type"] == "rk" and values["ts_rk_type"] in _EMBEDDED):
        method = f"-ts_rk_type {values['ts_rk_type']}" if values["ts_type"] == "rk" else f"-ts_type {values['ts_type']}"
        raise InputError(
            f"-ts_adapt_type basic needs a method with an error estimate, which {method} has not: "
            f"-ts_type rk with -ts_rk_type {', '.join(_EMBEDDED)}"
        )
    unheeded = [name for name in _OF_CONTROL if name in given] if values["ts_adapt_type"] == "none" else []
    if unheeded:
        raise InputError(f"-{given[unheeded[0]]} needs -ts_adapt_type basic: without it there is no step-size control")
    _check_stages(values, given)
    # who names times does not want the interval that the case suggests, and the other way round
    if "fsi_output_times" in given and "fsi_output_dt" not in given:
        values["fsi_output_dt"] = None
    if "fsi_output_dt" in given and "fsi_output_times" not in given:
        values["fsi_output_times"] = None


def _check_stages(values: Mapping[str, Any], given: Mapping[str, str]) -> None:
    """Options of the method ssp."""
    named = [name for name in ("ts_ssp_type", "ts_ssp_nstages") if name in given]
    if named and values["ts_type"] != "ssp":
        raise InputError(f"-{given[named[0]]} needs -ts_type ssp")
    stages, method = values["ts_ssp_nstages"], values["ts_ssp_type"]
    if stages is not None and (method == "rk104" or (method == "rks3" and isqrt(stages) ** 2 != stages)):
        expected = "has 10 stages" if method == "rk104" else "takes 4, 9, 16, … stages"
        raise InputError(f"-ts_ssp_nstages {stages}: the method {method} {expected}")


def publish(values: Mapping[str, Any]) -> None:
    """Put the ts_… values of an options dict into PETSc's database, under the names of this release of PETSc.

    To be called before TSSetFromOptions if ts_… values were changed after read_options.
    """
    from petsc4py import PETSc

    database = PETSc.Options()
    dt_name = "ts_time_step" if _petsc_version() >= (3, 25) else "ts_dt"
    for alias in _ALIASES:
        database.delValue(alias)
    for option in PETSC_OPTIONS:
        value = values[option.name]
        database.delValue(option.name)
        method = option.name.split("_")[1]  # ts_rk_type is of ts_type rk
        unused = (method in ("rk", "ssp") and values["ts_type"] != method) or option.name in _OF_CONTROL
        if value is not None and not unused:
            database.setValue(dt_name if option.name == "ts_dt" else option.name, str(value))
