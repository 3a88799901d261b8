"""Dissipation in two dimensions: undivided differences, in each direction k along its line of points. Point formulas.

    (J U)_t  -=  H^-1 Delta_q^T  s lambda U_w  Delta_q w,    lambda = |Ja^k . u - g^k| + c |Ja^k|

in a gas, w its four entropy variables ((h - |u|^2/2)/T - S, u/T, v/T, -1/T), h = e + p/rho, U_w = dU/dw at the mean rho,
u/T and 1/T of the points in the middle. For a perfect gas, with H = e + |u|^2/2,

    drho       = rho/R (dw1 + u dw2 + v dw3 + H dw4),     rho du = rho T (dw2 + u dw4),  rho dv likewise,
    rho cv dT  = rho cv T^2 dw4,                          d(rho H) = H drho + u rho du + v rho dv + rho cv dT,

a sum of squares: the entropy of the gas grows by the sum of s lambda (Delta_q w) U_w (Delta_q w). In a solid, of both
components of the velocity, Z = sqrt(K m0),

    m0 u_t        -=  H^-1 Delta_q^T  s Z  Delta_q u
    alpha m0 T_t  +=  H^-1 M_q^T      s Z |Delta_q u|^2

what the motion loses goes into heat at the points in the middle. With q half the order, s = sigma/4^q damps what the grid
does not resolve; with q = 1 and s = S/2 alpha, alpha from 0 to 1 where rho and p jump between two points of a gas, it is that
of shocks.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.vectors import fma, magnitude, maximum, minimum, root
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.solid import rate
from fsipetsc.physics.plane.two_point import flux_and_metrics, prepare_viscous

#: relative jumps (a - b)/(a + b) between two points up to which there is no shock, and from which on there is nothing else
NO_SHOCK, SHOCK = 0.05, 0.15
#: what goes to the points by the weights of the difference, and what to those in its middle
DIFFERENCE, MIDDLE = 0, 1


@njit(**FORMULA)
def prepare(law, c, q):
    """What ``two_point.prepare_viscous`` has, and w1."""
    found = prepare_viscous(law, c, q)
    rho, u, v, T, w2, w3, gas = found[0], found[1], found[2], found[6], found[9], found[10], c[0]
    w1 = gas[2] + gas[0] - law.gas.entropy(gas, rho, T) - 0.5 * fma(u, w2, v * w3)
    return (*found, w1)


@njit(**FORMULA)
def of_gas(law, c, mean, differences, m, strength):
    """s lambda U_w Delta w; mean: (rho, u/T, v/T, -1/T), m: (Ja_x, Ja_y, -g)."""
    R, gamma, cv = c[0][0], c[0][1], c[0][2]
    rho, w2, w3, w4 = mean
    d1, d2, d3, d4 = differences
    T = -1.0 / w4
    u, v = w2 * T, w3 * T
    normal = fma(m[0], u, fma(m[1], v, m[2]))
    speed = strength * (magnitude(normal) + root(gamma * R * T * fma(m[0], m[0], m[1] * m[1])))
    energy = fma(0.5, fma(u, u, v * v), cv * T)
    mass = speed * rho / R * fma(energy, d4, fma(v, d3, fma(u, d2, d1)))
    x, y = speed * rho * T * fma(u, d4, d2), speed * rho * T * fma(v, d4, d3)
    heat = speed * rho * cv * (T * T) * d4
    return mass, fma(u, mass, x), fma(v, mass, y), fma(energy, mass, fma(u, x, fma(v, y, heat)))


@njit(**FORMULA)
def jump_of_gas(here, there):
    """alpha; of (rho, p) at two points."""
    rho = magnitude(here[0] - there[0]) / (here[0] + there[0])
    p = magnitude(here[1] - there[1]) / (here[1] + there[1])
    return minimum(maximum((maximum(rho, p) - NO_SHOCK) * (1.0 / (SHOCK - NO_SHOCK)), 0.0), 1.0)


@njit(**FORMULA)
def of_solid(law, c, mean, differences, m, strength):
    """(s Z Delta u, s Z Delta v) / m0, and what is lost, over alpha m0."""
    u, v = differences
    rate = strength * root(c[7] * c[2])
    return rate * u, rate * v, -1.0 * rate * c[3] / c[2] * fma(u, u, v * v)


@njit(**FORMULA)
def no_jump(here, there):
    """Of a solid: shocks in it are not looked for."""
    return 0.0


def dissipative(equations: Formulas) -> Formulas:
    """Equations of ``two_point_gas`` or ``plane_solid`` with these terms, as fsipetsc.scheme.plane.dissipation takes them."""
    if equations.kind == FLUID:
        new = {
            "prepared": tuple(range(13)),
            "prepare": prepare,
            "flux": flux_and_metrics,
            "plain_flux": equations.flux,
            "extras": (0, 1, 2, 3, 4, 5, 6),
            "differenced": (12, 9, 10, 7),
            "averaged": (0, 9, 10, 7),
            "watched": (0, 4),
            "gather": (DIFFERENCE,) * 4,
            "dissipation": of_gas,
            "jump": jump_of_gas,
        }
    else:
        new = {
            "rate": solid_rate,
            "sums": (0, 1, 2),
            "differenced": (2, 3),
            "averaged": (),
            "watched": (),
            "gather": (DIFFERENCE, DIFFERENCE, MIDDLE),
            "dissipation": of_solid,
            "jump": no_jump,
        }
    return Formulas(**{**vars(equations), **new})


@njit(**FORMULA)
def solid_rate(law, c, v, divergence, extra, sums):
    """With what is lost and won."""
    x, y, u, w, T = rate(law, c, v, divergence, extra, sums)
    return x, y, u + sums[0], w + sums[1], T + sums[2]
