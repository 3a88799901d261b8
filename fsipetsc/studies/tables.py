"""What the commands of this folder share: their options, work on all ranks, tables."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fsipetsc.errors import InputError
from fsipetsc.options import read_options, read_table
from fsipetsc.output.file_layout import check_folder, writing
from fsipetsc.output.info import table
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, done_asleep, together


class Study:
    """A command of this folder as it runs on all ranks of comm. Making one, and all methods but
    ``say``, are collective.

    words: arguments of the command. options: heading -> its options, or with a case those beside
    the case's. name: of its CSV file if none is given. opt: the options in force; given: those that
    were given; path: of the CSV file. InputError, FileError.
    """

    def __init__(
        self, comm: Comm, words: Sequence[str], options: Any, name: str = "", case: Any = None
    ) -> None:
        self.comm, self.given = comm, start_petsc(words, comm)
        if case is None:
            self.opt = read_table(options, self.given)
        else:
            self.opt = read_options(case, self.given, options)
            if self.opt["fsi_restart"] is not None:
                raise InputError("-fsi_restart: this command begins with the data of the case")
        target = self.opt["fsi_output"] if case is None or "fsi_output" in self.given else name
        self.path = Path(re.sub(r"\.(csv|h5|png)$", "", target) + ".csv")
        check_folder(self.path)

    def say(self, text: str) -> None:
        """Print on rank 0; nothing with -fsi_quiet."""
        if self.comm.rank == 0 and not self.opt["fsi_quiet"]:
            print(text, flush=True)

    def save(self, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
        """Write a table of rank 0. FileError."""

        def write() -> None:
            with writing(self.path, "the table"), self.path.open("w", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerows([head, *rows])

        self.on_first(write)

    def table(self, head: Sequence[str], rows: Sequence[Sequence[object]], spec: str) -> None:
        """Print and write a table of rank 0; spec: format of the numbers that are printed."""
        cells = [[format(v, spec) if isinstance(v, float) else v for v in row] for row in rows]
        self.say(table([head, *cells], str.rjust))
        self.save(head, rows)
        self.say(f"\nsaved {self.path}")

    def on_first(self, action: Callable[[], Any]) -> Any:
        """action() on rank 0, while the others sleep: what it gives there, None elsewhere. FsiError
        of rank 0 on all.
        """
        here = self.comm.rank == 0
        return together(self.comm, action if here else lambda: None, asleep=True)

    @contextmanager
    def results_folder(self) -> Iterator[Path]:
        """A new folder beside the table, for results that are removed in the end."""
        where = {"dir": self.path.parent, "prefix": f"{self.path.stem}-"}
        made = partial(TemporaryDirectory, **where, ignore_cleanup_errors=True)
        with self.on_first(made) or nullcontext() as folder:
            yield Path(self.comm.bcast(folder))
            done_asleep(self.comm.Ibarrier())  # other ranks may still read


def listed_in(allowed: Sequence[int]) -> Callable[[Sequence[int]], str | None]:
    """Return the check of an option: some of the allowed numbers."""
    words = f"numbers out of {','.join(map(str, allowed))}"
    return lambda values: None if values and set(values) <= set(allowed) else words
