"""What the oracle of blocks (block_oracle.py) is made of: materials, conditions, formulas at a
point, SBP matrices.

Fields are numpy arrays with their components in front."""

from collections import namedtuple
from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.operators.sbp import AXIS, OPERATORS

TINY = 1e-30  # step into the complex plane, for derivatives


class Gas(NamedTuple):
    """p + p_inf = rho R T, rho e = rho cv T + p_inf, mu T^powers[0], kappa T^powers[1]."""

    gamma: float = 1.4
    R: float = 1.0
    mu: float = 0.0
    kappa: float = 0.0
    p_inf: float = 0.0
    force: tuple = ()
    powers: tuple = (0.0, 0.0)
    kind = "gas"

    @property
    def cv(self):
        return self.R / (self.gamma - 1.0)


class Solid(NamedTuple):
    """law: "log", "neo-hookean", "svk", "linear"; heat: "coupled", "elastic"; gruneisen: G of a
    pressure G m0 alpha T / J."""

    law: str = "log"
    mu_e: float = 1.0
    lambda_e: float = 2.0
    m0: float = 2.0
    alpha: float = 1.5
    kappa: float = 0.0
    p_ref: float = 0.0
    heat: str = "coupled"
    force: tuple = ()
    gruneisen: float = 0.0
    kind = "solid"


class Block(NamedTuple):
    """X: (d, n_1, ..., n_d) reference places; periods: by axis None, or the vector X(1) - X(0).
    prestress: its d d components at places (d, ...)."""

    name: str
    material: Any
    X: np.ndarray
    periods: tuple = ()
    prestress: Any = None


# conditions, as those of fsipetsc.blocks.conditions; T: a number or T(X, t); motion: places (X, t)
NoSlip = namedtuple("NoSlip", "T heat_flux motion", defaults=(None, None, None))
Slip = namedtuple("Slip", "motion", defaults=(None,))
Open = namedtuple("Open", "rho u T")
Outflow = namedtuple("Outflow", "pressure")
Given = namedtuple("Given", "values motion", defaults=(None,))
Clamped = namedtuple("Clamped", "motion T heat_flux", defaults=(None, None, None))
Roller = namedtuple("Roller", "")
Free = namedtuple("Free", "pressure T heat_flux", defaults=(0.0, None, None))


class Problem(NamedTuple):
    """faces: conditions of faces that meet no other, a function of (block's name, axis, side).
    form: "entropy" or "divergence"; dissipation: sigma, over 4^q; shock: strength at shocks."""

    blocks: tuple
    faces: Callable
    order: int = 4
    form: str = "entropy"
    dissipation: float = 0.0
    shock: float = 0.0


#: of a gas, per volume
State = namedtuple("State", "rho u p T E")
#: gas . (of the gas) + solid . (of the solid) = value; powers: the work of its force on both, over
#: its multiplier
Row = namedtuple("Row", "gas solid gas_power solid_power value")
#: D; D without the flux through the ends; S_il = 2 (H D)_il without diagonal; diagonal of H
Axis = namedtuple("Axis", "D flux_free S weight")


# numbers and matrices


def rate_of(value, X, t):
    """The derivative in time of a number or of value(X, t)."""
    if not callable(value):
        return 0.0 * np.asarray(value)
    return np.imag(np.array(value(X, t + 1j * TINY), complex)) / TINY


def dot(a, b):
    return (a * b).sum(axis=0)


def spread(vector, d):
    """Components in front of d axes of length 1."""
    return np.reshape(vector, (-1, *[1] * d))


def along(matrix, f, k, d):
    """matrix times f along the logical axis k, one of the last d axes of f."""
    axis = f.ndim - d + k
    return np.moveaxis(np.tensordot(matrix, f, (1, axis)), 0, axis)


def axis_of(order, n, periodic, around):
    """Of n nodes of [0, 1]. around: r = 0 is in the middle, with weights of its own beside it."""
    op, h = OPERATORS[order], 1.0 / n if periodic else 1.0 / (n - 1)
    if periodic:
        weight, D, one = np.full(n, h), np.zeros((n, n)), np.eye(n)
        for k, c in enumerate(op.interior, start=1):
            D += float(c) / h * (np.roll(one, k, axis=1) - np.roll(one, -k, axis=1))
    else:
        weight, D = h * op.norm_weights(n), op.matrix(n).astype(float) / h
    S = 2.0 * weight[:, None] * D
    np.fill_diagonal(S, 0.0)
    for (i, l), w in AXIS.get(order, {}).items() if around else ():
        for a, b in ((n // 2 + i, n // 2 + l), (n // 2 - 1 - l, n // 2 - 1 - i)):
            S[a, b], S[b, a] = float(w), -float(w)
    ends = np.diag(S.sum(axis=1))
    return Axis(*(0.5 * (S + sign * ends) / weight[:, None] for sign in (-1.0, 1.0)), S, weight)


def gauss(rows, z, inverse_mass):
    """z' nearest to z in the norm of the masses that obeys the rows, which may say the same, and
    their multipliers: force = multiplier * row."""
    if not rows:
        return z, np.zeros(0)
    C = np.array([np.concatenate([r.gas, r.solid]) for r in rows]).reshape(-1, len(z))
    B = C * np.sqrt(inverse_mass)
    size = np.sqrt((B * B).sum(axis=1))
    B, gap = B / size[:, None], (C @ z - [r.value for r in rows]) / size
    multipliers = -np.linalg.pinv(B @ B.T, rcond=1e-10, hermitian=True) @ gap
    return z + np.sqrt(inverse_mass) * (B.T @ multipliers), multipliers / size


# gas


def gas_state(m, q):
    """From (J, J rho, J rho u, J E)."""
    rho, u, E = q[1] / q[0], q[2:-1] / q[1], q[-1] / q[0]
    T = ((E - m.p_inf) / rho - 0.5 * dot(u, u)) / m.cv
    return State(rho, u, rho * m.R * T - m.p_inf, T, E)


def conserved(m, rho, u, T):
    """(rho, rho u, E)."""
    return np.array([rho, *(rho * u), rho * (m.cv * T + 0.5 * dot(u, u)) + m.p_inf])


def entropy_of(m, s):
    return m.cv * np.log(s.T) - m.R * np.log(s.rho)


def flux(s, a, g):
    """a.f(U) - g U at a point."""
    V = dot(a, s.u)
    return np.array([s.rho * (V - g), *(s.rho * s.u * (V - g) + a * s.p), s.E * (V - g) + s.p * V])


def log_mean(a, b):
    """(a - b) / log(a/b), by a series near a = b (Ismail and Roe 2009)."""
    f2 = ((a - b) / (a + b)) ** 2
    near = f2 < 1e-3
    series = 1.0 + f2 / 3.0 + f2**2 / 5.0 + f2**3 / 7.0 + f2**4 / 9.0 + f2**5 / 11.0
    exact = np.log(np.where(near, 2.0, a / b)) / np.where(near, 1.0, 2.0 * (a - b) / (a + b))
    return 0.5 * (a + b) / np.where(near, series, exact)


def pair_flux(m, left, right, a, g):
    """Ranocha's flux (2018), {a}.f# - g U#; a: mean metrics, g: volume flux of the pair."""
    p, u = 0.5 * (left.p + right.p), 0.5 * (left.u + right.u)
    mass = log_mean(left.rho, right.rho) * (dot(a, u) - g)
    c = 0.5 * dot(left.u, right.u) + m.cv / log_mean(1.0 / left.T, 1.0 / right.T)
    work = 0.5 * ((left.p + m.p_inf) * dot(a, right.u) + (right.p + m.p_inf) * dot(a, left.u))
    return np.array([mass, *(mass * u + a * p), mass * c + work - g * m.p_inf])


# solid


def three(F):
    """F of d dimensions as one of three, without strain in the others."""
    G = np.zeros((3, 3, *F.shape[2:]), F.dtype)
    G[range(3), range(3)] = 1.0
    G[: len(F), : len(F)] = F
    return G


def cofactor(F):
    """cof F = J F^-T, for any d."""
    G, d = three(F), len(F)
    return np.array([np.cross(G[i - 2], G[i - 1], axis=0) for i in range(3)])[:d, :d]


def det(F):
    return dot(three(F)[0], cofactor(three(F))[0])


def elastic_energy(m, F, p_ref):
    """W of a solid's law; F: (3, 3, ...)."""
    J, mu, lam, one = det(F), m.mu_e, m.lambda_e, three(0.0 * F[:0, :0])
    E = 0.5 * (np.einsum("ki...,kj...->ij...", F, F) - one)
    if m.law == "log":
        K = 2.0 * mu + lam
        W = K * (J * np.log(J) - J + 1.0) + mu * (np.trace(E) - 0.5 * (J**2 - 1.0))
    elif m.law == "neo-hookean":
        W = 0.5 * lam * np.log(J) ** 2 + mu * (np.trace(E) - np.log(J))
    else:
        E = E if m.law == "svk" else 0.5 * (F + np.swapaxes(F, 0, 1)) - one
        W = 0.5 * lam * np.trace(E) ** 2 + mu * (E * E).sum(axis=(0, 1))
    return W - p_ref * (J - 1.0)


def stress_of(energy, F):
    """P = dW/dF of W = energy(F)."""
    P = np.zeros_like(F)
    for at in product(range(3), repeat=2):
        stepped = F.astype(complex)
        stepped[at] += 1j * TINY
        P[at] = np.imag(energy(stepped)) / TINY
    return P
