"""The command `verify`: cases against references that other codes can be tested with, too."""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from importlib.resources import files
from itertools import takewhile
from math import tau
from pathlib import Path
from typing import Any

from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import RUN, Option
from fsipetsc.output.file_layout import writing
from fsipetsc.process.together import Comm
from fsipetsc.studies.trials import HEAD, Row, Study, picture

OPTIONS = (
    Option("verify_level", str, "quick", "", "how many grids and orders", ("quick", "full")),
    Option("verify_docs", str, None, "", "folder for a page and a picture of each entry"),
    Option("fsi_output", str, "verify", "", "base name of the table NAME.csv and the pictures"),
    *(option for option in RUN if option.name == "fsi_quiet"),
)


#: entry, a function of fsipetsc.studies.verify.entries -> for the levels quick and full: order of
#: the operators -> cells in a unit of length
GRIDS: dict[str, tuple[Any, Any]] = {
    "vortex": ({4: (4, 8)}, {**dict.fromkeys((2, 4, 6), (4, 8, 16)), 8: (8, 16, 32)}),
    "shock_tubes": ({4: (200, 400)}, dict.fromkeys((2, 4, 6), (100, 200, 400))),
    "taylor_green": (
        {6: (16 / tau, 32 / tau)},
        {**dict.fromkeys((2, 6), (16 / tau, 32 / tau)), 4: (16 / tau, 32 / tau, 48 / tau)},
    ),
    "oblique": ({4: (16, 32)}, dict.fromkeys((2, 4, 6), (16, 32, 64))),
    "viscous_tube": ({}, {4: (100, 200, 400), 6: (100, 200)}),
    "elastic_piston": ({4: (20, 40)}, dict.fromkeys((2, 4, 6, 8), (40, 80, 160, 320))),
    "riemann_problems": ({4: (100, 200)}, dict.fromkeys((2, 4, 6), (100, 200, 400))),
    "superseismic": ({4: (20, 40)}, {**dict.fromkeys((2, 6, 8), (20, 40)), 4: (20, 40, 80)}),
    "shock_on_panel": ({}, {4: (200, 400)}),
    "spinning_disk": ({4: (20, 40)}, {4: (10, 20, 40), 6: (20, 40)}),
    "large_deformation": ({4: (12, 24)}, dict.fromkeys((2, 4, 6), (16, 32, 64))),
    "beam": ({4: (20, 30)}, dict.fromkeys((2, 4, 6), (20, 40))),
    "normal_modes": ({4: (16, 24)}, {4: (16, 32), 6: (24, 32)}),
    "panel_flutter": ({4: (24,)}, {4: (24, 32, 48)}),
}


def verify(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError at the end where a row falls short; FileError.
    """
    names = list(takewhile(lambda word: not word.startswith("-"), arguments))
    study = Study(comm, arguments[len(names) :], OPTIONS)
    for name in names:
        if name not in GRIDS:
            raise InputError(f"verify: there is no entry {name!r}: expected {', '.join(GRIDS)}")
    from fsipetsc.studies.verify import entries  # which start PETSc if none has

    counts: Counter[str] = Counter()
    for name in names or GRIDS:
        text = problem(name)
        title, about = text.partition("\n")[0][2:], text.split("\n\n")[-1].rstrip()
        source = " ".join(about.split()).removeprefix("Reference: ").split(". Expected: ")[0]
        study.say(f"{title} ({name})\n{about}")
        cells = GRIDS[name][study.opt["verify_level"] == "full"].items()
        grids = {order: [1.0 / n for n in of_order] for order, of_order in cells}
        measured = study.measured(grids, getattr(entries, name))
        rows = [row for of_order in measured for row in of_order]
        study.add(name, source, rows)  # the table is written again after each entry
        study.say("" if rows else "only with -verify_level full\n")
        study.on_first(partial(_show, study, name, title, rows))
        counts += Counter(row.verdict for row in rows)
    short = counts["falls short"]
    said = f"{counts['converges']} converge, {counts['holds']} hold, {short} fall short"
    study.say(f"{said} of {counts.total()} rows; saved {study.path}")
    if short:
        raise ComputationError(f"{short} of {counts.total()} rows fall short of what is expected")


def _show(study: Study, name: str, title: str, rows: Sequence[Row]) -> None:
    """The picture, and FOLDER/NAME.md with problem, table and picture if wanted. FileError."""
    where = study.path.with_name(f"{study.path.stem}-{name}.png")
    if study.opt["verify_docs"]:
        where = Path(study.opt["verify_docs"]) / f"{name}.png"
        lines = [problem(name), "Only `-verify_level full` runs this."]
        if rows:
            table = [f"| {' | '.join(cells)} |" for cells in (HEAD, *(row.cells for row in rows))]
            lines[1:] = [table[0], "|---|---:|---|---|---|---|---|", *table[1:]]
            lines += ["", f"![{title}]({name}.png)"]
        with writing(where, "the page"):
            where.with_suffix(".md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    picture(title, rows, where)


def problem(name: str) -> str:
    """Return problems/NAME.md: title, problem and parameters; then a paragraph with the reference,
    and why its errors are expected, which no run of this program says.
    """
    return (files("fsipetsc.studies.verify") / "problems" / f"{name}.md").read_text("utf-8")
