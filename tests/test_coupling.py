"""The interface treatments `energy`, which is the orthogonal projection, and `traditional`."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")

from helpers import compute, from_python
from test_projection import (
    ALL,
    CONDUCTION,
    CV,
    JUMP,
    MU,
    P0,
    R,
    derivative_weights,
    interface,
    primitive,
    scaled_residuals,
    traces,
    treated,
)

import fsipetsc
from fsipetsc.operators import OPERATORS
from fsipetsc.paper.coupling import multipliers

multipliers = from_python(multipliers)

BOTH = pytest.mark.parametrize("kind", ["energy", "traditional"])


apply = treated


@ALL
@BOTH
@pytest.mark.parametrize("conduction", CONDUCTION)
@pytest.mark.parametrize("jump", JUMP)
@pytest.mark.parametrize("mu", [MU, 0.0])
@pytest.mark.parametrize("gruneisen", [0.0, 0.4])
def test_the_conditions_hold_to_round_off(kind, order, normal, conduction, jump, mu, gruneisen):
    kappa, kappa_e = CONDUCTION[conduction]
    values = JUMP[jump] if conduction != "none" else (*JUMP[jump][:3], 0.0)
    face = interface(normal, values, mu=mu, kappa=kappa, kappa_e=kappa_e, gruneisen=gruneisen)
    imposed = [True, True, conduction == "both", conduction != "none"]
    for seed in range(3):
        fluid, solid = traces(order, normal, seed)
        assert np.all(scaled_residuals(face, order, fluid, solid)[:2] > 1e-4)
        left = scaled_residuals(face, order, *apply(kind, face, order, fluid, solid))
        assert np.all(left[imposed] < 4e-15), left


@ALL
@BOTH
@pytest.mark.parametrize("conduction", CONDUCTION)
def test_treating_twice_changes_nothing_more(kind, order, normal, conduction):
    kappa, kappa_e = CONDUCTION[conduction]
    face = interface(normal, (0.3, 2e3, 5.0, 0.0), kappa=kappa, kappa_e=kappa_e, gruneisen=0.4)
    once = apply(kind, face, order, *traces(order, normal))
    twice = apply(kind, face, order, *once)
    for first, second in zip(once, twice, strict=True):
        assert np.all(np.abs(second - first) <= 1e-12 * np.abs(first).max(axis=0))


@BOTH
@pytest.mark.parametrize("order", OPERATORS)
def test_both_orientations_are_mirror_images(kind, order):
    right = traces(order, 1.0)
    left = (right[0] * [1, -1, 1], right[1] * [-1, 1, 1, -1])
    fluid, solid = apply(kind, interface(1.0), order, *right)
    mirrored_fluid, mirrored_solid = apply(kind, interface(-1.0), order, *left)
    np.testing.assert_allclose(mirrored_fluid * [1, -1, 1], fluid, rtol=1e-12)
    np.testing.assert_allclose(mirrored_solid * [-1, 1, 1, -1], solid, rtol=1e-12)


@ALL
@pytest.mark.parametrize("conduction", CONDUCTION)
@pytest.mark.parametrize("mu", [MU, 0.0])
@pytest.mark.parametrize("gruneisen", [0.0, 0.4])
def test_energy_changes_at_a_right_angle_to_what_the_conditions_leave_free(order, normal, conduction, mu, gruneisen):
    """The change of q = (u_s, sigma, T_s; rho, u_f, T_f) in the norm of the symmetric variables, all rows at once.

    The change of rho_0 that counts is that of the linearised pressure, R T^ drho + R rho^ dT.
    """
    kappa, kappa_e = CONDUCTION[conduction]
    face = interface(normal, JUMP["jumps"], mu=mu, kappa=kappa, kappa_e=kappa_e, gruneisen=gruneisen)
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply("energy", face, order, fluid, solid)
    (rho, u, T), (new_rho, new_u, new_T) = primitive(face, fluid), primitive(face, new_fluid)
    d, n = derivative_weights(face, order), len(u)
    a = np.array([*map(float, OPERATORS[order].norm), 1.0])[:n]
    cv, rho_hat, T_hat = CV, rho[1], T[1]
    x_X = -d @ solid[:, 3]
    c = gruneisen * face[0].solid.m0 * face[0].solid.alpha / x_X
    modulus = (face[0].solid.K + c * solid[0, 2]) / x_X

    pressure = R * (new_rho[0] * new_T[0] - rho[0] * T[0])
    linear_rho = (pressure - R * rho_hat * (new_T[0] - T[0])) / (R * T_hat)
    first = np.array([new_solid[0, 0] - solid[0, 0], new_solid[0, 1] - solid[0, 1], linear_rho])
    change = np.concatenate([first, new_solid[:, 2] - solid[:, 2], new_u - u, new_T - T])
    heat_s, heat_f = face[0].solid.alpha * face[0].solid.m0 / T_hat, rho_hat * cv / T_hat
    weights = np.concatenate(
        [a[0] * np.array([face[0].solid.m0, 1 / modulus, R * T_hat / rho_hat]), a * heat_s, a * rho_hat, a * heat_f]
    )
    conditions = np.zeros((4, 3 + 3 * n))
    Ts, uf, Tf = 3, 3 + n, 3 + 2 * n  # where they begin
    conditions[0, [0, uf]] = 1.0, -1.0
    conditions[1, [1, 2, Ts, Tf]] = 1.0, R * T_hat, -c, R * rho_hat
    conditions[1, uf : uf + n] -= mu * d
    conditions[2, [Ts, Tf]] = 1.0, -1.0
    conditions[3, Ts:uf], conditions[3, Tf:] = -kappa_e / x_X * d, -kappa * d
    conditions = conditions[[True, True, conduction == "both", conduction != "none"]]
    # in variables scaled by the norm: the change has no part in the null space of the conditions
    root = np.sqrt(weights)
    scaled = conditions / root
    free = np.linalg.svd(scaled / np.linalg.norm(scaled, axis=1)[:, None])[2][len(scaled) :]
    assert np.linalg.norm(free @ (root * change)) < 1e-11 * np.linalg.norm(root * change)
    assert np.linalg.norm(root * change) > 1.0


@ALL
def test_energy_keeps_density_beyond_the_interface_and_positions(order, normal):
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply("energy", interface(normal, JUMP["jumps"]), order, fluid, solid)
    assert np.array_equal(new_fluid[1:, 0], fluid[1:, 0])
    assert np.array_equal(new_solid[:, 3], solid[:, 3])
    assert np.array_equal(new_solid[1:, :2], solid[1:, :2])


@ALL
@pytest.mark.parametrize("gruneisen", [0.0, 0.4])
def test_energy_without_viscosity_and_conduction(order, normal, gruneisen):
    """The velocities weighted with the masses as in (4.17); the stress with the adiabatic moduli of both sides."""
    face = interface(normal, mu=0.0, kappa=0.0, kappa_e=0.0, gruneisen=gruneisen)
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply("energy", face, order, fluid, solid)
    (rho, u, T), (new_rho, new_u, new_T) = primitive(face, fluid), primitive(face, new_fluid)
    m0, rho_hat = face[0].solid.m0, rho[1]
    mean = (m0 * solid[0, 0] + rho_hat * u[0]) / (m0 + rho_hat)
    np.testing.assert_allclose([new_solid[0, 0], new_u[0]], mean, rtol=1e-12)
    x_X = -derivative_weights(face, order) @ solid[:, 3]
    c = gruneisen * m0 * face[0].solid.alpha / x_X
    of_gas = 1.4 * R * rho_hat * T[1]
    of_solid = (face[0].solid.K + c * solid[0, 2]) / x_X + c * c * T[1] / (face[0].solid.alpha * m0)
    loads = solid[0, 1] - c * solid[0, 2], -R * rho[0] * T[0]
    traction = (of_gas * loads[0] + of_solid * loads[1]) / (of_gas + of_solid)
    np.testing.assert_allclose(new_solid[0, 1] - c * new_solid[0, 2], traction, rtol=1e-12)
    np.testing.assert_allclose(-R * new_rho[0] * new_T[0], traction, rtol=1e-12)


@ALL
def test_traditional_takes_velocity_from_the_solid_and_load_from_the_fluid(order, normal):
    face = interface(normal, gruneisen=0.4)
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply("traditional", face, order, fluid, solid)
    _, new_u, new_T = primitive(face, new_fluid)
    assert new_solid[0, 0] == solid[0, 0]
    np.testing.assert_allclose(new_u[0], solid[0, 0], rtol=1e-14)
    assert new_fluid[0, 0] == fluid[0, 0]
    x_X = -derivative_weights(face, order) @ solid[:, 3]
    load = -R * fluid[0, 0] * new_T[0] + MU * (derivative_weights(face, order) @ new_u)
    p_solid = 0.4 * face[0].solid.m0 * face[0].solid.alpha * new_solid[0, 2] / x_X
    np.testing.assert_allclose(new_solid[0, 1], load + p_solid, rtol=1e-13, atol=1e-10 * P0)
    assert np.array_equal(new_solid[1:], solid[1:])
    assert np.array_equal(new_fluid[1:], fluid[1:])


def test_multipliers_solve_their_system():
    rng = np.random.default_rng(0)
    for _ in range(20):
        rows = rng.normal(size=(4, 9)) * 10.0 ** rng.uniform(-6, 6, (4, 1))  # conditions in any units
        S = rows @ rows.T
        S[0, 2:] = S[2:, 0] = 0.0
        S[0, 0] *= 4.0  # stays positive definite
        r = rows @ rng.normal(size=9)
        found = multipliers(S[0, 0], S[0, 1], *S[1, 1:], *S[2, 2:], S[3, 3], *r)
        size = np.sqrt(np.diag(S))
        np.testing.assert_allclose(found * size, np.linalg.solve(S / np.outer(size, size), r / size), rtol=1e-8)


# whole runs

_MMS = "-fsi_h {h} -fsi_order {order} -ts_max_time 0.2 -fsi_output_dt 1 -fsi_coupling {kind}"
_ROD = "-fsi_h {h} -ts_max_time 0.1 -fsi_output_dt 1 -fsi_coupling {kind}"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """name -> result of the short runs of this module, all made at once."""
    pytest.importorskip("petsc4py")
    kinds = ("projection", "energy")
    listed = {
        f"mms {kind} {order} {h}": ("mms", _MMS.format(h=h, order=order, kind=kind))
        for kind in kinds
        for order, h in ((2, 0.05), (4, 0.05), (6, 0.05), (8, 0.05), (4, 0.025))
    }
    listed |= {f"rod {kind} {h}": ("rod", _ROD.format(h=h, kind=kind)) for kind in kinds for h in (0.05, 0.025)}
    listed = {name.replace(" ", "_"): spec for name, spec in listed.items()}
    files = compute(1, tmp_path_factory.mktemp("coupling"), listed)
    return {name: fsipetsc.open_run(path) for name, path in files.items()}


@pytest.mark.mpi
@pytest.mark.parametrize(("order", "h"), [(2, 0.05), (4, 0.05), (6, 0.05), (8, 0.05), (4, 0.025)])
def test_mms_has_the_same_errors_and_steps_with_energy(runs, order, h):
    a, b = (runs[f"mms_{kind}_{order}_{h}"] for kind in ("projection", "energy"))
    assert abs(len(a.series["t"]) - len(b.series["t"])) <= 1
    for layer in ("fluid", "solid"):
        total = [np.sqrt(sum(e**2 for e in run.errors[layer].values())) for run in (a, b)]
        assert total[1] < 1.3 * total[0]
        assert total[0] < 1.3 * total[1]


@pytest.mark.mpi
def test_mms_with_energy_converges(runs):
    coarse, fine = (runs[f"mms_energy_4_{h}"].errors["solid"]["u"] for h in (0.05, 0.025))
    assert coarse > 2**2.5 * fine


@pytest.mark.mpi
def test_rod_moves_alike_with_energy_up_to_the_error_of_the_grid(runs):
    def end(kind: str, h: float) -> np.ndarray:
        return runs[f"rod_{kind}_{h}"].series["x_interface"][-1]

    steps = [len(runs[f"rod_{kind}_0.025"].series["t"]) for kind in ("projection", "energy")]
    assert abs(steps[0] - steps[1]) <= 1
    of_grid = max(np.abs(end(kind, 0.05) - end(kind, 0.025)).max() for kind in ("projection", "energy"))
    coarse, fine = (np.abs(end("energy", h) - end("projection", h)).max() for h in (0.05, 0.025))
    assert coarse < 2 * of_grid
    assert fine < 0.6 * coarse


@pytest.mark.mpi
def test_energy_is_the_same_bit_for_bit_on_four_ranks(tmp_path):
    """It changes temperatures on whole closure rows, which may lie on other ranks than the interface."""
    pytest.importorskip("petsc4py")
    options = "-fsi_h 0.02 -ts_max_time 0.02 -fsi_output_dt 1 -fsi_coupling energy"
    listed = {f"order{q}": ("mms", f"{options} -fsi_order {q}") for q in (2, 8)}
    one, many = (compute(k, tmp_path / str(k), listed) for k in (1, 4))
    for name in listed:
        a, b = fsipetsc.open_run(one[name]), fsipetsc.open_run(many[name])
        assert np.array_equal(a.series["x_interface"], b.series["x_interface"])
        for i in range(3):
            for field in a.layers[i].fields:
                assert np.array_equal(a.layers[i][field], b.layers[i][field], equal_nan=True), (name, i, field)
