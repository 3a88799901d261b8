"""The linearised coupled problem (4.2): a solid layer left of a fluid layer, each with n points, on dense matrices.

Small disturbances of a constant state obey (3.6) and (3.8). Per point there are six unknowns, fluid (rho, u, T) and
solid (u, S, T). S = sigma - p_rho rho' stands for the stress and the strain, which enter as this sum alone: with
rho' = -m0 x_X' and x_t = u it obeys S_t = (K + m0 p_rho) u_X, and sigma/K - x_X' keeps its value for ever.

    rho_t = -rho^ D u                                                     u_t = D (S - c T) / m0
    u_t   = -D (R T + R T^/rho^ rho) + mu'/rho^ D D u                     S_t = (K + p_s) D u
    T_t   = -(gamma-1) T^ D u + kappa/(rho^ cv) D D T                     T_t = ((sigma^ - p_s) D u + kappa_e D D T) / (alpha m0)

c = alpha p_eps. The energy E = h sum_j a_j (W q^2)_j has the weights of fsipetsc.coupling.energy. In it the equations
are symmetric but for the part sigma^ D u of the last one, the heat that the stress sigma^ != 0 sets free.

D is fsipetsc.operators' and the interface is treated by the compiled code that the solver calls, differentiated
numerically at the constant state. At the outer ends u = 0, and T = 0 in what conducts: orthogonal projections that
neither add nor take energy, so that growth comes from the interface or from the equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fsipetsc.coupling import INTERFACE, KINDS, couple
from fsipetsc.operators import operator, packed
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid

Array = NDArray[np.float64]
#: step of the numerical differentiation, relative to the size of each variable, and its formula of order 8
STEP = 2.0**-7
CENTRAL = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])


@dataclass(frozen=True)
class Constant:
    """The constant state and the materials: gas of density rho [kg/m3] and temperature T [K] at rest on a solid.

    The solid has the same temperature, x_X = 1, and the stress that balances the gas.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float

    @property
    def p(self) -> float:
        """Pressure of the gas [Pa]."""
        return self.gas.R * self.rho * self.T

    @property
    def solid_pressure(self) -> float:
        """p_s [Pa]; also m0 p_rho, and T times alpha p_eps."""
        return self.solid.gruneisen * self.solid.m0 * self.solid.alpha * self.T

    @property
    def stress(self) -> float:
        """sigma [Pa] of the solid, by sigma - p_s = -p."""
        return self.solid_pressure - self.p

    @property
    def weights(self) -> Array:
        """W of (rho, u, T) in the fluid and (u, S, T) in the solid."""
        gas, solid = self.gas, self.solid
        fluid = [gas.R * self.T / self.rho, self.rho, self.rho * gas.cv / self.T]
        return np.array([*fluid, solid.m0, 1.0 / (solid.K + self.solid_pressure), solid.alpha * solid.m0 / self.T])

    @property
    def scales(self) -> Array:
        """The size of each of these variables: what makes an energy of p per volume, at most rho, p, T themselves."""
        limits = np.array([self.rho, np.inf, self.T, np.inf, self.p, self.T])
        return np.minimum(np.sqrt(self.p / self.weights), limits)


@dataclass(frozen=True)
class Linear:
    """The assembled problem in the variables sqrt(h a W) q, in which the energy is the square of the vector.

    raw: (6n, 6n) right-hand side of both layers without any condition, sigma^ = 0 in the last equation;
    heating: (6n, 6n) what sigma^ adds; projection: (6n, 6n) all conditions; layers: the same for the two layers alone.
    Order: fluid rho, u, T, solid u, S, T; in each the points from left to right.
    """

    raw: Array
    heating: Array
    projection: Array
    layers: Array
    n: int

    def operator(self, heating: bool = True) -> Array:
        """P L P: the linearised semi-discrete problem."""
        return self.projection @ (self.raw + self.heating if heating else self.raw) @ self.projection


def assemble(state: Constant, order: int, n: int, h: float, coupling: str) -> Linear:
    """The problem with n points of spacing h [m] in each layer. ValueError if the closures do not fit."""
    op = operator(order)
    D, norm = op.matrix(n, h), op.norm_weights(n)
    size = np.sqrt(h * np.outer(state.weights, norm)).ravel()
    raw, heating = rates(state, D)
    ends = np.ones((6, n))
    ends[1, -1] = ends[3, 0] = 0.0
    ends[2, -1] = 0.0 if state.gas.kappa > 0 else 1.0
    ends[5, 0] = 0.0 if state.solid.kappa_e > 0 else 1.0
    alone = ends * np.concatenate([ends[:3, ::-1], ends[3:, ::-1]])
    at_interface = scatter(interface_jacobian(state, order, h, coupling), n)
    scaled = size[:, None] / size[None, :]
    return Linear(
        raw * scaled,
        heating * scaled,
        ends.ravel()[:, None] * (at_interface * scaled) * ends.ravel()[None, :],
        np.diag(alone.ravel()),
        n,
    )


def rates(state: Constant, D: Array) -> tuple[Array, Array]:
    """(right-hand side without the heating by sigma^, that heating), (6n, 6n), for the derivative D, (n, n)."""
    gas, solid, rho, T, ps = state.gas, state.solid, state.rho, state.T, state.solid_pressure
    heat = solid.alpha * solid.m0
    zero, DD = np.zeros_like(D), D @ D
    fluid = [
        [zero, -rho * D, zero],
        [-gas.R * T / rho * D, 4 / 3 * gas.mu / rho * DD, -gas.R * D],
        [zero, -(gas.gamma - 1) * T * D, gas.kappa / (rho * gas.cv) * DD],
    ]
    elastic = [
        [zero, D / solid.m0, -ps / T / solid.m0 * D],
        [(solid.K + ps) * D, zero, zero],
        [-ps / heat * D, zero, solid.kappa_e / heat * DD],
    ]
    n = len(D)
    raw, heating = np.zeros((6 * n, 6 * n)), np.zeros((6 * n, 6 * n))
    raw[: 3 * n, : 3 * n], raw[3 * n :, 3 * n :] = np.block(fluid), np.block(elastic)
    heating[5 * n :, 3 * n : 4 * n] = state.stress / heat * D
    return raw, heating


def interface_record(state: Constant, h: float, coupling: str, normal: float = 1.0) -> np.ndarray:
    """The INTERFACE record, shape (1,), of this solid and this gas."""
    face = np.zeros(1, INTERFACE)
    gas, solid = state.gas, state.solid
    values = {"gamma": gas.gamma, "R": gas.R, "cv": gas.cv, "mu": 4 / 3 * gas.mu, "kappa": gas.kappa}
    values |= {name: getattr(solid, name) for name in ("K", "kappa_e", "m0", "alpha", "gruneisen")}
    for name, value in {**values, "h": h, "coupling": KINDS[coupling], "normal": normal}.items():
        face[name] = value
    return face


def interface_jacobian(state: Constant, order: int, h: float, coupling: str) -> Array:
    """Derivative, (6 rows, 6 rows), of the interface treatment at the constant state, by the solver's own code.

    Order as in Linear, rows counted from the interface into each layer.
    """
    face, op = interface_record(state, h, coupling), np.array([packed(order)])
    rows = max(2, int(op[0]["rows"]))
    constant = np.repeat([[state.rho], [0.0], [state.T], [0.0], [state.stress], [state.T]], rows, axis=1)

    def treated(change: Array) -> Array:
        rho, u, T, v, sigma, Ts = constant + change
        fluid = state.gas.conserved(rho, u, T)
        solid = np.stack([v, sigma, Ts, -h * np.arange(rows)], axis=-1)
        couple(face[0], op[0], fluid, solid)
        rho, u, T, _ = state.gas.primitive(fluid)
        return np.stack([rho, u, T, *solid.T[:3]]) - constant

    jacobian = np.empty((6 * rows, 6 * rows))
    for column in range(6 * rows):
        change = np.zeros((6, rows))
        change[divmod(column, rows)] = step = STEP * state.scales[column // rows]
        differences = [treated(k * change) - treated(-k * change) for k in range(1, 5)]
        jacobian[:, column] = np.tensordot(CENTRAL, differences, 1).ravel() / step
    return jacobian


def scatter(jacobian: Array, n: int) -> Array:
    """The interface treatment on all points, (6n, 6n), from its derivative on the rows at the interface."""
    rows = len(jacobian) // 6
    fluid, solid = np.arange(rows), n - 1 - np.arange(rows)
    index = np.concatenate([v * n + (fluid if v < 3 else solid) for v in range(6)])
    full = np.eye(6 * n)
    full[np.ix_(index, index)] = jacobian
    return full
