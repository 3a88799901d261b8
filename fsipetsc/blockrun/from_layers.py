"""Problems that say layers as problems that say blocks.

A Problem (fsipetsc.problem) with the conservative coupling and gases whose grids go from end to
end is one dimension of the blocks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc import given
from fsipetsc.blocks import conditions as new
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.boundaries import CLAMPED, FREE, Dirichlet, Open, SolidEnd, Wall
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import Gruneisen
from fsipetsc.operators.sbp import operator
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

Function = Callable[..., Any]


def blocks_of_line(problem: Problem, h: float, order: int) -> BlockProblem:
    """A Problem in one dimension as blocks.

    h: spacing [m]; order: of the operators. InputError where h does not fit a solid, or for what
    only the paper's method has.
    """
    blocks, faces, notes = [], {}, list(problem.notes)
    ends = {0: problem.left, 1: problem.right}
    for k, layer in enumerate(problem.layers):
        at_end = {0: k == 0, 1: k == len(problem.layers) - 1}
        outer = {side: end for side, end in ends.items() if at_end[side]}
        low = layer.X[0] if k == 0 else problem.layers[k - 1].X[1]
        X = np.linspace(*layer.X, 1 + max(1, round((layer.X[1] - layer.X[0]) / h)))
        given.initial(layer, X, slice(None))  # what is wrong is found before it is used
        if isinstance(layer, SolidLayer):
            blocks.append(_solid_block(layer, (low, layer.X[1]), h))
            found = {side: _solid_end(end, layer, side) for side, end in outer.items()}
        else:
            for side in outer:
                _check_motion(problem, layer, side, h)
            grid = _gas_grid(layer, (low, layer.X[1]), outer, notes)
            blocks.append(_gas_block(layer, grid, h, order))
            found = {side: _gas_end(end, layer, side) for side, end in outer.items()}
        faces |= {(layer.name, 0, side): condition for side, condition in found.items()}
    jumps = _line_jumps(problem)
    return BlockProblem(tuple(blocks), faces, jumps, notes=tuple(notes), units=problem.units)


def _check_motion(problem: Problem, layer: FluidLayer, side: int, h: float) -> None:
    """InputError if a wall's velocity is not the rate of its place until sound has gone h."""
    rho, _, T = (
        float(v[0]) for v in given.fields(layer, "initial", np.array([layer.X[side]]), 0.0)
    )
    sound = layer.material.sound_speed(T, rho) if min(rho, T) > 0.0 else 1.0
    given.check_motion(problem, side, 0.0, h / float(sound))


def _gas_grid(
    layer: FluidLayer, X: tuple[float, float], outer: dict[int, Any], notes: list[str]
) -> tuple[float, float]:
    """Ends of the gas's grid before solids and walls move: where walls and open ends at rest are.

    Where that is not the layer's end, a note says so.
    """
    found = list(X)
    for side, end in outer.items():
        if not isinstance(end, Wall) or not end.moves:
            if abs(end.x - X[side]) > 1e-9 * (X[1] - X[0]):
                notes.append(
                    f"layer '{layer.name}' ends at X = {X[side]:g}, its {type(end).__name__} is at "
                    f"x = {end.x:g}: the gas is stretched to it, and has another mass"
                )
            found[side] = float(end.x)
    if not found[0] < found[1]:
        raise InputError(
            f"{layer.place}layer '{layer.name}' would begin at x = {found[0]:g} and end at {found[1]:g}: "
            "expected its ends in the order of X"
        )
    return found[0], found[1]


def _gas_block(layer: FluidLayer, grid: tuple[float, float], h: float, order: int) -> Block:
    """The functions of the layer go with the points of its X, wherever its grid begins and ends."""
    (a, b), (low, high) = layer.X, grid

    def of_grid(what: str) -> Function | None:
        if getattr(layer, what) is None:
            return None
        function = asked(layer, what)
        if (a, b) == (low, high):
            return function

        def moved(x: Array, *t: float) -> list[Array]:
            return function(a + (x - low) / (high - low) * (b - a), *t)

        moved.__wrapped__ = function
        return moved

    cells = max(round((b - a) / h), operator(order).min_points - 1)
    return Block(
        layer.name,
        layer.material,
        rectangle(low, high),
        (cells,),
        of_grid("initial"),
        of_grid("forcing"),
        of_grid("exact"),
    )


def asked(layer: FluidLayer | SolidLayer, what: str) -> Function:
    """layer.initial, exact or forcing, checked: what is wrong is said of the layer. InputError."""

    def called(X: Array, t: float = 0.0) -> list[Array]:
        return given.fields(layer, what, X, t)

    called.__wrapped__ = getattr(layer, what)
    return called


def _solid_block(layer: SolidLayer, X: tuple[float, float], h: float) -> Block:
    width = (X[1] - X[0]) / h
    cells = max(1, round(width))
    if abs(width - cells) > 1e-6 * max(1.0, width):
        raise InputError(
            f"-fsi_h {h:.10g} misses an interface: layer '{layer.name}' of length {X[1] - X[0]:g} "
            f"would have {width:.6g} cells; the nearest spacings that fit are "
            f"{(X[1] - X[0]) / max(1, np.ceil(width)):.10g} and "
            f"{(X[1] - X[0]) / max(1, np.floor(width)):.10g}"
        )
    stress = _Prestress(layer)
    uniform = stress.uniform()
    return Block(
        layer.name,
        _elastic(layer.material, 0.0 if uniform is None else -uniform),
        rectangle(*X),
        (cells,),
        _without_stress(asked(layer, "initial")),
        _forces_alone(layer),
        layer.exact and _without_stress(asked(layer, "exact")),
        exact_stress=layer.exact and (lambda X, t: (asked(layer, "exact")(X, t)[1],)),
        **({"prestress": stress} if uniform is None else {}),
    )


def _without_stress(function: Function) -> Function:
    """(u, sigma, T, x) of a solid as (v, T, x): its stress follows from x."""

    def called(*where: Any) -> Any:
        u, _, T, x = function(*where)
        return u, T, x

    called.__wrapped__ = function.__wrapped__
    return called


def _forces_alone(layer: SolidLayer) -> Function | None:
    """The forcing of a solid without that of its stress, which must be 0. InputError."""
    if layer.forcing is None:
        return None

    def called(X: Array, t: float) -> Any:
        u, sigma, T, x = asked(layer, "forcing")(X, t)
        if np.any(np.abs(sigma) > 1e-9 * layer.material.K):  # but for round-off
            raise InputError(
                f"forcing of layer '{layer.name}' at t = {t:.6g}: sigma has a right-hand side, but "
                "follows from x here: expected 0, or "
                "-fsi_coupling projection",
                collective=False,
            )
        return u, T, x

    called.__wrapped__ = layer.forcing
    return called


def _elastic(material: Solid, p_ref: float) -> ElasticSolid:
    """A solid in one dimension, whose stress is K ln x_X - p_ref less its pressure."""
    pressure = material.pressing
    if pressure is None and material.gruneisen > 0.0:
        pressure = Gruneisen(material.gruneisen)
    numbers = material.kappa_e, material.m0, material.alpha, p_ref
    return ElasticSolid(0.0, material.K, *numbers, force=material.force, pressing=pressure)


class _Prestress:
    """What the initial stress of a solid is beside K ln x_X [Pa]: a function of X."""

    #: points through which x goes, in steps of a thousandth of the layer, and the polynomials there
    steps = np.arange(-3, 4)
    powers = np.linalg.inv(np.vander(steps.astype(float), increasing=True))

    def __init__(self, layer: SolidLayer) -> None:
        self.layer, self.step = layer, 1e-3 * (layer.X[1] - layer.X[0])

    def __call__(self, X: Array) -> tuple[Array]:
        _, sigma, _, _ = asked(self.layer, "initial")(X)
        return (sigma - self.layer.material.K * np.log(self.stretch(X)),)

    def stretch(self, X: Array) -> Array:
        """x_X, of the displacement by polynomials of sixth degree, within the layer."""
        reach = 3 * self.step
        middle = np.clip(X, self.layer.X[0] + reach, self.layer.X[1] - reach)
        around = [middle + j * self.step for j in self.steps]
        moved = np.array([asked(self.layer, "initial")(place)[3] - place for place in around])
        z, c = (X - middle) / self.step, np.tensordot(self.powers, moved, 1)
        return 1.0 + sum(k * c[k] * z ** (k - 1) for k in range(1, len(c))) / self.step

    def uniform(self) -> float | None:
        """Its value if it is everywhere the same but for round-off of the derivatives."""
        low, high = self.layer.X
        X = np.linspace(low, high, 101)
        K, (_, sigma, _, x) = self.layer.material.K, asked(self.layer, "initial")(X)
        (found,) = self(X)
        noise = 3e-15 * K * (np.abs(x).max() if np.any(x != X) else 0.0) / self.step
        strained = K * np.ptp(np.log(self.stretch(X)))
        if np.ptp(found) > noise + 1e-6 * (np.ptp(sigma) + strained):
            return None
        return float(found[0] if np.ptp(found) == 0.0 else np.median(found))


def _gas_end(end: Any, layer: FluidLayer, side: int) -> new.Condition:
    """What stands at an outer end of a gas."""
    if isinstance(end, Wall):
        return new.NoSlip(
            **_heat(end, side),
            x=_vector(end.x, "x", side) if end.moves else None,
            velocity=end.velocity and _vector(end.velocity, "velocity", side),
        )
    if isinstance(end, Dirichlet):
        return new.Given(_of_place(end.values, "values", side, lambda values: values))
    if isinstance(end, Open):
        return new.Open(float(layer.material.gas_law.density(end.p0, end.T0)), (end.u0,), end.T0)
    raise InputError(f"layer '{layer.name}': no end of a gas: {end}")


def _solid_end(end: SolidEnd, layer: SolidLayer, side: int) -> new.Condition:
    """What stands at an outer end of a solid."""
    heat = _heat(end, side)
    if end.kind == CLAMPED:
        if not callable(end.value) and end.value == 0.0:
            return new.Clamped(**heat)
        return new.Clamped(velocity=_vector(end.value, "value", side), **heat)
    if end.kind == FREE:
        stress = end.value
        pressure = (
            _of_place(stress, "value", side, lambda p: -p[0]) if callable(stress) else -stress
        )
        return new.Free(pressure, **heat)
    return new.Absorbing(_number(end.value, "value", side), **heat)


def _heat(end: Wall | SolidEnd, side: int) -> dict[str, Any]:
    return {name: _number(getattr(end, name), name, side) for name in ("T", "heat_flux")}


def _number(value: Any, name: str, side: int) -> Any:
    """A number, or a function of t as one of X and t."""
    return _of_place(value, name, side, lambda found: found[0]) if callable(value) else value


def _vector(value: Any, name: str, side: int) -> Function:
    """A number, or a function of t, as a function of X and t that returns one component."""
    if callable(value):
        return _of_place(value, name, side, lambda found: found)
    return lambda X, t: (value,)


def _of_place(function: Function, name: str, side: int, then: Function) -> Function:
    """A function of t at an end as one of X and t: what is wrong is said of the end.

    Its `of_time` is the same as a function of t alone, whose values need not be looked at again.
    """

    def of_time(t: float) -> Any:
        return then(given.at_end(function, name, side, t))

    def called(X: Array, t: float) -> Any:
        return of_time(t)

    called.__wrapped__, called.of_time = function, of_time
    return called


def _line_jumps(problem: Problem) -> Function | None:
    """(traction, heat) that interfaces supply, by place. InputError for jumps of u and T."""
    if problem.jumps is None:
        return None
    places = np.array([layer.X[1] for layer in problem.layers[:-1]])

    def supplied(X: Array, t: float) -> Array:
        found = np.zeros((2, *np.shape(X)))
        for k, place in enumerate(places):
            here = np.abs(X - place) <= np.abs(X[..., None] - places).min(axis=-1)
            if not here.any():
                continue
            u, stress, T, flux = given.jumps(problem, k, t)
            if u != 0.0 or T != 0.0:
                raise InputError(
                    f"jumps at interface {k} at t = {t:.6g}: g_u = {u:g}, g_T = {T:g}: expected 0 "
                    "where gas and solid are one particle, or -fsi_coupling projection",
                    collective=False,
                )
            into_solid = 1.0 if problem.layers[k].kind == "fluid" else -1.0
            found[:, here] = np.array([[-into_solid * stress], [-into_solid * flux]])
        return found

    supplied.__wrapped__ = problem.jumps
    return supplied
