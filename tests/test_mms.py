"""The manufactured solution of Sec. 5.1: errors no larger and rates no lower than those of the reference prototype."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS

pytest.importorskip("petsc4py")

#: SCHEME, section 5: combined errors (fluid, solid) at t = 0.45 for h = 0.0125 and 0.00625
REFERENCE = {
    2: {0.0125: (5.0e-4, 3.9e-4), 0.00625: (1.15e-4, 9.3e-5)},
    4: {0.0125: (1.1e-5, 2.9e-5), 0.00625: (1.1e-6, 4.4e-6)},
    6: {0.0125: (3.7e-7, 5.6e-7), 0.00625: (1.8e-8, 2.8e-8)},
    8: {0.0125: (3.2e-7, 4.7e-7), 0.00625: (5.9e-9, 2.0e-8)},
}
LEAST_RATE = {2: 1.9, 4: 2.6, 6: 4.2, 8: 4.5}
SPACINGS = (0.0125, 0.00625)

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)


def combined(run) -> np.ndarray:
    return np.array([run.errors["fluid"]["combined"], run.errors["solid"]["combined"]])


@EVERY_ORDER
@pytest.mark.parametrize("h", SPACINGS)
def test_errors(computed, order, h):
    run = computed("mms", f"order{order}_h{h}")
    assert run.time[-1] == 0.45
    assert np.all(combined(run) <= 1.3 * np.array(REFERENCE[order][h]))


@EVERY_ORDER
def test_rates(computed, order):
    coarse, fine = (combined(computed("mms", f"order{order}_h{h}")) for h in SPACINGS)
    assert np.all(np.log2(coarse / fine) >= LEAST_RATE[order])


@EVERY_ORDER
def test_interface_conditions_hold_with_their_jumps(computed, order):
    run = computed("mms", f"order{order}_h0.0125")
    for name in ("u", "stress", "T", "flux"):
        assert np.abs(run.series[f"residual_{name}"]).max() < 2e-13


def test_errors_are_what_the_frames_say(computed):
    """The L2 errors in the file against the exact solution evaluated here."""
    from fsipetsc.cases import load_case
    from fsipetsc.options import defaults

    case, run = load_case("mms"), computed("mms", "order4_h0.0125")
    problem = case.build({**defaults(case), **run.options})
    sums = {"fluid": np.zeros(3), "solid": np.zeros(4)}
    for layer, saved in zip(problem.layers, run.layers, strict=True):
        names = ("rho", "u", "T") if layer.kind == "fluid" else ("u", "sigma", "T", "x")
        active = np.flatnonzero(np.isfinite(saved["u"][-1]))
        if saved.name == "left":
            active = active[1:]  # the ghost point does not count
        elif saved.name == "right":
            active = active[:-1]
        exact = layer.exact(saved.X[active], 0.45)
        sums[layer.kind] += [saved.h * np.sum((saved[n][-1][active] - e) ** 2) for n, e in zip(names, exact, strict=True)]
    for kind, squares in sums.items():
        listed = list(run.errors[kind].values())
        np.testing.assert_allclose([*np.sqrt(squares), np.sqrt(squares.sum())], listed, rtol=1e-10)


def test_forcing_balances_the_exact_solution():
    """Forcing and jumps of the case against differences of its exact solution, in all three layers."""
    from fsipetsc.cases import load_case
    from fsipetsc.options import defaults

    case = load_case("mms")
    options = {**defaults(case), "fsi_h": 0.01}
    problem = case.build(options)
    t, d = 0.3, 1e-4
    for k, layer in enumerate(problem.layers):
        X = np.linspace(layer.X[0], layer.X[1], 7)

        def slope(values, X=X):
            """Sixth-order difference in X of a function of X."""
            weights = {1: 45, 2: -9, 3: 1}
            return sum(c * (values(X + j * d) - values(X - j * d)) for j, c in weights.items()) / (60 * d)

        def rate(values):
            weights = {1: 45, 2: -9, 3: 1}
            return sum(c * (values(t + j * d) - values(t - j * d)) for j, c in weights.items()) / (60 * d)

        if layer.kind == "fluid":
            gas, X_I = layer.material, (1.0, None, 2.0)[k]
            s = layer.exact(np.array([X_I]), t)[1][0]
            mu = 4 / 3 * gas.mu

            def conserved(X, t, layer=layer, gas=gas):
                rho, u, T = layer.exact(X, t)
                return np.stack([rho, rho * u, rho * (gas.cv * T + u * u / 2)])

            def flux(X, layer=layer, gas=gas, s=s, mu=mu):
                rho, u, T = layer.exact(X, t)
                p = gas.R * rho * T
                e = rho * (gas.cv * T + u * u / 2)
                u_X, T_X = (slope(lambda Y, c=c: layer.exact(Y, t)[c], X) for c in (1, 2))
                stress = p - mu * u_X
                return np.stack([rho * (u - s), rho * u * (u - s) + stress, e * (u - s) + u * stress - gas.kappa * T_X])

            left = rate(lambda t, X=X: conserved(X, t)) + slope(lambda Y: flux(Y))
        else:
            solid = layer.material
            u, sigma, _, _ = layer.exact(X, t)

            def conduction(X, layer=layer, solid=solid):
                T_X, x_X = (slope(lambda Y, c=c: layer.exact(Y, t)[c], X) for c in (2, 3))
                return solid.kappa_e / x_X * T_X

            u_X, sigma_X, _, x_X = (slope(lambda Y, c=c, layer=layer: layer.exact(Y, t)[c]) for c in range(4))
            u_t, sigma_t, T_t, x_t = (rate(lambda t, c=c, X=X, layer=layer: layer.exact(X, t)[c]) for c in range(4))
            heat = (sigma * u_X + slope(conduction)) / (solid.alpha * solid.m0)
            left = np.stack([u_t - sigma_X / solid.m0, sigma_t - solid.K / x_X * u_X, T_t - heat, x_t - u])
        np.testing.assert_allclose(np.stack(layer.forcing(X, t)), left, rtol=1e-6, atol=1e-6)
