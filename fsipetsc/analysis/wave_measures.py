"""What the linearised problem in two dimensions says about stability: growth, and the largest step of RK4, by wave number.

A gas at rest over a solid on a wall, below a wall, both of the same number of cells; and the two layers alone, free of further
traction where they would meet: the coupling is a constraint on these two, so that no mode of it need be faster than theirs.
The gas then ends at a layer of nearly no weight and stiffness. Wave numbers are given as the symbol of the operator
(fsipetsc.analysis.wave_modes): fractions from 0 to 1 of its greatest value are all of 0 <= k h <= pi.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from fsipetsc.analysis.stability_measures import step_limit
from fsipetsc.analysis.wave_modes import Stack, WaveLinear, linearise, most, wave_number
from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blocks.conditions import Clamped, Condition, Free, NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.checks import Fields
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: growth over the largest |lambda| that counts as round-off
TOLERANCE = 1e-11
#: part of the smaller step of the uncoupled layers that the coupled ones must keep
STEP_KEPT = 0.99
#: modes that are told of each wave number, and how much they must swing, over the largest |lambda|
TOLD, SWINGING = 3, 1e-6
#: density and stiffness, over those of the gas, of what ends a gas that is free of traction
WEIGHTLESS = 1e-6


@dataclass(frozen=True)
class Rest:
    """A gas of density rho [kg/m3] and temperature T [K] at rest over a solid that is free of strain under its pressure.

    The solid's p_ref is replaced by that pressure. depth, height: of solid and gas [m]. held: whether the solid ends at what
    holds it, or at a free surface under the same pressure.
    """

    gas: Fluid
    solid: ElasticSolid
    rho: float = 1.0
    T: float = 1.0
    depth: float = 1.0
    height: float = 1.0
    held: bool = True

    @property
    def base(self) -> Condition:
        """The other end of the solid."""
        return Clamped() if self.held else Free(self.p)

    @property
    def p(self) -> float:
        """Pressure [Pa]."""
        return float(self.gas.gas_law.pressure(self.rho, self.T))

    @property
    def wall(self) -> Condition:
        """That of the gas: it slips where it has no viscosity."""
        return NoSlip() if self.gas.mu > 0 else Slip()

    def layers(self, cells: tuple[int, int]) -> tuple[Layer, Layer]:
        """The solid below Y = 0 and the gas above, with cells (solid, gas) across."""
        solid = replace(self.solid, p_ref=self.p)

        def still(X: np.ndarray, Y: np.ndarray) -> Fields:
            return self.rho + 0 * X, 0 * X, 0 * X, self.T + 0 * X

        def unstrained(X: np.ndarray, Y: np.ndarray) -> Fields:
            return 0 * X, 0 * X, self.T + 0 * X, X, Y

        return (
            Layer("solid", solid, (-self.depth, 0.0), unstrained, cells=cells[0]),
            Layer("gas", self.gas, (0.0, self.height), still, cells=cells[1]),
        )

    def coupled(self, cells: tuple[int, int]) -> Stack:
        """Both layers."""
        return Stack(self.layers(cells), self.base, self.wall)

    def alone(self, cells: tuple[int, int]) -> tuple[Stack, Stack, Stack]:
        """Solid and gas free where they would meet, and the gas with a rigid wall there instead."""
        solid, gas = self.layers(cells)
        light = ElasticSolid(0.0, WEIGHTLESS * self.p, 0.0, WEIGHTLESS * self.rho, self.solid.alpha, heat="elastic")
        return (
            Stack((solid,), self.base, Free(self.p)),
            replace(self, solid=light, held=True).coupled(cells),
            Stack((gas,), self.wall, self.wall),
        )


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


@dataclass(frozen=True)
class WaveResult:
    """Of one problem and all wave numbers, the worst of each: rates in 1/s, steps in s.

    growth: largest real part over the largest |lambda| of its wave number, radius: the largest of these; heated: the same
    with the heat of the pressure at rest, which growth leaves out (see ``measure``); step_ratio: the least of coupled over
    uncoupled step of one wave number, wall_ratio: that with a wall as the end of the gas alone; step, step_alone: those of
    all wave numbers together. slowest: k [1/m] and the slowest modes that swing, s [1/s].
    """

    order: int
    density_ratio: float
    stiffness_ratio: float
    growth: float
    heated: float
    radius: float
    step_ratio: float
    wall_ratio: float
    step: float
    step_alone: float
    slowest: tuple[tuple[float, tuple[complex, ...]], ...] = field(default=(), compare=False)

    @property
    def stable(self) -> bool:
        """No mode grows, to round-off."""
        return self.growth <= TOLERANCE

    @property
    def step_kept(self) -> bool:
        """The interface costs no time step."""
        return self.step_ratio >= STEP_KEPT


def measure(
    rest: Rest, order: int, cells: tuple[int, int], waves: Waves, h_x: float | None = None, form: BlockForm = BlockForm(),  # noqa: B008
) -> WaveResult:
    """Numbers with ``cells`` in (solid, gas), columns h_x apart [m], by default like the closest rows. InputError.

    With heat coupled the pressure at rest heats the solid where that is compressed, and nothing of the solid's stress answers
    to it: modes may grow by that. It is in the equations, and ``growth`` is that of the same matrix without it.
    """
    h_x = h_x or min(rest.depth / cells[0], rest.height / cells[1])
    linear = [linearise(stack, order, h_x, form=form) for stack in (rest.coupled(cells), *rest.alone(cells))]
    bare = linear[0].without_heat() if linear[0].warmed.size else None
    growths, heated, radii, steps, slowest = [], [], [], [], []
    for k in waves.numbers(order, h_x):
        spectra = [np.linalg.eigvals(one.matrix(k)) for one in linear]
        radii.append(np.abs(spectra[0]).max())
        heated.append(spectra[0].real.max() / radii[-1])
        without = spectra[0] if bare is None else np.linalg.eigvals(bare.matrix(k))
        growths.append(without.real.max() / radii[-1])
        steps.append([step_limit(spectrum) for spectrum in spectra])
        swinging = spectra[0][spectra[0].imag > SWINGING * radii[-1]]
        slowest.append((float(k), tuple(swinging[np.argsort(np.abs(swinging))[:TOLD]].tolist())))
    coupled, solid, gas, walled = np.array(steps).T
    limits = np.minimum(solid, gas)
    least = [float((coupled / alone).min()) for alone in (limits, np.minimum(solid, walled))]
    ratios = rest.solid.m0 / rest.rho, rest.solid.K / rest.p
    most_of = float(max(growths)), float(max(heated)), float(max(radii))
    return WaveResult(order, *ratios, *most_of, *least, float(coupled.min()), float(limits.min()), tuple(slowest))


def nearest(linear: WaveLinear, k: float, expected: complex) -> complex:
    """The eigenvalue at wave number k [1/m] that is next to an expected one."""
    values, _ = linear.modes(k)
    return complex(values[np.argmin(np.abs(values - expected))])
