"""The command `python -m fsipetsc bench`: what a time step costs, of the falling rod and of a gas beneath a solid in two
dimensions (fsipetsc.bench.plane), and where the time goes.

Measured for orders, grids and numbers of ranks (`mpiexec -n N` for up to N), one after the other, with ranks that have
no part sleeping: whole steps and their parts (fsipetsc.bench.measure), the bandwidth of memory, another program
if there is one (-bench_yardstick), and then output, start and memory of the program. Results are a table, the same as CSV,
a picture, and a model of the cost (fsipetsc.bench.cost_model); -bench_doc renews the tables of a Markdown file.
Nothing else should run on the machine meanwhile: the load is noted, and a warning printed.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsipetsc.options import RUN, read_table
from fsipetsc.options.option import Option
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.bench.table import BenchStudy


def _orders_only(values: Sequence[int]) -> str | None:
    return None if values and set(values) <= {2, 4, 6, 8} else "orders out of 2, 4, 6, 8"


def _dimensions_only(values: Sequence[int]) -> str | None:
    return None if values and set(values) <= {1, 2} else "1, 2 or both"


def _counts(values: Sequence[int]) -> str | None:
    return None if values and min(values) > 0 else "whole numbers above 0"


#: the names in fsipetsc.bench.square, which takes long to load
_FORMS = "entropy", "divergence", "viscous", "divergence-viscous"
OPTIONS = (
    Option("bench_orders", "ints", (4, 6, 8), "", "orders to measure", check=_orders_only),
    Option(
        *("bench_points", "ints", (480, 3840, 10_000, 100_000, 1_000_000), "points", "sizes of the grids, about"),
        check=_counts,
    ),
    Option("bench_ranks", "ints", None, "", "numbers of ranks; default 1, 2, 4 … up to those there are", check=_counts),
    Option("bench_seconds", float, 0.2, "s", "how long one sample takes, about", check="positive"),
    Option("bench_repeats", int, 5, "", "samples of each number, of which the median counts", check="positive"),
    Option(
        *("bench_yardstick", str, None, "", "folder of another program to compare with: its `rod ORDER H T -q -n STEPS`"),
    ),
    Option("bench_dimensions", "ints", (1, 2), "", "measure problems of one dimension, of two", check=_dimensions_only),
    Option("bench_squares", "ints", (64, 128, 256, 512), "", "columns and rows of a layer in two dimensions", check=_counts),
    Option("bench_form", str, "all", "", "what is measured in two dimensions", ("all", *_FORMS)),
    Option(
        *("bench_plane_yardstick", str, None, "", "folder of such a program of two dimensions: its `plane ORDER N N STEPS -q`"),
    ),
    Option("bench_more", bool, True, "", "measure weak scaling, output, start of the program and memory too"),
    Option("bench_from", str, None, "", "measure nothing: take the CSV of an earlier benchmark"),
    Option("bench_doc", str, None, "", "Markdown file whose tables are renewed"),
    Option("fsi_output", str, "bench", "", "base name of the results: NAME.csv, NAME-facts.csv, NAME.png"),
)
_OF_RUN = ("fsi_quiet", "fsi_partition", "fsi_shared_memory", "fsi_debug")
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Benchmark": OPTIONS,
    "Run": tuple(option for option in RUN if option.name in _OF_RUN),
}


def bench(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    Raises InputError for options, ranks that do not fit, and a yardstick that does not run; FileError.
    """
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    opt = read_table(SECTIONS, start_petsc(arguments, comm))
    say = (lambda text: None) if opt["fsi_quiet"] or comm.rank else (lambda text: print(text, flush=True))
    if opt["bench_from"]:
        from fsipetsc.bench.table import load

        study = load(Path(opt["bench_from"]))
    else:
        from fsipetsc.bench.study import measure

        study = measure(opt, comm, say)
    if comm.rank == 0:
        _present(study, opt, say)
    wait_asleep(comm)


def _present(study: BenchStudy, opt: Mapping[str, Any], say: Any) -> None:
    """Print what was not printed during the measurement, save everything."""
    from fsipetsc.bench.cost_model import fit
    from fsipetsc.bench.document import model_text, renew
    from fsipetsc.bench.figure import draw
    from fsipetsc.bench.plane import save
    from fsipetsc.bench.table import heading, line

    path, model, written = Path(f"{opt['fsi_output']}.csv"), None, []
    if opt["bench_from"]:
        say("\n".join([heading(), *map(line, study.rows)]))
    if study.rows:
        model = fit(study)
        say(model_text(model, study))
        if not opt["bench_from"]:
            study.save(path)
        picture = draw(study, model, path.with_suffix(".png"))
        written += [path, picture or "no picture: matplotlib is not installed"]
    if study.plane and not opt["bench_from"]:
        written.append(path.with_name(f"{path.stem}-plane.csv"))
        save(study.plane, written[-1])
    if opt["bench_doc"]:
        written.append(renew(Path(opt["bench_doc"]), study, model))
    say("results in " + ", ".join(map(str, written)))
