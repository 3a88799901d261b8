"""The linearised coupled problem (4.2): a solid layer left of a fluid layer, each with n points, as sparse matrices.

Small disturbances of a constant state obey (3.6) and (3.8). Per point there are six unknowns, fluid (rho, u, T) and
solid (u, S, T). S = sigma - p_rho rho' stands for stress and strain, which act as this sum alone: with x_t = u it obeys
S_t = K^ u_X, K^ = (K + p_s)/x_X, and what is left, K x_X'/x_X - sigma, never changes.

    fluid   rho_t = -rho^ D u
            u_t   = -D (R T + R T^/rho^ rho) + mu'/rho^ D2 u
            T_t   = -(gamma-1) T^ D u + kappa/(rho^ cv) D2 T
    solid   u_t   = D (S - c T) / m0
            S_t   = K^ D u
            T_t   = ((sigma^ - p_s) D u + kappa_e/x_X D2 T) / (alpha m0)

D2 is D twice or the narrow second derivative, c = alpha p_eps. The energy E = h sum_j a_j (W q^2)_j has the weights
of fsipetsc.coupling.energy. In it the equations are symmetric but for the part sigma^ D u of the last one, the heat
that the stress sigma^ != 0 sets free.

With the conservative coupling D of a flux is without what goes through the interface (fsipetsc.scheme.end_rates).
D is fsipetsc.operators' and the interface is treated by the compiled code that the solver calls, differentiated
numerically at the constant state. At the outer ends u = 0, and T = 0 in what conducts: orthogonal projections that
neither add nor take energy, so that growth comes from the interface or from the equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import bmat, csr_matrix, diags, identity, lil_matrix

from fsipetsc.coupling import INTERFACE, KINDS, couple
from fsipetsc.operators import operator, packed
from fsipetsc.operators.kernels import ENTRY
from fsipetsc.operators.narrow import remainder
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid
from fsipetsc.scheme.laws import PAIRS

Array = NDArray[np.float64]
#: of the built-in laws, for which the linear equations here are
BUILT_IN = PAIRS[0]
#: step of the numerical differentiation, relative to the size of each variable, and its formula of order 8
STEP = 2.0**-7
CENTRAL = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])


@dataclass(frozen=True)
class Constant:
    """The constant state and the materials: gas of density rho [kg/m3] and temperature T [K] at rest on a solid.

    The solid has the same temperature, the uniform strain x_X = stretch, and the stress that balances the gas.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float
    stretch: float = 1.0

    @property
    def p(self) -> float:
        """Pressure of the gas [Pa]."""
        return self.gas.R * self.rho * self.T

    @property
    def solid_pressure(self) -> float:
        """p_s [Pa]; also p_rho times the density, and alpha p_eps times T."""
        return self.solid.gruneisen * self.solid.m0 * self.solid.alpha * self.T / self.stretch

    @property
    def stress(self) -> float:
        """sigma [Pa] of the solid, by sigma - p_s = -p; 0 where the pressures are equal but for round-off."""
        stress = self.solid_pressure - self.p
        return stress if abs(stress) > 1e-12 * self.p else 0.0

    @property
    def modulus(self) -> float:
        """(K + p_s) / x_X [Pa]: S_t over u_X."""
        return (self.solid.K + self.solid_pressure) / self.stretch

    @property
    def weights(self) -> Array:
        """W of (rho, u, T) in the fluid and (u, S, T) in the solid."""
        gas, solid = self.gas, self.solid
        fluid = [gas.R * self.T / self.rho, self.rho, self.rho * gas.cv / self.T]
        return np.array([*fluid, solid.m0, 1.0 / self.modulus, solid.alpha * solid.m0 / self.T])

    @property
    def scales(self) -> Array:
        """The size of each of these variables: what makes an energy of p per volume, at most rho, p, T themselves."""
        limits = np.array([self.rho, np.inf, self.T, np.inf, self.p, self.T])
        return np.minimum(np.sqrt(self.p / self.weights), limits)


@dataclass(frozen=True)
class Linear:
    """The assembled problem in the variables sqrt(h a W) q, in which the energy is the square of the vector.

    raw: (6n, 6n) right-hand side of both layers without any condition, sigma^ = 0 in the last equation;
    heating: (6n, 6n) what sigma^ adds; projection: (6n, 6n) all conditions; layers: the same for the two layers alone, which
    end at the interface as at the outer ends, or free and insulated with the conservative coupling.
    Order: fluid rho, u, T, solid u, S, T; in each the points from left to right.
    """

    raw: csr_matrix
    heating: csr_matrix
    projection: csr_matrix
    layers: csr_matrix
    n: int

    def operator(self, heating: bool = True) -> csr_matrix:
        """P L P: the linearised semi-discrete problem."""
        return self.projection @ (self.raw + self.heating if heating else self.raw) @ self.projection


def assemble(state: Constant, order: int, n: int, h: float, coupling: str, narrow: bool = False) -> Linear:
    """The problem with n points of spacing h [m] in each layer. ValueError if the closures do not fit."""
    op = operator(order)
    D = op.matrix(n, h)
    narrowing = remainder(op.interior, np.ones(n)) / (h * h * op.norm_weights(n)[:, None]) if narrow else 0.0
    root = np.sqrt(h * np.outer(state.weights, op.norm_weights(n))).ravel()
    scale, unscale = diags(root), diags(1.0 / root)
    outer = D, D
    if coupling == "conservative":  # no flux through the interface is in the rates of the end points
        outer = D.copy(), D.copy()
        outer[0][0, 0] += 1.0 / (h * op.norm_weights(n)[0])
        outer[1][-1, -1] -= 1.0 / (h * op.norm_weights(n)[0])
    raw, heating = rates(state, D, outer, [divergence @ D - narrowing for divergence in outer])
    ends = np.ones((6, n))
    ends[1, -1] = ends[3, 0] = 0.0
    ends[2, -1] = 0.0 if state.gas.kappa > 0 else 1.0
    ends[5, 0] = 0.0 if state.solid.kappa_e > 0 else 1.0
    interface = scatter(interface_jacobian(state, order, h, coupling), n)
    return Linear(
        csr_matrix(scale @ raw @ unscale),
        csr_matrix(scale @ heating @ unscale),
        csr_matrix(diags(ends.ravel()) @ scale @ interface @ unscale @ diags(ends.ravel())),
        csr_matrix(diags((ends if coupling == "conservative" else ends * ends[:, ::-1]).ravel())),
        n,
    )


def rates(state: Constant, D: Array, outer: Sequence[Array], second: Sequence[Array]) -> tuple[csr_matrix, csr_matrix]:
    """(right-hand side without the heating by sigma^, that heating), (6n, 6n).

    D: derivative of the velocities, (n, n); outer, second: in fluid and solid those of the stress and, of second order, of what
    is conducted or diffuses.
    """
    gas, solid, rho, T, ps = state.gas, state.solid, state.rho, state.T, state.solid_pressure
    heat, n = solid.alpha * solid.m0, len(D)
    D, zero = csr_matrix(D), csr_matrix((n, n))
    (Df, Ds), (D2f, D2s) = map(csr_matrix, outer), map(csr_matrix, second)
    fluid = [
        [zero, -rho * D, zero],
        [-gas.R * T / rho * Df, 4 / 3 * gas.mu / rho * D2f, -gas.R * Df],
        [zero, -(gas.gamma - 1) * T * D, gas.kappa / (rho * gas.cv) * D2f],
    ]
    elastic = [
        [zero, Ds / solid.m0, -ps / T / solid.m0 * Ds],
        [state.modulus * D, zero, zero],
        [-ps / heat * D, zero, solid.kappa_e / state.stretch / heat * D2s],
    ]
    heated = [[zero] * 3, [zero] * 3, [state.stress / heat * D, zero, zero]]
    rest = csr_matrix((3 * n, 3 * n))
    raw = bmat([[bmat(fluid), None], [None, bmat(elastic)]], format="csr")
    return raw, bmat([[rest, None], [None, bmat(heated)]], format="csr")


def interface_record(state: Constant, h: float, coupling: str, normal: float = 1.0) -> np.ndarray:
    """The INTERFACE record, shape (1,), of this solid and this gas."""
    face = np.zeros(1, INTERFACE)
    gas, solid = state.gas, state.solid
    values = {"gamma": gas.gamma, "R": gas.R, "cv": gas.cv, "mu": 4 / 3 * gas.mu, "kappa": gas.kappa}
    values |= {name: getattr(solid, name) for name in ("K", "kappa_e", "m0", "alpha", "gruneisen")}
    values |= {"h": h, "h_gas": h, "J": 1.0, "spacing": h, "ratio": 1.0}
    for name, value in {**values, "coupling": KINDS[coupling], "normal": normal}.items():
        face[name] = value
    return face


def interface_jacobian(state: Constant, order: int, h: float, coupling: str) -> Array:
    """Derivative, (6 rows, 6 rows), of the interface treatment at the constant state, by the solver's own code.

    Order as in Linear, rows counted from the interface into each layer.
    """
    face, op = interface_record(state, h, coupling), np.array([packed(order)])
    rows = max(2, int(op[0]["rows"]))
    size = 6 * rows
    constant = np.repeat([state.rho, 0.0, state.T, 0.0, state.stress, state.T], rows)
    steps = STEP * np.repeat(state.scales, rows)
    multiples = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
    # change m of variable c stands in row (m, c)
    changed = constant + multiples[:, None, None] * np.diag(steps)
    rho, u, T, v, sigma, Ts = np.moveaxis(changed.reshape(8 * size, 6, rows), 1, 0)
    fluid, positions = state.gas.conserved(rho, u, T), np.broadcast_to(-h * state.stretch * np.arange(rows), rho.shape)
    solid = np.stack([v, sigma, Ts, positions, 0.5 * state.solid.m0 * v * v], axis=-1)
    couple_all(face, op, fluid, solid)
    rho, u, T, _ = state.gas.primitive(fluid)
    after = np.stack([rho, u, T, *np.moveaxis(solid, -1, 0)[:3]], axis=1).reshape(8, size, size)
    differences = after[4:] - after[3::-1]
    return np.tensordot(CENTRAL, differences, 1).T / steps


@njit(**ENTRY)
def couple_all(face, op, fluid, solid):
    """The treatment of one interface for many traces, in place: fluid (m, rows, 3), solid (m, rows, 5)."""
    for m in range(len(fluid)):
        couple(BUILT_IN, face[0], op[0], fluid[m], solid[m])


def scatter(jacobian: Array, n: int) -> csr_matrix:
    """The interface treatment on all points, (6n, 6n), from its derivative on the rows at the interface."""
    rows = len(jacobian) // 6
    fluid, solid = np.arange(rows), n - 1 - np.arange(rows)
    index = np.concatenate([v * n + (fluid if v < 3 else solid) for v in range(6)])
    full = lil_matrix(identity(6 * n))
    full[np.ix_(index, index)] = jacobian
    return csr_matrix(full)
