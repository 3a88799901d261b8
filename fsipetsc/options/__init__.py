"""The table of options: -help, checking, the options stored with a result and the docs use it.

Every option is read here, once, whatever way it came in (fsipetsc.options.sources). The rest of the
program gets a dict of typed values; PETSc's database gets what PETSc is to follow.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Any

from fsipetsc.errors import InputError
from fsipetsc.options.option import REQUIRED, Option, above_one, brief
from fsipetsc.options.sources import Given
from fsipetsc.options.tables import (
    ALIASES,
    AT_START,
    CHECKPOINTS,
    COMMON,
    DISCRETISATION,
    IN_LOOP,
    LONGEST_NAME,
    OF_A_RUN,
    OUTPUT,
    PASSED_ON,
    PETSC_OPTIONS,
    PETSCS,
    RUN,
)

__all__ = [
    "COMMON", "LONGEST_NAME", "OF_A_RUN", "PETSC_OPTIONS", "REQUIRED", "RUN", "InForce", "Option",
    "above_one", "check_petsc", "defaults", "groups", "publish", "read_options", "read_table",
    "spelt", "table",
]  # fmt: skip


def groups(
    case: Any, extra: Sequence[Option] = (), inherited: Mapping[str, Any] | None = None
) -> dict[str, tuple[Option, ...]]:
    """Heading -> options of a case, their defaults those in force for it.

    extra: options of a command. inherited: values of a checkpoint, which stand for the defaults.
    InputError if the case's OPTIONS or DEFAULTS do not fit.
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
    inherited = inherited or {}
    overrides = {"fsi_output": f"{case.NAME}.h5", **case.DEFAULTS, **inherited}
    who = {name: "the checkpoint" for name in inherited}
    known = {option.name for options in sections.values() for option in options}
    for name in case.DEFAULTS:
        if name not in known:
            hint = _nearest(str(name), known)
            raise InputError(f"case {case.NAME}: DEFAULTS has {name!r}, which is no option{hint}")
    return {
        title: tuple(
            _with_default(option, overrides, who.get(option.name, f"case {case.NAME}"))
            for option in options
        )
        for title, options in sections.items()
        if options
    }


def table(
    case: Any, extra: Sequence[Option] = (), inherited: Mapping[str, Any] | None = None
) -> dict[str, Option]:
    """Name in lower case -> option with the default in force, for every option of a case."""
    every = (option for options in groups(case, extra, inherited).values() for option in options)
    return {option.name.lower(): option for option in every}


def defaults(case: Any, extra: Sequence[Option] = ()) -> dict[str, Any]:
    """Name -> default in force for every option of a case; REQUIRED if the user must give it."""
    return {option.name: option.default for option in table(case, extra).values()}


def _check_own_names(case: Any) -> None:
    taken = {option.name.lower() for option in COMMON + PETSC_OPTIONS + PASSED_ON} | {"help"}
    for option in case.OPTIONS:
        name = option.name.lower()
        if name in taken or name.startswith(PETSCS):
            what = f"its option -{option.name} exists already; give it another name"
            raise InputError(f"case {case.NAME}: {what}")
        taken.add(name)


def _with_default(option: Option, values: Mapping[str, Any], who: str) -> Option:
    """The option with the default that values have for it; who has them, in a message."""
    value = values.get(option.name, option.default)
    try:
        if value is None and option.default is not None:
            raise ValueError  # None is for what need not be set
        return replace(option, default=option.convert(value))
    except (ValueError, TypeError, OverflowError):
        what = f"bad default {value!r} of -{option.name}: expected {option.expected()}"
        raise InputError(f"{who}: {what}") from None


class InForce(dict[str, Any]):
    """Name -> value of the options in force, as a case's build gets them.

    InputError for a name that there is not.
    """

    def __missing__(self, name: object) -> Any:
        raise InputError(f"opt[{name!r}]: there is no such option{_nearest(str(name), self)}")


def read_options(
    case: Any,
    given: Mapping[str, Given],
    extra: Sequence[Option] = (),
    inherited: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Name -> typed value of every option in force; PETSc, which runs, gets those it is to follow.

    given: what the user gave (fsipetsc.process.launch.start_petsc). inherited: values of a
    checkpoint, as JSON has them, which stand for the defaults. Not collective; the same on all
    ranks. InputError for an unknown name, a missing or bad value and for what contradicts itself.
    """
    options = table(case, extra, inherited)
    values, chosen = _read(options, given)
    _settle(values, chosen)
    from petsc4py import PETSc

    for option in IN_LOOP:
        PETSc.Options().delValue(option.name)
        if option.name in given:
            PETSc.Options().setValue(option.name, given[option.name].text)
    if "ts_view" in given and values["ts_type"] == "fused":
        what = "-ts_view shows PETSc's methods, not the fused one"
        raise InputError(f"{what}: give -ts_type rk, ssp or euler")
    if "ts_monitor" in given or "log_view" in given:
        values["fsi_burst"] = 1  # something of PETSc's is to see every step
    publish(values)
    return values


def spelt(given: Mapping[str, Given], name: str) -> Given | None:
    """What the user gave for an option, under one of its names."""
    names = [name.lower(), *(alias for alias, meant in ALIASES.items() if meant == name)]
    return next((given[spelling] for spelling in names if spelling in given), None)


def read_table(
    sections: Mapping[str, Sequence[Option]], given: Mapping[str, Given]
) -> dict[str, Any]:
    """Name -> typed value of the options of a command that runs no case.

    sections: heading -> options, as for ``groups``. InputError for an unknown name or a bad value.
    """
    every = (option for options in sections.values() for option in options)
    return _read({option.name.lower(): option for option in every}, given)[0]


def check_petsc(given: Mapping[str, Given]) -> None:
    """Raise InputError for a bad value of an option that PETSc reads."""
    for option in AT_START + IN_LOOP:
        if option.name in given:
            _value(option, given[option.name])


def _read(
    options: Mapping[str, Option], given: Mapping[str, Given]
) -> tuple[dict[str, Any], dict[str, str]]:
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
            both = f"-{chosen[option.name]} and -{one.name}"
            raise InputError(f"{both} mean the same; give one of them")
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
    known = {option.name for option in (*options.values(), *PASSED_ON)}
    known |= {alias for alias, name in ALIASES.items() if name in options}
    lower = {name.lower() for name in known}
    unknown = [
        f"-{brief(one.name)}{one.where}{_nearest(one.name, known)}"
        for name, one in sorted(given.items())
        if name not in lower
    ]
    if unknown:
        raise InputError(f"unknown option{'s' * (len(unknown) > 1)} {', '.join(unknown)}")


def _nearest(name: str, names: Iterable[str]) -> str:
    """A hint in brackets for a name that is none of the names."""
    if "=" in name:
        return " (write '-name value', without =)"
    spelt = {known.lower(): known for known in names}
    petscs = name.lower().startswith(PETSCS)
    best = get_close_matches(name.lower(), sorted(spelt), 1, 0.85 if petscs else 0.6)
    if best:
        return f" (did you mean -{spelt[best[0]]}?)"
    if petscs:
        return " (an option of PETSc's that has no effect here; -help lists those that have)"
    return " (-help lists the options there are)"


def _settle(values: dict[str, Any], chosen: Mapping[str, str]) -> None:
    """Settle in place what options leave open for each other. InputError for what is missing."""
    for option, value in values.items():
        if value is REQUIRED:
            raise InputError(f"-{option} must be given: the case has no default for it")
    for method in ("rk", "ssp"):  # who names one of PETSc's methods wants it, not the fused one
        if f"ts_{method}_type" in chosen and "ts_type" not in chosen:
            values["ts_type"] = method
    # who names times does not want the interval that the case suggests, and the other way round
    if "fsi_output_times" in chosen and "fsi_output_dt" not in chosen:
        values["fsi_output_dt"] = None
    if "fsi_output_dt" in chosen and "fsi_output_times" not in chosen:
        values["fsi_output_times"] = None


def _petsc_version() -> tuple[int, ...]:
    from petsc4py import PETSc

    return tuple(PETSc.Sys.getVersion()[:2])


def publish(values: Mapping[str, Any]) -> None:
    """Put the ts_… values of an options dict into PETSc's database, as this release names them.

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
        unused = method in ("rk", "ssp") and values["ts_type"] != method
        if value is not None and not unused:
            name = dt_name if option.name == "ts_dt" else option.name
            database.setValue(name, str(value))
