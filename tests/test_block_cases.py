"""Cases of the block engine: the manufactured solution fulfils the equations as they are written
in physical coordinates.
"""

from __future__ import annotations

import numpy as np
import pytest

from fsipetsc.cases import manufactured

DIMENSIONS = (1, 2, 3)
LAWS = ("log", "neo-hookean", "svk", "linear")
#: step of the differences, and the weights of those of sixth order for a first derivative
STEP = 0.01
SLOPE = np.array([-1 / 60, 3 / 20, -3 / 4, 3 / 4, -3 / 20, 1 / 60]) / STEP
OFFSETS = np.array([-3, -2, -1, 1, 2, 3]) * STEP


def solution(d, law="neo-hookean"):
    """Viscous and conducting on both sides."""
    return manufactured.Solution(d, mu=0.3, kappa=0.2, kappa_e=0.4, law=law)


def points(d, low, high, n=7):
    """Random ones, d arrays."""
    rough = np.random.default_rng(d)
    return [rough.uniform(0.0, 1.0, n) for _ in range(d - 1)] + [rough.uniform(low, high, n)]


def slope(function, where, axis):
    """The derivative of a function of d coordinates and t, arrays (n,), by differences: (…, n)."""
    n = len(where[0])
    at = [np.tile(np.broadcast_to(w, n), (6, 1)) for w in where]
    at[axis] = at[axis] + OFFSETS[:, None]
    values = np.asarray(function(*(w.ravel() for w in at)))
    return np.einsum("s,...sn->...n", SLOPE, values.reshape(*values.shape[:-1], 6, n))


def place_in_gas(exact, X, t):
    """x of the gas's grid, whose interface is the solid's first row: x = X + eta D."""
    d = len(X)
    interface = [*X[:-1], np.ones_like(X[-1])]
    moved = np.array(exact.exact_solid(*interface, t)[d + 1 :]) - np.array(interface)
    return np.array(X) + X[-1] * moved


def label(exact, x, t):
    """X of the gas's grid at a place x, by Newton's method."""
    X = np.array(x, float)
    for _ in range(8):
        off = place_in_gas(exact, list(X), t) - x
        G = np.moveaxis(exact.grid((*X, t))[0], -1, 0)
        X = X - np.linalg.solve(G, off.T[..., None])[..., 0].T
    assert np.abs(off).max() < 1e-14
    return list(X)


def eulerian(exact):
    """(rho, u, T)(*x, t) in physical coordinates."""
    return lambda *where: np.array(exact.exact_gas(*label(exact, where[:-1], where[-1]), where[-1]))


def stress_of_gas(exact, fields, where):
    """(tau, kappa grad T) at a place in physical coordinates."""
    d = len(where) - 1
    gradients = np.array([slope(fields, where, k) for k in range(d)])
    grad_u = np.swapaxes(gradients[:, 1:-1], 0, 1)  # [i, j]: of u_i along x_j
    div = sum(grad_u[i, i] for i in range(d))
    one = np.eye(d)[..., None]
    tau = exact.mu * (grad_u + np.swapaxes(grad_u, 0, 1) - 2 / 3 * div * one)
    return tau, exact.kappa * gradients[:, -1]


@pytest.mark.parametrize("d", DIMENSIONS)
def test_gas_fulfils_navier_stokes_with_its_forcing(d):
    """In physical coordinates, where no grid moves: U_t + div F = forcing."""
    exact, t = solution(d), 0.4
    X = points(d, 0.1, 0.9, 3)
    where = [*place_in_gas(exact, X, t), t]
    fields = eulerian(exact)

    def conserved(*at):
        rho, *u, T = fields(*at)
        u = np.array(u)
        return np.array([rho, *(rho * u), rho * (exact.cv * T + 0.5 * (u**2).sum(0))])

    def flux(axis, *at):
        rho, *u, T = fields(*at)
        u, p = np.array(u), rho * exact.R * T
        tau, heat = stress_of_gas(exact, fields, at)
        U, along = conserved(*at), np.array([float(axis == i) for i in range(d)])[:, None]
        momentum = U[1:-1] * u[axis] + p * along - tau[axis]
        energy = (U[-1] + p) * u[axis] - (tau[axis] * u).sum(0) - heat[axis]
        return np.array([U[0] * u[axis], *momentum, energy])

    lack = slope(conserved, where, d)
    for axis in range(d):
        lack = lack + slope(lambda *at, axis=axis: flux(axis, *at), where, axis)
    forcing = np.array(exact.force_gas(*X, t))
    assert np.abs(forcing).max(axis=1).min() > 0.05
    assert np.abs(lack - forcing).max() < 2e-7 * np.abs(forcing).max()


def energy(law, mu, lam, F):
    """W(F) [J/m3] of the laws, F (n, d, d), with the strain 0 across the missing axes."""
    d = F.shape[-1]
    C = np.swapaxes(F, 1, 2) @ F
    trace, J = np.trace(C, axis1=1, axis2=2) - d, np.linalg.det(F)
    if law == "log":
        volume = (2 * mu + lam) * (J * np.log(J) - J + 1) - mu * (0.5 * (J * J - 1) - np.log(J))
        return 0.5 * mu * (trace - 2 * np.log(J)) + volume
    if law == "neo-hookean":
        return 0.5 * mu * (trace - 2 * np.log(J)) + 0.5 * lam * np.log(J) ** 2
    strain = 0.5 * (C - np.eye(d)) if law == "svk" else 0.5 * (F + np.swapaxes(F, 1, 2)) - np.eye(d)
    return 0.5 * lam * np.trace(strain, axis1=1, axis2=2) ** 2 + mu * (strain**2).sum((1, 2))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("d", DIMENSIONS)
def test_stress_is_the_derivative_of_the_energy(d, law):
    """And what a solid in fewer dimensions has is that of one held across the others."""
    rough = np.random.default_rng(d)
    F = np.eye(d) + 0.1 * rough.uniform(-1, 1, (6, d, d))
    P = np.moveaxis(manufactured.stress(law, 1.3, 0.7, np.moveaxis(F, 0, 2)), 2, 0)
    for i in range(d):
        for k in range(d):

            def stretched(step, i=i, k=k):
                G = np.tile(F, (6, 1, 1))
                G[:, i, k] += step
                return energy(law, 1.3, 0.7, G)

            assert np.abs(slope(stretched, [np.zeros(6)], 0) - P[:, i, k]).max() < 1e-9
    whole = np.tile(np.eye(3), (6, 1, 1))
    whole[:, :d, :d] = F
    assert np.allclose(energy(law, 1.3, 0.7, whole), energy(law, 1.3, 0.7, F), rtol=1e-10, atol=0)


@pytest.mark.parametrize("d", DIMENSIONS)
def test_solid_fulfils_its_equations_with_its_forcing(d):
    """m0 v_t = Div P, m0 alpha T_t = P : v_X + Div(kappa J F^-1 F^-T grad T), x_t = v."""
    exact, t = solution(d, "log"), 0.4
    where = [*points(d, 1.05, 1.95), t]

    def fields(*at):
        return np.array(exact.exact_solid(*at))

    def gradient(of, at):
        return np.stack([slope(of, at, k) for k in range(d)], axis=1)

    def inner(*at):
        """P and the conducted heat below it, [component, axis]; P : v_X."""
        fields_X = gradient(fields, at)
        F = fields_X[d + 1 :]
        P = manufactured.stress("log", exact.mu_e, exact.lambda_e, F)
        inverse = np.linalg.inv(np.moveaxis(F, 2, 0))
        spread = np.einsum("nki,nji,jn->kn", inverse, inverse, fields_X[d])
        heat = exact.kappa_e * np.linalg.det(np.moveaxis(F, 2, 0)) * spread
        return np.concatenate([P, heat[None]]), (P * fields_X[:d]).sum((0, 1))

    rates, work = slope(fields, where, d), inner(*where)[1]
    divergence = sum(slope(lambda *at, k=k: inner(*at)[0][:, k], where, k) for k in range(d))
    forcing = np.array(exact.force_solid(*where))
    most = np.abs(forcing).max()
    assert np.abs(rates[:d] - divergence[:d] / exact.m0 - forcing[:d]).max() < 2e-7 * most
    heating = (work + divergence[d]) / (exact.m0 * exact.alpha)
    assert np.abs(rates[d] - heating - forcing[d]).max() < 2e-7 * most
    assert np.abs(rates[d + 1 :] - fields(*where)[:d]).max() < 1e-9
    assert not forcing[d + 1 :].any() and np.abs(forcing[: d + 1]).max(axis=1).min() > 0.05


@pytest.mark.parametrize("d", DIMENSIONS)
def test_interface(d):
    """Velocity and temperature are one there; what is supplied is what tractions and heat lack."""
    exact, t = solution(d), 0.4
    X = [*points(d, 1.0, 1.0)[:-1], np.ones(7)]
    gas, solid = np.array(exact.exact_gas(*X, t)), np.array(exact.exact_solid(*X, t))
    assert np.abs(gas[1:] - solid[: d + 1]).max() < 1e-14

    def fields(*at):
        return np.array(exact.exact_solid(*at))

    fields_X = np.stack([slope(fields, [*X, t], k) for k in range(d)], axis=1)
    F = fields_X[d + 1 :]
    J, inverse = np.linalg.det(np.moveaxis(F, 2, 0)), np.linalg.inv(np.moveaxis(F, 2, 0))
    area = J * inverse[:, -1].T  # of the surface, per reference area, into the solid
    into_solid = -manufactured.stress(exact.law, exact.mu_e, exact.lambda_e, F)[:, -1]
    spread = np.einsum("ni,nji,jn->n", inverse[:, -1], inverse, fields_X[d])
    heat_of_solid = -exact.kappa_e * J * spread
    place = [*place_in_gas(exact, X, t), t]
    tau, heat = stress_of_gas(exact, eulerian(exact), place)
    p = gas[0] * exact.R * gas[-1]
    from_gas = p * area - np.einsum("ijn,jn->in", tau, area)
    heat_of_gas = -np.einsum("jn,jn->n", heat, area)
    found = np.array(exact.supplied(*X, t))
    assert np.abs(found[:-1] - (into_solid - from_gas)).max() < 2e-7
    assert np.abs(found[-1] - (heat_of_solid - heat_of_gas)).max() < 2e-7
    assert np.abs(found).max(axis=1).min() > 0.05


@pytest.mark.parametrize("d", DIMENSIONS)
def test_grids_do_not_fold(d):
    """Neither that of the gas nor the solid, for all t; the density and T stay above 0."""
    exact = solution(d)
    X = np.meshgrid(*[np.arange(12) / 12] * (d - 1), np.linspace(0, 1, 7))
    for t in np.linspace(0.0, 6.0, 25):
        gas, above = (*X, t), (*X[:-1], X[-1] + 1, t)
        F = exact.displacement.at(above).gradient
        assert manufactured.determinant(exact.grid(gas)[0]).min() > 0.4
        assert manufactured.determinant(F + manufactured.unit(F)).min() > 0.4
        rho, *_, T = exact.exact_gas(*X, t)
        assert rho.min() > 0.7 and T.min() > 0.7
