"""Shells around an axis and a centre: the case shell, the command modes shell, what is refused."""

import numpy as np
import pytest
from helpers import assert_same_fields, computed, message, solve
from mpi4py import MPI
from test_ring import modes_of

from fsipetsc.analysis.modes import media_of
from fsipetsc.analysis.ring_theory import Medium, mode_near
from fsipetsc.analysis.spectra import step_limit
from fsipetsc.analysis.wave_modes import linear_modes, radial_modes
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Centre, Free, Slip
from fsipetsc.blocks.maps import ball, off_axis, rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.cases import shell
from fsipetsc.cases.common import at_rest
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.scheme.plan import RATE

STEEL = ElasticSolid(1.0, 1.5, 0.0, 2.0, 1.0, heat="elastic")
KAPPA = pytest.mark.parametrize("kappa", [1, 2])


def mode_errors(kappa, gas, order, h):
    """Of the first three modes, over their frequencies."""
    opt = {option.name: option.default for option in shell.OPTIONS}
    opt.update(shell_kappa=kappa, shell_gas=gas, shell_charge=0.0, fsi_order=order, fsi_h=h)
    problem = shell.build(opt)
    found = radial_modes(problem, order)[:3]
    exact = np.array([mode_near(media_of(problem), 0, complex(omega)) for omega in found])
    assert np.diff(exact.real).min() > 0.1  # three different ones
    assert np.abs(found.imag).max() < 1e-8
    return np.abs(found / exact - 1.0)


@pytest.mark.parametrize("gas", ["centre", "around", "none"])
@KAPPA
def test_modes_of_shells(kappa, gas):
    """Measured: 4/2 rates 3.8 to 4.2, or 4.3 of waves within the shell, whose fastest has 13 nodes
    and an error of 1.5e-2; 6/3 up to 1.3e-9, in a vacuum 9.8e-12, 1.1e-7, 5.9e-6; 8/4 up to 8e-10.
    """
    coarse, fine = (mode_errors(kappa, gas, 4, h) for h in (0.0375, 0.01875))
    assert (coarse < ([1e-6, 2e-3, 2e-2] if gas == "none" else [2e-6, 3e-5, 8e-5])).all()
    rates = np.log2(coarse / fine)
    exact_at_first = (kappa, gas) == (2, "centre")  # an error of the second one passes through 0
    assert np.delete(rates, 1 if exact_at_first else []).min() > 3.7
    most = [1e-10, 2e-7, 1e-5] if gas == "none" else [2e-9] * 3
    assert (mode_errors(kappa, gas, 6, 0.0125) < most).all()
    if gas != "none":
        assert mode_errors(kappa, gas, 8, 0.01875).max() < 2e-9
        assert 1e-3 < mode_errors(kappa, gas, 2, 0.0375).max() < 1e-2


@KAPPA
def test_order_of_6_3_with_gas_to_the_centre(kappa):
    """Measured: 6.4, 6.5 and 7.1, 6.7; around an axis with the weights of a plane 3.1 and 2.0. The
    first mode is left out: its error is round-off.
    """
    coarse, fine = (mode_errors(kappa, "centre", 6, h)[1:] for h in (0.025, 0.0125))
    assert np.log2(coarse / fine).min() > 6.0


#: frequencies of the first two radial modes of a free ball of steel
OF_BALL = 3.53236207, 8.05894403


def modes_of_a_ball(order, cells):
    """Errors of these, over the frequencies, and the longest step of RK4 over that at a Courant
    number of 1.
    """
    body = Block("ball", STEEL, ball(1.0, cells), (cells,), at_rest())
    faces = {("ball", 0, 0): Centre(), ("ball", 0, 1): Free()}
    problem = BlockProblem((body,), faces, symmetry=2)
    with BlockState(MPI.COMM_SELF, problem, order, BlockForm()) as state:
        longest = step_limit(linear_modes(state, 1, 0)[0])
        state.finish()
        longest *= state.results[RATE]
    medium = Medium(0.0, 1.0, 2.0, 1.5, 1.0, kappa=2)
    exact = [mode_near((medium,), 0, 1.01 * omega) for omega in OF_BALL]
    assert np.abs(exact - np.array(OF_BALL)).max() < 1e-7
    return np.abs(radial_modes(problem, order)[:2] / exact - 1.0), longest


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_modes_of_a_ball(order):
    (coarse, longest), (fine, _) = (modes_of_a_ball(order, n) for n in (20, 40))
    assert longest > 1.05
    assert fine.max() < (1.5e-3 if order == 2 else 1e-6)
    assert np.log2(coarse[0] / fine[0]) > min(order, 5) - 0.1


def test_the_command_writes_the_modes(tmp_path):
    found, exact = modes_of(tmp_path, "-shell_gas none -fsi_order 6 -modes_count 3", "shell")
    assert exact[:2] == pytest.approx([1.6872611834362685, 13.964942938841924], abs=1e-9)
    assert found == pytest.approx(exact, rel=1e-5)
    done = solve("modes", "rod", cwd=tmp_path)
    message(done, 2, "the command modes knows the cases ring and shell")


def test_a_charge_in_a_shell(tmp_path):
    """A strong blast to the centre: the same bits on any ranks, mass and energy stay, entropy falls
    in no step, and the shell is driven outwards.
    """
    words = "shell -shell_kappa 2 -shell_charge 200 -fsi_h 0.025 -ts_max_time 0.6"
    words = f"{words} -fsi_output_dt 0.3".split()
    two, three = (computed(tmp_path, f"{n}.h5", *words, ranks=n) for n in (2, 3))
    assert_same_fields(two, three)
    series = two.series
    assert np.abs(series["mass"] / series["mass"][0] - 1.0).max() < 1e-13
    # the pressure at which the shell is free of strain stands on its faces as a load
    energy = series["energy"] - np.cumsum(series["energy_in"])
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-13
    entropy = series["entropy"]
    assert np.diff(entropy).min() > -1e-14 * np.abs(entropy).max()
    assert entropy[-1] > entropy[0]
    assert (two.layers[1]["x"][-1] > two.layers[1]["x"][0] + 0.02).all()


def test_a_shock_in_a_nozzle(tmp_path):
    """In (z, r): the same bits on two and four ranks; mass, energy and the momentum along the
    axis are what they were and what came in; the wall swells.
    """
    words = "nozzle -fsi_h 0.1 -ts_max_time 0.5 -fsi_output_dt 0.25".split()
    two, four = (computed(tmp_path, f"{n}.h5", *words, ranks=n) for n in (2, 4))
    assert_same_fields(two, four)
    series = two.series
    for name, came in (("energy", "energy_in"), ("momentum_x", "impulse_x")):
        left = series[name] - np.cumsum(series[came])
        assert np.abs(left - left[0]).max() < 1e-13 * np.abs(series[name]).max(), name
    mass = series["mass"] - np.cumsum(series["mass_in"], axis=0)
    assert np.abs(mass / mass[0] - 1.0).max() < 1e-13
    assert two.layers[1]["y"][-1].max() > two.layers[1]["y"][0].max() + 1e-4


UNIT, SHIFTED = rectangle((0, 0), (1, 1)), rectangle((0, 1), (1, 2))
ASLANT = off_axis(lambda xi: (xi[0] + 2 * xi[1], xi[1]), 12)
#: map, symmetry, conditions below and above the last coordinate, words; the gas is a solid if said
WRONG = [
    (ball(1.0, 12), 0, Centre(), Slip(), ""),
    (rectangle(0.0, 1.0), 2, Centre(), Slip(), ""),
    (rectangle(-0.5, 1.0), 2, Slip(), Slip(), ""),
    (rectangle(0.1, 1.0), 2, Centre(), Slip(), ""),
    (rectangle(0.5, 1.0), 2, Slip(), Centre(), ""),
    (ball(1.0, 12), 3, Centre(), Slip(), ""),
    (ball(1.0, 12), 1, Centre(), Free(), "a solid cannot reach an axis"),
    (UNIT, 1, Slip(), Slip(), "a node is at (X, Y) = (0, 0): expected r > 0"),
    (SHIFTED, 2, Slip(), Slip(), "symmetry is 2 in 2 dimensions: expected 0, 1 in"),
    (SHIFTED, 1, Centre(), Slip(), "at (X, Y) = (0, 1) and (X, Y)"),
    (ASLANT, 1, Centre(), Slip(), "expected half a spacing"),
]


@pytest.mark.parametrize(("map_", "symmetry", "below", "above", "said"), WRONG)
def test_mistakes(map_, symmetry, below, above, said):
    """A centre without symmetry, at a node, at another side; nodes on the axis or beyond it."""
    cells = (12,) * (2 if map_ in (UNIT, SHIFTED, ASLANT) else 1)
    start = at_rest() if "solid" in said else lambda *X: (1.0, *(0.0 * x for x in X), 1.0)
    material = STEEL if "solid" in said else Fluid(0.0, 0.0, 1.4, 1.0)
    faces = {("it", axis, side): Slip() for axis in range(len(cells)) for side in (0, 1)}
    faces |= {("it", len(cells) - 1, 0): below, ("it", len(cells) - 1, 1): above}
    block = Block("it", material, map_, cells, start)
    with pytest.raises(InputError) as raised:
        BlockProblem((block,), faces, symmetry=symmetry)
    assert said in str(raised.value)
