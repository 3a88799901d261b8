"""The linearised coupled problem (4.2): a solid layer left of a fluid layer, each with n points.

Small disturbances of a constant state obey (3.6) and (3.8). Per point there are six unknowns, fluid
(rho, u, T) and solid (u, S, T). S = sigma - x_X' dp_s/dx_X stands for stress and strain, which act
as this sum alone: with x_t = u it obeys S_t = K^ u_X, K^ = (K - x_X dp_s/dx_X)/x_X, and what is
left, K x_X'/x_X - sigma, never changes.

    fluid   rho_t = -rho^ D u
            u_t   = -D (p_T T + p_rho rho)/rho^ + mu'/rho^ D2 u
            T_t   = -T^ p_T/(rho^ cv) D u + kappa/(rho^ cv) D2 T
    solid   u_t   = D (S - c T) / m0
            S_t   = K^ D u
            T_t   = (-p^ D u + kappa_e/x_X D2 T) / (alpha m0)

D2 is D twice or the narrow second derivative, c = dp_s/dT; of the gas p_T = rho^ R, p_rho = R T^.
The energy E = h sum_j a_j (W q^2)_j has the weights of fsipetsc.paper.coupling. In it the equations
are symmetric but for a part of the last one: -p^ = -c T^ + sigma^. That part, the heat that a
stress sigma^ != 0 sets free, is left out.

At the outer ends u = 0, and T = 0 in what conducts: orthogonal projections that neither add nor
take energy, so that growth comes from the interface or from the equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from scipy.linalg import orth

from fsipetsc.cases.common import gas_of, solid_of
from fsipetsc.kernels.procedure import Code
from fsipetsc.kernels.unit import unit
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid
from fsipetsc.operators.narrow import remainder
from fsipetsc.operators.sbp import operator, row_length
from fsipetsc.paper.coupling import Face, couple
from fsipetsc.paper.layout import law_of
from fsipetsc.paper.stencils import Stencils, stencils
from fsipetsc.process.libraries import libraries
from fsipetsc.studies.spectra import Real, derivatives, step_limit

#: step of the numerical differentiation, relative to the size of each variable
STEP = 2.0**-7
#: growth over the largest |lambda| that counts as round-off: of the energy, of a mode (an
#: eigenvalue of a matrix that is not normal is less certain); part of the step limit of the
#: uncoupled layers that a treatment of the interface must leave
ENERGY_TOLERANCE, MODE_TOLERANCE, STEP_KEPT = 1e-10, 1e-9, 0.95


@dataclass(frozen=True)
class Constant:
    """A perfect gas of density rho [kg/m3] and temperature T [K] at rest on a solid of the same
    temperature and the uniform strain x_X = stretch; the solid's pressure p_s is Grüneisen's or 0.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float
    stretch: float = 1.0

    @property
    def p(self) -> float:
        """Pressure of the gas [Pa]."""
        return self.rho * self.gas.R * self.T

    @property
    def solid_pressure(self) -> float:
        """p_s of the solid [Pa]; proportional to T / x_X."""
        return float(self.solid.pressure(self.T, self.stretch))

    @property
    def stress(self) -> float:
        """sigma = p_s - p, which balances the gas [Pa]."""
        difference = self.solid_pressure - self.p
        return difference if abs(difference) > 1e-12 * self.p else 0.0

    @property
    def modulus(self) -> float:
        """K^ = (K - x_X dp_s/dx_X) / x_X [Pa]."""
        return (self.solid.K + self.solid_pressure) / self.stretch

    @property
    def weights(self) -> Real:
        """W of (rho, u, T) in the fluid and (u, S, T) in the solid."""
        rho, T, solid = self.rho, self.T, self.solid
        fluid = [self.p / rho**2, rho, rho * self.gas.cv / T]
        return np.array([*fluid, solid.m0, 1.0 / self.modulus, solid.alpha * solid.m0 / T])

    @property
    def scales(self) -> Real:
        """The size of each of these variables: what makes an energy of p per volume, at most rho,
        p, T themselves."""
        limits = np.array([self.rho, np.inf, self.T, np.inf, self.p, self.T])
        return np.minimum(np.sqrt(self.p / self.weights), limits)

    def swept(self, density_ratio: float, stiffness_ratio: float) -> Constant:
        """The same with another density and stiffness of the solid; alpha m0 keeps its value, and
        so do the pressures."""
        solid, m0 = self.solid, density_ratio * self.rho
        other = replace(solid, m0=m0, K=stiffness_ratio * self.p, alpha=solid.alpha * solid.m0 / m0)
        return replace(self, solid=other)


def of_options(opt: Mapping[str, Any]) -> Constant:
    """The state that the options describe."""
    gas, solid, rho = gas_of(opt), solid_of(opt), opt["fluid_rho"]
    if opt["solid_eos"] == "ideal":  # p_s = p, sigma = 0
        solid = replace(solid, gruneisen=gas.R * rho / (solid.m0 * solid.alpha))
    return Constant(gas, solid, rho, opt["fluid_T"])


class Result(NamedTuple):
    """Numbers of one problem. Rates of growth are over the largest |lambda|.

    energy, growth: those of the energy and of the fastest mode. step: that RK4 can take [s],
    step_ratio: over that of the uncoupled layers. estimate, stable, step_kept: the energy does not
    grow, no mode does, the interface costs no step.
    """

    order: int
    coupling: str
    density_ratio: float
    stiffness_ratio: float
    energy: float
    growth: float
    step: float
    step_ratio: float
    estimate: bool
    stable: bool
    step_kept: bool


def assemble(
    state: Constant, order: int, n: int, h: float, coupling: str, narrow: bool = False
) -> tuple[Real, Real, Real]:
    """The problem with n points of spacing h [m] in each layer, in the variables sqrt(h a W) q, in
    which the energy is the square of the vector; in each the points from left to right.

    Returns the right-hand side (6n, 6n) of both layers without any condition, symmetric in the last
    equation; all conditions (6n, 6n); and (6n,) 0 where a layer alone is held: at its outer end,
    and at the interface in the same way, but with the conservative coupling, where it is free and
    insulated.
    """
    op, conservative = operator(order), coupling == "conservative"
    gas, solid, rho, T = state.gas, state.solid, state.rho, state.T
    D, H = op.matrix(n, h), h * op.norm_weights(n)
    narrowing = remainder(op.interior, np.ones(n)) / (h * H[:, None]) if narrow else 0.0
    Df, Ds = D.copy(), D.copy()
    if conservative:  # no flux through the interface is in the rates of the end points
        Df[0, 0] += 1.0 / H[0]
        Ds[-1, -1] -= 1.0 / H[0]
    D2f, D2s = Df @ D - narrowing, Ds @ D - narrowing
    c, p_T, heat = state.solid_pressure / T, rho * gas.R, solid.alpha * solid.m0
    heat_f, o, mu = rho * gas.cv, np.zeros_like(D), 4 / 3 * gas.mu
    raw = np.block(
        [
            [o, -rho * D, o, o, o, o],
            [-state.p / rho**2 * Df, mu / rho * D2f, -p_T / rho * Df, o, o, o],
            [o, -T * p_T / heat_f * D, gas.kappa / heat_f * D2f, o, o, o],
            [o, o, o, o, Ds / solid.m0, -c / solid.m0 * Ds],
            [o, o, o, state.modulus * D, o, o],
            [o, o, o, -c * T / heat * D, o, solid.kappa_e / state.stretch / heat * D2s],
        ]
    )
    ends = np.ones((6, n))
    ends[1, -1] = ends[3, 0] = 0.0
    ends[2, -1] = 0.0 if gas.kappa > 0 else 1.0
    ends[5, 0] = 0.0 if solid.kappa_e > 0 else 1.0
    both = ends if conservative else ends * ends[:, ::-1]
    treatment = one_particle(state, n) if conservative else of_paper(state, order, n, h, coupling)
    root = np.sqrt(np.outer(state.weights, H)).ravel()
    scaled = root[:, None] / root
    return scaled * raw, scaled * np.outer(ends, ends) * treatment, both.ravel()


def of_paper(state: Constant, order: int, n: int, h: float, coupling: str) -> Real:
    """Derivative, (6n, 6n), of the interface treatment at the constant state, by the solver's own
    code, on the rows next to the interface."""
    rows, gas, solid = row_length(operator(order)), law_of(state.gas), law_of(state.solid)
    constant = np.repeat([state.rho, 0.0, state.T, 0.0, state.stress, state.T], rows)
    face, x = Face(coupling, gas, solid, True, h), -h * state.stretch * np.arange(rows)
    interface = Interface(
        stencils(order), face, np.zeros(4), np.empty((rows, 3)), np.empty((rows, 4))
    )

    def couple_rows(of):
        """Couple the rows of an interface."""
        couple(of.op, of.face, of.jump, of.f, of.s)

    code = Code(unit({}, []))
    treat = code.procedure("couple_rows", couple_rows, interface)
    code.load(libraries(MPI.COMM_SELF, [code.text])[0])

    def treated(i: int, change: float) -> Real:
        """What the treatment makes of the constant state with a change of number i."""
        y = constant.copy()
        y[i] += change
        rho, u, T, *of_solid = y.reshape(6, rows)
        interface.f[:] = np.stack([rho, rho * u, gas.total_energy(rho, u, T)], axis=-1)
        interface.s[:] = np.stack([*of_solid, x], axis=-1)
        treat()
        u, T = gas.velocity_and_temperature(*interface.f.T)
        return np.concatenate([interface.f[:, 0], u, T, *interface.s.T[:3]])

    near, beyond = np.arange(rows), n - 1 - np.arange(rows)
    index = np.concatenate([c * n + (near if c < 3 else beyond) for c in range(6)])
    jacobian = np.eye(6 * n)
    jacobian[np.ix_(index, index)] = derivatives(treated, STEP * np.repeat(state.scales, rows))
    return jacobian


class Interface(NamedTuple):
    """The rows of an interface: f (rows, 3) of the gas, s (rows, 4) of the solid."""

    op: Stencils
    face: Face
    jump: Real
    f: Real
    s: Real


def one_particle(state: Constant, n: int) -> Real:
    """The same of the conservative coupling: the two end points share momentum, and heat if both
    conduct it."""
    gas, solid, jacobian = state.gas, state.solid, np.eye(6 * n)
    pairs = [(1, 3, state.rho, solid.m0)]
    if gas.kappa > 0.0 and solid.kappa_e > 0.0:
        pairs.append((2, 5, state.rho * gas.cv, solid.alpha * solid.m0))
    for of_gas, of_solid, a, b in pairs:
        points = of_gas * n, of_solid * n + n - 1
        jacobian[np.ix_(points, points)] = np.array([[a, b], [a, b]]) / (a + b)
    return jacobian


def measure(
    state: Constant, order: int, n: int, h: float, coupling: str, narrow: bool = False
) -> Result:
    """All numbers for n points of spacing h [m] in each layer, and D twice or narrow second
    derivatives.

    Energy: with w = P w, the vector of ``assemble``, d/dt |w|^2 / 2 = w^T P L w. Its largest value
    for |w| = 1 is the largest eigenvalue of the symmetric part of Z^T P L Z, Z an orthonormal basis
    of the range of P: 0 or less where the estimate holds. Modes: eigenvalues of Z^T P L Z.
    """
    raw, P, free = assemble(state, order, n, h, coupling, narrow)
    Z = orth(P, rcond=1e-9)
    A = Z.T @ (P @ raw @ P) @ Z
    energy, spectrum = float(np.linalg.eigvalsh((A + A.T) / 2).max()), np.linalg.eigvals(A)
    alone = np.outer(free, free) * raw
    halves = alone[: 3 * n, : 3 * n], alone[3 * n :, 3 * n :]
    uncoupled = min(step_limit(np.linalg.eigvals(half)) for half in halves)
    radius, step = float(np.abs(spectrum).max()), step_limit(spectrum)
    growth = float(spectrum.real.max()) / radius
    return Result(
        order=order,
        coupling=coupling,
        density_ratio=state.solid.m0 / state.rho,
        stiffness_ratio=state.solid.K / state.p,
        energy=energy / radius,
        growth=growth,
        step=step,
        step_ratio=step / uncoupled,
        estimate=energy <= ENERGY_TOLERANCE * radius,
        stable=growth <= MODE_TOLERANCE,
        step_kept=step >= STEP_KEPT * uncoupled,
    )
