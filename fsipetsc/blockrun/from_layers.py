"""Problems of layers in one dimension (fsipetsc.problem) as blocks: each layer becomes one, its
functions and ends those of a block.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.maps import rectangle
from fsipetsc.boundaries import Wall
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.kernels.symbols import Symbol
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.operators.sbp import operator
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

Function = Callable[..., Any]


def blocks_of_line(problem: Problem, h: float, order: int) -> BlockProblem:
    """A Problem in one dimension as blocks.

    h: spacing [m] of layers without cells of their own; order: of the operators. InputError where
    h does not fit a solid, or for what only the paper's method has.
    """
    blocks, notes, least = [], list(problem.notes), operator(order).min_points - 1
    for layer in problem.layers:
        cells = layer.cells or layer.fitting(h)
        layer.first_values(np.linspace(*layer.X, cells + 1))  # checks it
        if isinstance(layer, SolidLayer):
            blocks.append(_solid(layer, cells))
        else:
            cells = layer.cells or max(cells, least)
            blocks.append(_gas(layer, _gas_grid(problem, layer, notes), cells))
    ends = zip((0, 1), (problem.left, problem.right), (blocks[0], blocks[-1]), strict=True)
    faces = {(of.name, 0, side): end.condition(of.material) for side, end, of in ends}
    jumps = None if problem.jumps is None else _jumps(problem)
    return BlockProblem(tuple(blocks), faces, jumps, notes=tuple(notes), units=problem.units)


# gases


def _gas_grid(problem: Problem, layer: FluidLayer, notes: list[str]) -> tuple[float, float]:
    """Ends of the gas's grid before solids and walls move: where walls and open ends at rest are.

    Where that is not the layer's end, a note says so.
    """
    found = list(layer.X)
    ends = (0, problem.left, problem.layers[0]), (1, problem.right, problem.layers[-1])
    for side, end, outer in ends:
        if outer is not layer or (isinstance(end, Wall) and end.moves):
            continue
        if abs(end.x - layer.X[side]) > 1e-9 * (layer.X[1] - layer.X[0]):
            notes.append(
                f"layer '{layer.name}' ends at X = {layer.X[side]:g}, its {type(end).__name__} is "
                f"at x = {end.x:g}: the gas is stretched to it, and has another mass"
            )
            found[side] = float(end.x)
    if not found[0] < found[1]:
        raise InputError(
            f"{layer.place}layer '{layer.name}' would begin at x = {found[0]:g} and end at "
            f"{found[1]:g}: expected its ends in the order of X"
        )
    return found[0], found[1]


def _gas(layer: FluidLayer, grid: tuple[float, float], cells: int) -> Block:
    """The functions of the layer go with the points of its X, wherever its grid begins and ends."""
    (a, b), (low, high) = layer.X, grid

    def of_grid(what: str) -> Function | None:
        function = getattr(layer, what)
        if function is None or (a, b) == (low, high):
            return function

        @wraps(function)
        def moved(x: Array, *t: float) -> list[Array]:
            return function(a + (x - low) / (high - low) * (b - a), *t)

        return moved

    functions = map(of_grid, ("initial", "forcing", "exact"))
    return Block(layer.name, layer.material, rectangle(low, high), (cells,), *functions)


# solids


def _solid(layer: SolidLayer, cells: int) -> Block:
    """The stress of its material is K ln x_X - p_ref less its pressure."""
    stress, exact, of = _prestress(layer), layer.exact, layer.material
    (found,) = stress(np.linspace(*layer.X, 101))
    uniform = np.ptp(found) == 0.0
    numbers = 0.0, of.K, of.kappa_e, of.m0, of.alpha, -float(found[0]) if uniform else 0.0
    return Block(
        layer.name,
        ElasticSolid(*numbers, force=of.force, pressing=of.pressure_law),
        rectangle(*layer.X),
        (cells,),
        _picked(layer.initial, lambda u, sigma, T, x: (u, T, x)),
        forcing=layer.forcing and _forces_alone(layer),
        exact=exact and _picked(exact, lambda u, sigma, T, x: (u, T, x)),
        exact_stress=exact and _picked(exact, lambda u, sigma, T, x: (sigma,)),
        prestress=None if uniform else stress,
    )


def _picked(function: Function, pick: Function) -> Function:
    """What pick takes of u, sigma, T, x of a solid: the stress of a block follows from x."""

    @wraps(function)
    def called(*where: Any) -> Any:
        u, sigma, T, x = function(*where)
        return pick(u, sigma, T, x)

    return called


def _forces_alone(layer: SolidLayer) -> Function:
    """The forcing of a solid without that of its stress, which must be 0. InputError."""
    allowed = 1e-9 * layer.material.K  # for round-off

    @wraps(layer.forcing)
    def called(X: Any, t: Any) -> Any:
        u, sigma, T, x = layer.forcing(X, t)
        wrong = np.abs(sigma) > allowed
        if not isinstance(wrong, Symbol) and np.any(wrong):
            raise InputError(
                f"forcing of layer '{layer.name}' at t = {t:.6g}: sigma has a right-hand side, but "
                "follows from x here: expected 0, or -fsi_coupling projection",
                collective=False,
            )
        return u, T + np.where(wrong, np.nan, 0.0), x  # where it is recorded, the step fails

    return called


def _prestress(layer: SolidLayer) -> Function:
    """What the initial stress of a solid is beside K ln x_X [Pa]: a function of X.

    x_X is that of polynomials of sixth degree through x, in steps of a thousandth of the layer.
    """
    (low, high), initial, K = layer.X, layer.initial, layer.material.K
    step, points = 1e-3 * (high - low), np.arange(-3.0, 4.0)
    powers = np.linalg.inv(np.vander(points, increasing=True))

    def found(X: Array) -> tuple[Array]:
        middle = np.clip(X, low + 3 * step, high - 3 * step)
        around, z = [middle + j * step for j in points], (X - middle) / step
        moved = [initial(place)[3] - place for place in around]
        # sums of their own: those of a library's product of matrices depend on how many X there are
        c = [sum(map(np.multiply, row, moved)) for row in powers]
        stretch = 1.0 + sum(k * c[k] * z ** (k - 1) for k in range(1, len(c))) / step
        return (initial(X)[1] - K * np.log(stretch),)

    return found


# interfaces


def _jumps(problem: Problem) -> Function:
    """(traction, heat) that interfaces supply, by place. InputError for jumps of u and T."""
    places = np.array([layer.X[1] for layer in problem.layers[:-1]])

    @wraps(problem.jumps)
    def supplied(X: Array, t: float) -> Array:
        found, nearest = np.zeros((2, *np.shape(X))), np.abs(X[..., None] - places).argmin(axis=-1)
        for k in np.unique(nearest).tolist():
            u, stress, T, flux = problem.jumps_at(k, t)
            if u != 0.0 or T != 0.0:
                raise InputError(
                    f"jumps at interface {k} at t = {t:.6g}: g_u = {u:g}, g_T = {T:g}: expected 0 "
                    "where gas and solid are one particle, or -fsi_coupling projection",
                    collective=False,
                )
            into_solid = 1.0 if problem.layers[k].kind == "fluid" else -1.0
            found[:, nearest == k] = -into_solid * np.array([[stress], [flux]])
        return found

    return supplied
