"""Results have the same bits on any number of ranks, however layers are dealt out and stored."""

from functools import cache

import numpy as np
import pytest
from helpers import REPOSITORY, SUMS, compute, computed, different, kept, message, on_ranks, solve

PISTON = str(REPOSITORY / "runs" / "piston.py")
_PAPER = "-fsi_coupling projection"
#: falls by more than a cell
_ROD = f"{_PAPER} -fsi_h 0.05 -ts_max_time 0.04 -rod_gravity -100 -fsi_output_dt 0.01"
#: a step that is bound by the solid, with a pressure in it and cut in two
_STIFF = f"{_PAPER} -fsi_h 0.05 -ts_max_time 0.004 -solid_modulus 1e9 -solid_gruneisen 0.5"
_STIFF += " -rod_gravity -1000"
#: falls by four cells, through PETSc's own methods
_FALL = "-fsi_h 0.05 -ts_max_time 0.02 -rod_gravity -1000"
_PULSE = "-fsi_h 0.025 -fsi_order 8 -fsi_output_dt 0.001 -ts_max_time 0.003 -pulse_amplitude 1000"
#: a wall that moves
_DRIVEN = "-ts_max_time 0.01 -fsi_output_dt 0.005"
_ELSEWHERE = "-fsi_partition balanced"
_SHOCK = "-shock_problem strong -fsi_dissipation 1 -fsi_shock 1 -fsi_order 4 -fsi_h 0.02"
_SHOCK += f" {_ELSEWHERE} -ts_max_time 0.1 -fsi_output_dt 0.1"
#: each sequence of layers is compiled by itself: few of them
RUNS = {
    "rod": ("rod", _ROD),
    "rod elsewhere": ("rod", f"{_ROD} {_ELSEWHERE}"),
    "rod stiff": ("rod", f"{_STIFF} {_ELSEWHERE}"),
    "rod rk": ("rod", f"{_FALL} {_PAPER} -ts_type rk"),
    "rod rk elsewhere": ("rod", f"{_FALL} {_PAPER} -ts_type rk {_ELSEWHERE}"),
    "rod energy": ("rod", f"{_FALL} -fsi_coupling energy"),
    "rod traditional": ("rod", f"{_FALL} -fsi_coupling traditional"),
    "driven": ("piston", _DRIVEN),
    "driven messages": ("piston", f"{_DRIVEN} -fsi_partition physics"),
    "driven at order 8": ("piston", f"{_DRIVEN} -fsi_order 8"),
    "mms": ("mms", "-fsi_h 0.025 -fsi_order 6 -ts_max_time 0.2 -fsi_output_dt 0.05"),
    "pulse": ("pulse", _PULSE),
    "piston": (PISTON, "-ts_max_time 0.048"),
    "shock": ("shock", _SHOCK),
}
#: differ in where things are computed and stored, not in what
SAME = {"rod elsewhere": "rod", "rod rk elsewhere": "rod rk", "driven messages": "driven"}

#: ranks -> the runs that are made on them: each on one, on two or three, those of SAME on four
ON = {1: list(RUNS), 4: [*SAME, *SAME.values()]}
ON[3] = ["rod stiff", "rod traditional", "driven at order 8", "pulse"]
ON[2] = [name for name in RUNS if name not in ON[3]]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """results(ranks, name): a run of RUNS on so many ranks."""

    @cache
    def made(n):
        runs = {run: RUNS[run] for run in ON[n]}
        found = compute(n, tmp_path_factory.mktemp(f"ranks{n}"), runs)
        return {run: kept(of, 1e-10) if "driven" in run else of for run, of in found.items()}

    return lambda n, name: made(n)[name]


def assert_same(one, other) -> None:
    """Profiles and series bit for bit; integrals over x up to the order of summation."""
    assert one.summary["ranks"] != other.summary["ranks"] or one.options != other.options
    assert different(one.path, other.path, same_ranks=False) == []
    energy, dt = (np.abs(one.series[name]).max() for name in ("energy", "dt"))
    # of parts that cancel: in impulses pressures of 1e5 Pa at both ends, in losses the energies
    least = {"impulse_x": 1e-15 * 1e5 * dt, "lost_energy": 1e-14 * energy}
    least |= dict.fromkeys(("momentum", "momentum_x", "momentum_y"), 1e-15 * energy)
    for name in one.series.keys() & SUMS:
        values = one.series[name]
        atol = max(least.get(name, 0.0), 1e-12 * np.abs(values).max())
        np.testing.assert_allclose(other.series[name], values, rtol=1e-12, atol=atol)
    for kind, listed in one.errors.items():
        found = list(other.errors[kind].values())
        np.testing.assert_allclose(found, list(listed.values()), rtol=1e-9)
        assert np.isfinite(found).all()


@pytest.mark.parametrize(("n", "name"), [(n, name) for n in (2, 3, 4) for name in ON[n]])
def test_as_on_one_rank(results, n, name):
    assert results(n, name).summary["ranks"] == n
    assert_same(results(1, name), results(n, name))


@pytest.mark.parametrize(("name", "same"), SAME.items())
def test_partition_and_storage_do_not_matter(results, name, same):
    assert_same(results(1, same), results(1, name))


def test_the_boundaries_cross_cells(results):
    """So that the runs above say something about points that appear and disappear."""
    cells = {("rod", 0): 1, ("rod", 2): 2, ("mms", 0): 1, ("mms", 2): 1, ("piston", 0): 15}
    cells |= {("rod rk", 0): 3, ("rod rk", 2): 3}
    for (name, layer), least in cells.items():
        counts = np.isfinite(results(1, name).layers[layer]["rho"]).sum(axis=1)
        assert np.ptp(counts) >= least, (name, layer)


@pytest.mark.parametrize(("d", "h"), [(2, 0.0625), (3, 0.1)])
def test_periodic_blocks(d, h, tmp_path):
    line = f"box_mms -box_dimension {d} -fsi_h {h} -ts_max_time 0.01 -fsi_output_dt 0.005"
    assert on_ranks(tmp_path, line, 1, 2, 4).summary["steps"] > 1


def test_short_parts_of_solids_that_conduct(tmp_path):
    line = "box_mms -box_dimension 1 -ts_max_time 0.02 -fsi_output_dt 0.01 -fsi_h"
    assert on_ranks(tmp_path, f"{line} 0.0666667", 1, 4).layers[1]["T"].shape[1] == 16
    refused = solve(*f"{line} 0.0833333".split(), cwd=tmp_path, ranks=4)  # 13 nodes on two ranks
    message(refused, 2, "4 ranks", "3 is the largest number that works")


def test_the_largest_number_of_ranks_works_and_one_more_is_refused(tmp_path):
    args = f"rod {_PAPER} -fsi_h 0.125 -rod_top 3 -ts_max_steps 10".split()
    refused = solve(*args, cwd=tmp_path, ranks=4)
    message(refused, 2, "4 ranks", "3 is the largest number that works")
    run = computed(tmp_path, "rod.h5", *args, ranks=3)
    assert (run.summary["ranks"], run.summary["steps"]) == (3, 10)
