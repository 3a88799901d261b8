"""The case `shock`: its exact solution, and what the runs keep and reach."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import compute, run

import fsipetsc

pytest.importorskip("petsc4py")

from fsipetsc.cases import load_case, shock
from fsipetsc.options import defaults

CASE = load_case("shock")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """results(name): the result of a run."""
    folder = tmp_path_factory.mktemp("shocks")
    runs = {f"{norm}": ("shock", f"-fsi_h 0.02 -fsi_output_dt 1 -fsi_norm {norm}") for norm in ("L1", "L2")}
    compute(1, folder, runs)
    return lambda name: fsipetsc.open_run(folder / f"{name}.h5")


def problem(**options):
    """The case with some options."""
    return CASE.build({**defaults(CASE), **options})


def test_errors_in_both_norms(results):
    """Computed here from the fields."""
    for norm, power in (("L1", 1), ("L2", 2)):
        result = results(norm)
        for layer, given in zip(result.layers, problem().layers, strict=True):
            names = given.fields[:3] if given.kind == "fluid" else given.fields[:4]
            exact = given.exact(layer.X, result.time[-1])
            sums = [0.02 * np.sum(np.abs(layer[name][-1] - e) ** power) for name, e in zip(names, exact, strict=True)]
            errors = result.errors[given.kind]
            assert [errors[name] for name in names] == pytest.approx([s ** (1 / power) for s in sums], rel=1e-12)
            assert errors["combined"] == pytest.approx(sum(sums) ** (1 / power), rel=1e-12)
    assert results("L1").errors["fluid"]["rho"] < 0.02, "the solution is the right one"


def test_the_result_says_which_norm(tmp_path):
    done = run("-m", "fsipetsc", "shock", "-fsi_h", 0.05, "-ts_max_time", 0.02, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "L1 errors in the solid: u " in done.stdout
    assert "L1 errors" in run("-m", "fsipetsc", "info", "shock.h5", cwd=tmp_path).stdout


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
