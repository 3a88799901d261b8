"""The command `verify`: cases against references that other codes can be tested with, too."""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from importlib.resources import files
from itertools import takewhile
from pathlib import Path

from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import Option
from fsipetsc.output.file_layout import writing
from fsipetsc.process.together import Comm
from fsipetsc.studies.trials import HEAD, USUAL, Row, Study, picture
from fsipetsc.studies.verify.entries import ENTRIES

OPTIONS = (
    Option("verify_level", str, "quick", "", "how many grids and orders", ("quick", "full")),
    Option("verify_docs", str, None, "", "folder for a page and a picture of each entry"),
    *USUAL,
)


def verify(arguments: list[str], comm: Comm) -> None:
    """Run the command. Collective; InputError, FileError; ComputationError if a row falls short."""
    names = list(takewhile(lambda word: not word.startswith("-"), arguments))
    study = Study(comm, arguments[len(names) :], OPTIONS, "verify")
    for name in names:
        if name not in ENTRIES:
            raise InputError(f"verify: there is no entry {name!r}: expected {', '.join(ENTRIES)}")
    counts: Counter[str] = Counter()
    for name in names or ENTRIES:
        text = problem(name)
        title, about = text.partition("\n")[0][2:], text.split("\n\n")[-1].rstrip()
        source = " ".join(about.split()).removeprefix("Reference: ").split(". Expected: ")[0]
        study.say(f"{title} ({name})\n{about}")
        measure, cells, quick = ENTRIES[name]
        if study.opt["verify_level"] == "quick":
            cells = {order: of[:2] for order, of in [*cells.items()][:quick]}
        grids = {order: [1.0 / n for n in of] for order, of in sorted(cells.items())}
        rows: list[Row] = []
        for trials in study.trials(grids):
            for trial in trials:
                measure(trial)
            rows += trials[0].rows.values()
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
    if rows and study.opt["verify_docs"]:
        where = Path(study.opt["verify_docs"]) / f"{name}.png"
        table = [f"| {' | '.join(cells)} |" for cells in (HEAD, *(row.cells for row in rows))]
        table.insert(1, "|---|---:|---|---|---|---|---|")
        lines = [problem(name), *table, "", f"![{title}]({name}.png)", ""]
        with writing(where, "the page"):
            where.with_suffix(".md").write_text("\n".join(lines), encoding="utf-8")
    picture(title, rows, where)


def problem(name: str) -> str:
    """Return problems/NAME.md: title, problem, parameters; then reference and expectation."""
    return (files("fsipetsc.studies.verify") / "problems" / f"{name}.md").read_text("utf-8")
