"""The command ``python -m fsipetsc bench``: what a time step costs.

Measured are the falling rod (fsipetsc.cases.rod) and a gas beneath a solid in one, two and three
dimensions (fsipetsc.bench.square), for orders, grids, forms and numbers of ranks. A sample is some
whole steps as a run makes them, with everything but output. Samples of all numbers of ranks and of
other programs are taken in turn, so that all see the same machine; ranks without a part sleep. A
time is the median of its samples, a ratio that of pairs taken one after the other.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from fsipetsc.bench import square
from fsipetsc.bench.other_program import executable, time_of
from fsipetsc.cases import load_case
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import RUN, defaults, read_table
from fsipetsc.options.option import Option
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import agree, together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

#: right-hand sides of a step
STAGES = 4
#: form -> -fsi_convection, whether there is viscosity, words for the other program
FORMS = {
    "entropy": ("entropy", False, ""),
    "divergence": ("divergence", False, "-form div"),
    "viscous": ("entropy", True, "-visc 1"),
    "divergence-viscous": ("divergence", True, "-form div -visc 1"),
}
COLUMNS = ("problem", "order", "form", "n", "ranks", "step_us", "ns_node_rhs")
COLUMNS += ("other_us", "ratio", "speed_up")


def _only(*allowed: int) -> Callable[[Sequence[int]], str | None]:
    text = f"numbers out of {', '.join(map(str, allowed))}"
    return lambda values: None if values and set(values) <= set(allowed) else text


_WHAT = "problems: 0 is the rod; 1, 2, 3 are gas | solid in so many dimensions"
OPTIONS = (
    Option("bench_problems", "ints", (0, 1, 2, 3), "", _WHAT, check=_only(0, 1, 2, 3)),
    Option("bench_orders", "ints", (4,), "", "orders", check=_only(2, 4, 6, 8)),
    Option("bench_form", str, "all", "", "form of gas | solid", ("all", *FORMS)),
    Option("bench_rod", "ints", (480, 3840, 100_000), "", "points of the rod, about", check="positive"),
    Option("bench_line", "ints", (240, 2000, 50_000), "", "nodes of a block in 1-D", check="positive"),
    Option("bench_square", "ints", (64, 128, 256), "", "nodes of an axis in 2-D", check="positive"),
    Option("bench_cube", "ints", (32, 64), "", "nodes of an axis in 3-D", check="positive"),
    Option("bench_ranks", "ints", None, "", "numbers of ranks; default: 1, 2, 4 … up to those there are", check="positive"),
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


#: the first columns of a row, a case, options of its run; another program, its words before and behind
#: the number of steps
Target = tuple[tuple[Any, ...], Any, dict[str, Any], str, tuple[Any, ...], tuple[str, ...]]


def targets(opt: Mapping[str, Any]) -> Iterator[Target]:
    """All that the options ask for. The rod is 6 m of gas and solid, of which 1 m is solid."""
    of_dimension = {1: "bench_line", 2: "bench_square", 3: "bench_cube"}
    forms = FORMS if opt["bench_form"] == "all" else (opt["bench_form"],)
    for problem, order in product(opt["bench_problems"], opt["bench_orders"]):
        for points in opt["bench_rod"] if problem == 0 else ():
            own = {"fsi_order": order, "fsi_h": 1.0 / max(1, round(points / 6))}
            words = order, repr(own["fsi_h"]), 3, "-q", "-n"
            yield ("rod", order, "", points), load_case("rod"), own, "rod", words, ()
        for form, n in product(forms, opt[of_dimension[problem]]) if problem else ():
            convection, viscous, words = FORMS[form]
            own = {"fsi_order": order, "fsi_h": 1.0 / n, "fsi_convection": convection}
            own |= {"square_dimension": problem, "square_viscous": viscous}
            about, program = (f"{problem}-D", order, form, n), "plane" if problem == 2 else ""
            yield about, square, own, program, (order, n, n), ("-q", *words.split())


def bench(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    InputError for options, ranks that do not fit, another program that does not run; FileError.
    """
    opt = read_table(SECTIONS, start_petsc(arguments, comm))
    say = (lambda text: None) if opt["fsi_quiet"] or comm.rank else partial(print, flush=True)
    counts = sorted({*(opt["bench_ranks"] or [1 << k for k in range(16) if 1 << k <= comm.size])})
    if counts[-1] > comm.size:
        most = counts[-1]
        raise InputError(f"-bench_ranks {most}: put mpiexec -n {most} before the command")
    teams = {n: comm.Split(int(comm.rank >= n), comm.rank) for n in counts}
    folders = {"rod": opt["bench_rod_program"], "plane": opt["bench_square_program"]}
    given = {name: folder for name, folder in folders.items() if folder and comm.rank == 0}
    rows: list[Sequence[object]] = []
    with TemporaryDirectory() as copies:
        programs = together(comm, lambda: {n: executable(n, given[n], copies) for n in given})
        say(f"load of the machine: {os.getloadavg()[0]:.1f}")
        say(" ".join(f"{name:>11}" for name in COLUMNS))
        for about, case, own, name, before, behind in targets(opt):
            options = {**defaults(case), "fsi_partition": opt["fsi_partition"], **own}

            def other(steps: int) -> float | None:
                program = programs.get(name)  # noqa: B023
                return program and time_of(program, *before, steps, *behind)  # noqa: B023

            for row in measured(case, options, opt, comm, teams, other):
                rows.append([*about, *row])
                say(" ".join(f"{value!s:>11}" for value in rows[-1]))
    path = Path(f"{opt['fsi_output']}.csv")
    together(comm, lambda: None if comm.rank else _save(path, rows))
    say(f"the table is in {path}")


def _save(path: Path, rows: Sequence[Sequence[object]]) -> None:
    try:
        path.write_text("".join(",".join(map(str, row)) + "\n" for row in (COLUMNS, *rows)))
    except OSError as error:
        raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error


def measured(
    case: Any,
    options: Mapping[str, Any],
    opt: Mapping[str, Any],
    comm: MPI.Comm,
    teams: Mapping[int, MPI.Comm],
    other: Callable[[int], float | None],
) -> list[Sequence[object]]:
    """The last columns for each number of ranks, on rank 0. Collective. InputError where ranks do
    not fit. other: another program's time of a step, of so many steps; None where there is none.
    """

    def on(ranks: int, action: Callable[[], Any]) -> Any:
        """What an action gives on the first ranks, None on the others, which sleep meanwhile."""
        value, fault = None, None
        try:
            value = action() if comm.rank < ranks else None
        except InputError as error:
            fault = error
        wait_asleep(comm)
        agree(comm, fault)
        return value

    samples = {n: on(n, lambda: Sample(case, options, teams[n])) for n in teams}  # noqa: B023
    first = min(teams)
    on(first, lambda: samples[first].steps(2))  # for what is made once
    step = comm.bcast(on(first, lambda: min(samples[first].steps(10) for _ in range(2))))
    steps = min(20_000, max(6, round(1e6 * opt["bench_seconds"] / (step or 1.0))))
    times: dict[int, list[float]] = {n: [] for n in teams}
    beside = []
    for _ in range(opt["bench_repeats"]):
        for n, own in times.items():
            own.append(on(n, lambda: samples[n].steps(steps)))  # noqa: B023
        beside.append(on(1, lambda: other(steps)))
    rows: list[Sequence[object]] = []
    for n, own in times.items() if comm.rank == 0 else ():
        of_node = 1e3 * median(own) / (STAGES * samples[n].nodes)
        row = [n, f"{median(own):.4g}", f"{of_node:.3g}", "", "", ""]
        if None not in beside:
            row[3:5] = f"{median(beside):.4g}", _ratio(own, beside)
        if n > 1 and 1 in times:
            row[5] = _ratio(times[1], own)
        rows.append(row)
    for sample in samples.values():
        if sample is not None:
            sample.destroy()
    return rows


def _ratio(a: list[float], b: list[float]) -> str:
    return f"{median(x / y for x, y in zip(a, b, strict=True)):.3g}"


class Sample:
    """A problem on the ranks of comm, compiled. All methods are collective on comm.

    nodes: of all blocks. InputError where grid, order and ranks do not fit.
    """

    def __init__(self, case: Any, opt: Mapping[str, Any], comm: MPI.Comm) -> None:
        from fsipetsc.stepping.solve import build_problem, make_state

        self._comm, self._options = comm, dict(opt)
        self._state = make_state(build_problem(case, opt, comm), opt, comm)
        self._state.compile(lambda text: None)
        self._state.set_initial()
        self.nodes, self.destroy = self._state.points, self._state.destroy

    def steps(self, count: int) -> float:
        """Time [µs] of a step, on the average over the first ``count`` from the initial data."""
        from mpi4py import MPI

        from fsipetsc.stepping.integrator import Integrator

        comm, end = self._comm, [self._options["ts_max_time"]]
        integrator = Integrator(
            *(self._state, {**self._options, "ts_max_steps": count}, end),
            on_frame=lambda t: None,
            on_series=lambda: integrator.series.take(comm),
            on_step=lambda steps, t, dt: None,
            on_grids=lambda: None,
        )
        integrator.start()
        comm.Barrier()
        integrator.run()
        return 1e6 * comm.allreduce(integrator.wall_time, MPI.MAX) / integrator.steps
