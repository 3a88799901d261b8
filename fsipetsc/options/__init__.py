"""The table of options: -help, checking, the options stored with a result and the docs use it.

PETSc reads the command line, PETSC_OPTIONS and options files into its database. What it then holds
is checked here, once. The rest of the program gets a dict of typed values; PETSc's database keeps
what PETSc is to follow.
"""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import pairwise, permutations
from typing import Any

from fsipetsc.errors import FileError, InputError, petsc_words
from fsipetsc.options import all_options
from fsipetsc.options.all_options import (
    COMMON,
    INT_MAX,
    OF_A_RUN,
    PETSC_OPTIONS,
    PROGRAM,
    REQUIRED,
    RUN,
    Option,
    above_one,
    floats,
)

__all__ = [
    "COMMON", "INT_MAX", "OF_A_RUN", "PETSC_OPTIONS", "PROGRAM", "REQUIRED", "RUN", "InForce",
    "Option", "above_one", "defaults", "floats", "given_options", "groups", "is_option", "present",
    "put", "read_options", "read_table", "table",
]  # fmt: skip


def groups(
    case: Any, extra: Sequence[Option] = (), inherited: Mapping[str, Any] | None = None
) -> dict[str, tuple[Option, ...]]:
    """Return heading -> options of a case, their defaults those in force for it.

    extra: options of a command. inherited: values of a checkpoint, which stand for the defaults.
    InputError if the case's OPTIONS or DEFAULTS do not fit.
    """
    sections = {
        f"Case {case.NAME}": tuple(case.OPTIONS),
        "This command": tuple(extra),
        "Discretisation": all_options.DISCRETISATION,
        "Output": all_options.OUTPUT,
        "Checkpoints": all_options.CHECKPOINTS,
        "Run": RUN,
        "Time integration (PETSc)": PETSC_OPTIONS,
    }
    taken = {option.name.lower() for option in COMMON + PETSC_OPTIONS}
    taken |= {*all_options.PASSED_ON, "help"}
    for name in (option.name.lower() for option in case.OPTIONS):
        if name in taken or name.startswith(all_options.PETSCS):
            what = f"its option -{name} exists already; give it another name"
            raise InputError(f"case {case.NAME}: {what}")
        taken.add(name)
    values = {"fsi_output": f"{case.NAME}.h5", **case.DEFAULTS, **(inherited or {})}
    known = {option.name for options in sections.values() for option in options}
    for name in case.DEFAULTS:
        if name not in known:
            hint = _nearest(str(name), known)
            raise InputError(f"case {case.NAME}: DEFAULTS has {name!r}, which is no option{hint}")

    def in_force(option: Option) -> Option:
        value = values.get(option.name, option.default)
        unset = value is None and option.default is None  # None is for what need not be set
        if value is not REQUIRED and not unset:
            said = f"case {case.NAME}: bad default {value!r} of -{option.name}"
            value = option.checked(value, said)
        return replace(option, default=value)

    return {title: tuple(map(in_force, found)) for title, found in sections.items() if found}


def table(case: Any) -> dict[str, Option]:
    """Return name in lower case -> option with the default in force, for every option of a case."""
    return {option.name.lower(): option for found in groups(case).values() for option in found}


def defaults(case: Any) -> dict[str, Any]:
    """Return name -> default in force for every option of a case; REQUIRED if it must be given."""
    return {option.name: option.default for option in table(case).values()}


class InForce(dict[str, Any]):
    """Name -> value of the options in force, as a case's build gets them.

    InputError for a name that there is not.
    """

    def __missing__(self, name: object) -> Any:
        raise InputError(f"opt[{name!r}]: there is no such option{_nearest(str(name), self)}")


# what was given


def is_option(word: str) -> bool:
    """PETSc's rule: a dash, or two, and a letter. -10, -.5 and -inf are values."""
    return re.match(r"--?(?!(inf|infinity|nan)$)[a-z]", word, re.IGNORECASE) is not None


def given_options(words: Sequence[str]) -> dict[str, str]:
    """Return name in lower case -> text, "" without a value, of the options that were given, each
    under the name that the tables have.

    PETSc, which runs, reads PETSC_OPTIONS, then the words of the command line, and the files that
    either names. Its database is empty afterwards. Not collective. InputError for what PETSc does
    not take and for a word that is no option's value, FileError for a file that cannot be read.
    """
    from petsc4py import PETSc

    for before, word in pairwise(["", *words]):
        if not is_option(word) and not is_option(before):
            what = f"unexpected argument {word[:80]!r}"
            raise InputError(f"{what}: a value comes right after its option")
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
    asked = (pair for pair in given.items() if pair[0] != "help")
    return {all_options.ALIASES.get(name, name): text for name, text in asked}


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
    inherited: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Return name -> typed value of every option in force; PETSc, which runs, gets those it is to
    follow.

    given: what the user gave (``given_options``). inherited: values of a checkpoint, as JSON has
    them, which stand for the defaults. Not collective; the same on all ranks. InputError for an
    unknown name, a missing or bad value.
    """
    from petsc4py import PETSc

    values = read_table(groups(case, extra, inherited), given)
    for option, value in values.items():
        if value is REQUIRED:
            raise InputError(f"-{option} must be given: the case has no default for it")
    for method in ("rk", "ssp"):  # who names one of PETSc's methods wants it, not the fused one
        if f"ts_{method}_type" in given and "ts_type" not in given:
            values["ts_type"] = method
    # who names times does not want the interval that the case suggests, and the other way round
    for this, instead in permutations(("fsi_output_times", "fsi_output_dt")):
        if this in given and instead not in given:
            values[instead] = None
    told = {option.name: values[option.name] for option in PETSC_OPTIONS}
    told |= {name: given.get(name) for name in all_options.IN_LOOP}
    if PETSc.Sys.getVersion() >= (3, 25):
        told["ts_time_step"] = told.pop("ts_dt")
    for name, value in told.items():
        if value is not None:
            PETSc.Options().setValue(name, str(value))
    return values


def read_table(
    sections: Mapping[str, Sequence[Option]], given: Mapping[str, str]
) -> dict[str, Any]:
    """Return name -> typed value of the options of a command: heading -> options, as ``groups`` has
    them. InputError for an unknown name or a bad value.
    """
    options = {option.name: option for found in sections.values() for option in found}
    known = [*options, *all_options.PASSED_ON]
    unknown = sorted(given.keys() - {name.lower() for name in known})
    if unknown:
        listed = ", ".join(f"-{name}{_nearest(name, known)}" for name in unknown)
        raise InputError(f"unknown option{'s' * (len(unknown) > 1)} {listed}")
    return {
        name: option.parse(given[name.lower()]) if name.lower() in given else option.default
        for name, option in options.items()
    }


def _nearest(name: str, names: Iterable[str]) -> str:
    """Return a hint in brackets for a name that is none of the names."""
    if "=" in name:
        return " (write '-name value', without =)"
    spelt = {known.lower(): known for known in names}
    petscs = name.lower().startswith(all_options.PETSCS)
    best = get_close_matches(name.lower(), sorted(spelt), 1, 0.85 if petscs else 0.6)
    if best:
        return f" (did you mean -{spelt[best[0]]}?)"
    if petscs:
        return " (an option of PETSc's that has no effect here; -help lists those that have)"
    return " (-help lists the options there are)"
