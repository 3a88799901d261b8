"""What the commands of this folder have in common: tables, and work that ranks share."""

from __future__ import annotations

import csv
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fsipetsc.errors import FileError
from fsipetsc.process.together import together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

Task, Result = TypeVar("Task"), TypeVar("Result")


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
    path: Path, head: Sequence[str], rows: Iterable[Sequence[object]], about: str = ""
) -> Path:
    """Write a table; about: a first line, which begins with #. FileError."""
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            file.write(f"# {about}\n" if about else "")
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(head)
            writer.writerows(rows)
    except OSError as error:
        raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error
    return path


def csv_target(name: str) -> Path:
    """The CSV file of a study that is called NAME, whatever suffix the name has. FileError."""
    path = Path(name).with_suffix(".csv")
    if not path.parent.is_dir() or path.is_dir():
        wrong = "is a directory" if path.is_dir() else f"no directory {path.parent}"
        raise FileError(f"{path}: {wrong}")
    return path


@contextmanager
def results_folder(comm: MPI.Comm, beside: Path, prefix: str) -> Iterator[Path]:
    """A new folder in the folder `beside`, PREFIX…, for results that are removed in the end.

    Collective; FileError.
    """

    def made() -> str:
        try:
            return tempfile.mkdtemp(dir=beside, prefix=prefix)
        except OSError as error:
            raise FileError(f"{beside}: cannot keep results there: {error.strerror}") from None

    folder = Path(comm.bcast(together(comm, lambda: "" if comm.rank else made())))
    try:
        yield folder
        wait_asleep(comm)  # other ranks may still read
    finally:
        if comm.rank == 0:
            shutil.rmtree(folder, ignore_errors=True)


def shared(comm: MPI.Comm, tasks: Sequence[Task], one: Callable[[Task], Result]) -> list[Result]:
    """one(task) of all tasks on every rank; each computes its share. Collective; FsiError."""
    mine = together(comm, lambda: [one(task) for task in tasks[comm.rank :: comm.size]])
    shares = comm.allgather(mine)
    return [shares[i % comm.size][i // comm.size] for i in range(len(tasks))]


def printer(comm: MPI.Comm, opt: Mapping[str, Any]) -> Callable[[str], None]:
    """Prints on rank 0, and nothing with -fsi_quiet."""
    quiet = opt["fsi_quiet"] or comm.rank > 0
    return (lambda text: None) if quiet else (lambda text: print(text, flush=True))


def listed_in(allowed: Sequence[int]) -> Callable[[Sequence[int]], str | None]:
    """Check of an option: some of the allowed numbers."""
    words = f"numbers out of {','.join(map(str, allowed))}"
    return lambda values: None if values and set(values) <= set(allowed) else words
