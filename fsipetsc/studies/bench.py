"""The command ``python -m fsipetsc bench``: what a time step costs.

A sample is some whole steps as a run makes them, but for output. Samples of all numbers of ranks
and of other programs are taken in turn; ranks without a part sleep. A time is the median of its
samples, a ratio that of pairs taken one after the other.
"""

import subprocess
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from fsipetsc import BlockProblem, ElasticSolid, Fluid, InputError, Layer, layers
from fsipetsc.blocks.conditions import Clamped, NoSlip
from fsipetsc.cases import case_of, load_case
from fsipetsc.cases.common import at_rest
from fsipetsc.options import RUN, Option, defaults
from fsipetsc.process.together import Comm
from fsipetsc.studies.trials import USUAL, Study

#: form -> -fsi_convection, whether there is viscosity, words for the other program
FORMS = {
    "entropy": ("entropy", False, ""),
    "divergence": ("divergence", False, "-form div"),
    "viscous": ("entropy", True, "-visc 1"),
    "divergence-viscous": ("divergence", True, "-form div -visc 1"),
}
COLUMNS = "problem order form n ranks step_us ns_node_rhs other_us ratio speed_up".split()
OPTIONS = (
    Option("bench_problems", "ints", (0, 1, 2, 3), "", "0: rod; 1 to 3: blocks", (0, 1, 2, 3)),
    Option("bench_orders", "ints", (4,), "", "operators' orders", (2, 4, 6, 8)),
    Option("bench_form", str, "all", "", "form of gas | solid", ("all", *FORMS)),
    Option("bench_rod", "ints", (480, 3840, 100_000), "", "points of the rod", check="positive"),
    Option("bench_line", "ints", (240, 2000, 50_000), "", "nodes of a block", check="positive"),
    Option("bench_square", "ints", (64, 128, 256), "", "nodes of an axis in 2-D", check="positive"),
    Option("bench_cube", "ints", (32, 64), "", "nodes of an axis in 3-D", check="positive"),
    Option("bench_ranks", "ints", None, "", "numbers of ranks; else 1, 2, 4 …", check="positive"),
    Option("bench_seconds", float, 0.2, "s", "approximate length of a sample", check="positive"),
    Option("bench_repeats", int, 5, "", "samples; their median counts", check="positive"),
    Option("bench_rod_program", str, None, "", "folder of another program for the rod"),
    Option("bench_square_program", str, None, "", "the same for gas | solid, 2-D"),
    *(option for option in RUN if option.name == "fsi_partition"),
    *USUAL,
)  # fmt: skip


def bench(arguments: list[str], comm: Comm) -> None:
    """Run the command. Collective; FileError; InputError, also if another program does not run."""
    study = Study(comm, arguments, OPTIONS, "bench")
    opt = study.opt
    counts = sorted({*(opt["bench_ranks"] or [1 << k for k in range(16) if 1 << k <= comm.size])})
    if comm.size < (most := counts[-1]):
        raise InputError(f"-bench_ranks {most}: put mpiexec -n {most} before the command")
    teams = {n: comm.Split(int(comm.rank >= n), comm.rank) for n in counts}
    rows: list[list[object]] = []
    study.say(" ".join(f"{name:>11}" for name in COLUMNS))
    for about, case, own, program in targets(opt):
        options = {**defaults(case), "fsi_partition": opt["fsi_partition"], **own}
        for row in measured(study, case, options, teams, program):
            rows.append([*about, *row])
            study.say(" ".join(f"{value!s:>11}" for value in rows[-1]))
    study.save(COLUMNS, rows)
    study.say(f"saved {study.path}")


def targets(opt: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """All that the options ask for: the first columns of a row, a case, options of its run; another
    program and its words, or nothing. The rod's 6 m have 1 m of solid.

    ``rod ORDER H T -q -n STEPS`` makes steps of the falling rod from rest; the fifth word that it
    prints is µs a step. ``plane ORDER N N STEPS -q [-form div] [-visc 1]`` makes those of a gas and
    a solid of N by N points; µs a step follow the word ``median``.
    """
    of_dimension = {1: "bench_line", 2: "bench_square", 3: "bench_cube"}
    forms = FORMS if opt["bench_form"] == "all" else (opt["bench_form"],)
    rod, plane = opt["bench_rod_program"], opt["bench_square_program"]
    for problem, order in product(opt["bench_problems"], opt["bench_orders"]):
        for points in opt["bench_rod"] if problem == 0 else ():
            h = 1.0 / max(1, round(points / 6))
            own = {"fsi_order": order, "fsi_h": h, "fsi_coupling": "projection"}  # the paper's
            program = Path(rod or "", "rod").resolve(), order, repr(h), 3, "-q", "-n", None
            yield ("rod", order, "", points), load_case("rod"), own, program if rod else ()
        for form, n in product(forms, opt[of_dimension[problem]]) if problem else ():
            convection, viscous, more = FORMS[form]
            case = case_of(square(problem, n, viscous), fsi_h=1.0 / n, ts_max_time=1.0)
            own, there = {"fsi_order": order, "fsi_convection": convection}, plane and problem == 2
            program = Path(plane or "", "plane").resolve(), order, n, n, None, "-q", *more.split()
            yield (f"{problem}-D", order, form, n), case, own, program if there else ()


def square(d: int, n: int, viscous: bool) -> BlockProblem:
    """A gas, which begins with waves, beneath a solid: unit cubes of n nodes along each axis,
    periodic along the interface; viscous: viscosity and conduction in both.
    """

    def waves(*X: Any) -> tuple[Any, ...]:
        *beside, Y = X
        phase = 2.0 * np.pi * sum(beside, 0.0 * Y)
        rho, T = 1.0 + 0.1 * np.sin(phase + Y), 1.0 + 0.1 * np.cos(phase) * np.sin(Y)
        return rho, *(0.0 * x for x in X), T

    plate = ElasticSolid(1.5, 2.0, 0.02 * viscous, 2.0, 1.0, heat="elastic")
    air = Fluid(0.02 * viscous, 0.03 * viscous, 1.4, 1.0)
    below = Layer("gas", air, (0.0, 1.0), waves, cells=n - 1)
    above = Layer("solid", plate, (1.0, 2.0), at_rest(), cells=n - 1)
    beside = {"along": ((0.0, 1.0),) * (d - 1), "cells": (n,) * (d - 1)}
    return layers(below, above, lower=NoSlip(), upper=Clamped(), units="none", **beside)


def measured(
    study: Study, case: Any, options: dict[str, Any], teams: Any, program: Sequence[object]
) -> Iterator[list[object]]:
    """The last columns for each number of ranks, on rank 0. Collective. InputError where ranks do
    not fit. teams: number -> communicator; program: as ``targets`` has it.
    """
    from fsipetsc.stepping.run import build_problem, make_state

    def make(team: Comm) -> Any:
        return make_state(build_problem(case, options, team), options, team)

    def sample(n: int, steps: int) -> Any:
        return study.on_first(lambda: step_time(states[n], options, steps), n)

    states = {n: study.on_first(partial(make, team), n) for n, team in teams.items()}
    points = {n: study.on_first(lambda n=n: states[n].points, n) for n in teams}
    sample(min(teams), 2)  # for what is made once
    step = study.comm.bcast(sample(min(teams), 10))
    steps = min(20_000, max(6, round(1e6 * study.opt["bench_seconds"] / step)))
    rounds = []  # times of a step [µs]: number of ranks -> ours, 0 -> of the other program
    for _ in range(study.opt["bench_repeats"]):
        times = {n: sample(n, steps) for n in teams}
        rounds.append({**times, 0: study.on_first(lambda: time_of(program, steps))})

    def ratio(a: int, b: int) -> str:
        return f"{median(times[a] / times[b] for times in rounds):.3g}"

    for n in teams if study.comm.rank == 0 else ():
        own, other = (median(times[k] for times in rounds) for k in (n, 0))
        of_node = 1e3 * own / (4 * points[n])  # four stages
        beside = (f"{other:.4g}", ratio(n, 0)) if program else ("", "")
        speed_up = ratio(1, n) if n > 1 and 1 in teams else ""
        yield [n, f"{own:.4g}", f"{of_node:.3g}", *beside, speed_up]
    for state in filter(None, states.values()):
        state.destroy()


def step_time(state: Any, opt: Mapping[str, Any], count: int) -> float:
    """Time [µs] of a step, the average of the first ``count``. Collective."""
    from mpi4py import MPI

    from fsipetsc.stepping.integrator import Integrator

    nothing = dict.fromkeys(("fsi_output_dt", "fsi_output_times"))
    state.set_initial()
    integrator = Integrator(state, {**opt, **nothing, "ts_max_steps": count})
    state.comm.Barrier()
    integrator.run()
    return 1e6 * state.comm.allreduce(integrator.wall_time, MPI.MAX) / integrator.steps


def time_of(program: Sequence[object], steps: int) -> float:
    """Time of a step [µs] by another program, whose word None is the number of steps; nan if there
    is none. InputError."""
    if not program:
        return np.nan
    words = [str(steps if word is None else word) for word in program]
    try:
        said = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
        return float(said[said.index("median") + 1] if "median" in said else said[4])
    except (OSError, subprocess.CalledProcessError, IndexError, ValueError) as error:
        raise InputError(f"{' '.join(words)} does not answer as it should: {error}") from None
