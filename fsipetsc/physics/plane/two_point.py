"""Compressible flow in two dimensions with convection in two-point form: entropy is conserved by it. Perfect gas.

What fsipetsc.physics.plane.gas has as D_k (Ja^k . (f, g) - g^k U) is here, at point i,

    2 sum_l D_il F(i, l),    F = {Ja} . (f, g)# - {g} U#,    {a} = (a_i + a_l)/2

    U#              = rho^ (1, {u}, {v}, c),    c = (u_i u_l + v_i v_l)/2 + cv T^
    {Ja} . (f, g)#  = rho^ V (1, {u}, {v}, c) + (0, {Ja_x} {p}, {Ja_y} {p}, (p_i V_l + p_l V_i)/2)
    V_i             = {Ja_x} u_i + {Ja_y} v_i,    V = {Ja_x} {u} + {Ja_y} {v}

with rho^ the logarithmic mean of rho, and 1/T^ that of 1/T: the flux of Ranocha, "Comparison of some entropy conservative
numerical fluxes for the Euler equations", J. Sci. Comput. 76 (2018), on a grid that moves as in Schnuecke et al., J. Sci.
Comput. 82:69 (2020).
F(i, l) = F(l, i) and h H D is antisymmetric but for the ends: each pair is evaluated once, and what one point gains the
other one loses. The terms l = i at the ends are boundary fluxes, which are left out. J itself has the whole derivative
D_k g^k. Friction and conduction are those of fsipetsc.physics.plane.gas.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.means import distance, mean_factors
from fsipetsc.operators.vectors import fma
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.gas import constants, friction, less, metrics


@njit(**FORMULA)
def taken_apart(law, c, q):
    """(rho, u, v, e, p, 1/rho, T, -1/T, 1/J, J rho); with one division, which takes as long as twenty products."""
    J, r, m, n, e = q
    heat = fma(-0.5, fma(m, m, n * n), e * r)  # r^2 cv T
    both = J * r
    per_all = 1.0 / (both * heat)
    per_both = heat * per_all
    per_J, per_r = r * per_both, J * per_both
    u, v, rho, T = m * per_r, n * per_r, r * per_J, heat * (per_r * per_r) * c[0][3]
    w = -1.0 * c[0][2] * (r * r) * (both * per_all)
    return rho, u, v, e * per_J, law.gas.pressure(c[0], rho, T), J * per_r, T, w, per_J, r


@njit(**FORMULA)
def prepare_inviscid(law, c, q):
    """(rho, u, v, e, p, 1/rho, T, -1/T, J rho)."""
    rho, u, v, e, p, per_rho, T, w, _, r = taken_apart(law, c, q)
    return rho, u, v, e, p, per_rho, T, w, r


@njit(**FORMULA)
def prepare_viscous(law, c, q):
    """The same, u/T, v/T, 1/J."""
    rho, u, v, e, p, per_rho, T, w, per_J, r = taken_apart(law, c, q)
    return rho, u, v, e, p, per_rho, T, w, r, -1.0 * (u * w), -1.0 * (v * w), per_J


@njit(**FORMULA)
def inviscid_flux(law, c, v, m, along, across):
    """J_t."""
    return (), (), (m.J_t,)


@njit(**FORMULA)
def viscous_flux(law, c, v, m, along, across):
    """The fluxes of momentum and energy, of friction and conduction, and J_t."""
    w1, w2, w3 = along[1], along[2], along[0]
    z1, z2, z3 = across[1], across[2], across[0]
    xx, xy, yy, hx, hy = friction(law, c, (v[1], v[2], v[6], v[11]), m, (w1, w2, w3), (z1, z2, z3))
    nothing = (0.0, 0.0, 0.0, 0.0)
    of_x, of_y = less(m.a1x, m.a1y, nothing, xx, xy, yy, hx, hy), less(m.a2x, m.a2y, nothing, xx, xy, yy, hx, hy)
    return of_x, of_y, (m.J_t,)


@njit(**FORMULA)
def flux_and_metrics(law, c, v, m, along, across):
    """``plain_flux``, and before J_t Ja1, -2 g1, Ja2, -g2, which fsipetsc.scheme.plane.dissipation takes."""
    of_x, of_y, extra = law.plain_flux(law, c, v, m, along, across)
    return of_x, of_y, (m.a1x, m.a1y, -2.0 * m.g1, m.a2x, m.a2y, -1.0 * m.g2, *extra)


@njit(**FORMULA)
def pair(law, c, here, there, m):
    """The fluxes of J (rho, rho u, rho v, e) between two points, times a number w.

    m = (w {Ja_x} / 2, w {Ja_y} / 2, -w {g}); here, there: (rho, u, v, p, 1/rho, T, -1/T).
    """
    rho, u, v, p, per_rho, T, w = here
    rho_l, u_l, v_l, p_l, per_rho_l, T_l, w_l = there
    ax, ay, g = m
    of_rho, of_T = mean_factors(distance(rho, per_rho, rho_l, per_rho_l), distance(T, -1.0 * w, T_l, -1.0 * w_l))
    V, V_l = fma(ax, u, ay * v), fma(ax, u_l, ay * v_l)
    half = (rho + rho_l) * (0.25 * of_rho) * (V + V_l + g)
    both = p + p_l
    energy = fma(u, u_l, fma(v, v_l, c[0][2] * (T + T_l) * of_T))
    return (
        half + half,
        fma(half, u + u_l, ax * both),
        fma(half, v + v_l, ay * both),
        fma(half, energy, fma(p, V_l, p_l * V)),
    )


@njit(**FORMULA)
def inviscid_rate(law, c, v, divergence, extra, sums):
    """Of J what the grid says, of the others what the pairs give and a body force."""
    r, fx, fy = v[8], c[4], c[5]
    return extra[-1], sums[0], fma(fx, r, sums[1]), fma(fy, r, sums[2]), fma(r, fma(fx, v[1], fy * v[2]), sums[3])


@njit(**FORMULA)
def viscous_rate(law, c, v, divergence, extra, sums):
    """The same less the divergence of friction and conduction."""
    J, mass, x, y, e = inviscid_rate(law, c, v, divergence, extra, sums)
    return J, mass, x - divergence[0], y - divergence[1], e - divergence[2]


def two_point_gas(gas: Formulas, transport: Formulas, viscous: bool) -> Formulas:
    """The equations as fsipetsc.scheme.plane.sweep takes them, for a perfect gas; viscous: or conducting."""
    return Formulas(
        kind=FLUID,
        gas=gas,
        transport=transport,
        unknowns=(0, 1, 2, 3, 4),
        prepared=tuple(range(12 if viscous else 9)),
        differentiated=(7, 9, 10) if viscous else (),
        fluxes=(0, 1, 2) if viscous else (),
        extras=(0,),
        paired=(0, 1, 2, 4, 5, 6, 7),
        sums=(0, 1, 2, 3),
        constants=constants,
        grid=metrics,
        prepare=prepare_viscous if viscous else prepare_inviscid,
        flux=viscous_flux if viscous else inviscid_flux,
        pair=pair,
        rate=viscous_rate if viscous else inviscid_rate,
    )
