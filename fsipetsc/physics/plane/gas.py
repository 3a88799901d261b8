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
from fsipetsc.operators.vectors import fma, load
from fsipetsc.physics.layer import FLUID

#: lines of the grid: displacement in x, y, velocity, and derivatives along X of the first two, of the lower and the upper one
LINE_ROWS = 6


class Metrics(NamedTuple):
    """Ja1, Ja2, w at a point."""

    a1x: float
    a1y: float
    a2x: float
    a2y: float
    wx: float
    wy: float


@njit(**FORMULA)
def metrics(s, lines, stride, per_length, i, zeta):
    """Of the grid at the points i ..; lines: where its lines stand, per_length: 1 over the distance of the two in Y."""
    low, high = lines + i, lines + LINE_ROWS * stride + i
    dx, y, u, v = load(s, low), load(s, low + stride), load(s, low + 2 * stride), load(s, low + 3 * stride)
    x_xi, y_xi = load(s, low + 4 * stride), load(s, low + 5 * stride)
    return Metrics(
        (load(s, high + stride) - y) * per_length,
        (dx - load(s, high)) * per_length,
        -1.0 * fma(zeta, load(s, high + 5 * stride) - y_xi, y_xi),
        fma(zeta, load(s, high + 4 * stride) - x_xi, x_xi) + 1.0,
        fma(zeta, load(s, high + 2 * stride) - u, u),
        fma(zeta, load(s, high + 3 * stride) - v, v),
    )


@njit(**FORMULA)
def constants(law, layer):
    """(those of the gas law, those of transport, mu, kappa, body force)."""
    return law.gas.constants(layer), law.transport.constants(layer), layer.mu, layer.kappa, layer.force[0], layer.force[1]


@njit(**FORMULA)
def primitive(law, c, q):
    """(1/J, 1/rho, rho, u, v, e, p, T) from J (1, rho, rho u, rho v, e)."""
    J, r, m, n, e = q
    per_J, per_r = 1.0 / J, 1.0 / r
    u, v, rho = m * per_r, n * per_r, r * per_J
    T = law.gas.temperature_in_loops(c[0], rho, e * per_r - 0.5 * fma(u, u, v * v))
    return per_J, J * per_r, rho, u, v, e * per_J, law.gas.pressure(c[0], rho, T), T


@njit(**FORMULA)
def prepare_inviscid(law, c, q):
    """(rho, u, v, e, p)."""
    _, _, rho, u, v, e, p, _ = primitive(law, c, q)
    return rho, u, v, e, p


@njit(**FORMULA)
def prepare_viscous(law, c, q):
    """(rho, u, v, e, p, u/T, v/T, -1/T, T, 1/J)."""
    per_J, _, rho, u, v, e, p, T = primitive(law, c, q)
    w = -1.0 / T
    return rho, u, v, e, p, -1.0 * (u * w), -1.0 * (v * w), w, T, per_J


@njit(**FORMULA)
def convection(v, m, ax, ay):
    """Ja . (f, g) - Ja . w U of the inviscid flow in one direction, that of J first."""
    rho, u, w, e, p = v
    V = fma(ax, u - m.wx, ay * (w - m.wy))
    mass = rho * V
    return (
        -1.0 * fma(ax, m.wx, ay * m.wy),
        mass,
        fma(mass, u, ax * p),
        fma(mass, w, ay * p),
        fma(e, V, p * fma(ax, u, ay * w)),
    )


@njit(**FORMULA)
def inviscid_flux(law, c, v, m, along, across):
    """The fluxes in both directions."""
    return convection(v, m, m.a1x, m.a1y), convection(v, m, m.a2x, m.a2y), ()


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
    xx, xy, yy, hx, hy = friction(law, c, (v[1], v[2], v[8], v[9]), m, along, across)
    state = v[0], v[1], v[2], v[3], v[4]
    a, b = convection(state, m, m.a1x, m.a1y), convection(state, m, m.a2x, m.a2y)
    return (
        (a[0], a[1], *less(m.a1x, m.a1y, a, xx, xy, yy, hx, hy)),
        (b[0], b[1], *less(m.a2x, m.a2y, b, xx, xy, yy, hx, hy)),
        (),
    )


@njit(**FORMULA)
def less(ax, ay, f, xx, xy, yy, hx, hy):
    """Fluxes of momentum and energy with friction and conduction."""
    return f[2] - fma(ax, xx, ay * xy), f[3] - fma(ax, xy, ay * yy), f[4] - fma(ax, hx, ay * hy)


@njit(**FORMULA)
def rate(law, c, q, v, divergence, extra, sums):
    """-(D_xi + D_eta) of the fluxes, and what a body force adds."""
    r, fx, fy = q[1], c[4], c[5]
    pull = fma(fx, q[2], fy * q[3])
    return (
        -1.0 * divergence[0],
        -1.0 * divergence[1],
        fma(fx, r, -1.0 * divergence[2]),
        fma(fy, r, -1.0 * divergence[3]),
        pull - divergence[4],
    )


def plane_gas(gas: Formulas, transport: Formulas, viscous: bool) -> Formulas:
    """The equations for a gas law and a transport law, as fsipetsc.scheme.plane.sweep takes them; viscous: or conducting."""
    return Formulas(
        kind=FLUID,
        gas=gas,
        transport=transport,
        unknowns=(0, 1, 2, 3, 4),
        prepared=(0, 1, 2, 3, 4, 5, 6, 7, 8, 9) if viscous else (0, 1, 2, 3, 4),
        differentiated=(5, 6, 7) if viscous else (),
        fluxes=(0, 1, 2, 3, 4),
        loose=(0, 1, 1, 1, 1),
        extras=(),
        sums=(),
        constants=constants,
        grid=metrics,
        prepare=prepare_viscous if viscous else prepare_inviscid,
        flux=viscous_flux if viscous else inviscid_flux,
        rate=rate,
    )
