"""The command `python -m fsipetsc stability [CASE]`: the linear theory, checked for given materials, or those of a case.

It ends with status 3 where the interface treatment does not keep what it promises. `energy` promises that the energy
never grows (Theorem 4.1), that no mode grows and that the step of the uncoupled layers is kept; the others promise
the last two. What the heating by a stress at rest adds (sigma^ u_X / (alpha m0), see stability_linear) is shown too,
but as it belongs to the equations, not to the interface, it does not count. The materials of a case may have any laws; its
initial data at an interface say which state is at rest.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from fsipetsc.analysis.stability_options import (
    FOR_CASES,
    OF_TWO_DIMENSIONS,
    SECTIONS,
    check,
    constant_state,
    named,
    orders,
    swept,
)
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.cases import load_case
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import read_options, read_table
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.analysis.stability_measures import Result
    from fsipetsc.analysis.stability_state import Constant
    from fsipetsc.analysis.wave_stability import WaveSetting

PROMISES = {"conservative": "estimate", "energy": "estimate", "projection": "modes", "traditional": "modes"}


def stability(arguments: list[str], comm: MPI.Comm) -> None:
    """Run the command; the ranks of comm share a sweep. Collective; ComputationError if a promise is not kept."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the matrices are small: threads would only get in each other's way
    opt, state = described(arguments, comm)
    from fsipetsc.analysis.wave_stability import WaveSetting, wave_stability  # PETSc has been started

    if isinstance(state, WaveSetting):
        wave_stability(opt, state, comm)
        return
    results = compute(opt, state, comm)
    if comm.rank == 0 and not opt["fsi_quiet"]:
        show(opt, state, results)
    if comm.rank == 0 and opt["sweep"]:
        for path in save(opt, results):
            if not opt["fsi_quiet"]:
                print(f"saved {path}")
    wait_asleep(comm)
    judge(results)


def described(arguments: list[str], comm: MPI.Comm) -> tuple[dict[str, Any], Constant | WaveSetting]:
    """Options and the state at rest. Collective. InputError, also where a case has none."""
    if not named(arguments):
        given = start_petsc(arguments, comm)
        opt = read_table(SECTIONS, given)
        check(opt)
        state = together(comm, lambda: constant_state(opt))
        if opt["stability_plane"]:
            from fsipetsc.analysis.wave_stability import setting_of_options

            return opt, setting_of_options(opt, state, given)
        _only_in_two(given, "-stability_plane asks for two dimensions")
        return opt, state

    case = together(comm, lambda: load_case(arguments[0]))
    given = start_petsc(arguments[1:], comm)
    from fsipetsc.analysis.stability_state import of_problem
    from fsipetsc.analysis.wave_stability import setting_of_problem
    from fsipetsc.stepping.solve import block_form, build_problem, check_begin

    opt = read_options(case, given, FOR_CASES)
    check_begin(opt)
    problem = build_problem(case, {**opt, "fsi_coupling": "energy"}, comm)  # whose layers are wanted, whatever the coupling
    plane = isinstance(problem, RunProblem)
    if "fsi_order" not in given and not (plane and "fsi_orders" not in given):
        opt["fsi_order"] = None  # in two dimensions the layers of a case may be too thin for other orders than its own
    if "fsi_output" not in given:
        opt["fsi_output"] = None
    check(opt)
    if plane:
        return opt, together(comm, lambda: setting_of_problem(problem, opt, block_form(opt)))
    _only_in_two(given, f"{case.NAME} is a case of one dimension")
    return opt, together(comm, lambda: of_problem(problem, opt["stability_interface"], opt["fsi_h"]))


def _only_in_two(chosen: Mapping[str, Any], why: str) -> None:
    """InputError for an option that was given and is of two dimensions."""
    for name in OF_TWO_DIMENSIONS:
        if name in chosen:
            raise InputError(f"-{chosen[name].name} is of two dimensions: {why}")


def compute(opt: Mapping[str, Any], state: Constant, comm: MPI.Comm) -> list[Result]:
    """Results of all orders and, in a sweep, ratios, in this order, on every rank. Collective."""
    from fsipetsc.analysis.stability_measures import measure

    states = [state]
    if opt["sweep"]:
        states = [swept(state, *ratios) for ratios in product(opt["density_ratios"], opt["stiffness_ratios"])]
    tasks = list(product(orders(opt), states))
    grid = (opt["stability_points"], opt["fsi_h"], opt["fsi_coupling"], opt["fsi_viscous"] == "narrow")
    mine = [measure(one, order, *grid) for order, one in tasks[comm.rank :: comm.size]]
    shares = comm.allgather(mine)
    return [shares[i % comm.size][i // comm.size] for i in range(len(tasks))]


def show(opt: Mapping[str, Any], state: Constant, results: Sequence[Result]) -> None:
    """Print the problem and the results."""
    from fsipetsc.analysis.stability_report import heading, one_state, sweep_tables

    print(heading(opt, state))
    print(sweep_tables(results) if opt["sweep"] else one_state(results))


def save(opt: Mapping[str, Any], results: Sequence[Result]) -> list[str]:
    """Write the table and the picture of a sweep; returns their paths."""
    from fsipetsc.analysis.stability_report import draw, write_table

    base = opt["fsi_output"] or f"stability-{opt['fsi_coupling']}"
    write_table(f"{base}.csv", results)
    try:
        draw(f"{base}.png", results)
    except ModuleNotFoundError as error:
        if error.name != "matplotlib":
            raise
        return [f"{base}.csv (no picture: matplotlib is not installed)"]
    return [f"{base}.csv", f"{base}.png"]


def judge(results: Sequence[Result]) -> None:
    """Raise ComputationError, which names the worst, if a result does not keep what its treatment promises."""
    promise = PROMISES[results[0].coupling]
    broken = [result for result in results if not result.keeps(promise)]
    if not broken:
        return
    growing = [r for r in broken if not r.stable]
    slowed = [r for r in broken if not r.step_kept]
    faults = []
    if growing:
        worst = max(growing, key=lambda r: r.mode_growth / r.radius)
        faults.append(f"a mode grows in {len(growing)}, at {worst.mode_growth:.2g} 1/s with {_where(worst)}")
    if slowed:
        worst = min(slowed, key=lambda r: r.step_ratio)
        part = f"{worst.step_ratio:.2g} of the uncoupled one with {_where(worst)}"
        faults.append(f"the step limit is lower in {len(slowed)}, {part}")
    if not faults:
        worst = max(broken, key=lambda r: r.energy_growth / r.radius)
        faults.append(f"the energy grows, at {worst.energy_growth:.2g} 1/s with {_where(worst)}")
    raise ComputationError(f"{worst.coupling} fails in {len(broken)} of {len(results)}: {'; '.join(faults)}")


def _where(result: Result) -> str:
    return f"order {result.order}, m0/rho = {result.density_ratio:g}, K/p = {result.stiffness_ratio:g}"
