"""Compressible Navier–Stokes equations in two dimensions, on a curvilinear grid that moves.

The grid x(xi, eta, t) has the velocity w. With the metrics Ja1 = (y_eta, -x_eta), Ja2 = (-y_xi, x_xi) and
g^k = Ja^k . w, U = (rho, rho u, rho v, e), and f, g the fluxes in x and y,

    J_t     = D_xi g^1 + D_eta g^2
    (JU)_t  = - sum_k D_k (Ja^k . (f, g) - g^k U)
    f       = (rho u, rho u^2 + p - tau_xx, rho u v - tau_xy, u (e + p) - u tau_xx - v tau_xy - kappa T_x),  g likewise

tau the stress of a Newtonian fluid without bulk viscosity. J is an unknown: taken from the grid anew, it would not be what the
operators make of w, and a uniform flow would not stay uniform. Gradients are those of the entropy variables W = (u, v, -1)/T,

    grad f = 1/J sum_k Ja^k D_k f,    grad u = T (grad W1 + u grad W3),    grad T = T^2 grad W3,

because then friction and conduction produce entropy at each point, whatever the metrics are.

The grid is straight in eta between its lower and its upper line: x = (1 - zeta) x_low + zeta x_high, zeta from 0 to 1, so
that Ja1 does not depend on eta and Ja2 and w are linear in it, which the operators differentiate exactly.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.memory import load_twice
from fsipetsc.operators.rows import STRIDE
from fsipetsc.operators.vectors import fma
from fsipetsc.physics.layer import FLUID

#: lines of the grid: displacement in x, y, velocity, and derivatives along X of the first two, of the lower and the upper one
LINE_ROWS = 6
#: behind them what follows from these, by column: Ja1; of Ja2 and g1 what they are at the lower line and how much more at the
#: upper one; g2 by powers of zeta; D_xi g1; and for each distance k of two points Q Ja1, Q g1 between i and i + k
JA1, JA2_X, JA2_Y, G1, G2, DG1, OF_PAIRS = 12, 14, 16, 18, 20, 23, 25
PAIR_ROWS, DISTANCES = 4, 7
GRID_ROWS = OF_PAIRS + PAIR_ROWS * DISTANCES


class Metrics(NamedTuple):
    """Ja1, Ja2, g1, g2 at a point, and J_t = D_xi g1 + D_eta g2."""

    a1x: float
    a1y: float
    a2x: float
    a2y: float
    g1: float
    g2: float
    J_t: float


@njit(**FORMULA)
def metrics(s, lines, height, i):
    """Of the grid at the points i ..; lines: where its lines stand, height: zeta and what D_eta makes of its powers."""
    zeta, first, second = height
    more, most = line_of(s, lines, G2 + 1, i), line_of(s, lines, G2 + 2, i)
    return Metrics(
        line_of(s, lines, JA1, i),
        line_of(s, lines, JA1 + 1, i),
        between(s, lines, JA2_X, zeta, i),
        between(s, lines, JA2_Y, zeta, i),
        between(s, lines, G1, zeta, i),
        fma(zeta, fma(zeta, most, more), line_of(s, lines, G2, i)),
        between(s, lines, DG1, zeta, i) + fma(first, more, second * most),
    )


@njit(**FORMULA)
def line_of(s, lines, row, i):
    """What stands there."""
    return load_twice(s, lines + row * STRIDE + i)


@njit(**FORMULA)
def between(s, lines, row, zeta, i):
    """Of what is linear in zeta."""
    return fma(zeta, line_of(s, lines, row + 1, i), line_of(s, lines, row, i))


@njit(**FORMULA)
def constants(law, layer):
    """(those of the gas law, those of transport, mu, kappa, body force)."""
    return law.gas.constants(layer), law.transport.constants(layer), layer.mu, layer.kappa, layer.force[0], layer.force[1]


@njit(**FORMULA)
def primitive(law, c, q):
    """(1/J, 1/rho, rho, u, v, e, p, T) from J (1, rho, rho u, rho v, e)."""
    J, r, m, n, e = q
    per_both = 1.0 / (J * r)  # divisions take as long as twenty products
    per_J, per_r = r * per_both, J * per_both
    u, v, rho = m * per_r, n * per_r, r * per_J
    T = law.gas.temperature_in_loops(c[0], rho, e * per_r - 0.5 * fma(u, u, v * v))
    return per_J, J * per_r, rho, u, v, e * per_J, law.gas.pressure(c[0], rho, T), T


@njit(**FORMULA)
def prepare_inviscid(law, c, q):
    """(rho, u, v, e, p, J rho)."""
    _, _, rho, u, v, e, p, _ = primitive(law, c, q)
    return rho, u, v, e, p, q[1]


@njit(**FORMULA)
def prepare_viscous(law, c, q):
    """(rho, u, v, e, p, J rho, u/T, v/T, -1/T, T, 1/J)."""
    per_J, _, rho, u, v, e, p, T = primitive(law, c, q)
    w = -1.0 / T
    return rho, u, v, e, p, q[1], -1.0 * (u * w), -1.0 * (v * w), w, T, per_J


@njit(**FORMULA)
def convection(v, ax, ay, g):
    """Ja . (f, g) - g U of the inviscid flow in one direction."""
    rho, u, w, e, p = v
    through = fma(ax, u, ay * w)
    V = through - g
    mass = rho * V
    return mass, fma(mass, u, ax * p), fma(mass, w, ay * p), fma(e, V, p * through)


@njit(**FORMULA)
def inviscid_flux(law, c, v, m, along, across):
    """The fluxes in both directions."""
    state = v[0], v[1], v[2], v[3], v[4]
    return convection(state, m.a1x, m.a1y, m.g1), convection(state, m.a2x, m.a2y, m.g2), (m.J_t,)


@njit(**FORMULA)
def friction(law, c, point, m, along, across):
    """(tau_xx, tau_xy, tau_yy, u tau_xx + v tau_xy + kappa T_x, u tau_xy + v tau_yy + kappa T_y); point: (u, v, T, 1/J)."""
    u, w, T, per_J = point
    of_mu, of_kappa = law.transport.relative(c[1], T)
    scale = per_J * T
    w3x = fma(m.a1x, along[2], m.a2x * across[2])
    w3y = fma(m.a1y, along[2], m.a2y * across[2])
    ux = scale * fma(u, w3x, fma(m.a1x, along[0], m.a2x * across[0]))
    uy = scale * fma(u, w3y, fma(m.a1y, along[0], m.a2y * across[0]))
    vx = scale * fma(w, w3x, fma(m.a1x, along[1], m.a2x * across[1]))
    vy = scale * fma(w, w3y, fma(m.a1y, along[1], m.a2y * across[1]))
    mu, conduction = of_mu * c[2], of_kappa * c[3] * (scale * T)
    third = (2.0 / 3.0) * mu
    xx, yy, xy = third * (2.0 * ux - vy), third * (2.0 * vy - ux), mu * (uy + vx)
    return xx, xy, yy, fma(u, xx, fma(w, xy, conduction * w3x)), fma(u, xy, fma(w, yy, conduction * w3y))


@njit(**FORMULA)
def viscous_flux(law, c, v, m, along, across):
    """The fluxes in both directions."""
    xx, xy, yy, hx, hy = friction(law, c, (v[1], v[2], v[9], v[10]), m, along, across)
    state = v[0], v[1], v[2], v[3], v[4]
    a, b = convection(state, m.a1x, m.a1y, m.g1), convection(state, m.a2x, m.a2y, m.g2)
    return (
        (a[0], *less(m.a1x, m.a1y, a, xx, xy, yy, hx, hy)),
        (b[0], *less(m.a2x, m.a2y, b, xx, xy, yy, hx, hy)),
        (m.J_t,),
    )


@njit(**FORMULA)
def less(ax, ay, f, xx, xy, yy, hx, hy):
    """Fluxes of momentum and energy with friction and conduction."""
    return f[1] - fma(ax, xx, ay * xy), f[2] - fma(ax, xy, ay * yy), f[3] - fma(ax, hx, ay * hy)


@njit(**FORMULA)
def rate(law, c, v, divergence, extra, sums):
    """-(D_xi + D_eta) of the fluxes, and what a body force adds."""
    r, fx, fy = v[5], c[4], c[5]
    return (
        extra[0],
        -1.0 * divergence[0],
        fma(fx, r, -1.0 * divergence[1]),
        fma(fy, r, -1.0 * divergence[2]),
        fma(r, fma(fx, v[1], fy * v[2]), -1.0 * divergence[3]),
    )


def plane_gas(gas: Formulas, transport: Formulas, viscous: bool) -> Formulas:
    """The equations for a gas law and a transport law, as fsipetsc.scheme.plane.sweep takes them; viscous: or conducting."""
    return Formulas(
        kind=FLUID,
        gas=gas,
        transport=transport,
        unknowns=(0, 1, 2, 3, 4),
        prepared=tuple(range(11 if viscous else 6)),
        differentiated=(6, 7, 8) if viscous else (),
        fluxes=(0, 1, 2, 3),
        extras=(0,),
        sums=(),
        constants=constants,
        grid=metrics,
        prepare=prepare_viscous if viscous else prepare_inviscid,
        flux=viscous_flux if viscous else inviscid_flux,
        rate=rate,
    )
