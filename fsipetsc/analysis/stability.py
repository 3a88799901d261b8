"""The command `python -m fsipetsc stability [CASE]`: the linear theory, checked for given
materials, or those of a case.

It ends with status 3 where the interface treatment does not keep what it promises. `energy` and
`conservative` promise that the energy never grows (Theorem 4.1), that no mode grows and that the
step of the uncoupled layers is kept; the others, and any in two dimensions, promise the last two.
What the heat of the stress at rest adds is shown too, but as it belongs to the equations, not to
the interface, it does not count. The materials of a case may have any laws; its initial data at an
interface say which state is at rest.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from fsipetsc.analysis.stability_options import (
    FOR_CASES,
    OF_TWO_DIMENSIONS,
    SECTIONS,
    named,
    orders,
)
from fsipetsc.analysis.tables import printer, save_csv, shared, text_table
from fsipetsc.cases import load_case
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.operators import operator
from fsipetsc.options import read_options, read_table
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.analysis.spectra import Result
    from fsipetsc.analysis.stability_state import Constant
    from fsipetsc.analysis.wave_measures import Rest

THEORY = {
    "energy": "orthogonal projection, all four conditions at once (Theorem 4.1)",
    "projection": "temperatures first, then u, sigma, rho (Theorem 4.2)",
    "conservative": "the end points are one particle; mass, momentum and energy are kept",
    "traditional": "the solid moves the fluid, the fluid loads the solid",
}


class Problem(NamedTuple):
    """What is studied: words about it, the state at rest (with ``swept``), the numbers of such a
    state and an order."""

    heading: str
    state: Any
    measure: Callable[[Any, int], Result]


def stability(arguments: list[str], comm: MPI.Comm) -> None:
    """Run the command; the ranks of comm share a sweep. Collective; InputError; ComputationError if
    a promise is not kept."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # small matrices: threads would get in each other's way
    opt, problem = described(arguments, comm)
    states = [problem.state]
    if opt["sweep"]:
        ratios = product(opt["density_ratios"], opt["stiffness_ratios"])
        states = [problem.state.swept(*both) for both in ratios]
    tasks = list(product(orders(opt), states))
    results = shared(comm, tasks, lambda task: problem.measure(task[1], task[0]))
    say = printer(comm, opt)
    told = summary(results) if opt["sweep"] else table(results)
    say("\n".join([problem.heading, "", told, *_heating(results), ""]))
    if opt["sweep"] and comm.rank == 0:
        for path in save(opt, results):
            say(f"saved {path}")
    wait_asleep(comm)
    judge(results)


def described(arguments: list[str], comm: MPI.Comm) -> tuple[dict[str, Any], Problem]:
    """Options and what they ask for. Collective. InputError, also where a case has no state at
    rest."""
    if named(arguments):
        return _of_case(arguments, comm)
    from fsipetsc.analysis.stability_state import of_options

    given = start_petsc(arguments, comm)
    opt = read_table(SECTIONS, given)
    orders(opt)
    state = together(comm, lambda: of_options(opt))
    if opt["stability_plane"]:
        from fsipetsc.analysis.wave_measures import rest_of_options

        return opt, _in_two(opt, rest_of_options(opt, state, given))
    _only_in_two(given, "-stability_plane asks for two dimensions")
    return opt, _in_one(opt, state)


def _of_case(arguments: list[str], comm: MPI.Comm) -> tuple[dict[str, Any], Problem]:
    """The same where a case is named."""
    case = together(comm, lambda: load_case(arguments[0]))
    given = start_petsc(arguments[1:], comm)
    from fsipetsc.analysis.stability_state import of_problem
    from fsipetsc.blockrun.run_problem import RunProblem
    from fsipetsc.stepping.solve import build_problem, check_begin

    opt = read_options(case, given, FOR_CASES)
    check_begin(opt)
    # the layers of the case are wanted, whatever its coupling
    problem = build_problem(case, {**opt, "fsi_coupling": "energy"}, comm)
    if isinstance(problem, RunProblem):
        raise InputError(f"{case.NAME} is no case of layers; in 2-D: stability -stability_plane")
    if "fsi_order" not in given:
        opt["fsi_order"] = None
    if "fsi_output" not in given:
        opt["fsi_output"] = None
    orders(opt)
    k, h = opt["stability_interface"], opt["fsi_h"]
    return opt, _in_one(opt, together(comm, lambda: of_problem(problem, k, h)))


def _only_in_two(chosen: Mapping[str, Any], why: str) -> None:
    """InputError for an option that was given and is of two dimensions."""
    for name in OF_TWO_DIMENSIONS:
        if name in chosen:
            raise InputError(f"-{chosen[name].name} is of two dimensions: {why}")


def _in_one(opt: Mapping[str, Any], state: Constant) -> Problem:
    from fsipetsc.analysis.stability_linear import measure
    from fsipetsc.analysis.stability_state import law_name

    gas, solid = state.gas, state.solid
    names = "stability_points", "fsi_h", "fsi_coupling", "fsi_viscous"
    n, h, coupling, viscous = (opt[name] for name in names)
    laws = [law_name(law) for law in (gas.law, gas.transport, solid.pressing) if law is not None]
    body = f"m0 {solid.m0:g} kg/m3, K {solid.K:g} Pa"
    if opt["sweep"]:
        body = f"alpha m0 {solid.alpha * solid.m0:g} J/(m3 K)"
    heading = [
        f"stability of {coupling}: {THEORY[coupling]}",
        f"solid | gas at rest, linearised (4.2): {n} points of h = {h:g} m in each, {viscous} "
        "second derivatives",
        f"gas    rho {state.rho:g} kg/m3, T {state.T:g} K, p {state.p:g} Pa, mu {state.mu:g} Pa s, "
        f"kappa {state.kappa:g} W/(m K), sound {gas.sound_speed(state.T, state.rho):.3g} m/s",
        f"solid  {body}, kappa {solid.kappa_e:g} W/(m K), x_X {state.stretch:g}, pressure "
        f"{state.solid_pressure:g} Pa, sigma {state.stress:g} Pa",
        *([f"laws   {'; '.join(laws)}"] if laws else []),
    ]
    narrow = viscous == "narrow"
    return Problem(
        "\n".join(heading),
        state,
        lambda one, order: measure(one, order, n, h, coupling, narrow),
    )


def _in_two(opt: Mapping[str, Any], rest: Rest) -> Problem:
    from fsipetsc.analysis.wave_measures import Waves, measure

    k, symbols = opt["stability_k"], opt["stability_symbols"]
    waves = Waves(k=tuple(k)) if k else Waves(tuple(symbols))
    listed = ", ".join(f"{value:g}" for value in k or symbols)
    heading = [
        "gas over a solid in two dimensions, linearised at rest: the scheme by wave number",
        f"{rest.cells[0] + 1} points across the solid, {rest.cells[1] + 1} across the gas, columns "
        f"{rest.columns:.6g} m apart",
        f"k = {listed} 1/m" if k else f"symbol of D at {listed} of its greatest value",
    ]
    return Problem("\n".join(heading), rest, lambda one, order: measure(one, order, waves))


def verdict(result: Result) -> str:
    """One phrase about a result."""
    if not result.stable:
        return "a mode grows"
    if not result.step_kept:
        return "stable, but at smaller steps"
    if result.energy != result.energy:
        return "stable"
    if result.estimate:
        return "energy never grows"
    return "stable, but the energy may grow for a while"


def table(results: Sequence[Result]) -> str:
    """A line for each order, and the slowest modes, if they are known."""
    head = ["order", "m0/rho", "K/p", "largest |lambda|\n[1/s]", "RK4 step up to\n[s]"]
    head += ["of uncoupled", "fastest mode\n[|lambda|]", "energy grows\n[|lambda|]", ""]
    rows = []
    for r in results:
        energy = "" if r.energy != r.energy else f"{r.energy:.1e}"
        row = [operator(r.order).name, f"{r.density_ratio:g}", f"{r.stiffness_ratio:g}"]
        row += [f"{r.radius:.4g}", f"{r.step:.4g}", f"{r.step_ratio:.4f}", f"{r.growth:.1e}"]
        rows.append([*row, energy, verdict(r)])
    lines = [text_table(head, rows)]
    waves = [(operator(r.order).name, *slowest) for r in results for slowest in r.slowest]
    if waves:
        lines += ["", "slowest modes that swing, s [1/s]"]
    for name, k, modes in waves:
        told = ", ".join(f"{s.real:.6g} + {s.imag:.6g}i" for s in modes) or "none"
        lines.append(f"  order {name}, k = {k:>8.5g}  {told}")
    return "\n".join(lines)


def summary(results: Sequence[Result]) -> str:
    """Of a sweep: for each order in how many combinations all is well, and the worst."""
    head = ["order", "of", "no mode\ngrows", "at most\n[|lambda|]", "step\nkept"]
    head += ["least of\nuncoupled", "energy never\ngrows", "at most\n[|lambda|]"]
    if results[0].energy != results[0].energy:
        head = head[:-2]
    rows = []
    for order in dict.fromkeys(r.order for r in results):
        own = [r for r in results if r.order == order]
        row = [operator(order).name, len(own)]
        row += [sum(r.stable for r in own), f"{max(r.growth for r in own):.1e}"]
        row += [sum(r.step_kept for r in own), f"{min(r.step_ratio for r in own):.3f}"]
        row += [sum(r.estimate for r in own), f"{max(r.energy for r in own):.1e}"]
        rows.append(row[: len(head)])
    return text_table(head, rows)


def _heating(results: Sequence[Result]) -> list[str]:
    """What the heat of the stress at rest adds, in two lines."""
    if all(r.heated == r.growth for r in results):
        return []
    worst, growing = max(r.heated for r in results), sum(not r.heated_stable for r in results)
    told = "no mode grows, either"
    if growing:
        told = f"modes grow at up to {worst:.1e} |lambda| ({growing} of {len(results)})"
    return [
        "",
        "These numbers leave out the heat that the stress at rest sets free, which is not the "
        "interface's doing:",
        f"sigma u_X/(alpha m0), in two dimensions -p div v/(alpha m0). With it {told}.",
    ]


def save(opt: Mapping[str, Any], results: Sequence[Result]) -> list[Path]:
    """Write the table and, in one dimension, the picture of a sweep; returns their paths.
    FileError."""
    from fsipetsc.output.plots.studies import sweep_figure

    plane = results[0].energy != results[0].energy
    base = opt["fsi_output"] or f"stability-{'plane' if plane else opt['fsi_coupling']}"
    names = [field.name for field in fields(results[0]) if field.name != "slowest"]
    rows = [[getattr(result, name) for name in names] for result in results]
    path = save_csv(Path(f"{base}.csv"), names, rows)
    if plane:
        return [path]
    return [path, *sweep_figure(results, f"{base}.png", THEORY[opt["fsi_coupling"]])]


def judge(results: Sequence[Result]) -> None:
    """Raise ComputationError, which names the worst, if a result does not keep what its treatment
    promises."""
    promised = {"a mode grows": "stable", "the step is shorter": "step_kept"}
    if results[0].coupling in ("conservative", "energy"):
        promised["the energy grows"] = "estimate"
    counts = {what: sum(not getattr(r, name) for r in results) for what, name in promised.items()}
    broken = [r for r in results if not all(getattr(r, name) for name in promised.values())]
    if broken:
        worst = max(broken, key=lambda r: (not r.stable, -r.step_ratio if r.stable else r.growth))
        faults = ", ".join(f"{fault} in {count}" for fault, count in counts.items() if count)
        raise ComputationError(
            f"{worst.coupling} fails in {len(broken)} of {len(results)}: {faults}; the worst is "
            f"order {worst.order}, m0/rho = {worst.density_ratio:g}, K/p = "
            f"{worst.stiffness_ratio:g}: growth {worst.growth:.2g} |lambda|, step "
            f"{worst.step_ratio:.2g} of the uncoupled one"
        )
