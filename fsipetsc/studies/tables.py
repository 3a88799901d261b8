"""What the commands of this folder have in common: tables, and work that ranks share."""

import csv
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from fsipetsc.errors import FileError, InputError
from fsipetsc.options import Option, read_options
from fsipetsc.output.file_layout import check_folder, writing
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, together, wait_asleep

Task, Result = TypeVar("Task"), TypeVar("Result")


def begin(
    case: Any,
    words: Sequence[str],
    comm: Comm,
    extra: Sequence[Option],
    name: str,
    instead: Mapping[str, str] | None = None,
) -> tuple[dict[str, Any], Path]:
    """Return the options in force of a study of a case, and its CSV file, NAME.csv if no name is
    given. Collective; InputError, FileError.

    instead: options of a run that a study does not take -> those that it takes.
    """
    given = start_petsc(words, comm)
    opt = read_options(case, given, extra)
    if opt["fsi_restart"] is not None:
        raise InputError("-fsi_restart: this command begins with the data of the case")
    for single, several in (instead or {}).items():
        if single in given:
            raise InputError(f"-{single} is for a single run; a study takes -{several}, a list")
    return opt, csv_target(opt["fsi_output"] if "fsi_output" in given else name)


def text_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Columns that end below each other, two blanks apart. A head may have several lines."""
    cells = [[str(cell) for cell in row] for row in rows]
    words = [cell.split("\n") for cell in head]
    lines = [[w[k] if k < len(w) else "" for w in words] for k in range(max(map(len, words)))]
    widths = [max(map(len, column)) for column in zip(*lines, *cells)]
    return "\n".join(
        "  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths)).rstrip()
        for line in (*lines, *cells)
    )


def save_csv(
    comm: Comm, path: Path, head: Sequence[str], rows: Iterable[Sequence[object]], about: str = ""
) -> None:
    """Write a table of rank 0; about: a first line, which begins with #. Collective; FileError."""

    def write() -> None:
        with writing(path, "the table"), path.open("w", newline="", encoding="utf-8") as file:
            file.write(f"# {about}\n" if about else "")
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(head)
            writer.writerows(rows)

    on_first(comm, write)


def on_first(comm: Comm, action: Callable[[], Result]) -> Result | None:
    """action() on rank 0, while the others sleep: what it gives there, None elsewhere. Collective;
    FsiError of rank 0 on all."""
    return together(comm, action if comm.rank == 0 else lambda: None, asleep=True)


def csv_target(name: str) -> Path:
    """The CSV file of a study that is called NAME, NAME.csv, NAME.h5 or NAME.png. FileError."""
    given = Path(name)
    bare = given.with_suffix("") if given.suffix in (".csv", ".h5", ".png") else given
    path = bare.with_name(f"{bare.name}.csv") if given.name else given
    check_folder(path)
    if path.is_dir():
        raise FileError(f"{path}: is a directory")
    return path


@contextmanager
def results_folder(comm: Comm, beside: Path, prefix: str) -> Iterator[Path]:
    """A new folder in the folder `beside`, PREFIX…, for results that are removed in the end.

    Collective; FileError.
    """

    def made() -> str:
        with writing(beside / f"{prefix}…", "results"):
            return tempfile.mkdtemp(dir=beside, prefix=prefix)

    folder = Path(comm.bcast(together(comm, lambda: "" if comm.rank else made())))
    try:
        yield folder
        wait_asleep(comm)  # other ranks may still read
    finally:
        if comm.rank == 0:
            shutil.rmtree(folder, ignore_errors=True)


def shared(comm: Comm, tasks: Sequence[Task], one: Callable[[Task], Result]) -> list[Result]:
    """one(task) of all tasks on every rank; each computes its share. Collective; FsiError."""
    mine = together(comm, lambda: [one(task) for task in tasks[comm.rank :: comm.size]])
    shares = comm.allgather(mine)
    return [shares[i % comm.size][i // comm.size] for i in range(len(tasks))]


def printer(comm: Comm, opt: Mapping[str, Any]) -> Callable[[str], None]:
    """Return what prints on rank 0, and nothing with -fsi_quiet."""
    quiet = opt["fsi_quiet"] or comm.rank > 0
    return (lambda text: None) if quiet else (lambda text: print(text, flush=True))


def listed_in(allowed: Sequence[int]) -> Callable[[Sequence[int]], str | None]:
    """Return the check of an option: some of the allowed numbers."""
    words = f"numbers out of {','.join(map(str, allowed))}"
    return lambda values: None if values and set(values) <= set(allowed) else words
