"""The closed box on rigid grids: mass, energy and sigma - K ln x_X of particles stay, at the order of the scheme."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import compute

import fsipetsc
from fsipetsc.operators import operator

pytest.importorskip("petsc4py")

SPACINGS = (0.025, 0.0125)
#: of the total energy over t = 2 at h = 0.0125; measured 1.0e-6, 1.1e-7, 7.0e-8, 7.5e-8
LARGEST_DRIFT = {2: 5e-6, 4: 4e-7, 6: 2e-7, 8: 2e-7}
EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """box(order, h): the result."""
    folder = tmp_path_factory.mktemp("box")
    energy, paper = (f"-fsi_mapping rigid -fsi_coupling {coupling}" for coupling in ("energy", "projection"))
    options = {f"{q}_{h}": ("box", f"-fsi_order {q} -fsi_h {h} {energy}") for q in ORDERS for h in SPACINGS}
    options |= {f"{q}_projection": ("box", f"-fsi_order {q} -fsi_h 0.025 {paper}") for q in ORDERS}
    compute(1, folder, options)
    return lambda order, h: fsipetsc.open_run(folder / f"{order}_{h}.h5")


def drifts(run) -> tuple[float, np.ndarray]:
    """Largest relative changes of the total energy and of the two masses."""
    energy = run.series["energy"] / run.summary["initial_energy"] - 1
    mass = run.series["mass"] / np.array(run.summary["initial_mass"]) - 1
    return np.abs(energy).max(), np.abs(mass).max(axis=0)


def invariant(run) -> np.ndarray:
    """Change of sigma/K - ln x_X since the start, (frames, points), with the derivative of the scheme."""
    solid = run.layers[1]
    D = operator(run.options["fsi_order"]).matrix(len(solid.X), run.options["fsi_h"])
    value = solid["sigma"] / run.options["solid_modulus"] - np.log(solid.x @ D.T)
    return value - value[0]


@EVERY_ORDER
def test_energy_and_mass(box, order):
    fine, coarse = (drifts(box(order, h)) for h in sorted(SPACINGS))
    assert fine[0] < LARGEST_DRIFT[order]
    assert np.all(fine[1] < 4 * LARGEST_DRIFT[order])
    assert fine[0] < coarse[0] / 2 ** {2: 1.6, 4: 2.5, 6: 2.5, 8: 2.5}[order]  # measured 1.7, 3.4, 3.3, 3.2


def test_higher_orders_keep_more_energy(box):
    second, fourth, sixth = (drifts(box(order, 0.0125))[0] for order in (2, 4, 6))
    assert second > 5 * fourth > 6 * sixth


@EVERY_ORDER
def test_energy_is_better_than_projection(box, order):
    """In the temperatures at the interfaces and in the energy; measured 1.6, 4.8, 4.0, 3.5 times; 1.8, 1.1, 1.7, 1.9 times."""
    run, paper, reference = box(order, 0.025), box(order, "projection"), box(8, 0.0125)
    assert (run.options["fsi_coupling"], paper.options["fsi_coupling"]) == ("energy", "projection")
    t = np.linspace(0.05, 1.95, 39)

    def error(of) -> float:
        at = [[np.interp(t, r.series["t"], T) for T in r.series["T_interface"].T] for r in (of, reference)]
        return float(np.abs(np.subtract(*at)).max())

    assert error(paper) > {2: 1.3, 4: 3.0, 6: 2.0, 8: 2.0}[order] * error(run)
    assert drifts(paper)[0] > (1.0 if order == 4 else 1.3) * drifts(run)[0]


@EVERY_ORDER
def test_stress_belongs_to_the_strain(box, order):
    """Inside, only the time integration changes the invariant; at the two ends the interface does."""
    coarse, fine = (np.abs(invariant(box(order, h))).max(axis=0) for h in SPACINGS)
    assert fine[1:-1].max() < 1e-11
    assert fine[[0, -1]].max() < {2: 5e-4, 4: 6e-5, 6: 2e-5, 8: 1e-5}[order]
    least = {2: 1.1, 4: 1.8, 6: 2.2, 8: 2.9}[order]  # the closures are exact to the degrees 1, 2, 3, 4
    assert np.log2(coarse[[0, -1]].max() / fine[[0, -1]].max()) > least


@EVERY_ORDER
def test_initial_state_satisfies_all_conditions(box, order):
    """It is at rest near walls and interfaces: the first projection changes next to nothing."""
    run = box(order, 0.0125)
    left, solid, right = run.layers
    for layer, p, T in ((left, 2.2, 5.0), (right, 2.0, 4.0)):
        active = np.isfinite(layer["T"][0])
        np.testing.assert_allclose(layer["p"][0][active], p, rtol=1e-7)
        np.testing.assert_allclose(layer["T"][0][active], T, rtol=1e-7)
    assert np.abs(solid["u"][0]).max() < 1e-7
    for name in ("u", "stress", "T", "flux"):
        assert np.abs(run.series[f"residual_{name}"]).max() < 1e-12
