"""The command `python -m fsipetsc stability [CASE]`: the linear theory, checked for given materials, or those of a case.

It ends with status 3 where the interface treatment does not keep what it promises. `energy` and `conservative` promise
that the energy never grows (Theorem 4.1), that no mode grows and that the step of the uncoupled layers is kept; the others,
and any in two dimensions, promise the last two. What the heat of the stress at rest adds is shown too, but as it belongs to
the equations, not to the interface, it does not count. The materials of a case may have any laws; its initial data at an
interface say which state is at rest.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from fsipetsc.analysis.stability_options import FOR_CASES, OF_TWO_DIMENSIONS, SECTIONS, named, orders
from fsipetsc.analysis.tables import printer, save_csv, shared, text_table
from fsipetsc.cases import load_case
from fsipetsc.errors import ComputationError, InputError
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
    """What is studied: words about it, the state at rest (with ``swept``), the numbers of such a state and an order."""

    heading: str
    state: Any
    measure: Callable[[Any, int], Result]


def stability(arguments: list[str], comm: MPI.Comm) -> None:
    """Run the command; the ranks of comm share a sweep. Collective; InputError; ComputationError if a promise is not kept."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the matrices are small: threads would only get in each other's way
    opt, problem = described(arguments, comm)
    states = [problem.state]
    if opt["sweep"]:
        states = [problem.state.swept(*both) for both in product(opt["density_ratios"], opt["stiffness_ratios"])]
    tasks = list(product(orders(opt), states))
    results = shared(comm, tasks, lambda task: problem.measure(task[1], task[0]))
    say = printer(comm, opt)
    say("\n".join([problem.heading, "", summary(results) if opt["sweep"] else table(results), *_heating(results), ""]))
    if opt["sweep"] and comm.rank == 0:
        for path in save(opt, results):
            say(f"saved {path}")
    wait_asleep(comm)
    judge(results)


def described(arguments: list[str], comm: MPI.Comm) -> tuple[dict[str, Any], Problem]:
    """Options and what they ask for. Collective. InputError, also where a case has no state at rest."""
    if not named(arguments):
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

    case = together(comm, lambda: load_case(arguments[0]))
    given = start_petsc(arguments[1:], comm)
    from fsipetsc.analysis.stability_state import of_problem
    from fsipetsc.analysis.wave_measures import rest_of_problem
    from fsipetsc.blockrun.run_problem import RunProblem
    from fsipetsc.stepping.solve import block_form, build_problem, check_begin

    opt = read_options(case, given, FOR_CASES)
    check_begin(opt)
    problem = build_problem(case, {**opt, "fsi_coupling": "energy"}, comm)  # whose layers are wanted, whatever the coupling
    plane = isinstance(problem, RunProblem)
    if "fsi_order" not in given and not (plane and "fsi_orders" not in given):
        opt["fsi_order"] = None  # in two dimensions the layers of a case may be too thin for other orders than its own
    if "fsi_output" not in given:
        opt["fsi_output"] = None
    orders(opt)
    if plane:
        form = block_form(opt)
        return opt, _in_two(opt, together(comm, lambda: rest_of_problem(problem, opt)), form)
    _only_in_two(given, f"{case.NAME} is a case of one dimension")
    return opt, _in_one(opt, together(comm, lambda: of_problem(problem, opt["stability_interface"], opt["fsi_h"])))


def _only_in_two(chosen: Mapping[str, Any], why: str) -> None:
    """InputError for an option that was given and is of two dimensions."""
    for name in OF_TWO_DIMENSIONS:
        if name in chosen:
            raise InputError(f"-{chosen[name].name} is of two dimensions: {why}")


def _in_one(opt: Mapping[str, Any], state: Constant) -> Problem:
    from fsipetsc.analysis.stability_linear import measure
    from fsipetsc.analysis.stability_state import law_name

    gas, solid, swept = state.gas, state.solid, opt["sweep"]
    n, h, coupling, viscous = (opt[name] for name in ("stability_points", "fsi_h", "fsi_coupling", "fsi_viscous"))
    laws = [law_name(law) for law in (gas.law, gas.transport, solid.pressing) if law is not None]
    body = f"alpha m0 {solid.alpha * solid.m0:g} J/(m3 K)" if swept else f"m0 {solid.m0:g} kg/m3, K {solid.K:g} Pa"
    heading = [
        f"stability of {coupling}: {THEORY[coupling]}",
        f"solid | gas at rest, linearised (4.2): {n} points of h = {h:g} m in each, {viscous} second derivatives",
        f"gas    rho {state.rho:g} kg/m3, T {state.T:g} K, p {state.p:g} Pa, mu {state.mu:g} Pa s, "
        f"kappa {state.kappa:g} W/(m K), sound {gas.sound_speed(state.T, state.rho):.3g} m/s",
        f"solid  {body}, kappa {solid.kappa_e:g} W/(m K), x_X {state.stretch:g}, pressure {state.solid_pressure:g} Pa, "
        f"sigma {state.stress:g} Pa",
        *([f"laws   {'; '.join(laws)}"] if laws else []),
    ]
    narrow = viscous == "narrow"
    return Problem("\n".join(heading), state, lambda one, order: measure(one, order, n, h, coupling, narrow))


def _in_two(opt: Mapping[str, Any], rest: Rest, *form: Any) -> Problem:
    from fsipetsc.analysis.wave_measures import Waves, measure

    k, symbols = opt["stability_k"], opt["stability_symbols"]
    waves = Waves(k=tuple(k)) if k else Waves(tuple(symbols))
    listed = ", ".join(f"{value:g}" for value in k or symbols)
    heading = [
        "gas over a solid in two dimensions, linearised at rest: the scheme's own rates, by wave number",
        f"{rest.cells[0] + 1} points across the solid, {rest.cells[1] + 1} across the gas, columns {rest.columns:.6g} m apart",
        f"k = {listed} 1/m" if k else f"symbol of D at {listed} of its greatest value",
    ]
    return Problem("\n".join(heading), rest, lambda one, order: measure(one, order, waves, *form))


def verdict(result: Result) -> str:
    """One phrase about a result."""
    if not result.stable:
        return "a mode grows"
    if not result.step_kept:
        return "stable, but at smaller steps"
    if result.energy != result.energy:
        return "stable"
    return "energy never grows" if result.estimate else "stable, but the energy may grow for a while"


def table(results: Sequence[Result]) -> str:
    """A line for each order, and the slowest modes, if they are known."""
    head = ["order", "m0/rho", "K/p", "largest |lambda|\n[1/s]", "RK4 step up to\n[s]", "of uncoupled"]
    head += ["fastest mode\n[|lambda|]", "energy grows\n[|lambda|]", ""]
    rows = []
    for r in results:
        energy = "" if r.energy != r.energy else f"{r.energy:.1e}"
        row = [_name(r), f"{r.density_ratio:g}", f"{r.stiffness_ratio:g}", f"{r.radius:.4g}", f"{r.step:.4g}"]
        rows.append([*row, f"{r.step_ratio:.4f}", f"{r.growth:.1e}", energy, verdict(r)])
    lines = [text_table(head, rows)]
    waves = [(r, k, modes) for r in results for k, modes in r.slowest]
    if waves:
        lines += ["", "slowest modes that swing, s [1/s]"]
    for r, k, modes in waves:
        told = ", ".join(f"{s.real:.6g} + {s.imag:.6g}i" for s in modes) or "none"
        lines.append(f"  order {_name(r)}, k = {k:>8.5g}  {told}")
    return "\n".join(lines)


def summary(results: Sequence[Result]) -> str:
    """Of a sweep: for each order in how many combinations all is well, and the worst."""
    head = ["order", "of", "no mode\ngrows", "at most\n[|lambda|]", "step\nkept", "least of\nuncoupled"]
    head += ["energy never\ngrows", "at most\n[|lambda|]"] if results[0].energy == results[0].energy else []
    rows = []
    for order in dict.fromkeys(r.order for r in results):
        own = [r for r in results if r.order == order]
        counts = [sum(getattr(r, name) for r in own) for name in ("stable", "step_kept", "estimate")]
        growth, energy = (f"{max(getattr(r, name) for r in own):.1e}" for name in ("growth", "energy"))
        worst = growth, f"{min(r.step_ratio for r in own):.3f}", energy
        row = [_name(own[0]), len(own), *(cell for pair in zip(counts, worst) for cell in pair)]
        rows.append(row[: len(head)])
    return text_table(head, rows)


def _heating(results: Sequence[Result]) -> list[str]:
    """What the heat of the stress at rest adds, in two lines."""
    if all(r.heated == r.growth for r in results):
        return []
    worst, growing = max(r.heated for r in results), sum(not r.heated_stable for r in results)
    told = f"modes grow at up to {worst:.1e} |lambda| ({growing} of {len(results)})" if growing else "no mode grows, either"
    return [
        "",
        "These numbers leave out the heat that the stress at rest sets free, which is not the interface's doing: sigma u_X/",
        f"(alpha m0), in two dimensions -p div v/(alpha m0). With it {told}.",
    ]


def save(opt: Mapping[str, Any], results: Sequence[Result]) -> list[Path]:
    """Write the table and, in one dimension, the picture of a sweep; returns their paths. FileError."""
    from fsipetsc.analysis.spectra import Result
    from fsipetsc.output.plots.studies import sweep_figure

    plane = results[0].energy != results[0].energy
    base = opt["fsi_output"] or f"stability-{'plane' if plane else opt['fsi_coupling']}"
    names = [field.name for field in fields(Result) if field.name != "slowest"]
    rows = [[getattr(result, name) for name in names] for result in results]
    path = save_csv(Path(f"{base}.csv"), names, rows)
    return [path] if plane else [path, *sweep_figure(results, f"{base}.png", THEORY[opt["fsi_coupling"]])]


def judge(results: Sequence[Result]) -> None:
    """Raise ComputationError, which names the worst, if a result does not keep what its treatment promises."""
    promised = {"a mode grows": "stable", "the step is shorter": "step_kept"}
    if results[0].coupling in ("conservative", "energy"):
        promised["the energy grows"] = "estimate"
    counts = {fault: sum(not getattr(r, name) for r in results) for fault, name in promised.items()}
    broken = [r for r in results if not all(getattr(r, name) for name in promised.values())]
    if broken:
        worst = max(broken, key=lambda r: (not r.stable, r.growth if not r.stable else -r.step_ratio))
        raise ComputationError(
            f"{worst.coupling} fails in {len(broken)} of {len(results)}: "
            f"{', '.join(f'{fault} in {count}' for fault, count in counts.items() if count)}; the worst is order "
            f"{worst.order}, m0/rho = {worst.density_ratio:g}, K/p = {worst.stiffness_ratio:g}: growth "
            f"{worst.growth:.2g} |lambda|, step {worst.step_ratio:.2g} of the uncoupled one"
        )


def _name(result: Result) -> str:
    from fsipetsc.operators import operator

    return operator(result.order).name
