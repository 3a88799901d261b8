"""-fsi_view: layers, ranks, points, materials, operators and the method in time, in the manner of PETSc's views."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blockrun.view_of_blocks import block_lines
from fsipetsc.boundaries import ABSORBING, CLAMPED, FREE, SolidEnd
from fsipetsc.stepping.state import State

#: kind of a solid's end -> its name and that of its value
_SOLID_ENDS = {CLAMPED: ("clamped", "velocity"), FREE: ("free", "stress"), ABSORBING: ("absorbing", "stress")}
#: parts of a layer that are listed
_LISTED = 4


def view(state: State, name: str, opt: Mapping[str, Any]) -> list[str]:
    """The lines. Not collective: all ranks know what is in them. name: of the case."""
    problem, size = state.problem, state.comm.size
    m = problem.unit("m")
    lines = [f"FSI Object: ({name}) {size} MPI process{'es' * (size > 1)}"]
    of = "blocks" if isinstance(problem, RunProblem) else "layers"
    lines.append(f"  type: {problem.dimension}-D, {len(problem.layers)} {of}, {state.points} points, units {problem.units}")
    if isinstance(problem, RunProblem):
        lines += [*block_lines(state, described), *_operators(state, opt)]
        return [*lines, f"  Time: {_method(opt)}, to t = {opt['ts_max_time']:g}{problem.unit('s')}"]
    for k, layer in enumerate(problem.layers):
        low, high = layer.X
        lines.append(f"  Layer {k}: ({layer.name}) {layer.kind}, X = {low:g} … {high:g}{m}")
        lines.append(f"    grid: {_grid(state, k)}")
        lines.append(f"    ranks: {_ranks(state, k)}")
        lines.append(f"    material: {described(layer.material)}")
    for number, (fluid, solid) in enumerate(problem.interfaces):
        names = [problem.layers[k].name for k in sorted((fluid, solid))]
        lines.append(f"  Interface {number}: ({' | '.join(names)}) {opt['fsi_coupling']}")
    lines += [f"  {side} end: {described(getattr(problem, side))}" for side in ("left", "right")]
    lines += _operators(state, opt)
    lines.append(f"  Time: {_method(opt)}, to t = {opt['ts_max_time']:g}{problem.unit('s')}")
    return lines


def _grid(state: State, k: int) -> str:
    grid, m = state.layout.grids[k], state.problem.unit("m")
    active = grid.hi - grid.lo + 1
    held = f" ({grid.n - active} more in reserve)" if grid.n > active else ""
    kind = "Lagrangian" if state.problem.layers[k].kind == "solid" else "rigid"
    return f"{active} points{held}, h = {grid.h:.6g}{m}, {kind}"


def _ranks(state: State, k: int) -> str:
    """Which ranks own how many points."""
    share = state.layout.shares[k]
    parts = [f"{rank} ({end - begin})" for rank, begin, end in share]
    more = f", … {parts[-1]}" if len(parts) > _LISTED else ""
    return ", ".join(parts[:_LISTED]) + more


def _operators(state: State, opt: Mapping[str, Any]) -> Iterator[str]:
    op = state.op
    yield f"  Operators: SBP {op.name}, stencil of {2 * op.p + 1} points, {op.rows} rows in the closure, diagonal norm"
    yield f"    convection: {state.convection}, dissipation {opt['fsi_dissipation']:g}, at shocks {opt['fsi_shock']:g}"
    yield f"    second derivatives: {opt['fsi_viscous']}"


def _method(opt: Mapping[str, Any]) -> str:
    kind = opt["ts_type"]
    names = {"fused": "fused (classical Runge-Kutta, order 4)"}
    names |= {"rk": f"rk {opt['ts_rk_type']}", "ssp": f"ssp {opt['ts_ssp_type']}"}
    step = f"dt = {opt['ts_dt']:g}" if opt["ts_dt"] else f"Courant number {opt['fsi_cfl']:g}"
    control = f", error control to {opt['ts_rtol']:g}" if opt["ts_adapt_type"] != "none" else ""
    return f"{names.get(kind, kind)}, {step}{control}"


def described(thing: Any) -> str:
    """A material or an end: its kind, its numbers, the names of its laws."""
    kind, values = type(thing).__name__, [(entry.name, getattr(thing, entry.name)) for entry in fields(thing)]
    if isinstance(thing, SolidEnd):
        kind, values = _SOLID_ENDS[thing.kind][0], [(_SOLID_ENDS[thing.kind][1], thing.value), *values[2:]]
    known = ", ".join(f"{name} {_text(value)}" for name, value in values if not _empty(value))
    return f"{kind}{f': {known}' if known else ''}"


def _empty(value: Any) -> bool:
    return value is None or (isinstance(value, str) and not value)


def _text(value: Any) -> str:
    if is_dataclass(value):
        return described(value)
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))})"
    if callable(value):
        return "a function"
    return f"{value:g}" if isinstance(value, float) else str(value)
