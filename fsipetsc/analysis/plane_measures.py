"""What the linearised problem in two dimensions says about stability: growth, and the largest step of RK4, by wave number.

A gas at rest over a solid on a wall, below a wall, both of the same number of cells; and the two layers alone, free of further
traction where they would meet: the coupling is a constraint on these two, so that no mode of it need be faster than theirs.
The gas then ends at a layer of nearly no weight and stiffness. Wave numbers are given as the symbol of the operator
(fsipetsc.analysis.plane_modes): fractions from 0 to 1 of its greatest value are all of 0 <= k h <= pi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsipetsc.analysis.plane_modes import PlaneLinear, linearise
from fsipetsc.analysis.stability_measures import step_limit
from fsipetsc.boundaries.plane import Clamped, Edge, Free, NoSlip, Slip
from fsipetsc.operators.formulas import in_python
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.material_law import formulas_of
from fsipetsc.plane import Fields, PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

#: growth over the largest |lambda| that counts as round-off
TOLERANCE = 1e-11
#: part of the smaller step of the uncoupled layers that the coupled ones must keep
STEP_KEPT = 0.99
#: density and stiffness, over those of the gas, of what ends a gas that is free of traction
WEIGHTLESS = 1e-6


@dataclass(frozen=True)
class PlaneRest:
    """A gas of density rho [kg/m3] and temperature T [K] at rest over a solid that is free of strain under its pressure.

    The solid's p_ref is replaced by that pressure. depth, height: of solid and gas [m].
    """

    gas: Fluid
    solid: PlaneSolid
    rho: float = 1.0
    T: float = 1.0
    depth: float = 1.0
    height: float = 1.0

    @property
    def p(self) -> float:
        """Pressure [Pa]."""
        known = formulas_of(self.gas.law)
        return float(in_python(known.pressure)(in_python(known.constants)(self.gas), self.rho, self.T))

    @property
    def wall(self) -> Edge:
        """That of the gas: it slips where it has no viscosity."""
        return NoSlip() if self.gas.mu > 0 else Slip()

    def layers(self, cells: tuple[int, int]) -> tuple[PlaneSolidLayer, PlaneFluidLayer]:
        """The solid below Y = 0 and the gas above, with cells (solid, gas) across."""
        solid = PlaneSolid(**{**vars(self.solid), "p_ref": self.p})

        def still(X: np.ndarray, Y: np.ndarray) -> Fields:
            return self.rho + 0 * X, 0 * X, 0 * X, self.T + 0 * X

        def unstrained(X: np.ndarray, Y: np.ndarray) -> Fields:
            return 0 * X, 0 * X, self.T + 0 * X, X, Y

        return (
            PlaneSolidLayer("solid", solid, (-self.depth, 0.0), unstrained, cells=cells[0]),
            PlaneFluidLayer("gas", self.gas, (0.0, self.height), still, cells=cells[1]),
        )

    def coupled(self, cells: tuple[int, int]) -> PlaneProblem:
        """Both layers."""
        return PlaneProblem(self.layers(cells), (0.0, 1.0), Clamped(), self.wall)

    def alone(self, cells: tuple[int, int]) -> tuple[PlaneProblem, PlaneProblem, PlaneProblem]:
        """Solid and gas free where they would meet, and the gas with a rigid wall there instead."""
        solid, gas = self.layers(cells)
        light = PlaneSolid(0.0, WEIGHTLESS * self.p, 0.0, WEIGHTLESS * self.rho, self.solid.alpha, heat="elastic")
        return (
            PlaneProblem((solid,), (0.0, 1.0), Clamped(), Free(self.p)),
            replace(self, solid=light).coupled(cells),
            PlaneProblem((gas,), (0.0, 1.0), self.wall, self.wall),
        )


@dataclass(frozen=True)
class PlaneResult:
    """Of one problem and all wave numbers, the worst of each: rates in 1/s, steps in s.

    growth: largest real part over the largest |lambda| of its wave number, radius: the largest of these; step_ratio: the
    least of coupled over uncoupled step of one wave number, wall_ratio: that with a wall as the end of the gas alone; step,
    step_alone: those of all wave numbers together.
    """

    order: int
    density_ratio: float
    stiffness_ratio: float
    growth: float
    radius: float
    step_ratio: float
    wall_ratio: float
    step: float
    step_alone: float

    @property
    def stable(self) -> bool:
        """No mode grows, to round-off."""
        return self.growth <= TOLERANCE

    @property
    def step_kept(self) -> bool:
        """The interface costs no time step."""
        return self.step_ratio >= STEP_KEPT


def measure(rest: PlaneRest, order: int, cells: int, fractions: Sequence[float]) -> PlaneResult:
    """Numbers with ``cells`` in each layer, at symbols that are these fractions of the greatest one. InputError."""
    both, h = (cells, cells), min(rest.depth, rest.height) / cells
    problems = rest.coupled(both), *rest.alone(both)
    linear = [linearise(problem, order, h) for problem in problems]
    growths, radii, steps = [], [], []
    for fraction in fractions:
        spectra = [one.eigenvalues(fraction) for one in linear]
        radii.append(np.abs(spectra[0]).max())
        growths.append(spectra[0].real.max() / radii[-1])
        steps.append([step_limit(spectrum) for spectrum in spectra])
    coupled, solid, gas, walled = np.array(steps).T
    limits = np.minimum(solid, gas)
    least = [float((coupled / alone).min()) for alone in (limits, np.minimum(solid, walled))]
    ratios = rest.solid.m0 / rest.rho, rest.solid.K / rest.p
    whole = float(coupled.min()), float(limits.min())
    return PlaneResult(order, *ratios, float(max(growths)), float(max(radii)), *least, *whole)


def nearest(linear: PlaneLinear, k: float, expected: complex) -> complex:
    """The eigenvalue at wave number k [1/m] that is next to an expected one."""
    values, _ = linear.modes(k)
    return complex(values[np.argmin(np.abs(values - expected))])
