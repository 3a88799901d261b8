"""The texts that explain the program: the overview and the options of a case, as tables."""

import os
import sys
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from fsipetsc.options import groups
from fsipetsc.options.option import INT_MAX, REQUIRED, Option
from fsipetsc.options.tables import IN_LOOP, PASSED_ON

#: characters of a line, and of the first column of an overview
WIDTH, _LEFT = 100, 29
_HEADER = ("option", "type", "default", "meaning")
_NOTES = (
    "An option is written -name value. If one is given more than once the last counts, and the "
    "command line overrides PETSC_OPTIONS. A bool without a value is true; ints and floats are "
    "lists such as 0.1,0.25. These are all options there are: of PETSc's own, others are refused."
)


def program() -> str:
    """How this program was called, for examples that can be copied."""
    by_module = os.path.basename(sys.argv[0]) in ("__main__.py", "-m", "-c")
    return "python -m fsipetsc" if by_module else "fsipetsc"


def overview(cases: Mapping[str, str], commands: Mapping[str, tuple[str, str]]) -> str:
    """The short usage; cases: name -> summary; commands: name -> (arguments, summary)."""
    me = program()
    sections = {
        "Usage": {
            f"{me} CASE [-option value ...]": "run a case; in parallel with mpiexec -n N before it",
            f"{me} CASE -help": "all options of a case, with defaults and units",
            f"{me} COMMAND ...": "run a command, see below",
        },
        "Cases": {**cases, "FILE.py": "a case of your own, from a file"},
        "Commands": {f"{name} {words}".rstrip(): what for name, (words, what) in commands.items()},
    }
    lines = ["fsipetsc: compressible gas and elastic solids, coupled, with PETSc"]
    for title, rows in sections.items():
        lines += ["", title]
        for left, right in rows.items():
            long = len(left) > _LEFT  # beside such a name the line stays empty
            lines += _wrapped(left, "  ", 4) if long else []
            lines += _wrapped(right, f"  {'' if long else left:<{_LEFT}}  ", _LEFT + 4)
    return "\n".join(lines)


def _wrapped(text: str, first: str, indent: int) -> list[str]:
    """Lines of a text: after ``first``, then indented."""
    width = max(WIDTH, indent + 30)
    form = textwrap.TextWrapper(width, first, " " * indent, break_on_hyphens=False)
    return form.wrap(text) or [first.rstrip()]


def case_help(case: Any, called: str) -> str:
    """Every option of a case with type, default, unit and meaning; called: as the user did."""
    title = f"{case.NAME}: {case.SUMMARY}" if case.SUMMARY else case.NAME
    return _help(title, f"{called} [-option value ...]", groups(case), PASSED_ON)


def command_help(
    name: str, arguments: str, summary: str, sections: Mapping[str, Sequence[Option]]
) -> str:
    """The same for a command with options of its own; sections: heading -> options."""
    petsc = {option: what for option, what in PASSED_ON.items() if option not in IN_LOOP}
    return _help(f"{name}: {summary}", f"{name} {arguments}", sections, petsc)


def _help(
    title: str, usage: str, groups: Mapping[str, Sequence[Option]], petsc: Mapping[str, str]
) -> str:
    sections = {heading: [_row(option) for option in rows] for heading, rows in groups.items()}
    sections["More of PETSc"] = [(f"-{name}", "", "", what) for name, what in petsc.items()]
    rows = [_HEADER, *(row for section in sections.values() for row in section)]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]

    def laid_out(row: Sequence[str]) -> list[str]:
        columns = (f"{text:<{n}}" for text, n in zip(row, widths))
        return _wrapped(row[3], f"  {'  '.join(columns)}  ", sum(widths) + 8)

    lines = [title, "", f"  [mpiexec -n N] {program()} {usage}", "", *laid_out(_HEADER)]
    for heading, section in sections.items():
        lines += ["", heading, *(line for row in section for line in laid_out(row))]
    return "\n".join([*lines, "", *textwrap.wrap(_NOTES, WIDTH)])


def _row(option: Option) -> tuple[str, str, str, str]:
    """Name, type, default and meaning."""
    choices = f": {', '.join(map(str, option.choices))}" if option.choices else ""
    kind = "text" if option.kind == "str" else str(option.kind)
    return f"-{option.name}", kind, _shown(option), option.help + choices


def _shown(option: Option) -> str:
    """The default with its unit, as text."""
    value = option.default
    if value is REQUIRED or value is None:
        unit = f" [{option.unit}]" if option.unit else ""
        return f"{'none' if value is None else 'required'}{unit}"
    if isinstance(value, bool):
        return str(value).lower()
    if value == INT_MAX:
        return "no limit"
    items = value if isinstance(value, tuple) else (value,)
    text = ",".join(f"{item:.10g}" if isinstance(item, float) else str(item) for item in items)
    return f"{text} {option.unit}".rstrip()
