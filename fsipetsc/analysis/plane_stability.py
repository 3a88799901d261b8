"""`python -m fsipetsc stability -stability_plane`: growth and step of the coupled problem in two dimensions, by wave number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from fsipetsc.analysis.plane_measures import PlaneRest, PlaneResult, measure
from fsipetsc.analysis.stability_options import orders, swept
from fsipetsc.errors import ComputationError
from fsipetsc.plane import PlaneSolid

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.analysis.stability_state import Constant


def plane_stability(opt: Mapping[str, Any], state: Constant, comm: MPI.Comm) -> None:
    """Compute, print, judge. Collective; the ranks share the combinations. ComputationError if a mode grows or the step is
    less than that of the layers alone.
    """
    states = [state]
    if opt["sweep"]:
        states = [swept(state, *ratios) for ratios in product(opt["density_ratios"], opt["stiffness_ratios"])]
    tasks = list(product(orders(opt), states))
    cells, fractions = opt["stability_points"] - 1, opt["stability_symbols"]
    mine = [measure(_rest(opt, one, cells), order, cells, fractions) for order, one in tasks[comm.rank :: comm.size]]
    shares = comm.allgather(mine)
    results = [shares[i % comm.size][i // comm.size] for i in range(len(tasks))]
    if comm.rank == 0 and not opt["fsi_quiet"]:
        print(table(opt, results))
    comm.Barrier()
    _judge(results)


def _rest(opt: Mapping[str, Any], state: Constant, cells: int) -> PlaneRest:
    K, size = state.solid.K, cells * opt["fsi_h"]
    shear = opt["solid_shear"] * K
    solid = PlaneSolid(shear, K - 2.0 * shear, state.solid.kappa_e, state.solid.m0, state.solid.alpha, heat=opt["solid_heat"])
    return PlaneRest(state.gas, solid, state.rho, state.T, size, size)


def table(opt: Mapping[str, Any], results: Sequence[PlaneResult]) -> str:
    """A line for each combination."""
    fractions = ", ".join(f"{value:g}" for value in opt["stability_symbols"])
    lines = [
        "gas over a solid in two dimensions, linearised at rest: the scheme's own rates, by wave number",
        f"{opt['stability_points']} points of h = {opt['fsi_h']:g} m in each; symbol of D at {fractions} of its greatest value",
        "",
        "order   m0/rho      K/p   fastest mode  largest |lambda|  RK4 step up to  of uncoupled  of gas at a wall",
        "                           [|lambda|]             [1/s]             [s]",
    ]
    for r in results:
        lines.append(
            f"{r.order:>5} {r.density_ratio:>8g} {r.stiffness_ratio:>8g} {r.growth:>14.1e} {r.radius:>17.4g} {r.step:>15.4g}"
            f" {r.step_ratio:>13.4f} {r.wall_ratio:>17.4f}"
        )
    return "\n".join([*lines, ""])


def _judge(results: Sequence[PlaneResult]) -> None:
    broken = [r for r in results if not (r.stable and r.step_kept)]
    if broken:
        worst = max(broken, key=lambda r: (r.growth, -r.step_ratio))
        fault = f"a mode grows at {worst.growth:.1e} |lambda|" if not worst.stable else f"the step is {worst.step_ratio:.3f}"
        where = f"order {worst.order}, m0/rho = {worst.density_ratio:g}, K/p = {worst.stiffness_ratio:g}"
        raise ComputationError(f"{fault} with {where}; {len(broken)} of {len(results)} fail")
