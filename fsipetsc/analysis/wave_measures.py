"""What the linearised problem in two dimensions says about stability, by wave number.

A gas at rest over a solid on a wall, below a wall; and the two layers alone, free of further
traction where they would meet: the coupling is a constraint on these two, so that no mode of it
need be faster than theirs. The gas then ends at a layer of nearly no weight and stiffness. Wave
numbers are given as the symbol of the operator (fsipetsc.analysis.wave_modes): fractions from 0 to
1 of its greatest value are all of 0 <= k h <= pi.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.analysis.spectra import Result, step_limit
from fsipetsc.analysis.stability_options import OF_ONE_DIMENSION
from fsipetsc.analysis.stability_state import Constant
from fsipetsc.analysis.wave_modes import Stack, linearise, most, wave_number
from fsipetsc.blocks.conditions import Clamped, Free, NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: growth over the largest |lambda| that counts as round-off; part of the smaller step of the
#: uncoupled layers that is kept
TOLERANCE, STEP_KEPT = 1e-11, 0.99
#: modes that are told of each wave number, and how much they must swing, over the largest |lambda|
TOLD, SWINGING = 3, 1e-6
#: density and stiffness, over those of the gas, of what ends a gas that is free of traction
WEIGHTLESS = 1e-6


@dataclass(frozen=True)
class Rest:
    """A gas of density rho [kg/m3] and temperature T [K] at rest over an elastic solid.

    The solid is free of strain under the gas's pressure, which replaces its p_ref. cells across
    (solid, gas), depth, height: of solid and gas [m]. h_x: distance of the columns [m], by default
    like the closest rows.
    """

    gas: Fluid
    solid: ElasticSolid
    rho: float = 1.0
    T: float = 1.0
    cells: tuple[int, int] = (31, 31)
    depth: float = 1.0
    height: float = 1.0
    h_x: float | None = None

    @property
    def p(self) -> float:
        """Pressure [Pa]."""
        return float(self.gas.gas_law.pressure(self.rho, self.T))

    @property
    def columns(self) -> float:
        """Distance of the columns [m]."""
        return self.h_x or min(self.depth / self.cells[0], self.height / self.cells[1])

    def layers(self) -> tuple[Layer, Layer]:
        """The solid below Y = 0 and the gas above."""
        solid = replace(self.solid, p_ref=self.p)
        below, above = (-self.depth, 0.0), (0.0, self.height)
        gas_at_rest = lambda X, Y: (self.rho, 0.0, 0.0, self.T)  # noqa: E731
        at_rest = lambda X, Y: (0.0, 0.0, self.T, X, Y)  # noqa: E731
        return (
            Layer("solid", solid, below, at_rest, cells=self.cells[0]),
            Layer("gas", self.gas, above, gas_at_rest, cells=self.cells[1]),
        )

    def coupled(self) -> Stack:
        """Both layers. The gas slips along the wall where it has no viscosity."""
        return Stack(self.layers(), Clamped(), NoSlip() if self.gas.mu > 0 else Slip())

    def alone(self) -> tuple[Stack, Stack]:
        """Solid and gas free where they would meet."""
        weight = WEIGHTLESS * self.p, 0.0, WEIGHTLESS * self.rho, self.solid.alpha
        light = ElasticSolid(0.0, *weight, heat="elastic")
        solid = Stack(self.layers()[:1], Clamped(), Free(self.p))
        return solid, replace(self, solid=light).coupled()

    def swept(self, density_ratio: float, stiffness_ratio: float) -> Rest:
        """The same with another density and stiffness of the solid; alpha m0 keeps its value."""
        solid, m0 = self.solid, density_ratio * self.rho
        stiffer = stiffness_ratio * self.p / solid.K
        moduli = {"mu_e": stiffer * solid.mu_e, "lambda_e": stiffer * solid.lambda_e}
        alpha = solid.alpha * solid.m0 / m0
        return replace(self, solid=replace(solid, m0=m0, alpha=alpha, **moduli))


class Waves(NamedTuple):
    """Wave numbers along the layers: k [1/m], or fractions of the greatest symbol of D."""

    symbols: tuple[float, ...] = ()
    k: tuple[float, ...] = ()

    def numbers(self, order: int, h: float) -> list[float]:
        """All as k [1/m] for columns h apart. InputError where these cannot tell two apart."""
        beyond = [k for k in self.k if k * h > np.pi]
        if beyond:
            known = f"columns {h:g} m apart know wave numbers up to {np.pi / h:g} 1/m"
            raise InputError(f"-stability_k {beyond[0]:g}: {known}")
        greatest = most(order, h)[1]
        return [wave_number(order, h, part * greatest) for part in self.symbols] + list(self.k)


def measure(rest: Rest, order: int, waves: Waves) -> Result:
    """The worst of all wave numbers; step_ratio: the least of one of them. InputError."""
    linear = [linearise(stack, order, rest.columns) for stack in (rest.coupled(), *rest.alone())]
    rows, slowest = [], []
    for k in waves.numbers(order, rest.columns):
        spectra = [np.linalg.eigvals(one.matrix(k)[0]) for one in linear]
        both, steps = spectra[0], [step_limit(spectrum) for spectrum in spectra]
        radius = np.abs(both).max()
        rows.append([both.real.max() / radius, radius, -steps[0], -steps[0] / min(steps[1:])])
        swinging = both[both.imag > SWINGING * radius]
        slowest.append((float(k), tuple(swinging[np.argsort(np.abs(swinging))[:TOLD]].tolist())))
    growth, radius, step, ratio = (float(worst) for worst in np.max(rows, axis=0))
    nan, stable = float("nan"), growth <= TOLERANCE
    return Result(
        order=order,
        coupling="conservative",
        density_ratio=rest.solid.m0 / rest.rho,
        stiffness_ratio=rest.solid.K / rest.p,
        energy=nan,
        growth=growth,
        heated_energy=nan,
        heated=growth,
        radius=radius,
        step=-step,
        step_ratio=-ratio,
        estimate=True,
        stable=stable,
        heated_stable=stable,
        step_kept=-ratio >= STEP_KEPT,
        slowest=tuple(slowest),
    )


def rest_of_options(opt: Mapping[str, Any], state: Constant, chosen: Collection[str]) -> Rest:
    """Two layers of as many points. chosen: names of the options that were given.

    InputError for one of one dimension.
    """
    for name in OF_ONE_DIMENSION:
        if name in chosen and (name, opt[name]) != ("fsi_coupling", "conservative"):
            raise InputError(f"-{name} {opt[name]}: -stability_plane does not have it")
    K, cells = state.solid.K, opt["stability_points"] - 1
    shear, size = opt["solid_shear"] * K, cells * opt["fsi_h"]
    conducting = state.solid.kappa_e, state.solid.m0, state.solid.alpha
    solid = ElasticSolid(shear, K - 2.0 * shear, *conducting, heat="elastic")
    return Rest(state.gas, solid, state.rho, state.T, (cells, cells), size, size, opt["fsi_h"])
