"""The table of options: -help, checking, the options stored with a result and the documentation all come from it.

Every option is read here, once, whatever way it came in (fsipetsc.options.sources): command line, -options_file, YAML,
PETSC_OPTIONS. The rest of the program gets a dict of typed values; PETSc's database gets what PETSc is to follow.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from math import isqrt
from typing import Any

from fsipetsc.errors import InputError
from fsipetsc.options.option import REQUIRED, Option, above_one, brief
from fsipetsc.options.petsc_names import AT_START, IN_LOOP, IN_SOURCES, is_family_name, why_refused
from fsipetsc.options.sources import Given
from fsipetsc.options.tables import (
    ALIASES,
    CHECKPOINTS,
    COMMON,
    DISCRETISATION,
    LONGEST_NAME,
    OF_A_RUN,
    OUTPUT,
    PETSC_OPTIONS,
    RUN,
)

__all__ = [
    "COMMON", "LONGEST_NAME", "OF_A_RUN", "PETSC_OPTIONS", "REQUIRED", "RUN", "InForce", "Option", "above_one", "check_petsc",
    "defaults", "groups", "publish", "read_options", "read_table", "spelt", "table",
]  # fmt: skip


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
        if name in taken or name in ALIASES or is_family_name(name):
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
    if "ts_view" in given and values["ts_type"] == "fused":
        raise InputError("-ts_view shows PETSc's methods, not the fused one: give -ts_type rk, ssp or euler")
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
    names = [name.lower(), *(alias for alias, meant in ALIASES.items() if meant == name)]
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
    known = {option.name for option in _PASSED_ON + PETSC_OPTIONS} | set(ALIASES)
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
        option = options.get(ALIASES.get(lower, lower))
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
        error.args = (f"{error}{one.where}",)
        raise


def _check_names(given: Mapping[str, Given], options: Mapping[str, Option]) -> None:
    passed = {option.name for option in _PASSED_ON}
    aliases = {alias for alias, name in ALIASES.items() if name in options}
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

    major, minor, *_ = PETSc.Sys.getVersion()
    return major, minor


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
    for alias in ALIASES:
        database.delValue(alias)
    for option in PETSC_OPTIONS:
        value = values[option.name]
        database.delValue(option.name)
        method = option.name.split("_")[1]  # ts_rk_type is of ts_type rk
        unused = (method in ("rk", "ssp") and values["ts_type"] != method)
        if value is not None and not unused:
            database.setValue(dt_name if option.name == "ts_dt" else option.name, str(value))
