"""The paper's method, fsipetsc.paper, held against the program that it replaces: rates,
projections, integrals, bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.boundaries import Dirichlet, Open, absorbing, clamped, free
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import defaults
from fsipetsc.paper.state import make_paper_state
from fsipetsc.physics.own_laws import gas_law
from fsipetsc.physics.power_law import power_law
from fsipetsc.physics.stiffened_gas import stiffened_gas
from fsipetsc.physics.sutherland import sutherland
from fsipetsc.stepping.solve import make_layer_state

SOLID_ENDS = {
    "clamped": clamped(0.3, T=310.0),
    "free": free(-9e4, heat_flux=1e3),
    "absorbing": absorbing(-9e4),
}
GAS_ENDS = {
    "open": Open(1.5, 1e5, 300.0, 0.0),
    "open0": Open(1.5, 1e5, 300.0, 5.0, order=0),
    "inflow": Dirichlet(1.5, lambda t: (1.2, -30.0, 305.0), 3),
    "outflow": Dirichlet(1.5, lambda t: (1.1, 20.0, 295.0)),
    "supersonic": Dirichlet(1.5, lambda t: (1.2, -500.0, 300.0)),
}
_VISCOUS = {"fluid_mu": 0.5, "fluid_kappa": 0.7, "solid_kappa": 0.5}


def pair_of(name, ends=(None, None), laws=(None, None, None), **changed):
    """The old state and the new one, of the same problem."""
    case = load_case(name)
    opt = {**defaults(case), "fsi_h": 0.05, "fsi_entropy": True, **changed}
    problem = case.build(opt)
    left, right = (new or old for new, old in zip(ends, (problem.left, problem.right), strict=True))
    layers = []
    for layer in problem.layers:
        names = {"fluid": ("law", "transport"), "solid": ("pressing",)}[layer.kind]
        given = dict(zip(names, laws[:2] if layer.kind == "fluid" else laws[2:], strict=True))
        material = replace(layer.material, **{k: v for k, v in given.items() if v is not None})
        layers.append(replace(layer, material=material))
    problem = replace(problem, left=left, right=right, layers=tuple(layers))
    old = make_layer_state(problem, opt, MPI.COMM_SELF)
    return old, make_paper_state(problem, opt, MPI.COMM_SELF)


def disturbed(state, y, seed, noise):
    """A state of random numbers about y."""
    rng, y = np.random.default_rng(seed), y.copy()
    for k, layer in enumerate(state.problem.layers):
        part = state.layout.local(k, y)
        size = np.abs(part).max(axis=0)
        if layer.kind == "fluid":
            size[1] = part[:, 0].max() * float(
                layer.material.sound_speed(part[0, 2] / part[0, 0] / layer.material.cv)
            )
        else:
            size[0], size[3] = layer.material.sound_speed(), 0.1 * state.h
        part += noise * size * rng.uniform(-1, 1, part.shape)
    return y


def off(found, expected, scale=None):
    """Largest difference, relative to the largest number."""
    scale = np.abs(expected).max() if scale is None else scale
    return np.abs(found - expected).max() / max(scale, 1e-300)


def size_of(name, state):
    """What a difference in an integral is compared with: forces on two ends may cancel."""
    record = state.latest
    sizes = {
        "force": np.abs(record["sigma_interface"]).max(),
        "momentum": 1e-3 * abs(record["energy"]) ** 0.5,
    }
    return max(np.abs(record[name]).max(), sizes.get(name, 0.0))


def assert_alike(old, new, noise=0.02, rest=1e-12):
    """Completed initial states, their integrals, and rates at random states."""
    with old, new:
        t = 0.01
        for state in (old, new):
            state.set_initial()
            state.set_data(t)
        y = old.solution.getArray().copy()
        assert off(new.solution.getArray(), y) < rest
        assert off(new.results, old.results) < 1e-12
        for name in (
            "energy",
            "force",
            "entropy",
            "mass",
            "x_interface",
            "sigma_interface",
            "T_interface",
        ):
            if name in old.latest.dtype.names:
                found, expected = np.atleast_1d(new.latest[name]), np.atleast_1d(old.latest[name])
                assert off(found, expected, size_of(name, old)) < 1e-11, name
        for seed in range(2):
            stage = disturbed(old, y, seed, noise)
            kept, f, g = stage.copy(), np.full_like(stage, np.nan), np.full_like(stage, np.nan)
            old.right_hand_side(stage, f)
            new.right_hand_side(stage, g)
            assert np.array_equal(stage, kept), "the stage is PETSc's"
            for k, layer in enumerate(old.problem.layers):
                expected, found = old.layout.local(k, f), new.layout.local(k, g)
                assert np.abs(expected).max() > 0
                for c in range(expected.shape[1]):
                    assert off(found[:, c], expected[:, c]) < 1e-12, (layer.name, c)
            old.solution.getArray()[:] = stage
            new.solution.getArray()[:] = stage
            old.finish()
            new.finish()
            assert off(new.solution.getArray(), old.solution.getArray()) < 1e-12
            assert off(new.results, old.results) < 1e-12
            for name in ("energy", "momentum", "force", "entropy", "heating"):
                assert off(new.latest[name], old.latest[name], size_of(name, old)) < 1e-11, name
            assert [(r["lo"], r["hi"]) for r in new.layout.records] == [
                (r["lo"], r["hi"]) for r in old.layout.records
            ]


@pytest.mark.parametrize("order", (2, 4, 6, 8))
@pytest.mark.parametrize("viscous", ("wide", "narrow"))
@pytest.mark.parametrize("coupling", ("projection", "energy", "traditional"))
@pytest.mark.parametrize("name", ("rod", "mms"))
def test_rates_are_those_of_the_older_program(name, coupling, viscous, order):
    assert_alike(*pair_of(name, fsi_order=order, fsi_coupling=coupling, fsi_viscous=viscous))


@pytest.mark.parametrize("coupling", ("projection", "energy", "traditional"))
@pytest.mark.parametrize("conducting", ("both", "gas", "solid", "none"))
def test_without_heat_on_a_side(coupling, conducting):
    heat = {
        "fluid_kappa": 0.7 * (conducting in ("both", "gas")),
        "solid_kappa": 0.5 * (conducting in ("both", "solid")),
    }
    for order in (4, 8):
        changed = {
            **_VISCOUS,
            **heat,
            "solid_gruneisen": 0.3,
            "fsi_order": order,
            "fsi_coupling": coupling,
        }
        assert_alike(*pair_of("pulse", **changed))


@pytest.mark.parametrize("end", SOLID_ENDS)
@pytest.mark.parametrize("order", (2, 6))
def test_ends_of_solids(end, order):
    changed = {**_VISCOUS, "solid_gruneisen": 0.2, "fsi_order": order}
    assert_alike(*pair_of("pulse", ends=(SOLID_ENDS[end], None), **changed))


@pytest.mark.parametrize("end", GAS_ENDS)
@pytest.mark.parametrize("order", (2, 8))
def test_ends_of_gases(end, order):
    for changed in (_VISCOUS, {"pulse_amplitude": 100.0}):
        assert_alike(
            *pair_of("pulse", ends=(None, GAS_ENDS[end]), **changed, fsi_order=order), rest=1e-11
        )


def _noble_abel():
    """p = rho R T / (1 - 0.05 rho): a law by hand."""
    return gas_law(
        constants=lambda record: (record.R, record.cv),
        temperature=lambda c, rho, e: e / c[1],
        energy=lambda c, rho, T: c[1] * T,
        pressure=lambda c, rho, T: c[0] * rho * T / (1 - 0.05 * rho),
        density=lambda c, p, T: p / (c[0] * T + 0.05 * p),
        temperature_of_pressure=lambda c, rho, p: p * (1 - 0.05 * rho) / (c[0] * rho),
        heat_capacity=lambda c, rho, T: c[1] + 0.0 * T,
        pressure_by_temperature=lambda c, rho, T: c[0] * rho / (1 - 0.05 * rho),
        bulk_modulus=lambda c, rho, T: c[0] * rho * T / (1 - 0.05 * rho) ** 2,
        entropy=lambda c, rho, T: c[1] * np.log(T) - c[0] * np.log(rho / (1 - 0.05 * rho)),
    )


@pytest.mark.parametrize("coupling", ("projection", "energy"))
def test_other_laws(coupling):
    laws = _noble_abel(), power_law(300.0, 0.7, 0.9), stiffened_gas(2.0, 1e6, 300.0)
    assert_alike(*pair_of("pulse", laws=laws, **_VISCOUS, fsi_coupling=coupling))


def test_sutherland_and_a_body_force():
    old, new = pair_of(
        "rod", laws=(None, sutherland(273.0, 111.0, 194.0), None), fsi_viscous="narrow"
    )
    assert_alike(old, new)


def test_what_the_paper_has_not_is_refused():
    case = load_case("rod")
    opt = {**defaults(case), "fsi_h": 0.05}
    for changed, words in (
        ({"fsi_mapping": "stretched"}, "rigid frames"),
        ({"fsi_coupling": "conservative"}, "expected projection, energy, traditional"),
        ({"fsi_dissipation": 1.0}, "fsi_dissipation"),
        ({"fsi_h": 0.03}, "misses an interface"),
        ({"fsi_h": 0.5, "fsi_order": 8}, "needs at least"),
    ):
        with pytest.raises(InputError, match=words):
            make_paper_state(case.build(opt), {**opt, **changed}, MPI.COMM_SELF)
