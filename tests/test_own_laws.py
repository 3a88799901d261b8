"""Laws of materials that case files bring, in one dimension: they are used everywhere, and blamed."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, compute, solve

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

import fsipetsc

SUTHERLAND, OWN_GAS = REPOSITORY / "runs" / "sutherland.py", REPOSITORY / "tests" / "own_gas.py"
#: a solid between gases in rigid frames, or beside one
_PAPERS = "-fsi_coupling energy"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """name -> result, with Sutherland's law; those of one process share what is compiled for it."""
    folder = tmp_path_factory.mktemp("laws")
    found = compute(
        1,
        folder / "one",
        {
            **{f"hot_{h}": (str(SUTHERLAND), f"-fsi_h {h} -fsi_cfl 0.5 {_PAPERS}") for h in (0.025, 0.0125, 0.00625)},
            "hot_papers": (str(SUTHERLAND), "-fsi_h 0.0125 -fsi_coupling energy"),
            "constant": (str(SUTHERLAND), f"-fsi_h 0.025 -hot_law 0 {_PAPERS}"),
        },
    )
    hot = {"hot": (str(SUTHERLAND), f"-fsi_h 0.0125 -fsi_cfl 0.5 {_PAPERS}")}
    found |= {"two_ranks": compute(2, folder / "two", hot)["hot"]}
    return {name: fsipetsc.open_run(path) for name, path in found.items()}


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """name -> result, with a gas law of its own or the built-in one."""
    short = f"-fsi_h 0.025 -ts_max_time 1 -fsi_entropy {_PAPERS}"
    listed = {
        "built_in": ("box", short),
        "by_hand": (str(OWN_GAS), short),
        "perfect": ("box", f"{short} -fluid_gamma 1.5"),
        "noble": (str(OWN_GAS), f"{short} -fluid_gamma 1.5"),
    }
    found = compute(1, tmp_path_factory.mktemp("boxes"), listed)
    return {name: fsipetsc.open_run(path) for name, path in found.items()}


def same(a, b) -> bool:
    names = [("rho", "u", "T", "p") if "rho" in layer.fields else ("u", "sigma", "T", "x") for layer in a.layers]
    return all(
        np.array_equal(one[name], other[name], equal_nan=True)
        for one, other, fields in zip(a.layers, b.layers, names, strict=True)
        for name in fields
    )


@pytest.mark.long
def test_a_perfect_gas_written_by_hand_has_the_bits_of_the_built_in_one(boxes):
    assert same(boxes["built_in"], boxes["by_hand"])
    for name in ("mass", "energy", "momentum", "residual_stress"):
        assert np.array_equal(boxes["built_in"].series[name], boxes["by_hand"].series[name]), name


@pytest.mark.long
def test_another_gas_drifts_as_the_perfect_one_does(boxes):
    """And is another one: the same energy in another pressure."""
    own, perfect = boxes["noble"].series, boxes["perfect"].series
    assert np.abs(own["x_interface"][-1] - perfect["x_interface"][-1]).max() > 1e-4
    for name in ("mass", "energy"):
        drift = [np.abs(series[name] / series[name][0] - 1).max() for series in (own, perfect)]
        assert drift[0] < 1.5 * drift[1]


@pytest.mark.long
def test_sutherland(runs):
    """The interface meets its conditions with the viscosity there; the errors fall; ranks change no bit.

    (So it is, always, of the law by hand in materials.py: tests/test_materials.py.)
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


def test_a_run_with_a_wrong_law_ends_with_status_2(tmp_path):
    text = SUTHERLAND.read_text().replace("/ (T + S))\n", "/ (T + S)).wrong\n")
    (tmp_path / "wrong.py").write_text(text)
    done = solve("wrong.py", "-fsi_coupling", "energy", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "transport_law" in done.stderr, done.stderr
    text = OWN_GAS.read_text()
    (tmp_path / "entropy.py").write_text(text[: text.index("    def entropy")] + text[text.index("def of_this_gas") :])
    done = solve("entropy.py", "-fsi_entropy", "-fsi_coupling", "energy", cwd=tmp_path)
    assert done.returncode == 2 and "-fsi_entropy" in done.stderr and "'left'" in done.stderr, done.stderr
