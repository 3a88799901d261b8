"""The texts that explain the program: the overview and the options of a case, as tables."""

import textwrap
from collections.abc import Mapping, Sequence

from fsipetsc.options.all_options import IN_LOOP, PASSED_ON
from fsipetsc.options.option import INT_MAX, REQUIRED, Option

#: how the program is called, in examples that can be copied
PROGRAM = "python -m fsipetsc"
#: characters of a line
WIDTH = 100
_NOTES = (
    "An option is written -name value; above its type and default follow its name. If one is given "
    "more than once the last counts, and the command line overrides PETSC_OPTIONS. A bool without "
    "a value is true; ints and floats are lists such as 0.1,0.25. These are all options there are: "
    "of PETSc's own, others are refused."
)


def overview(cases: Mapping[str, str], commands: Mapping[str, tuple[str, str]]) -> str:
    """The short usage; cases: name -> summary; commands: name -> (arguments, summary)."""
    sections = {
        f"Usage: {PROGRAM} ...": {
            "CASE [-option value ...]": "run a case; in parallel with mpiexec -n N before it",
            "CASE -help": "all options of a case, with defaults and units",
            "COMMAND ...": "run a command, see below",
        },
        "Cases": {**cases, "FILE.py": "a case of your own, from a file"},
        "Commands": {f"{name} {words}": what for name, (words, what) in commands.items()},
    }
    title = "fsipetsc: compressible gas and elastic solids, coupled, with PETSc"
    return _laid_out(title, sections, 29)


def options_help(
    title: str, usage: str, options: Mapping[str, Sequence[Option]], in_loop: bool = True
) -> str:
    """Every option with type, default, unit and meaning; options: heading -> options. usage: what
    comes after the program's name. in_loop: the options of PETSc's time integrator count.
    """
    head = f"{title}\n\n  [mpiexec -n N] {PROGRAM} {usage}"
    sections = {heading: dict(map(_row, found)) for heading, found in options.items()}
    petsc = {f"-{o}": what for o, what in PASSED_ON.items() if in_loop or o not in IN_LOOP}
    sections["More of PETSc"] = petsc
    return "\n".join([_laid_out(head, sections, 44), "", *textwrap.wrap(_NOTES, WIDTH)])


def _laid_out(title: str, sections: Mapping[str, Mapping[str, str]], most: int) -> str:
    """sections: heading -> name -> text, which stands on the right of the name, or below it if that
    has more than ``most`` characters.
    """
    names = [name for rows in sections.values() for name in rows]
    left, lines = max(len(name) for name in names if len(name) <= most), [title]
    form = textwrap.TextWrapper(WIDTH, break_on_hyphens=False, subsequent_indent=" " * (left + 4))
    for heading, rows in sections.items():
        lines += ["", heading]
        for name, text in rows.items():
            below = textwrap.wrap(name, WIDTH, initial_indent="  ", subsequent_indent=" " * 4)
            lines += below if len(name) > left else []
            form.initial_indent = f"  {'' if len(name) > left else name:<{left}}  "
            lines += form.wrap(text) or [form.initial_indent.rstrip()]
    return "\n".join(lines)


def _row(option: Option) -> tuple[str, str]:
    """(name, type, default and unit; meaning)."""
    kind = "text" if option.kind == "str" else option.kind
    choices = f": {', '.join(map(str, option.choices))}" if option.choices else ""
    value, unit = option.default, option.unit
    if value is REQUIRED or value is None:
        text, unit = "none" if value is None else "required", f"[{unit}]" if unit else ""
    elif isinstance(value, bool):
        text = str(value).lower()
    elif value == INT_MAX:
        text = "no limit"
    else:
        items = value if isinstance(value, tuple) else (value,)
        text = ",".join(f"{item:.10g}" if isinstance(item, float) else str(item) for item in items)
    return f"-{option.name} {kind} {text} {unit}".rstrip(), option.help + choices
