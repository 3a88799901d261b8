"""Linear theory in two dimensions: the scheme's rates against modes that are known otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import solve

from fsipetsc.analysis.wave_measures import Rest, Waves, measure
from fsipetsc.analysis.wave_modes import Stack, linearise, most, symbol, wave_number
from fsipetsc.blocks.conditions import Clamped, Free, Slip
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: a gas of height 1 over an elastic layer of depth 1/2, wave number 2 pi: by a spectral method
KNOWN = (-0.367881432498 + 4.726877249787j, -0.433440151802 + 10.993326674370j)
MU, GAMMA = 0.01, 1.4  # the speed of sound is 1 where gamma p = rho
STONE = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, heat="elastic")


def gas_over_layer(n):
    """That problem, n cells in the gas."""
    gas = Fluid(MU, MU * 3.5 / 0.72, GAMMA, 1.0)
    return Rest(gas, STONE, cells=(n // 2, n), depth=0.5).coupled()


def slipping(**changes):
    """An inviscid gas with sound of speed 1, over a solid of the same mass; all parameters 1."""
    return Rest(Fluid(0.0, 0.0, GAMMA, 1.0 / GAMMA), STONE, **changes)


def distance(linear, k, s):
    return np.abs(linear.modes(k)[0] - s).min() / abs(s)


def test_normal_modes():
    """As in the notes to the scheme: 4/2 with 32 cells, and 6/3 with 48."""

    def distances(order, n):
        linear = linearise(gas_over_layer(n), order, 1 / n)
        return np.array([distance(linear, 2 * np.pi, s) for s in KNOWN])

    four, coarse = distances(4, 32), distances(4, 16)
    assert (four < (7e-4, 4e-5)).all() and (np.log2(coarse / four) > 3.8).all()
    assert (distances(6, 48) < (2.5e-5, 4e-6)).all()


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_columns_enter_by_the_symbol_alone(order):
    """Two grids along X on which waves have one symbol have one spectrum."""
    cells, kappa = {2: 8, 4: 8, 6: 12, 8: 16}[order], 5.0
    stack, spectra = slipping(cells=(cells, cells)).coupled(), []
    for h in (0.1, 0.07):
        values = linearise(stack, order, h).modes(wave_number(order, h, kappa))[0]
        spectra.append(np.sort_complex(np.round(values, 7)))
    assert np.abs(spectra[0].imag - spectra[1].imag).max() < 1e-5
    top, greatest = most(order, 0.1)
    assert symbol(order, 0.1, top) == greatest > symbol(order, 0.1, 0.9 * top)
    with pytest.raises(InputError, match="waves on this grid go up to"):
        wave_number(order, 0.1, 1.01 * greatest)


def test_differences_are_exact_enough():
    """Twice the disturbance makes no difference: that is the derivative."""
    one, two = (linearise(gas_over_layer(16), 4, 1 / 16, nudge) for nudge in (0.005, 0.01))
    assert np.abs(one.rates - two.rates).max() < 1e-11 * np.abs(one.rates).max()
    assert np.abs(one.projection @ one.projection - one.projection).max() < 1e-14
    # (u, v) of the wall, of the interface and of the clamped end
    assert np.linalg.matrix_rank(one.projection) == len(one.projection) - 6


def test_a_wave_along_an_interface():
    """Scholte's wave, all parameters 1: c = .711001723, 11 deep on both sides."""
    linear = linearise(slipping(cells=(55, 55), depth=11.0, height=11.0).coupled(), 6, 0.2)
    assert distance(linear, wave_number(6, 0.2, 1.0), 0.711001723j) < 1e-4


@pytest.mark.parametrize("order", [4, 6])
def test_nothing_grows_and_the_step_is_kept(order):
    for density, stiffness in ((1e-3, 1.0), (1.0, 100.0), (1e3, 1e-2)):
        moduli = stiffness / 4, stiffness / 2
        solid = ElasticSolid(*moduli, 0.0, density, 1.0 / density, heat="elastic")
        rest = Rest(Fluid(0.0, 0.0, GAMMA, 1.0), solid, cells=(12, 12))
        result = measure(rest, order, Waves((0.2, 1.0)))
        assert result.stable and result.step_kept, result


@pytest.mark.parametrize("rows", [16, 18, 21])
def test_thin_layers_of_the_widest_operator(rows):
    """Scratch of rows that are still needed gives way to no other."""
    solid, _ = slipping(cells=(rows - 1, 16)).layers()
    linear = linearise(Stack((solid,), Clamped(), Free(slipping().p)), 8, 0.1)
    values, _ = linear.modes(*Waves((0.5,)).numbers(8, 0.1))
    assert values.real.max() < 1e-11 * np.abs(values).max()


def test_only_about_rest():
    layer = slipping(cells=(8, 8)).layers()[1]
    moving = replace(layer, initial=lambda X, Y: (1.0, 0.1, 0.0, 1 + 0.1 * Y))
    with pytest.raises(InputError, match="not at rest"):
        linearise(Stack((moving,), Slip(), Slip()), 2, 0.1)


def test_the_command(tmp_path):
    """A table of a sweep as CSV; one message for what there is not."""
    words = "stability -stability_plane -fsi_order 4 -stability_points 8 -stability_symbols 0.2"
    sweep = "-sweep -density_ratios 0.001,1000 -stiffness_ratios 0.1,10"
    well = solve(*words.split(), *sweep.split(), cwd=tmp_path)
    assert (well.returncode, well.stderr) == (0, "") and "4/2   4        4" in well.stdout
    assert (tmp_path / "stability-plane.csv").read_text().count("\n") == 5
    for words, said in {
        "-stability_plane -stability_symbols 1.5": "-stability_symbols",
        "-stability_plane -fsi_viscous narrow": "narrow: -stability_plane does not have it",
        "-stability_plane -stability_k 101": "up to 100.531",
        "-stability_k 2": "-stability_plane asks",
        "panel": "panel is no case of layers",
    }.items():
        done = solve("stability", *words.split(), cwd=tmp_path)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1) and said in done.stderr
