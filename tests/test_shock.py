"""The case `shock`: its exact solution, and what the runs keep and reach."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import compute, solve

import fsipetsc

pytest.importorskip("petsc4py")

from fsipetsc.cases import load_case, shock
from fsipetsc.operators.bands import band
from fsipetsc.options import defaults
from fsipetsc.output.plots.fields import domain

CASE = load_case("shock")


PROBLEMS = ("sod", "strong")
ORDERS = (4, 8)
SPACINGS = (0.02, 0.01, 0.005)
_OFTEN = "-fsi_output_dt 0.05 -shock_problem"
#: so many points that a step goes over them in tiles, and few steps
_FINE = "-fsi_h 0.0004 -ts_max_steps 20 -fsi_order"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """results(name): the result of a run."""
    folder = tmp_path_factory.mktemp("shocks")
    runs = {
        f"{name}_{order}_{h}": ("shock", f"-fsi_h {h} -fsi_order {order} {_OFTEN} {name}")
        for name in PROBLEMS
        for order in ORDERS
        for h in SPACINGS
    }
    runs |= {"L2": ("shock", "-fsi_h 0.02 -fsi_norm L2"), "pressure": ("shock", "-fsi_h 0.01 -solid_gruneisen 0.4")}
    runs |= {"fine_1": ("shock", f"{_FINE} 6")}
    compute(1, folder, runs)
    compute(3, folder, {"fine_3": ("shock", f"{_FINE} 6")})
    return lambda name: fsipetsc.open_run(folder / f"{name}.h5")


def problem(**options):
    """The case with some options."""
    return CASE.build({**defaults(CASE), **options})


def test_errors_in_both_norms(results):
    """Computed here from the fields."""
    for name, power in (("sod_4_0.02", 1), ("L2", 2)):
        result = results(name)
        for layer, given in zip(result.layers, problem().layers, strict=True):
            names = given.fields[:3] if given.kind == "fluid" else given.fields[:4]
            exact = given.exact(layer.X, result.time[-1])
            weight = band(4, len(layer.X) - 1, False).weight
            weight = weight / weight.sum() * np.ptp(layer.X)
            sums = [np.sum(weight * np.abs(layer[name][-1] - e) ** power) for name, e in zip(names, exact, strict=True)]
            errors = result.errors[given.kind]
            assert [errors[name] for name in names] == pytest.approx([s ** (1 / power) for s in sums], rel=1e-12)
            assert errors["combined"] == pytest.approx(sum(sums) ** (1 / power), rel=1e-12)


def test_pictures_show_where_the_piston_was(results):
    """Not only from where it is at the end."""
    run = results("strong_4_0.02")
    left, right = domain(run, run.layers)
    assert left == 0.0 and right == pytest.approx(2.0)


def test_the_result_says_which_norm(tmp_path):
    done = solve("shock", "-fsi_h", 0.05, "-ts_max_time", 0.02, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "L1 errors in the solid: u " in done.stdout
    assert "L1 errors" in solve("info", "shock.h5", cwd=tmp_path).stdout


@pytest.mark.parametrize("options", [{}, {"shock_problem": "strong"}, {"shock_problem": "strong", "solid_gruneisen": 0.4}])
def test_the_exact_solution_keeps_what_there_is(options):
    """Mass, momentum less what wall and end give, energy less the work, on a fine grid, before and after the hit."""
    gas, rod = problem(**options).layers
    speed = shock.behind_shock(gas.material, shock.LOW, 3.0)[0] if options else None
    n = 200_000
    middle = (np.arange(n) + 0.5) / n
    start = _sums(gas, rod, middle, 0.0, 0.0)
    for t in (0.05, 0.2, 0.3):
        wall = 0.0 if speed is None else speed.u * t
        now = _sums(gas, rod, middle, t, wall)
        pressure = 1.0 if speed is None else speed.p  # at the wall, which no wave has reached
        given = np.array([0.0, (pressure - shock.LOW.p) * t, pressure * wall])
        assert np.abs(now - start - given).max() < 2e-5, t


def _sums(gas, rod, middle: np.ndarray, t: float, wall: float) -> np.ndarray:
    """Mass of the gas, momentum and energy of all, by the midpoint rule."""
    rho, u, T = gas.exact(middle, t)
    v, _, T_s, _ = rod.exact(1 + middle, t)
    length = rod.exact(np.array([1.0]), t)[3][0] - wall
    m0, heat = rod.material.m0, rod.material.m0 * rod.material.alpha
    gas_sums = length * np.array([rho.mean(), (rho * u).mean(), (rho * (T / 0.4 + 0.5 * u * u)).mean()])
    return gas_sums + np.array([0.0, (m0 * v).mean(), (0.5 * m0 * v * v + heat * T_s).mean()])


def test_until_when_the_exact_solution_holds():
    """The waves are inside then, and at an end a little later."""
    for name in ("sod", "strong"):
        opt = {**defaults(CASE), "shock_problem": name}
        note = CASE.build(opt).notes[1]
        valid = float(note.split("t = ")[1])
        assert opt["ts_max_time"] < valid < 0.41
        gas, rod = CASE.build(opt).layers
        for t, inside in ((valid - 1e-4, True), (valid + 1e-4, False)):
            first, last = gas.exact(np.array([0.0]), t), rod.exact(np.array([2.0]), t)
            at_rest = [first[0][0] - gas.exact(np.array([0.0]), 0.0)[0][0], last[0][0]]
            assert (np.abs(at_rest).max() < 1e-12) == inside


def ends(run) -> tuple[float, float]:
    """(velocity of the piston, stress that loads the rod's end; 0 where it is clamped)."""
    built = CASE.build(run.options)
    return (built.left.velocity(0.0), built.right.value) if run.options["shock_problem"] == "strong" else (0.0, 0.0)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", PROBLEMS)
def test_mass_momentum_and_energy_are_kept(results, name, order):
    """Momentum less the impulse of piston and load, energy less their work."""
    for h in SPACINGS:
        run = results(f"{name}_{order}_{h}")
        series, start = run.series, run.summary
        speed, load = ends(run)
        assert np.abs(series["mass"] / np.array(start["initial_mass"]) - 1).max() < 1e-13
        impulse = np.cumsum(series["impulse_x"])
        change = series["momentum_x"] - start["initial_momentum_x"]
        assert np.abs(change - impulse).max() < 1e-13 * np.abs(impulse).max()
        at = np.searchsorted(series["t"], run.time[1:])  # the steps after which there are profiles
        assert np.array_equal(series["t"][at], run.time[1:])
        of_wall = impulse - load * series["t"]
        work = speed * of_wall[at] + load * (run.layers[1]["x"][1:, -1] - 2.0)
        assert np.abs(series["energy"][at] - start["initial_energy"] - work).max() < 1e-13 * series["energy"].max()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", PROBLEMS)
def test_errors_in_L1_are_of_order_1(results, name, order):
    """Density of the gas, velocity and stress of the rod, where shocks are; and all of them together.

    Measured 0.80 to 1.14 for the orders 4, 6 and 8, 0.66 to 1.06 for 2, whose dissipation of half the order is of first order,
    too: the ends of a fan then have less than order 1 on any grid, and the weak shock of `sod` on these.
    """
    errors = [results(f"{name}_{order}_{h}").errors for h in SPACINGS]
    for kind, of in (("fluid", "rho"), ("fluid", "combined"), ("solid", "u"), ("solid", "sigma"), ("solid", "combined")):
        values = np.array([e[kind][of] for e in errors])
        rates = np.log2(values[:-1] / values[1:])
        assert rates.min() > (0.6 if order == 2 else 0.75) and rates.max() < 1.25, (kind, of, values, rates)


def overshoots(run, kind: str, names: tuple[str, ...]) -> dict[str, float]:
    """name -> by how much the last profile is beyond the exact one's extremes, over what it jumps."""
    k = 0 if kind == "fluid" else 1
    given, layer = CASE.build(run.options).layers[k], run.layers[k]
    exact = dict(zip(given.fields, given.exact(layer.X, run.time[-1]), strict=False))
    found = {}
    for name in names:
        values, known = layer[name][-1], exact[name]
        found[name] = max(values.max() - known.max(), known.min() - values.min()) / np.ptp(known)
    return found


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", PROBLEMS)
def test_nothing_overshoots(results, name, order):
    """Measured 2.13 % of the jump at 4/2, 3.20 % at 8/4, density behind the contact of Sod's tube."""
    for h in SPACINGS:
        run = results(f"{name}_{order}_{h}")
        beyond = overshoots(run, "fluid", ("rho", "u")) | overshoots(run, "solid", ("u", "sigma"))
        assert max(beyond.values()) < {4: 0.022, 8: 0.033}[order], (h, beyond)


@pytest.mark.parametrize("name", PROBLEMS)
def test_density_and_pressure_stay_above_zero(results, name):
    """They do by far: the least there are in the exact solution are 0.125 and 0.1."""
    for order in ORDERS:
        gas, rod = results(f"{name}_{order}_0.01").layers
        assert gas["rho"].min() > 0.1 and gas["p"].min() > 0.05
        assert rod["T"].min() > 0.95


def test_a_rod_with_a_pressure(results):
    """Grüneisen's: T has a say in the shock, which is right nevertheless, because energy is kept."""
    run = results("pressure")
    beyond = overshoots(run, "fluid", ("rho", "u")) | overshoots(run, "solid", ("u",))
    assert max(beyond.values()) < 0.021
    assert run.errors["solid"]["u"] < 2 * results("sod_4_0.01").errors["solid"]["u"]
    assert np.abs(run.series["energy"] / run.summary["initial_energy"] - 1).max() < 1e-13


def test_the_energy_does_not_depend_on_tiles_and_ranks(results):
    one, three = results("fine_1"), results("fine_3")
    for a, b in zip(one.layers, three.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name])
    assert np.abs(one.series["energy"] / one.summary["initial_energy"] - 1).max() < 1e-13


@pytest.mark.long  # kernels that no other test needs
def test_petscs_methods_have_the_same_rates(results, tmp_path):
    """And the same energy: it is linear in what a Runge-Kutta method integrates."""
    fused = results("sod_4_0.02")
    run = fsipetsc.open_run(compute(1, tmp_path, {"rk": ("shock", "-fsi_h 0.02 -ts_type rk")})["rk"])
    drift = np.abs(run.series["energy"] / run.summary["initial_energy"] - 1).max()
    assert drift < 1e-13
    for a, b in zip(run.layers, fused.layers, strict=True):
        assert a["u"][-1] == pytest.approx(b["u"][-1], abs=1e-3)
