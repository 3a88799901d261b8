"""The command ``python -m fsipetsc bench``: what a time step costs.

Measured are the falling rod (fsipetsc.cases.rod) and a gas beneath a solid in one, two and three
dimensions (fsipetsc.bench.square), for orders, grids, forms and numbers of ranks. A sample is some
whole steps as a run makes them, with everything but output. Samples of all numbers of ranks and of
other programs are taken in turn, so that all see the same machine; ranks without a part sleep. A
time is the median of its samples, a ratio that of pairs taken one after the other.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from fsipetsc.bench import square
from fsipetsc.bench.other_program import OtherProgram
from fsipetsc.cases import load_case
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import RUN, defaults, read_table
from fsipetsc.options.option import Option
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import agree, together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.bench.sample import Sample

#: right-hand sides of a step
STAGES = 4
#: form -> options of a run, words for the other program
FORMS: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "entropy": ({"square_viscous": False}, ()),
    "divergence": ({"square_viscous": False}, ("-form", "div")),
    "viscous": ({"square_viscous": True}, ("-visc", "1")),
    "divergence-viscous": ({"square_viscous": True}, ("-form", "div", "-visc", "1")),
}
COLUMNS = ("problem", "order", "form", "n", "ranks", "step_us", "ns_node_rhs")
COLUMNS += ("other_us", "ratio", "speed_up")


def _only(*allowed: int) -> Callable[[Sequence[int]], str | None]:
    text = f"numbers out of {', '.join(map(str, allowed))}"
    return lambda values: None if values and set(values) <= set(allowed) else text


def _sizes(name: str, default: tuple[int, ...] | None, text: str) -> Option:
    def check(values: Sequence[int]) -> str | None:
        return None if values and min(values) > 0 else "whole numbers above 0"

    return Option(name, "ints", default, "", text, check=check)


_WHAT = "problems: 0 is the rod; 1, 2, 3 are gas | solid in so many dimensions"
OPTIONS = (
    Option("bench_problems", "ints", (0, 1, 2, 3), "", _WHAT, check=_only(0, 1, 2, 3)),
    Option("bench_orders", "ints", (4,), "", "orders", check=_only(2, 4, 6, 8)),
    Option("bench_form", str, "all", "", "form of gas | solid", ("all", *FORMS)),
    _sizes("bench_rod", (480, 3840, 100_000), "points of the rod, about"),
    _sizes("bench_line", (240, 2000, 50_000), "nodes of a block in 1-D"),
    _sizes("bench_square", (64, 128, 256), "nodes of an axis in 2-D"),
    _sizes("bench_cube", (32, 64), "nodes of an axis in 3-D"),
    _sizes("bench_ranks", None, "numbers of ranks; default: 1, 2, 4 … up to those there are"),
    Option("bench_seconds", float, 0.2, "s", "length of a sample, about", check="positive"),
    Option("bench_repeats", int, 5, "", "samples, of which the median counts", check="positive"),
    Option("bench_rod_program", str, None, "", "folder of another program for the rod"),
    Option("bench_square_program", str, None, "", "folder of another program for gas | solid, 2-D"),
    Option("fsi_output", str, "bench", "", "base name of the table NAME.csv"),
)
_OF_RUN = ("fsi_quiet", "fsi_partition", "fsi_debug")
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Benchmark": OPTIONS,
    "Run": tuple(option for option in RUN if option.name in _OF_RUN),
}


class Target(NamedTuple):
    """What a row measures: the first columns, a case, options of its run; words for ``program``."""

    about: tuple[Any, ...]
    case: Any
    options: dict[str, Any]
    program: str = ""
    before: tuple[Any, ...] = ()
    behind: tuple[str, ...] = ()


def targets(opt: Mapping[str, Any]) -> Iterator[Target]:
    """All that the options ask for. The rod is 6 m of gas and solid, of which 1 m is solid."""
    of_dimension = {1: "bench_line", 2: "bench_square", 3: "bench_cube"}
    forms = FORMS if opt["bench_form"] == "all" else (opt["bench_form"],)
    for problem, order in product(opt["bench_problems"], opt["bench_orders"]):
        if problem == 0:
            for points in opt["bench_rod"]:
                chosen = {"fsi_order": order, "fsi_h": 1.0 / max(1, round(points / 6))}
                words = (order, repr(chosen["fsi_h"]), 3, "-q", "-n")
                yield Target(("rod", order, "", points), load_case("rod"), chosen, "rod", words)
            continue
        for form, n in product(forms, opt[of_dimension[problem]]):
            more, words = FORMS[form]
            convection = "divergence" if form.startswith("divergence") else "entropy"
            chosen = {"fsi_order": order, "fsi_h": 1.0 / n, "square_dimension": problem, **more}
            chosen["fsi_convection"] = convection
            about, program = (f"{problem}-D", order, form, n), "plane" if problem == 2 else ""
            yield Target(about, square, chosen, program, (order, n, n), ("-q", *words))


def bench(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    InputError for options, ranks that do not fit, another program that does not run; FileError.
    """
    opt = read_table(SECTIONS, start_petsc(arguments, comm))
    quiet = opt["fsi_quiet"] or comm.rank > 0
    say: Callable[[str], None] = (lambda text: None) if quiet else _print
    path, ranks = Path(f"{opt['fsi_output']}.csv"), _ranks(opt, comm)
    others: dict[str, OtherProgram] = together(comm, lambda: _others(opt) if comm.rank == 0 else {})
    teams = {n: _team(comm, n) for n in ranks}
    rows: list[dict[str, Any]] = []
    try:
        say(f"load of the machine: {os.getloadavg()[0]:.1f}")
        say(" ".join(f"{name:>11}" for name in COLUMNS))
        for target in targets(opt):
            found = Measurement(comm, teams, others, opt, target).rows()
            for row in found:
                say(" ".join(f"{value!s:>11}" for value in row.values()))
            rows += found
    finally:
        for program in others.values():
            program.close()
    together(comm, lambda: _save(path, rows) if comm.rank == 0 else None)
    say(f"the table is in {path}")


def _print(text: str) -> None:
    """Print at once."""
    print(text, flush=True)


def _ranks(opt: Mapping[str, Any], comm: MPI.Comm) -> list[int]:
    counts = opt["bench_ranks"] or [1 << k for k in range(16) if 1 << k <= comm.size]
    if max(counts) > comm.size:
        most = max(counts)
        raise InputError(f"-bench_ranks {most}: put mpiexec -n {most} before the command")
    return sorted(set(counts))


def _others(opt: Mapping[str, Any]) -> dict[str, OtherProgram]:
    folders = {"rod": opt["bench_rod_program"], "plane": opt["bench_square_program"]}
    return {name: OtherProgram(name, folder) for name, folder in folders.items() if folder}


def _team(comm: MPI.Comm, ranks: int) -> MPI.Comm | None:
    """The first ranks; None on the others."""
    split = comm.Split(int(comm.rank >= ranks), comm.rank)
    return split if comm.rank < ranks else None


def _save(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error


class Measurement:
    """A target on teams of ranks. Collective on world. InputError where ranks do not fit."""

    def __init__(
        self,
        world: MPI.Comm,
        teams: Mapping[int, MPI.Comm | None],
        others: Mapping[str, OtherProgram],
        opt: Mapping[str, Any],
        target: Target,
    ) -> None:
        from fsipetsc.bench.sample import Sample

        self._world, self._teams, self._target, self._opt = world, teams, target, opt
        self._other = others.get(target.program)
        case = target.case
        options = {**defaults(case), "fsi_partition": opt["fsi_partition"], **target.options}
        self._samples: dict[int, Sample | None] = {
            ranks: self._on(ranks, lambda comm: Sample(case, options, comm)) for ranks in teams
        }

    def _on(self, ranks: int, action: Callable[[MPI.Comm], Any]) -> Any:
        """What an action gives on the first ranks, None on the others, which sleep meanwhile."""
        team, value, fault = self._teams[ranks], None, None
        try:
            value = action(team) if team is not None else None
        except InputError as error:
            fault = error
        wait_asleep(self._world)
        agree(self._world, fault)
        return value

    def rows(self) -> list[dict[str, Any]]:
        """A row for each number of ranks, on rank 0."""
        samples, target, seconds = self._samples, self._target, self._opt["bench_seconds"]
        first = min(samples)
        steps = self._world.bcast(self._on(first, lambda comm: samples[first].count(seconds)))
        times: dict[int, list[float]] = {ranks: [] for ranks in samples}
        other: list[float] = []
        for _ in range(self._opt["bench_repeats"]):
            for ranks, own in times.items():
                own.append(self._on(ranks, lambda comm: samples[ranks].steps(steps)))  # noqa: B023
            if self._other is not None:
                other.append(self._other.step(*target.before, steps, *target.behind))
            wait_asleep(self._world)
        rows = [self._row(ranks, times, other) for ranks in times if self._world.rank == 0]
        for sample in samples.values():
            if sample is not None:
                sample.destroy()
        return rows

    def _row(
        self, ranks: int, times: Mapping[int, list[float]], other: Sequence[float]
    ) -> dict[str, Any]:
        mine, nodes = times[ranks], self._samples[ranks].nodes
        step = median(mine)
        found = [f"{step:.4g}", f"{1e3 * step / (STAGES * nodes):.3g}", "", "", ""]
        if other:
            found[2] = f"{median(other):.4g}"
            found[3] = f"{median(a / b for a, b in zip(mine, other, strict=True)):.3g}"
        if ranks > 1 and 1 in times:
            found[4] = f"{median(a / b for a, b in zip(times[1], mine, strict=True)):.3g}"
        return dict(zip(COLUMNS, [*self._target.about, ranks, *found], strict=True))
