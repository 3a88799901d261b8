"""Hyperelastic solid in two dimensions (plane strain), in Lagrangian coordinates.

    (x, y)_t     = (u, v),                          F = grad (x, y)
    m0 (u, v)_t  = Div P(F) + m0 b,                 P = dW/dF, a law: see ``log_solid``, ``neo_hookean``,
                 ``st_venant_kirchhoff``
    m0 alpha T_t = P : grad (u, v) + Div (kappa_e J C^-1 grad T),      C = F^T F, J = det F

The heat is ``COUPLED``, as the paper's (3.1c): what the stresses do becomes heat, and the sum of kinetic energy and m0
alpha T is conserved. ``ELASTIC`` leaves P : grad (u, v) out: W is an energy of its own, and kinetic energy, W and m0 alpha
T together are conserved. These are different solids. Derivatives are taken of the displacement, which is periodic where the
layer is.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.vectors import fma
from fsipetsc.physics.layer import SOLID


@njit(**FORMULA)
def constants(law, layer):
    """(those of the law, kappa_e, 1/m0, 1/(m0 alpha), body force, 1 if the heat is coupled, K)."""
    heating = 1.0 if layer.heat == 0 else 0.0
    per_m0 = 1.0 / layer.m0
    K, (x, y) = 2.0 * layer.mu_e + layer.lambda_e, (layer.force[0], layer.force[1])
    return law.elastic.constants(layer), layer.kappa_e, per_m0, per_m0 / layer.alpha, x, y, heating, K


@njit(**FORMULA)
def prepare(law, c, q):
    """Displacement, velocity and temperature: they are the unknowns."""
    return q


@njit(**FORMULA)
def no_grid(s, lines, height, i):
    """Lagrangian coordinates need no metrics."""
    return ()


@njit(**FORMULA)
def conduction(kappa_e, F, Tx, Ty):
    """kappa_e J C^-1 grad T, with C^-1 = adj(C) / J^2."""
    f11, f12, f21, f22 = F
    c11, c12, c22 = fma(f11, f11, f21 * f21), fma(f11, f12, f21 * f22), fma(f12, f12, f22 * f22)
    scale = kappa_e / (f11 * f22 - f12 * f21)
    return scale * (c22 * Tx - c12 * Ty), scale * (c11 * Ty - c12 * Tx)


@njit(**FORMULA)
def flux(law, c, v, m, along, across):
    """(P_11, P_21, heat) and (P_12, P_22, heat) in the two directions, and P : grad (u, v)."""
    F = along[0] + 1.0, across[0], along[1], across[1] + 1.0
    p11, p12, p21, p22 = law.elastic.stress(c[0], F)
    qx, qy = conduction(c[1], F, along[4], across[4])
    return (p11, p21, qx), (p12, p22, qy), (work(p11, p12, p21, p22, along, across),)


@njit(**FORMULA)
def work(p11, p12, p21, p22, along, across):
    """P : grad (u, v)."""
    return fma(p11, along[2], fma(p12, across[2], fma(p21, along[3], p22 * across[3])))


@njit(**FORMULA)
def rate(law, c, v, divergence, extra, sums):
    """Of (x, y, u, v, T)."""
    return (
        v[2],
        v[3],
        fma(divergence[0], c[2], c[4]),
        fma(divergence[1], c[2], c[5]),
        fma(c[6], extra[0], divergence[2]) * c[3],
    )


@njit(**FORMULA)
def cold_flux(law, c, v, m, along, across):
    """(P_11, P_21) and (P_12, P_22), and P : grad (u, v)."""
    p11, p12, p21, p22 = law.elastic.stress(c[0], (along[0] + 1.0, across[0], along[1], across[1] + 1.0))
    return (p11, p21), (p12, p22), (work(p11, p12, p21, p22, along, across),)


@njit(**FORMULA)
def cold_rate(law, c, v, divergence, extra, sums):
    """Of (x, y, u, v, T), of which the last one stays."""
    return v[2], v[3], fma(divergence[0], c[2], c[4]), fma(divergence[1], c[2], c[5]), 0.0 * v[4]


def plane_solid(elastic: Formulas, cold: bool = False) -> Formulas:
    """The equations for a law, as fsipetsc.scheme.plane.sweep takes them; cold: they leave T as it is, heat is neither made nor
    conducted.
    """
    if cold:
        warm = plane_solid(elastic)
        new = {"differentiated": (0, 1, 2, 3), "fluxes": (0, 1), "flux": cold_flux, "rate": cold_rate}
        return Formulas(**{**vars(warm), **new})
    return Formulas(
        kind=SOLID,
        elastic=elastic,
        unknowns=(0, 1, 2, 3, 4),
        prepared=(0, 1, 2, 3, 4),
        differentiated=(0, 1, 2, 3, 4),
        fluxes=(0, 1, 2),
        extras=(0,),
        sums=(),
        constants=constants,
        grid=no_grid,
        prepare=prepare,
        flux=flux,
        rate=rate,
    )
