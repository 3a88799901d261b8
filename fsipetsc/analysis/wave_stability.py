"""`python -m fsipetsc stability` in two dimensions: growth, modes and step of the coupled problem, by wave number."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.analysis.stability_options import OF_ONE_DIMENSION, orders
from fsipetsc.analysis.stability_state import same_temperature
from fsipetsc.analysis.wave_measures import TOLERANCE, Rest, WaveResult, Waves, measure
from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blocks.conditions import Free
from fsipetsc.blocks.values import block_values
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.process.together import wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.analysis.stability_state import Constant


@dataclass(frozen=True)
class WaveSetting:
    """What is studied: a state at rest; by order, cells across (solid, gas) and the distance of columns [m]; the form."""

    rest: Rest
    grids: Mapping[int, tuple[tuple[int, int], float]]
    form: BlockForm = BlockForm()  # noqa: RUF009


def setting_of_options(opt: Mapping[str, Any], state: Constant, chosen: Collection[str]) -> WaveSetting:
    """Two layers of as many points. chosen: names of the options that were given; InputError for one of one dimension."""
    unheeded = [name for name in OF_ONE_DIMENSION if name in chosen and (name, opt[name]) != ("fsi_coupling", "conservative")]
    if unheeded:
        raise InputError(f"-{unheeded[0]} {opt[unheeded[0]]}: two dimensions (-stability_plane) do not have it")
    K, cells = state.solid.K, opt["stability_points"] - 1
    shear, size = opt["solid_shear"] * K, cells * opt["fsi_h"]
    solid = ElasticSolid(shear, K - 2.0 * shear, state.solid.kappa_e, state.solid.m0, state.solid.alpha, heat=opt["solid_heat"])
    rest = Rest(state.gas, solid, state.rho, state.T, size, size)
    return WaveSetting(rest, {order: ((cells, cells), opt["fsi_h"]) for order in orders(opt)})


def setting_of_problem(problem: RunProblem, opt: Mapping[str, Any], form: BlockForm) -> WaveSetting:
    """The blocks at interface -stability_interface, with the case's cells, but no more than -stability_points of each.

    The state is that of the initial data at -stability_X, or in the middle of the interface; what moves or is strained there is
    left out. InputError where there is no such interface, the blocks are no flat layers, or have two temperatures.
    """
    if problem.dimension != 2:
        raise InputError(f"stability: the case has blocks in {problem.dimension} dimensions: expected two")
    known, k = problem.interfaces, opt["stability_interface"]
    if not 0 <= k < len(known):
        listed = [f"{number} ({name})" for number, name in enumerate(problem.interface_names)]
        raise InputError(f"-stability_interface {k}: expected {', '.join(listed) or 'a case with an interface'}")
    fluid, solid = known[k]
    gas, elastic = problem.layers[fluid], problem.layers[solid]
    (_, _, side), nodes = problem.interface_faces[k], problem.interface_nodes(k)
    (left, Y), (right, _) = problem.places(solid, nodes)[[0, -1]]
    if elastic.periodic[0]:
        right += elastic.periods[0][0] / elastic.cells[0]
    X = 0.5 * (left + right) if opt["stability_X"] is None else opt["stability_X"]
    if not left <= X <= right:
        raise InputError(f"-stability_X {X:g}: the interface is between {left:g} and {right:g}")
    h_x, (h_solid, h_gas) = (right - left) / elastic.cells[0], (_row(problem, n) for n in (solid, fluid))
    place = np.array([[X], [Y]])
    rho, _, _, T = (float(v[0]) for v in block_values(gas, "initial", place, 0.0))
    same_temperature(gas.name, T, elastic.name, float(block_values(elastic, "initial", place, 0.0)[2][0]))
    least = opt["stability_points"] - 1
    cells = min(elastic.cells[1], least), min(gas.cells[1], least)
    other = problem.faces_of(solid)[1, 1 - side]
    rest = Rest(gas.material, elastic.material, rho, T, cells[0] * h_solid, cells[1] * h_gas, not isinstance(other, Free))
    return WaveSetting(rest, {order: (cells, h_x) for order in orders(opt)}, form)


def _row(problem: RunProblem, k: int) -> float:
    """Distance of the rows of a block [m]. InputError where it is no flat layer, axis 0 along X and axis 1 along Y."""
    block = problem.layers[k]
    X, Y = (values.reshape(block.shape[::-1]) for values in problem.places(k, np.arange(np.prod(block.shape))).T)
    steps = np.diff(Y, axis=0)
    bent = np.ptp(X, axis=0).max() + np.ptp(Y, axis=1).max() + np.ptp(steps)
    if bent > 1e-9 * (np.ptp(X) + np.ptp(Y)):
        raise InputError(f"stability: block '{block.name}' is no flat layer of equal cells: the linear theory is about those")
    return float(steps[0, 0])


def wave_stability(opt: Mapping[str, Any], setting: WaveSetting, comm: MPI.Comm) -> None:
    """Compute, print, judge. Collective; the ranks share the combinations. ComputationError if a mode grows or the step is
    less than that of the layers alone.
    """
    states = [setting.rest]
    if opt["sweep"]:
        states = [setting.rest.swept(*both) for both in product(opt["density_ratios"], opt["stiffness_ratios"])]
    tasks, k = list(product(orders(opt), states)), opt["stability_k"]
    waves = Waves(k=tuple(k)) if k else Waves(tuple(opt["stability_symbols"]))
    mine = []
    for order, rest in tasks[comm.rank :: comm.size]:
        cells, h_x = setting.grids[order]
        mine.append(measure(rest, order, cells, waves, h_x, setting.form))
    shares = comm.allgather(mine)
    results = [shares[i % comm.size][i // comm.size] for i in range(len(tasks))]
    if comm.rank == 0 and not opt["fsi_quiet"]:
        print(table(opt, setting, results))
    wait_asleep(comm)
    _judge(results)


def table(opt: Mapping[str, Any], setting: WaveSetting, results: Sequence[WaveResult]) -> str:
    """A line for each combination; of one alone the modes, too."""
    symbols = f"symbol of D at {_listed(opt['stability_symbols'])} of its greatest value"
    lines = ["gas over a solid in two dimensions, linearised at rest: the scheme's own rates, by wave number"]
    for order, ((solid, gas), h) in setting.grids.items():
        lines.append(f"order {order}: {solid + 1} points across the solid, {gas + 1} across the gas, columns {h:.6g} m apart")
    lines += [
        f"k = {_listed(opt['stability_k'])} 1/m" if opt["stability_k"] else symbols,
        "",
        "order   m0/rho      K/p   fastest mode  largest |lambda|  RK4 step up to  of uncoupled  of gas at a wall",
        "                           [|lambda|]             [1/s]             [s]",
    ]
    for r in results:
        rates = f"{r.density_ratio:>8.4g} {r.stiffness_ratio:>8.4g} {r.growth:>14.1e} {r.radius:>17.4g}"
        lines.append(f"{r.order:>5} {rates} {r.step:>15.4g} {r.step_ratio:>13.4f} {r.wall_ratio:>17.4f}")
    if not opt["sweep"]:
        lines += ["", "slowest modes that swing, s [1/s]"]
        lines += [f"  order {r.order}, k = {k:>8.5g}  " + _modes(modes) for r in results for k, modes in r.slowest]
    if any(r.heated != r.growth for r in results):
        worst = max(r.heated for r in results)
        lines += [
            "",
            "The fastest mode is without the heat of the pressure at rest, -p div v/(alpha m0), which is not the interface's",
            f"doing. With it {f'modes grow at up to {worst:.1e} |lambda|' if worst > TOLERANCE else 'none grows, either'}.",
        ]
    return "\n".join([*lines, ""])


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _modes(modes: Sequence[complex]) -> str:
    return ", ".join(f"{s.real:.6g} + {s.imag:.6g}i" for s in modes) or "none"


def _judge(results: Sequence[WaveResult]) -> None:
    broken = [r for r in results if not (r.stable and r.step_kept)]
    if broken:
        worst = max(broken, key=lambda r: (r.growth, -r.step_ratio))
        fault = f"a mode grows at {worst.growth:.1e} |lambda|" if not worst.stable else f"the step is {worst.step_ratio:.3f}"
        where = f"order {worst.order}, m0/rho = {worst.density_ratio:g}, K/p = {worst.stiffness_ratio:g}"
        raise ComputationError(f"{fault} with {where}; {len(broken)} of {len(results)} fail")
