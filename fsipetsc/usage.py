"""The texts that explain the program: the overview and the options of a case, laid out as
tables.
"""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from fsipetsc.options import groups
from fsipetsc.options.option import INT_MAX, REQUIRED, Option
from fsipetsc.options.tables import AT_START, IN_LOOP, IN_SOURCES

_TYPES = {
    "int": "int",
    "float": "float",
    "str": "text",
    "bool": "bool",
    "ints": "ints",
    "floats": "floats",
}


#: characters of the first column of an overview
_LEFT = 29
_HEADER = ("option", "type", "default", "meaning")
_NOTES = """
An option is written -name value. If one is given more than once the last counts, and the command
line overrides PETSC_OPTIONS. A bool without a value is true; ints and floats are lists such as
0.1,0.25. These are all options there are: of PETSc's own, others are refused.
"""


def program() -> str:
    """How this program was called, for examples that can be copied."""
    return (
        "python -m fsipetsc"
        if os.path.basename(sys.argv[0]) in ("__main__.py", "-m", "-c")
        else "fsipetsc"
    )


def overview(cases: Mapping[str, str], commands: Mapping[str, tuple[str, str]]) -> str:
    """The short usage; cases: name -> summary; commands: name -> (arguments, summary)."""
    me = program()
    sections = {
        "Usage": {
            f"{me} CASE [-option value ...]": "run a case; in parallel with mpiexec -n N before it",
            f"{me} CASE -help": "all options of a case, with defaults and units",
            f"{me} COMMAND ...": "do something else",
        },
        "Cases": {**cases, "FILE.py": "a case of your own, from a file"},
        "Commands": {
            f"{name} {arguments}".rstrip(): summary
            for name, (arguments, summary) in commands.items()
        },
    }
    lines = ["fsipetsc: fluid–structure interaction in layers, with PETSc"]
    for title, rows in sections.items():
        lines += ["", title, *_listed(rows)]
    return "\n".join(lines)


def _listed(rows: Mapping[str, str]) -> list[str]:
    """Names and what they mean in two columns; of what is too long for the first one the meaning
    begins a new line.
    """
    indent = 4 + max(len(left) for left in rows if len(left) <= _LEFT)
    lines = []
    for left, right in rows.items():
        first = f"  {left:<{indent - 2}}" if len(left) <= _LEFT else " " * indent
        if len(left) > _LEFT:
            lines += textwrap.wrap(
                left,
                _width(),
                initial_indent="  ",
                subsequent_indent="    ",
                break_on_hyphens=False,
            )
        lines += textwrap.wrap(
            right,
            _width(),
            initial_indent=first,
            subsequent_indent=" " * indent,
            break_on_hyphens=False,
        )
    return lines


def _width() -> int:
    """Of what is printed, in characters."""
    return min(max(shutil.get_terminal_size((110, 24)).columns, 80), 120)


def case_help(case: Any, called: str) -> str:
    """Every option of a case with type, default, unit and meaning; called: the case as the user
    named it.
    """
    title = f"{case.NAME}: {case.SUMMARY}" if case.SUMMARY else case.NAME
    return _help(title, f"[mpiexec -n N] {program()} {called} [-option value ...]", groups(case))


def command_help(
    name: str, arguments: str, summary: str, sections: Mapping[str, Sequence[Option]]
) -> str:
    """The same for a command with options of its own; sections: heading -> options."""
    return _help(
        f"{name}: {summary}",
        f"[mpiexec -n N] {program()} {name} {arguments}",
        sections,
        IN_SOURCES + AT_START,
    )


def _help(
    title: str,
    usage: str,
    groups: Mapping[str, Sequence[Option]],
    petsc: Sequence[Option] = IN_SOURCES + IN_LOOP + AT_START,
) -> str:
    width = _width()
    sections = {
        heading: [_row(option) for option in options] for heading, options in groups.items()
    }
    sections["More of PETSc"] = [
        (f"-{option.name}", *_taken(option), option.help) for option in petsc
    ]
    rows = [row for section in sections.values() for row in section]
    columns = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = [title, "", f"  {usage}", "", *_laid_out(_HEADER, columns, width)]
    for heading, section in sections.items():
        lines += ["", heading]
        for row in section:
            lines += _laid_out(row, columns, width)
    lines += ["", *textwrap.wrap(_NOTES.strip(), width)]
    return "\n".join(lines)


def _taken(option: Option) -> tuple[str, str]:
    """What an option of PETSc's takes, in the columns of types and of defaults."""
    return (f"[{option.unit}]" if option.unit else "") if option.kind == "optional" else _TYPES[
        option.kind
    ], ""


def _row(option: Option) -> tuple[str, str, str, str]:
    choices = f": {', '.join(map(str, option.choices))}" if option.choices else ""
    return f"-{option.name}", _TYPES[option.kind], shown(option), option.help + choices


def shown(option: Option) -> str:
    """The default with its unit, as text."""
    value = option.default
    if value is REQUIRED:
        return f"required [{option.unit}]" if option.unit else "required"
    if value is None:
        return f"none [{option.unit}]" if option.unit else "none"
    if isinstance(value, bool):
        return str(value).lower()
    if value == INT_MAX:
        return "no limit"
    items = value if isinstance(value, tuple) else (value,)
    text = ",".join(f"{item:.10g}" if isinstance(item, float) else str(item) for item in items)
    return f"{text} {option.unit}".rstrip()


def _laid_out(row: Sequence[str], columns: Sequence[int], width: int) -> list[str]:
    """One option: three columns and the wrapped meaning in a fourth."""
    left = "  " + "  ".join(f"{text:<{n}}" for text, n in zip(row[:3], columns)) + "  "
    return textwrap.wrap(
        row[3], max(width, len(left) + 30), initial_indent=left, subsequent_indent=" " * len(left),
        break_on_hyphens=False,
    ) or [left.rstrip()]  # fmt: skip
