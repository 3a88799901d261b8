"""Laws of materials that case files bring: they are used everywhere, and blamed."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, compute, from_python, solve

pytest.importorskip("numba")
pytest.importorskip("petsc4py")


import fsipetsc
from fsipetsc.boundaries import Wall
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.physics.own_laws import check, gas_law, pressure_law, transport_law
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.materials.line_solid import Solid
from fsipetsc.problem import FluidLayer, Problem

SUTHERLAND, OWN_GAS = REPOSITORY / "runs" / "sutherland.py", REPOSITORY / "tests" / "own_gas.py"
NEEDED = {
    "temperature": lambda c, rho, e: e / c[2],
    "energy": lambda c, rho, T: c[2] * T,
    "pressure": lambda c, rho, T: c[0] * rho * T,
    "density": lambda c, p, T: p / (c[0] * T),
    "temperature_of_pressure": lambda c, rho, p: p / (c[0] * rho),
    "heat_capacity": lambda c, rho, T: c[2],
    "pressure_by_temperature": lambda c, rho, T: c[0] * rho,
    "bulk_modulus": lambda c, rho, T: c[0] * rho * T,
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """name -> result, with Sutherland's law; those of one process share what is compiled for it."""
    folder = tmp_path_factory.mktemp("laws")
    found = compute(
        1,
        folder / "one",
        {
            **{f"hot_{h}": (str(SUTHERLAND), f"-fsi_h {h} -fsi_cfl 0.5") for h in (0.025, 0.0125, 0.00625)},
            "hot_papers": (str(SUTHERLAND), "-fsi_h 0.0125 -fsi_mapping rigid -fsi_coupling energy"),
            "constant": (str(SUTHERLAND), "-fsi_h 0.025 -hot_law 0"),
        },
    )
    found |= {"two_ranks": compute(2, folder / "two", {"hot": (str(SUTHERLAND), "-fsi_h 0.0125 -fsi_cfl 0.5")})["hot"]}
    return {name: fsipetsc.open_run(path) for name, path in found.items()}


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """name -> result, with a gas law of its own or the built-in one."""
    short = "-fsi_h 0.025 -ts_max_time 1 -fsi_entropy"
    found = compute(
        1,
        tmp_path_factory.mktemp("boxes"),
        {
            "built_in": ("box", short),
            "by_hand": (str(OWN_GAS), short),
            "perfect": ("box", f"{short} -fluid_gamma 1.5"),
            "perfect_energy": ("box", f"{short} -fluid_gamma 1.5 -fsi_coupling energy"),
            "noble": (str(OWN_GAS), f"{short} -fluid_gamma 1.5"),
            "noble_energy": (str(OWN_GAS), f"{short} -fluid_gamma 1.5 -fsi_coupling energy"),
        },
    )
    return {name: fsipetsc.open_run(path) for name, path in found.items()}


def same(a, b) -> bool:
    names = [("rho", "u", "T", "p") if "rho" in layer.fields else ("u", "sigma", "T", "x") for layer in a.layers]
    return all(
        np.array_equal(one[name], other[name], equal_nan=True)
        for one, other, fields in zip(a.layers, b.layers, names, strict=True)
        for name in fields
    )


def alone(fluid):
    """A problem that is a gas of this material between walls."""
    layer = FluidLayer("gas", fluid, (0.0, 1.0), lambda X: [1 + 0 * X, 0 * X, 1 + 0 * X])
    return Problem((layer,), Wall(0.0), Wall(1.0), units="none")


@pytest.mark.long
def test_a_perfect_gas_written_by_hand_has_the_bits_of_the_built_in_one(boxes):
    assert same(boxes["built_in"], boxes["by_hand"])
    for name in ("mass", "energy", "momentum", "entropy", "residual_stress"):
        assert np.array_equal(boxes["built_in"].series[name], boxes["by_hand"].series[name]), name


@pytest.mark.long
@pytest.mark.parametrize("name", ["noble", "noble_energy"])
def test_another_gas_conserves_as_the_perfect_one_does(boxes, name):
    """And is another one: the same energy in another pressure."""
    own, perfect = boxes[name].series, boxes[name.replace("noble", "perfect")].series
    assert np.abs(own["x_interface"][-1] - perfect["x_interface"][-1]).max() > 1e-4
    drift = {k: np.abs(s["mass"] / s["mass"][0] - 1).max() for k, s in (("own", own), ("perfect", perfect))}
    assert drift["own"] < 1.5 * drift["perfect"]
    energy = {k: np.abs(s["energy"] / s["energy"][0] - 1).max() for k, s in (("own", own), ("perfect", perfect))}
    assert energy["own"] < 1.5 * energy["perfect"]


@pytest.mark.long
def test_sutherland(runs):
    """The interface meets its conditions with the viscosity there; the errors fall; ranks change no bit.

    (So it is, always, of the law by hand in materials.py: tests/test_materials.py and test_same_bits.py.)
    """
    coarse, middle, fine = (runs[f"hot_{h}"] for h in (0.025, 0.0125, 0.00625))
    # (the data at rest start sound that is not smooth: u, which is that sound, does not show a rate)
    states = [result.layers[0]["T"][-1] for result in (coarse, middle, fine)]
    points = [np.flatnonzero(np.isfinite(state))[::-1] for state in states]  # from the interface on
    count = len(points[0]) - 2
    a, b, c = (state[at[:: 2**k]][:count] for k, (state, at) in enumerate(zip(states, points, strict=True)))
    assert np.log2(np.abs(a - b).max() / np.abs(b - c).max()) > 3.0
    stress, flux = 1e5, 1000.0 * 300 / 0.0125
    assert np.abs(runs["hot_papers"].series["residual_stress"]).max() < 1e-14 * stress
    assert np.abs(runs["hot_papers"].series["residual_flux"]).max() < 1e-14 * flux
    assert same(middle, runs["two_ranks"])
    assert (
        np.abs(coarse.layers[0]["T"][-1] - runs["constant"].layers[0]["T"][-1])[np.isfinite(coarse.layers[0]["T"][-1])].max()
        > 10
    )


def test_what_follows_from_the_needed_formulas():
    law = gas_law(**NEEDED)
    gas, own = Fluid(0.0, 0.0, 1.4, 287.0), Fluid(0.0, 0.0, 1.4, 287.0, law=law)
    c, rho, T = perfect_gas.constants.py_func(gas), 1.3, 310.0
    e = c[2] * T
    for name, x in {
        "sound_speed_squared": T,
        "sound_speed_squared_of_energy": e,
        "pressure_of_energy": rho * e,
        "bulk_modulus_of_energy": rho * e,
        "temperature_in_loops": e,
    }.items():
        values = [from_python(getattr(which, name))(c, rho, x) for which in (law, perfect_gas)]
        np.testing.assert_allclose(*values, rtol=1e-14)
    np.testing.assert_allclose(own.sound_speed(T, rho), gas.sound_speed(T), rtol=1e-14)
    rock = {"K": 1e5, "kappa_e": 0.0, "m0": 2000.0, "alpha": 700.0, "gruneisen": 0.4}
    pressing = pressure_law(
        pressure=lambda c, T, x_X: c[0] * T / x_X,
        pressure_by_temperature=lambda c, T, x_X: c[0] / x_X,
        stiffness=lambda c, T, x_X: c[0] * T / x_X,
    )
    speeds = [Solid(**rock, **more).sound_speed(0.8, 300.0, -5e3) for more in ({}, {"pressing": pressing})]
    np.testing.assert_allclose(*speeds, rtol=1e-14)


# what is wrong


@pytest.mark.parametrize(
    ("relative", "said"),
    [
        (lambda T: (T, T, T), "relative returns 3 values: expected (mu(T)/mu, kappa(T)/kappa), two numbers"),
        (lambda T: T, "expected (mu(T)/mu, kappa(T)/kappa), two numbers"),
        (lambda T: None, "relative returns nothing (is its return missing?)"),
        (lambda T: (T.nowhere, T), "relative cannot be compiled for numbers"),
        (lambda T: (1.0 if T > 300 else 2.0, 1.0), "relative cannot be compiled for vectors of points"),
    ],
)
def test_a_wrong_law_is_blamed(relative, said):
    line = relative.__code__.co_firstlineno
    with pytest.raises(InputError) as caught:
        check(transport_law(relative), "transport")
    assert said in str(caught.value) and f"test_own_laws.py, line {line}: " in str(caught.value)


def test_laws_that_are_not_whole():
    with pytest.raises(InputError, match=r"gas_law: the formula energy\(c, rho, T\) is missing"):
        gas_law(temperature=NEEDED["temperature"])
    with pytest.raises(InputError, match="there is no formula 'viscosity'"):
        gas_law(**NEEDED, viscosity=NEEDED["energy"])
    with pytest.raises(InputError, match=r"line \d+: energy of gas_law takes 2 arguments: expected energy\(c, rho, T\)"):
        gas_law(**{**NEEDED, "energy": lambda c, T: T})
    with pytest.raises(InputError, match="relative is 3: expected a function"):
        transport_law(3)
    with pytest.raises(InputError, match=r"Fluid: transport is .*: expected what transport_law\(…\) returns"):
        Fluid(1.0, 1.0, 1.4, 1.0, transport=lambda T: T)
    with pytest.raises(InputError, match=r"Solid: pressing is 3: expected what pressure_law\(…\) returns"):
        Solid(1.0, 1.0, 1.0, 1.0, pressing=3)


def test_a_run_with_a_wrong_law_ends_with_status_2(tmp_path):
    text = SUTHERLAND.read_text().replace("    return factor, factor\n", "    return factor, factor.wrong\n")
    (tmp_path / "wrong.py").write_text(text)
    line = 1 + text.splitlines().index("    return factor, factor.wrong")
    done = solve("wrong.py", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert done.stderr.startswith(f"fsipetsc: error: wrong.py, line {line}: relative cannot be compiled")
    (tmp_path / "entropy.py").write_text(
        OWN_GAS.read_text().replace("sound_speed_squared_of_energy entropy", "sound_speed_squared_of_energy")
    )
    done = solve("entropy.py", "-fsi_entropy", cwd=tmp_path)
    assert done.returncode == 2 and "-fsi_entropy" in done.stderr and "'left'" in done.stderr, done.stderr
