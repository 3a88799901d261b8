"""The linearised coupled problem (4.2): a solid layer left of a fluid layer, each with n points, as sparse matrices.

Small disturbances of a constant state obey (3.6) and (3.8). Per point there are six unknowns, fluid (rho, u, T) and
solid (u, S, T). S = sigma - x_X' dp_s/dx_X stands for stress and strain, which act as this sum alone: with x_t = u it obeys
S_t = K^ u_X, K^ = (K - x_X dp_s/dx_X)/x_X, and what is left, K x_X'/x_X - sigma, never changes.

    fluid   rho_t = -rho^ D u
            u_t   = -D (p_T T + p_rho rho)/rho^ + mu'/rho^ D2 u
            T_t   = -T^ p_T/(rho^ cv) D u + kappa/(rho^ cv) D2 T
    solid   u_t   = D (S - c T) / m0
            S_t   = K^ D u
            T_t   = (-p^ D u + kappa_e/x_X D2 T) / (alpha m0)

D2 is D twice or the narrow second derivative, c = dp_s/dT, and the gas's equation of T is that of laws p(rho, T) and e(rho, T)
with rho^2 e_rho = p - T p_T, as thermodynamics has it. The energy E = h sum_j a_j (W q^2)_j has the weights of
fsipetsc.paper.coupling. In it the equations are symmetric but for a part of the last one: -p^ = -c T^ + (c T^ - p^). In
Grüneisen's solid c T^ - p^ is the stress sigma^, and that part the heat that a stress sigma^ != 0 sets free.

With the conservative coupling D of a flux is without what goes through the interface (fsipetsc.blocks).
D is fsipetsc.operators' and the interface is treated by the code that the solver calls, differentiated numerically at the
constant state. At the outer ends
u = 0, and T = 0 in what conducts: orthogonal projections that neither add nor take energy, so that growth comes from the
interface or from the equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import bmat, csr_matrix, diags, identity, lil_matrix

from fsipetsc.analysis.stability_state import Constant
from fsipetsc.operators import operator
from fsipetsc.operators.narrow import remainder
from fsipetsc.operators.sbp import row_length
from fsipetsc.paper.coupling import KINDS, Face, couple
from fsipetsc.paper.laws import elastic_of, gas_of
from fsipetsc.paper.stencils import CALL, packed

Array = NDArray[np.float64]
#: step of the numerical differentiation, relative to the size of each variable, and its formula of order 8
STEP = 2.0**-7
CENTRAL = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])


@dataclass(frozen=True)
class Linear:
    """The assembled problem in the variables sqrt(h a W) q, in which the energy is the square of the vector.

    raw: (6n, 6n) right-hand side of both layers without any condition, symmetric in the last equation;
    heating: (6n, 6n) what c T^ - p^ adds; projection: (6n, 6n) all conditions; layers: the same for the two layers alone, which
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
    """(right-hand side without the heating by c T^ - p^, that heating), (6n, 6n).

    D: derivative of the velocities, (n, n); outer, second: in fluid and solid those of the stress and, of second order, of what
    is conducted or diffuses.
    """
    solid, rho, T, c = state.solid, state.rho, state.T, state.solid_p_T
    heat, heat_f, n = solid.alpha * solid.m0, rho * state.heat_capacity, len(D)
    D, zero = csr_matrix(D), csr_matrix((n, n))
    (Df, Ds), (D2f, D2s) = map(csr_matrix, outer), map(csr_matrix, second)
    fluid = [
        [zero, -rho * D, zero],
        [-state.bulk / rho**2 * Df, 4 / 3 * state.mu / rho * D2f, -state.p_T / rho * Df],
        [zero, -T * state.p_T / heat_f * D, state.kappa / heat_f * D2f],
    ]
    elastic = [
        [zero, Ds / solid.m0, -c / solid.m0 * Ds],
        [state.modulus * D, zero, zero],
        [-c * T / heat * D, zero, solid.kappa_e / state.stretch / heat * D2s],
    ]
    heated = [[zero] * 3, [zero] * 3, [state.excess / heat * D, zero, zero]]
    rest = csr_matrix((3 * n, 3 * n))
    raw = bmat([[bmat(fluid), None], [None, bmat(elastic)]], format="csr")
    return raw, bmat([[rest, None], [None, bmat(heated)]], format="csr")


def interface_jacobian(state: Constant, order: int, h: float, coupling: str) -> Array:
    """Derivative, (6 rows, 6 rows), of the interface treatment at the constant state.

    Order as in Linear, rows counted from the interface into each layer. That of the paper's couplings is of the solver's own
    code.
    """
    rows = row_length(operator(order))
    if coupling == "conservative":
        return one_particle(state, rows)
    gas, solid = gas_of(state.gas), elastic_of(state.solid)
    size = 6 * rows
    constant = np.repeat([state.rho, 0.0, state.T, 0.0, state.stress, state.T], rows)
    steps = STEP * np.repeat(state.scales, rows)
    multiples = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
    # change m of variable c stands in row (m, c)
    changed = constant + multiples[:, None, None] * np.diag(steps)
    rho, u, T, v, sigma, Ts = np.moveaxis(changed.reshape(8 * size, 6, rows), 1, 0)
    places = np.broadcast_to(-h * state.stretch * np.arange(rows), rho.shape)
    f = np.stack([rho, rho * u, gas.total_energy(rho, u, T)], axis=-1)
    s = np.stack([v, sigma, Ts, places], axis=-1)
    couple_all(packed(order), Face(KINDS[coupling], gas, solid, 1.0, h), np.zeros(4), f, s)
    u, T = gas.velocity_and_temperature(*np.moveaxis(f, -1, 0))
    after = np.stack([f[..., 0], u, T, *np.moveaxis(s, -1, 0)[:3]], axis=1).reshape(8, size, size)
    differences = after[4:] - after[3::-1]
    return np.tensordot(CENTRAL, differences, 1).T / steps


@njit(**CALL)
def couple_all(ops, face, jump, f, s):
    """The treatment of one interface for many rows, in place: f (m, rows, 3) of the gas, s (m, rows, 4) of the solid."""
    for m in range(len(f)):
        couple(ops[0], face, jump, f[m], s[m])


def one_particle(state: Constant, rows: int) -> Array:
    """The same of the conservative coupling: the two end points share momentum, and heat if both conduct it."""
    jacobian = np.eye(6 * rows)
    pairs = [(1, 3, state.rho, state.solid.m0)]
    if state.kappa > 0.0 and state.solid.kappa_e > 0.0:
        pairs.append((2, 5, state.rho * state.heat_capacity, state.solid.alpha * state.solid.m0))
    for of_gas, of_solid, a, b in pairs:
        points = np.array([of_gas, of_solid]) * rows
        jacobian[np.ix_(points, points)] = np.array([[a, b], [a, b]]) / (a + b)
    return jacobian


def scatter(jacobian: Array, n: int) -> csr_matrix:
    """The interface treatment on all points, (6n, 6n), from its derivative on the rows at the interface."""
    rows = len(jacobian) // 6
    fluid, solid = np.arange(rows), n - 1 - np.arange(rows)
    index = np.concatenate([v * n + (fluid if v < 3 else solid) for v in range(6)])
    full = lil_matrix(identity(6 * n))
    full[np.ix_(index, index)] = jacobian
    return csr_matrix(full)
