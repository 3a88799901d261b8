"""The table of options: -help, checking, the options stored with a result and the docs use it.

PETSc reads the command line, PETSC_OPTIONS and options files into its database. What it then holds
is checked here, once. The rest of the program gets a dict of typed values; PETSc's database keeps
what PETSc is to follow.
"""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any

from fsipetsc.blame import brief
from fsipetsc.errors import FileError, InputError, petsc_words
from fsipetsc.options import tables
from fsipetsc.options.option import REQUIRED, Option, above_one
from fsipetsc.options.tables import COMMON, OF_A_RUN, PETSC_OPTIONS, RUN

__all__ = [
    "COMMON", "OF_A_RUN", "PETSC_OPTIONS", "REQUIRED", "RUN", "InForce", "Option",
    "above_one", "defaults", "given_options", "groups", "is_option", "present", "put",
    "read_options", "read_table", "spelt", "table",
]  # fmt: skip

#: PETSc's error where an options file cannot be read
_UNREADABLE = "Unable to open", "Specified options file"


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
        "Discretisation": tables.DISCRETISATION,
        "Output": tables.OUTPUT,
        "Checkpoints": tables.CHECKPOINTS,
        "Run": RUN,
        "Time integration (PETSc)": PETSC_OPTIONS,
    }
    taken = {option.name.lower() for option in COMMON + PETSC_OPTIONS} | {*tables.PASSED_ON, "help"}
    for name in (option.name.lower() for option in case.OPTIONS):
        if name in taken or name.startswith(tables.PETSCS):
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
        return _with_default(option, values.get(option.name, option.default), case.NAME)

    return {title: tuple(map(in_force, found)) for title, found in sections.items() if found}


def table(
    case: Any, extra: Sequence[Option] = (), inherited: Mapping[str, Any] | None = None
) -> dict[str, Option]:
    """Name in lower case -> option with the default in force, for every option of a case."""
    every = (option for options in groups(case, extra, inherited).values() for option in options)
    return {option.name.lower(): option for option in every}


def defaults(case: Any) -> dict[str, Any]:
    """Name -> default in force for every option of a case; REQUIRED if the user must give it."""
    return {option.name: option.default for option in table(case).values()}


def _with_default(option: Option, value: Any, case: str) -> Option:
    try:
        if value is None and option.default is not None:
            raise ValueError  # None is for what need not be set
        return replace(option, default=option.convert(value))
    except (ValueError, TypeError, OverflowError):
        what = f"bad default {value!r} of -{option.name}: expected {option.expected()}"
        raise InputError(f"case {case}: {what}") from None


class InForce(dict[str, Any]):
    """Name -> value of the options in force, as a case's build gets them.

    InputError for a name that there is not.
    """

    def __missing__(self, name: object) -> Any:
        raise InputError(f"opt[{name!r}]: there is no such option{_nearest(str(name), self)}")


# what was given


def is_option(word: str) -> bool:
    """PETSc's rule: a dash, or two, and a letter. -10, -.5 and -inf are values."""
    number = word.lower() in ("-inf", "-infinity", "-nan")
    return re.match(r"--?[A-Za-z]", word) is not None and not number


def given_options(words: Sequence[str]) -> dict[str, str]:
    """Name in lower case -> text, "" without a value, of the options that were given.

    PETSc, which runs, reads PETSC_OPTIONS, then the words of the command line, and the files that
    either names; its database holds these options alone then, and none after an error. Not
    collective. InputError, FileError for what PETSc does not take, InputError for a word that is no
    option's value, and for an options file that names another one.
    """
    from petsc4py import PETSc

    put({})
    for before, word in pairwise(["", *words]):
        if not is_option(word) and not is_option(before):
            what = f"unexpected argument '{brief(word)}'"
            raise InputError(f"{what}: a value comes right after its option")
    quoted = (word if is_option(word) else _quoted(word) for word in words)
    environment = os.environ.get("PETSC_OPTIONS", "").split()
    for option, name in pairwise([*environment, *words]):
        if option.lstrip("-").lower() in ("options_file", "options_file_yaml"):
            _refuse_nesting(Path(name))
    for text in (" ".join(environment), " ".join(quoted)):
        try:
            PETSc.Options().insertString(text)
        except PETSc.Error as error:
            put({})
            said = petsc_words(error).split(": ", 1)[-1].split("; ")[-1]
            kind = FileError if any(text in said for text in _UNREADABLE) else InputError
            raise kind(f"options: {said}") from None
    given = {name.lower(): text for name, text in present().items()}
    return {name: text for name, text in given.items() if name != "help"}


def _refuse_nesting(file: Path) -> None:
    """InputError for an options file that names another: PETSc crashes where one names itself."""
    with suppress(OSError):  # PETSc says so
        text = file.read_text(errors="replace") if file.is_file() else ""
        if re.search(r"^[^#\n]*\boptions_file", text, re.MULTILINE | re.IGNORECASE):
            raise InputError(f"-options_file {file}: an options file cannot name another one")


def _quoted(word: str) -> str:
    mark = "'" if '"' in word else '"'
    return f"{mark}{word}{mark}"


def present() -> dict[str, str]:
    """Name -> text of all options in PETSc's database; "" if there is no value."""
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


def spelt(given: Mapping[str, str], name: str) -> str | None:
    """What the user gave for an option, under one of its names."""
    names = [name.lower(), *(alias for alias, meant in tables.ALIASES.items() if meant == name)]
    return next((given[spelling] for spelling in names if spelling in given), None)


def read_options(
    case: Any,
    given: Mapping[str, str],
    extra: Sequence[Option] = (),
    inherited: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Name -> typed value of every option in force; PETSc, which runs, gets those it is to follow.

    given: what the user gave (``given_options``). inherited: values of a checkpoint, as JSON has
    them, which stand for the defaults. Not collective; the same on all ranks. InputError for an
    unknown name, a missing or bad value.
    """
    values = _read(table(case, extra, inherited), given)
    for option, value in values.items():
        if value is REQUIRED:
            raise InputError(f"-{option} must be given: the case has no default for it")
    for method in ("rk", "ssp"):  # who names one of PETSc's methods wants it, not the fused one
        if f"ts_{method}_type" in given and "ts_type" not in given:
            values["ts_type"] = method
    # who names times does not want the interval that the case suggests, and the other way round
    one, other = "fsi_output_times", "fsi_output_dt"
    for this, instead in ((one, other), (other, one)):
        if this in given and instead not in given:
            values[instead] = None
    _tell_petsc(values, given)
    return values


def _tell_petsc(values: Mapping[str, Any], given: Mapping[str, str]) -> None:
    """Put what PETSc's time integrator follows into its database, as this release names it."""
    from petsc4py import PETSc

    database = PETSc.Options()
    told = {name: given[name] for name in tables.IN_LOOP if name in given}
    for option in PETSC_OPTIONS:
        method = option.name.split("_")[1]  # ts_rk_type is of ts_type rk
        unused = method in ("rk", "ssp") and values["ts_type"] != method
        if values[option.name] is not None and not unused:
            told[option.name] = str(values[option.name])
    if "ts_dt" in told and PETSc.Sys.getVersion() >= (3, 25):
        told["ts_time_step"] = told.pop("ts_dt")
    for name in (*tables.ALIASES, *tables.IN_LOOP, *(option.name for option in PETSC_OPTIONS)):
        database.delValue(name)
    for name, text in told.items():
        database.setValue(name, text)


def read_table(
    sections: Mapping[str, Sequence[Option]], given: Mapping[str, str]
) -> dict[str, Any]:
    """Name -> typed value of the options of a command that runs no case.

    sections: heading -> options, as for ``groups``. InputError for an unknown name or a bad value.
    """
    every = (option for options in sections.values() for option in options)
    return _read({option.name.lower(): option for option in every}, given)


def _read(options: Mapping[str, Option], given: Mapping[str, str]) -> dict[str, Any]:
    """Name -> value; options: name in lower case -> option."""
    known = [option.name for option in options.values()] + list(tables.PASSED_ON)
    known += [alias for alias, name in tables.ALIASES.items() if name in options]
    lower = {name.lower() for name in known}
    unknown = [
        f"-{brief(name)}{_nearest(name, known)}" for name in sorted(given) if name not in lower
    ]
    if unknown:
        raise InputError(f"unknown option{'s' * (len(unknown) > 1)} {', '.join(unknown)}")
    values = {option.name: option.default for option in options.values()}
    for name, text in given.items():
        option = options.get(tables.ALIASES.get(name, name))
        if option is not None:
            values[option.name] = option.parse(text)
    return values


def _nearest(name: str, names: Iterable[str]) -> str:
    """A hint in brackets for a name that is none of the names."""
    if "=" in name:
        return " (write '-name value', without =)"
    spelt = {known.lower(): known for known in names}
    petscs = name.lower().startswith(tables.PETSCS)
    best = get_close_matches(name.lower(), sorted(spelt), 1, 0.85 if petscs else 0.6)
    if best:
        return f" (did you mean -{spelt[best[0]]}?)"
    if petscs:
        return " (an option of PETSc's that has no effect here; -help lists those that have)"
    return " (-help lists the options there are)"
