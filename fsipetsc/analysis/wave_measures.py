"""What the linearised problem in two dimensions says about stability: growth, and the largest step of RK4, by wave number.

A gas at rest over a solid on a wall, below a wall; and the two layers alone, free of further traction where they would
meet: the coupling is a constraint on these two, so that no mode of it need be faster than theirs. The gas then ends at a
layer of nearly no weight and stiffness. Wave numbers are given as the symbol of the operator
(fsipetsc.analysis.wave_modes): fractions from 0 to 1 of its greatest value are all of 0 <= k h <= pi.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.analysis.spectra import Result, step_limit
from fsipetsc.analysis.stability_options import OF_ONE_DIMENSION
from fsipetsc.analysis.stability_state import Constant, same_temperature
from fsipetsc.analysis.wave_modes import Stack, WaveLinear, linearise, most, wave_number
from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blocks.conditions import Clamped, Condition, Free, NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.blocks.values import block_values
from fsipetsc.checks import Fields
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: growth over the largest |lambda| that counts as round-off; part of the smaller step of the uncoupled layers that is kept
TOLERANCE, STEP_KEPT = 1e-11, 0.99
#: modes that are told of each wave number, and how much they must swing, over the largest |lambda|
TOLD, SWINGING = 3, 1e-6
#: density and stiffness, over those of the gas, of what ends a gas that is free of traction
WEIGHTLESS = 1e-6


@dataclass(frozen=True)
class Rest:
    """A gas of density rho [kg/m3] and temperature T [K] at rest over a solid that is free of strain under its pressure.

    The solid's p_ref is replaced by that pressure. cells across (solid, gas), depth, height: of solid and gas [m]. h_x:
    distance of the columns [m], by default like the closest rows. held: whether the solid ends at what holds it, or at a
    free surface under the same pressure.
    """

    gas: Fluid
    solid: ElasticSolid
    rho: float = 1.0
    T: float = 1.0
    cells: tuple[int, int] = (31, 31)
    depth: float = 1.0
    height: float = 1.0
    h_x: float | None = None
    held: bool = True

    @property
    def p(self) -> float:
        """Pressure [Pa]."""
        return float(self.gas.gas_law.pressure(self.rho, self.T))

    @property
    def columns(self) -> float:
        """Distance of the columns [m]."""
        return self.h_x or min(self.depth / self.cells[0], self.height / self.cells[1])

    @property
    def ends(self) -> tuple[Condition, Condition]:
        """Below the solid; above the gas, which slips where it has no viscosity."""
        return Clamped() if self.held else Free(self.p), NoSlip() if self.gas.mu > 0 else Slip()

    def layers(self) -> tuple[Layer, Layer]:
        """The solid below Y = 0 and the gas above."""
        solid = replace(self.solid, p_ref=self.p)

        def still(X: np.ndarray, Y: np.ndarray) -> Fields:
            return self.rho + 0 * X, 0 * X, 0 * X, self.T + 0 * X

        def unstrained(X: np.ndarray, Y: np.ndarray) -> Fields:
            return 0 * X, 0 * X, self.T + 0 * X, X, Y

        return (
            Layer("solid", solid, (-self.depth, 0.0), unstrained, cells=self.cells[0]),
            Layer("gas", self.gas, (0.0, self.height), still, cells=self.cells[1]),
        )

    def coupled(self) -> Stack:
        """Both layers."""
        return Stack(self.layers(), *self.ends)

    def alone(self) -> tuple[Stack, Stack]:
        """Solid and gas free where they would meet."""
        light = ElasticSolid(0.0, WEIGHTLESS * self.p, 0.0, WEIGHTLESS * self.rho, self.solid.alpha, heat="elastic")
        solid = Stack(self.layers()[:1], self.ends[0], Free(self.p))
        return solid, replace(self, solid=light, held=True).coupled()

    def swept(self, density_ratio: float, stiffness_ratio: float) -> Rest:
        """The same with another density and stiffness of the solid; alpha m0 keeps its value."""
        solid, m0 = self.solid, density_ratio * self.rho
        stiffer = stiffness_ratio * self.p / solid.K
        moduli = {"mu_e": stiffer * solid.mu_e, "lambda_e": stiffer * solid.lambda_e}
        return replace(self, solid=replace(solid, m0=m0, alpha=solid.alpha * solid.m0 / m0, **moduli))


class Waves(NamedTuple):
    """Wave numbers along the layers: k [1/m], or fractions of the greatest symbol of D."""

    symbols: tuple[float, ...] = ()
    k: tuple[float, ...] = ()

    def numbers(self, order: int, h: float) -> list[float]:
        """All as k [1/m] for columns h apart. InputError where these cannot tell one from another."""
        beyond = [k for k in self.k if k * h > np.pi]
        if beyond:
            raise InputError(f"-stability_k {beyond[0]:g}: columns {h:g} m apart know wave numbers up to {np.pi / h:g} 1/m")
        return [wave_number(order, h, part * most(order, h)[1]) for part in self.symbols] + list(self.k)


def measure(rest: Rest, order: int, waves: Waves, form: BlockForm = BlockForm()) -> Result:  # noqa: B008
    """The worst of all wave numbers; step_ratio: the least of one of them. InputError.

    With heat coupled the pressure at rest heats the solid where that is compressed, and nothing of the solid's stress answers
    to it: modes may grow by that. It is in the equations, and ``growth`` is that of the same matrix without it.
    """
    h_x = rest.columns
    linear = [linearise(stack, order, h_x, form=form) for stack in (rest.coupled(), *rest.alone())]
    bare = linear[0].without_heat() if linear[0].warmed.size else None
    rows, slowest = [], []
    for k in waves.numbers(order, h_x):
        spectra = [np.linalg.eigvals(one.matrix(k)) for one in linear]
        without = spectra[0] if bare is None else np.linalg.eigvals(bare.matrix(k))
        radius, steps = np.abs(spectra[0]).max(), [step_limit(spectrum) for spectrum in spectra]
        growths = [spectrum.real.max() / radius for spectrum in (without, spectra[0])]
        rows.append([*growths, radius, -steps[0], -steps[0] / min(steps[1:])])
        swinging = spectra[0][spectra[0].imag > SWINGING * radius]
        slowest.append((float(k), tuple(swinging[np.argsort(np.abs(swinging))[:TOLD]].tolist())))
    growth, heated, radius, step, ratio = (float(worst) for worst in np.max(rows, axis=0))
    ratios, nan = (rest.solid.m0 / rest.rho, rest.solid.K / rest.p), float("nan")
    fine = True, growth <= TOLERANCE, heated <= TOLERANCE, -ratio >= STEP_KEPT
    numbers = nan, growth, nan, heated, radius, -step, -ratio
    return Result(order, "conservative", *ratios, *numbers, *fine, tuple(slowest))


def nearest(linear: WaveLinear, k: float, expected: complex) -> complex:
    """The eigenvalue at wave number k [1/m] that is next to an expected one."""
    values, _ = linear.modes(k)
    return complex(values[np.argmin(np.abs(values - expected))])


def rest_of_options(opt: Mapping[str, Any], state: Constant, chosen: Collection[str]) -> Rest:
    """Two layers of as many points. chosen: names of the options that were given; InputError for one of one dimension."""
    unheeded = [name for name in OF_ONE_DIMENSION if name in chosen and (name, opt[name]) != ("fsi_coupling", "conservative")]
    if unheeded:
        raise InputError(f"-{unheeded[0]} {opt[unheeded[0]]}: two dimensions (-stability_plane) do not have it")
    K, cells = state.solid.K, opt["stability_points"] - 1
    shear, size = opt["solid_shear"] * K, cells * opt["fsi_h"]
    solid = ElasticSolid(shear, K - 2.0 * shear, state.solid.kappa_e, state.solid.m0, state.solid.alpha, heat=opt["solid_heat"])
    return Rest(state.gas, solid, state.rho, state.T, (cells, cells), size, size, opt["fsi_h"])


def rest_of_problem(problem: RunProblem, opt: Mapping[str, Any]) -> Rest:
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
    cells = tuple(min(block.cells[1], opt["stability_points"] - 1) for block in (elastic, gas))
    held = not isinstance(problem.faces_of(solid)[1, 1 - side], Free)
    return Rest(gas.material, elastic.material, rho, T, cells, cells[0] * h_solid, cells[1] * h_gas, h_x, held)


def _row(problem: RunProblem, k: int) -> float:
    """Distance of the rows of a block [m]. InputError where it is no flat layer, axis 0 along X and axis 1 along Y."""
    block = problem.layers[k]
    X, Y = (values.reshape(block.shape[::-1]) for values in problem.places(k, np.arange(np.prod(block.shape))).T)
    steps = np.diff(Y, axis=0)
    bent = np.ptp(X, axis=0).max() + np.ptp(Y, axis=1).max() + np.ptp(steps)
    if bent > 1e-9 * (np.ptp(X) + np.ptp(Y)):
        raise InputError(f"stability: block '{block.name}' is no flat layer of equal cells: the linear theory is about those")
    return float(steps[0, 0])
