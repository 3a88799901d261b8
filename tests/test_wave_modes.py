"""Linear theory in two dimensions: the scheme's own rates, linearised, against modes that are known independently."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import solve

from fsipetsc.analysis.wave_measures import Rest, Waves, measure, nearest
from fsipetsc.analysis.wave_modes import Stack, linearise, most, symbol, wave_number
from fsipetsc.blocks.conditions import Clamped, Free, Slip
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: a gas of height 1 over an elastic layer of depth 1/2, wave number 2 pi: by a spectral method
KNOWN = (-0.367881432498 + 4.726877249787j, -0.433440151802 + 10.993326674370j)
MU = 0.01
#: the speed of sound is 1 where gamma p = rho
GAMMA = 1.4


def gas_over_layer(n):
    """That problem, n cells in the gas."""
    gas = Fluid(MU, MU * 3.5 / 0.72, GAMMA, 1.0)
    return Rest(gas, ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, heat="elastic"), cells=(n // 2, n), depth=0.5).coupled()


def slipping(**changes):
    """An inviscid gas with sound of speed 1, over a solid of the same mass; all parameters 1."""
    solid = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, heat="elastic")
    return Rest(Fluid(0.0, 0.0, GAMMA, 1.0 / GAMMA), solid, **changes)


def distances(order, n, at_symbol):
    k, linear = 2 * np.pi, linearise(gas_over_layer(n), order, 1 / n)
    k = wave_number(order, 1 / n, k) if at_symbol else k
    return np.array([abs(nearest(linear, k, s) - s) / abs(s) for s in KNOWN])


def test_normal_modes():
    """As in the notes to the scheme: 4/2 with 32 cells, and 6/3 with 48; the symbol of D for k makes little of it."""
    four, same, six = distances(4, 32, False), distances(4, 32, True), distances(6, 48, False)
    assert (four < (7e-4, 4e-5)).all() and (same < (7e-4, 4e-5)).all() and (four > 1e-6).all()
    assert (six < (2.5e-5, 4e-6)).all()
    coarse = distances(4, 16, False)
    assert (np.log2(coarse / four) > 3.8).all()


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_columns_enter_by_the_symbol_alone(order):
    """Two grids along X on which waves have one symbol have one spectrum; and so have k and its mirror image."""
    cells, kappa = {2: 8, 4: 8, 6: 12, 8: 16}[order], 5.0
    rest = slipping(cells=(cells, cells))
    spectra = []
    for h in (0.1, 0.07):
        linear = linearise(rest.coupled(), order, h)
        spectra.append(np.sort_complex(np.round(np.linalg.eigvals(linear.matrix(wave_number(order, h, kappa))), 7)))
    assert np.abs(spectra[0].imag - spectra[1].imag).max() < 1e-5
    top, greatest = most(order, 0.1)
    assert symbol(order, 0.1, top) == greatest > symbol(order, 0.1, 0.9 * top)
    with pytest.raises(InputError, match="knows none of that size"):
        wave_number(order, 0.1, 1.01 * greatest)


def test_differences_are_exact_enough():
    """Twice the disturbance makes no difference: that is the derivative."""
    problem = gas_over_layer(16)
    one, two = (linearise(problem, 4, 1 / 16, nudge) for nudge in (0.005, 0.01))
    assert np.abs(one.rates - two.rates).max() < 1e-11 * np.abs(one.rates).max()
    assert np.abs(one.projection @ one.projection - one.projection).max() < 1e-14
    # (u, v) of the wall, of the interface and of the clamped end, whose D stays what it is
    assert np.linalg.matrix_rank(one.projection) == len(one.projection) - 6


def test_a_wave_along_an_interface():
    """Scholte's wave, all parameters 1: c = .711001723, 11 deep on both sides."""
    k, cells = 1.0, 55
    rest = slipping(cells=(cells, cells), depth=11.0, height=11.0)
    linear = linearise(rest.coupled(), 6, 0.2)
    assert abs(nearest(linear, wave_number(6, 0.2, k), 0.711j) - 0.711001723j) < 1e-4


@pytest.mark.parametrize("order", [4, 6])
def test_nothing_grows_and_the_step_is_kept(order):
    for density, stiffness in ((1e-3, 1.0), (1.0, 100.0), (1e3, 1e-2)):
        solid = ElasticSolid(stiffness / 4, stiffness / 2, 0.0, density, 1.0 / density, heat="elastic")
        result = measure(Rest(Fluid(0.0, 0.0, GAMMA, 1.0), solid, cells=(12, 12)), order, Waves((0.2, 1.0)))
        assert result.stable and result.step_kept, result


@pytest.mark.parametrize("rows", [16, 17, 18, 19, 20, 21])
def test_thin_layers_of_the_widest_operator(rows):
    """Rows of scratch that are still needed give way to no other: then displacements change by the velocity of their row."""
    solid, _ = slipping(cells=(rows - 1, 16)).layers()
    linear = linearise(Stack((solid,), Clamped(), Free(slipping().p)), 8, 0.1)
    values = np.linalg.eigvals(linear.matrix(*Waves((0.5,)).numbers(8, 0.1)))
    assert values.real.max() < 1e-11 * np.abs(values).max()


def test_only_about_rest():
    moving = replace(slipping(cells=(8, 8)).layers()[1], initial=lambda X, Y: (1 + 0 * X, 0.1 + 0 * X, 0 * X, 1 + 0.1 * Y))
    with pytest.raises(InputError, match="not at rest"):
        linearise(Stack((moving,), Slip(), Slip()), 2, 0.1)


@pytest.mark.parametrize(("m0", "K"), [(1e-3, 0.01), (1.0, 0.1)])
def test_what_grows_is_heated_by_the_pressure_at_rest(m0, K):
    """With coupled heat and conduction modes grow; by the term -p div v / (alpha m0) of the solid, and nothing else."""
    solid = ElasticSolid(K / 4, K / 2, 0.02, m0, 2.5 / m0, heat="coupled")
    gas, size = Fluid(0.01, 0.03, GAMMA, 1.0), 8 / 32
    rest = Rest(gas, solid, cells=(8, 8), depth=size, height=size)
    found = measure(rest, 4, Waves((0.0, 0.2)))
    assert found.heated > 1e-4 and found.growth < 1e-14 and found.stable
    linear = linearise(rest.coupled(), 4, 1 / 32)
    heat = linear.rates[len(linear.rates) // 2] - linear.without_heat().rates[len(linear.rates) // 2]
    n = 5 * 4  # the row in the middle of the solid: T by v of the rows beside it, over the scales of both
    weights = heat[n + 4, [n - 2, n + 8]] * linear.scales[n + 4] / linear.scales[n + 3]
    assert np.allclose(weights, np.array([2 / 3, -2 / 3]) * 32 * 1.0 / m0, rtol=1e-6)  # of e = alpha T: -p D v / m0


def test_the_command(tmp_path):
    """A table, the modes, and status 3 where something does not hold; heat of the pressure at rest is told apart."""
    words = ("stability", "-stability_plane", "-fsi_order", 4, "-stability_points", 8, "-stability_symbols", 0.2)
    well = solve(*words, "-sweep", "-density_ratios", "0.001,1000", "-stiffness_ratios", "0.1,10", cwd=tmp_path)
    assert (well.returncode, well.stderr) == (0, "") and "4/2   4        4" in well.stdout
    assert (tmp_path / "stability-plane.csv").read_text().count("\n") == 5
    grows = ("-solid_density", 1e-3, "-solid_modulus", 0.01, "-solid_alpha", 2500, "-solid_heat", "coupled")
    heated = solve(*words, *grows, cwd=tmp_path)
    assert (heated.returncode, heated.stderr) == (0, "") and "With it modes grow at up to 4.0e-03" in heated.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-stability_plane -stability_symbols 1.5", "-stability_symbols"),
        ("-stability_plane -fsi_coupling energy", "-fsi_coupling energy: two dimensions"),
        ("-stability_plane -fsi_viscous narrow", "-fsi_viscous narrow: two dimensions"),
        ("-stability_k 2", "-stability_plane asks"),
        ("rod -stability_k 2", "rod is a case of one dimension"),
        ("panel -fsi_viscous narrow", "with -fsi_coupling conservative it is wide"),
        ("panel -stability_X 2", "the interface is between 0 and 1"),
        ("panel -stability_interface 1", "expected 0 (panel | gas 2)"),
        ("panel -stability_k 101", "up to 100.531"),
    ],
)
def test_what_the_command_refuses(words, said, tmp_path):
    done = solve("stability", *words.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1) and said in done.stderr, done.stderr


def test_layers_of_a_case(tmp_path):
    """Its materials, grid and edges: a panel with a free surface, whose bending wave is slow; beside a gas above it."""
    words = "panel -stability_k 6.283185 -panel_height 0.25 -fsi_dissipation 0".split()
    done = solve("stability", *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "9 points across the solid, 15 across the gas, columns 0.03125 m apart" in done.stdout
    real, _, imaginary = done.stdout.split("k =   6.2832")[1].split()[:3]
    slowest = complex(float(real), float(imaginary.rstrip(",i")))
    # of a plate of stiffness D and mass m: sqrt(D k^4/m), more than with gas: gas adds to its mass
    D, m, k = 2 * 0.5 * 4 / (800 * np.sqrt(3)), 10.0, 2 * np.pi
    alone = np.sqrt(D * k**4 / m)
    assert 0.9 * alone < slowest.imag < alone and abs(slowest.real) < 1e-9
