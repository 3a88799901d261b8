"""Two dimensions: what the rates of any state keep, whatever the order, the density ratio and the motion of the grid.

Smooth random states, gas | solid, periodic in X, 16 x 17 points each, the grid curved and moving with the interface.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from fsipetsc.boundaries.plane import Clamped, NoSlip, Open, Periodic, Slip
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.plane.grids import make_grids
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer
from fsipetsc.scheme.plane.equations import USUAL, PlaneForm, equations_of
from fsipetsc.stepping.plane.edge_data import EdgeData
from fsipetsc.stepping.plane.path import PlanePath

N = 16
ORDERS = sorted(OPERATORS)
TINY = 1e-30


def smooth(seed, X, Y):
    """A sum of waves of random phases, of the size of 1."""
    rng, total = np.random.default_rng(seed), 0.0
    for k in range(3):
        for m in range(3):
            a, b, c = rng.uniform(-1, 1, 3)
            total = total + a * np.cos(2 * np.pi * k * X + 6 * b) * np.cos(2 * m * Y + 6 * c) / (1 + k + m)
    return total


def problem(mu, kappa, m0, heat="coupled", lower=None):
    """gas | solid, walls below and above."""
    gas = Fluid(mu, kappa, 1.4, 1.0)
    solid = PlaneSolid(1.0, 2.0, 0.05, m0, 1.5, heat=heat)
    return PlaneProblem(
        layers=(
            PlaneFluidLayer("gas", gas, (0.0, 1.0), lambda X, Y: (1 + 0 * X, 0 * X, 0 * X, 1 + 0 * X)),
            PlaneSolidLayer("solid", solid, (1.0, 2.0), lambda X, Y: (0 * X, 0 * X, 1 + 0 * X, X, Y)),
        ),
        X=(0.0, 1.0),
        lower=lower or NoSlip(),
        upper=Clamped(),
        units="none",
    )


class Rates:
    """A random state that fulfils all conditions (y), its rates (f), and the norms of both layers.

    rough: noise that is added; size: of the waves.
    """

    def __init__(self, case, order, form=USUAL, rough=0.0, size=1.0):
        op = OPERATORS[order]
        self.case, self.layout = case, PlaneLayout(MPI.COMM_SELF, case, op, make_grids(case, op, 1 / N))
        self.path = PlanePath(self.layout, order, EdgeData(self.layout), form)
        self.y, self.f = np.zeros(self.layout.local_size), np.zeros(self.layout.local_size)
        self.gas, self.solid = (self.layout.local(k, self.y) for k in range(2))
        self._fill(rough, size)
        self.path.project(self.y, 0.0)
        self.path.rates(self.y, self.f, 0.0)
        self.gas_rates, self.solid_rates = (self.layout.local(k, self.f) for k in range(2))
        self.norms = [op.norm_weights(g.ny)[:, None] * g.h_x * g.h_y for g in self.layout.grids]

    def _fill(self, rough, size):
        X, Y = self.layout.grids[0].points(*self.layout.owned(0))
        waves = [size * smooth(seed, X, Y) for seed in range(5)]
        noise = rough * np.random.default_rng(7).uniform(-1, 1, (5, *X.shape))
        rho, T, J = 1 + 0.2 * waves[0] + noise[0], 1 + 0.2 * waves[1] + noise[1], 1 + 0.2 * waves[2]
        u, v = 0.5 * waves[3] + noise[2], 0.5 * waves[4] + noise[3]
        for c, value in enumerate((1.0, rho, rho * u, rho * v, rho * (2.5 * T + 0.5 * (u * u + v * v)))):
            self.gas[..., c] = J * value
        X, Y = self.layout.grids[1].points(*self.layout.owned(1))
        for c, part in enumerate((0.03, 0.03, 0.3, 0.3, 0.2)):
            self.solid[..., c] = (c == 4) + size * part * smooth(10 + c, X, Y) + (rough if c > 1 else 0.0) * noise[c]
        m0 = self.case.layers[1].material.m0
        self.layout.energies(0, self.y)[:] = 0.5 * m0 * (self.solid[0, :, 2] ** 2 + self.solid[0, :, 3] ** 2)

    def close(self):
        self.path.destroy()
        self.layout.destroy()

    def mass(self):
        return self.norms[0] * self.gas_rates[..., 1]

    def energy(self):
        """Of gas, and of the solid: kinetic, heat and, where heat is without its work, elastic."""
        material, q, f = self.case.layers[1].material, self.solid, self.solid_rates
        parts = material.m0 * (q[..., 2] * f[..., 2] + q[..., 3] * f[..., 3]), material.m0 * material.alpha * f[..., 4]
        if material.heat == "elastic":
            parts = *parts, self.stress_power()
        return np.array([(self.norms[0] * self.gas_rates[..., 4]).sum(), *((self.norms[1] * p).sum() for p in parts)])

    def stress_power(self):
        """P : D v."""
        op, grid = self.layout_operator(), self.layout.grids[1]
        D = op.matrix(grid.ny, grid.h_y)
        wave = np.zeros(grid.nx)
        wave[1 : op.p + 1], wave[-op.p :] = [float(w) for w in op.interior], [-float(w) for w in op.interior[::-1]]
        C = np.array([np.roll(wave, i) for i in range(grid.nx)]) / grid.h_x
        x, y, u, v = (self.solid[..., c] for c in range(4))
        P = self.case.layers[1].material.stress((1 + x @ C.T, D @ x, y @ C.T, 1 + D @ y))
        return P[0] * (u @ C.T) + P[1] * (D @ u) + P[2] * (v @ C.T) + P[3] * (D @ v)

    def layout_operator(self):
        return OPERATORS[2 * (self.layout.halo // 2)]

    def entropy(self):
        """d/dt of J rho s at each point of the gas, by a step into the complex plane."""
        J, r, m, n, e = (self.gas + 1j * TINY * self.gas_rates)[..., :].transpose(2, 0, 1)
        rho, T = r / J, (e - 0.5 * (m * m + n * n) / r) / (2.5 * r)
        return self.norms[0] * (r * (2.5 * np.log(T) - np.log(rho))).imag / TINY


def relative(terms):
    return terms.sum() / np.abs(terms).sum()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(("m0", "heat"), [(0.01, "coupled"), (1.0, "elastic"), (50.0, "coupled")])
def test_two_point_form_keeps_mass_energy_and_entropy(order, m0, heat):
    state = Rates(problem(0.0, 0.0, m0, heat), order)
    assert np.abs(state.gas_rates).max() > 1.0  # or it would be no test
    assert abs(relative(state.mass())) < 1e-13
    assert abs(relative(state.energy())) < 1e-13
    assert abs(relative(state.entropy())) < 1e-12
    state.close()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(("m0", "heat"), [(0.01, "elastic"), (50.0, "coupled")])
def test_friction_and_conduction_produce_entropy(order, m0, heat):
    state = Rates(problem(0.02, 0.03, m0, heat), order)
    assert abs(relative(state.mass())) < 1e-13
    assert abs(relative(state.energy())) < 1e-13
    assert relative(state.entropy()) > 1e-3
    state.close()


def test_divergence_form_keeps_mass_and_energy():
    state = Rates(problem(0.0, 0.0, 1.0), 4, PlaneForm("divergence"))
    assert abs(relative(state.mass())) < 1e-13
    assert abs(relative(state.energy())) < 1e-13
    assert abs(relative(state.entropy())) > 1e-6  # not this one
    state.close()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(("mu", "heat"), [(0.0, "elastic"), (0.0, "coupled"), (0.02, "coupled")])
def test_slip_and_conduction(order, mu, heat):
    """Gas that slips along the solid and conducts into it, or sticks to it; all that it meets besides slips."""
    state = Rates(problem(mu, 0.03, 3.0, heat, Slip()), order)
    assert abs(relative(state.mass())) < 1e-13
    assert abs(relative(state.energy())) < 1e-13
    assert relative(state.entropy()) > 1e-4
    gap = np.abs(state.gas[-1, :, 2] / state.gas[-1, :, 1] - state.solid[0, :, 2]).max()
    assert gap > 0.1 if mu == 0.0 else gap < 1e-14
    state.close()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("convection", ["entropy", "divergence"])
@pytest.mark.parametrize("sides", [Periodic(), Open(1.3, 0.7, -0.4, 0.9)], ids=["periodic", "open"])
def test_a_uniform_flow_stays(order, convection, sides):
    """On a grid whose lines bend and move, in all rows and columns: the same flow stands beyond its edges. Without that the end
    rows would lack the flux through the edge, as the sweep leaves it out (fsipetsc.scheme.plane.edges).
    """
    rho, u, v, T = flow = 1.3, 0.7, -0.4, 0.9
    gas = PlaneFluidLayer("gas", Fluid(0.0, 0.0, 1.4, 1.0), (0.0, 1.0), lambda X, Y: np.ones((4, *X.shape)), sides, sides)
    case, op = PlaneProblem((gas,), (0.0, 1.0), Open(*flow), Open(*flow)), OPERATORS[order]
    layout = PlaneLayout(MPI.COMM_SELF, case, op, make_grids(case, op, 1 / 20))
    path = PlanePath(layout, order, EdgeData(layout), PlaneForm(convection))
    part = path.part(0)
    uniform = np.array([1.0, rho, rho * u, rho * v, rho * (2.5 * T + 0.5 * (u * u + v * v))])
    X = 2 * np.pi * (np.arange(part.held.shape[1]) - part.record["own_x"][0]) / 20
    part.held[...] = (1 + 0.2 * np.cos(X))[:, None] * uniform
    part._lines[0] = 0.05 * np.sin(X), 0.1 * np.cos(X), 0.4 * np.cos(X), np.sin(X)
    part._lines[1] = 0.04 * np.cos(X), 1 + 0.1 * np.sin(X), -0.5 * np.sin(2 * X), 0.6 * np.cos(X)
    part.evaluate(0.0)
    rates = part._rates.reshape(part.own.shape)
    assert np.abs(rates[..., 0]).max() > 1.0
    assert np.abs(rates - rates[..., :1] * uniform).max() < 1e-13 * np.abs(rates).max()
    path.destroy()
    layout.destroy()


def test_a_gas_with_a_law_of_its_own_has_no_two_point_form():
    case = problem(0.0, 0.0, 1.0)
    gas = Fluid(0.0, 0.0, 1.4, 1.0, law=Formulas(**vars(perfect_gas)))
    layer = PlaneFluidLayer("argon", gas, (0.0, 1.0), case.layers[0].initial)
    with pytest.raises(InputError, match=r"argon.*-fsi_convection divergence"):
        equations_of(layer, PlaneForm())
    assert equations_of(layer, PlaneForm("divergence")).sums == ()


@pytest.mark.long
@pytest.mark.parametrize(
    ("order", "form", "friction"),
    [
        *((order, PlaneForm(dissipation=0.3), 0.02) for order in ORDERS),
    ],
)
def test_dissipation_produces_entropy_alone(order, form, friction):
    """Of a state that is not smooth; in the solid what is lost of the motion becomes heat. Friction is left as it is."""
    for m0, heat in ((0.01, "elastic"), (50.0, "coupled")):
        plain = PlaneForm(form.convection)
        states = [Rates(problem(friction, 0.0, m0, heat), order, f, rough=0.1) for f in (plain, form)]
        for state in states:
            assert abs(relative(state.mass())) < 1e-13
            assert abs(relative(state.energy())) < 1e-13
        without, with_it = states
        assert with_it.entropy().sum() > without.entropy().sum() + 1e-3
        warmer = (with_it.solid_rates - without.solid_rates)[..., 4]
        assert warmer.min() >= -1e-12 and (form.shocks > 0.0 or warmer.max() > 1e-6)
        for state in states:
            state.close()
