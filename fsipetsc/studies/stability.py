"""The command `python -m fsipetsc stability`: the paper's linear theory, checked.

It ends with status 3 where the interface treatment does not keep what it promises. `energy` and
`conservative` promise that the energy never grows (Theorem 4.1), that no mode grows and that the
steps of a run are stable; the others promise the last two.

The solver's own right-hand side is linearised about a constant state, a solid beside a gas at rest.
Disturbances obey (4.2), of (rho, u, T) in the gas and (u, e, T) in the solid, e = S/K^ the strain.
S = sigma - x_X' dp_s/dx_X stands for stress and strain, which act as this sum alone: with x_t = u
it obeys S_t = K^ u_X, K^ = (K - x_X dp_s/dx_X)/x_X, and what is left, K x_X'/x_X - sigma, never
changes. With the conservative coupling the unknown is the displacement, and e its derivative.

The energy E = h sum_j a_j (W q^2)_j has the weights of fsipetsc.paper.coupling. In it the equations
are symmetric but for a part of alpha m0 T_t = ... + sigma^ u_X. That part, the heat that a stress
sigma^ != 0 sets free, is left out.

The layers are longer than the n points next to the interface that are disturbed, and rates are
projected on these, orthogonally in E. So what the outer ends do is not seen: they neither add nor
take energy, and growth comes from the interface or from the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import orth

from fsipetsc import Fluid, FluidLayer, Problem, Solid, SolidLayer, Wall, clamped
from fsipetsc.cases import case_of
from fsipetsc.cases.common import constant, gas_of, materials, solid_of
from fsipetsc.checks import Array
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import Option, defaults, read_table
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm
from fsipetsc.scheme.plan import RATE
from fsipetsc.studies.tables import csv_target, listed_in, printer, save_csv, shared, text_table

#: displacements of 1 that strain the solid by less, over h, are left out: 8/4 has one at its end,
#: which stores next to no energy
UNSEEN = 1e-2
#: step of the numerical differentiation, relative to the size of each variable
STEP = 2.0**-7
#: growth over the largest |lambda| that counts as round-off: of the energy, of a mode (an
#: eigenvalue of a matrix that is not normal is less certain)
ENERGY_TOLERANCE, MODE_TOLERANCE = 1e-10, 1e-9

ORDERS = (2, 4, 6, 8)
THEORY = {
    "conservative": "the end points are one particle; mass, momentum and energy are kept",
    "energy": "orthogonal projection, all four conditions at once (Theorem 4.1)",
    "projection": "temperatures first, then u, sigma, rho (Theorem 4.2)",
    "traditional": "the solid moves the fluid, the fluid loads the solid",
}
_DENSITIES = "m0 over the density of the gas, instead of -solid_density; alpha m0 keeps its value"
_STIFFNESSES = "K over the pressure of the gas, instead of -solid_modulus"
_EOS = "pressure p = G rho epsilon that balances the gas, or none: sigma = -p of the gas"
_POWERS = tuple(10.0**k for k in range(-3, 4))
_ABOVE = {"check": "positive"}
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Gas": (
        Option("fluid_rho", float, 1.0, "kg/m3", "density of the gas at rest", **_ABOVE),
        Option("fluid_T", float, 1.0, "K", "temperature, of the solid too", **_ABOVE),
        *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, fluid_R=1.0),
    ),
    "Solid": (
        *materials(solid_density=1.0, solid_modulus=1.0, solid_alpha=2.5, solid_kappa=0.02),
        Option("solid_eos", str, "ideal", "", _EOS, ("ideal", "elastic")),
    ),
    "Discretisation": (
        Option("fsi_coupling", str, "energy", "", "treatment of the interface", tuple(THEORY)),
        Option("fsi_viscous", str, "wide", "", "D twice, or narrow ones", ("wide", "narrow")),
        Option("fsi_orders", "ints", ORDERS, "", "interior orders", check=listed_in(ORDERS)),
        Option("fsi_h", float, 0.03125, "m", "grid spacing", **_ABOVE),
        Option("stability_points", int, 32, "", "points of each of the two layers", **_ABOVE),
    ),
    "Sweep": (
        Option("sweep", bool, False, "", "all combinations of the ratios below"),
        Option("density_ratios", "floats", _POWERS, "", _DENSITIES, **_ABOVE),
        Option("stiffness_ratios", "floats", _POWERS[1:-1], "", _STIFFNESSES, **_ABOVE),
    ),
    "Output": (
        Option("fsi_output", str, None, "", "table of a sweep, without suffix"),
        Option("fsi_quiet", bool, False, "", "print nothing but errors"),
    ),
}


def stability(arguments: list[str], comm: Comm) -> None:
    """Run the command; the ranks of comm share a sweep. Collective; InputError; ComputationError if
    a promise is not kept."""
    opt = read_table(SECTIONS, start_petsc(arguments, comm))
    for op in map(operator, opt["fsi_orders"]):
        if (points := opt["stability_points"]) < (least := max(4, op.min_points)):
            raise InputError(f"-stability_points {points}: the {op.name} operator needs {least}")
    state, ratios = of_options(opt), product(opt["density_ratios"], opt["stiffness_ratios"])
    states = [state.swept(*both) for both in ratios] if opt["sweep"] else [state]
    coupling, narrow = opt["fsi_coupling"], opt["fsi_viscous"] == "narrow"
    how = opt["stability_points"], opt["fsi_h"], coupling, narrow
    name = opt["fsi_output"] or f"stability-{coupling}"
    path = csv_target(name) if opt["sweep"] else None
    tasks, say = list(product(opt["fsi_orders"], states)), printer(comm, opt)
    results = shared(comm, tasks, lambda task: measure(task[1], task[0], *how))
    say(f"stability of {coupling}: {THEORY[coupling]}\nsolid | gas at rest, linearised (4.2)")
    say(f"gas    p {state.p:g} Pa; solid  p {state.solid_pressure:g} Pa, sigma {state.stress:g} Pa")
    say(f"\n{table(results)}\n")
    if path is not None:
        save_csv(comm, path, results[0]._fields, results)
        say(f"saved {path}")
    judge(results)


def table(results: Sequence[Result]) -> str:
    """For each order in how many combinations all is well, and the worst."""
    head = ["order", "of", "no mode\ngrows", "growth\n[|lambda|]", "energy never\ngrows"]
    head += ["its growth\n[|lambda|]", "step of a\nrun stable", "least RK4\nover it", "in s"]
    rows = []
    for order in dict.fromkeys(r.order for r in results):
        own = [r for r in results if r.order == order]
        row = [operator(order).name, len(own)]
        row += [sum(r.stable for r in own), f"{max(r.growth for r in own):.1e}"]
        row += [sum(r.estimate for r in own), f"{max(r.energy for r in own):.1e}"]
        row += [sum(r.step_kept for r in own), f"{min(r.step_ratio for r in own):.4f}"]
        rows.append([*row, f"{min(r.step for r in own):.4g}"])
    return text_table(head, rows)


def judge(results: Sequence[Result]) -> None:
    """Raise ComputationError, which names the worst, if a result does not keep what its treatment
    promises."""
    promised = {"a mode grows": "stable", "the step of a run is too long": "step_kept"}
    if results[0].coupling in ("conservative", "energy"):
        promised["the energy grows"] = "estimate"
    counts = {what: sum(not getattr(r, name) for r in results) for what, name in promised.items()}
    broken = [r for r in results if not all(getattr(r, name) for name in promised.values())]
    if broken:
        worst = max(broken, key=lambda r: (not r.stable, -r.step_ratio if r.stable else r.growth))
        faults = ", ".join(f"{fault} in {count}" for fault, count in counts.items() if count)
        raise ComputationError(
            f"{worst.coupling} fails in {len(broken)} of {len(results)}: {faults}; the worst is "
            f"order {worst.order}, m0/rho = {worst.density_ratio:g}, K/p = "
            f"{worst.stiffness_ratio:g}: growth {worst.growth:.2g} |lambda|, stable step "
            f"{worst.step_ratio:.2g} of that of a run"
        )


@dataclass(frozen=True)
class Constant:
    """A perfect gas of density rho [kg/m3] and temperature T [K] at rest on a solid of the same
    temperature and the uniform strain x_X = stretch; the solid's pressure p_s is Grüneisen's or 0.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float
    stretch: float = 1.0

    @property
    def p(self) -> float:
        """Pressure of the gas [Pa]."""
        return self.rho * self.gas.R * self.T

    @property
    def solid_pressure(self) -> float:
        """p_s of the solid [Pa]; proportional to T / x_X."""
        return float(self.solid.pressure(self.T, self.stretch))

    @property
    def stress(self) -> float:
        """sigma = p_s - p, which balances the gas [Pa]."""
        difference = self.solid_pressure - self.p
        return difference if abs(difference) > 1e-12 * self.p else 0.0

    @property
    def modulus(self) -> float:
        """K^ = (K - x_X dp_s/dx_X) / x_X [Pa]."""
        return (self.solid.K + self.solid_pressure) / self.stretch

    def at_rest(self, X: Array) -> list[Array]:
        """Return (u, sigma, T, x) of the solid."""
        return [0.0 * X, self.stress + 0.0 * X, self.T + 0.0 * X, self.stretch * X]

    def swept(self, density_ratio: float, stiffness_ratio: float) -> Constant:
        """The same with another density and stiffness of the solid; alpha m0 keeps its value, and
        so do the pressures."""
        solid, m0 = self.solid, density_ratio * self.rho
        other = replace(solid, m0=m0, K=stiffness_ratio * self.p, alpha=solid.alpha * solid.m0 / m0)
        return replace(self, solid=other)


def of_options(opt: Mapping[str, Any]) -> Constant:
    """Return the state that the options describe."""
    gas, solid, rho = gas_of(opt), solid_of(opt), opt["fluid_rho"]
    if opt["solid_eos"] == "ideal":  # p_s = p, sigma = 0
        solid = replace(solid, gruneisen=gas.R * rho / (solid.m0 * solid.alpha))
    return Constant(gas, solid, rho, opt["fluid_T"])


class Result(NamedTuple):
    """Numbers of one problem. Rates of growth are over the largest |lambda|.

    energy, growth: those of the energy and of the fastest mode. step: that RK4 can take [s],
    step_ratio: over that of a run with the default of -fsi_cfl. estimate, stable, step_kept: the
    energy does not grow, no mode does, and the step of a run is not too long.
    """

    order: int
    coupling: str
    density_ratio: float
    stiffness_ratio: float
    energy: float
    growth: float
    step: float
    step_ratio: float
    estimate: bool
    stable: bool
    step_kept: bool


def measure(
    state: Constant, order: int, n: int, h: float, coupling: str, narrow: bool = False
) -> Result:
    """All numbers for disturbances of n points of spacing h [m] in each layer; narrow: with narrow
    second derivatives. InputError where the coupling has none.

    What the conditions make of q is P q, and L q are the rates of that. w = root q has the energy
    w^T w / 2; Z is an orthonormal basis of the w that are disturbed and fulfil the conditions, B
    are their q. The modes are the eigenvalues of A = Z^T root P L B, and the energy grows at most
    by the largest one of its symmetric part.
    """
    from fsipetsc.studies.linear import step_limit

    op, solid, conservative = operator(order), state.solid, coupling == "conservative"
    N = n + 3 * op.rows  # outer ends do not reach what is disturbed
    near = np.concatenate([np.arange(n) + k * N + (N - n) * (k > 2) for k in range(6)])
    gas_weights = state.p / state.rho**2, state.rho, state.rho * state.gas.cv / state.T
    weights = np.array([*gas_weights, solid.m0, state.modulus, solid.alpha * solid.m0 / state.T])
    limits = state.rho, np.inf, state.T, np.inf, 1.0, state.T
    sizes = np.minimum(np.sqrt(state.p / weights), limits)
    sizes[4] *= h if conservative else 1.0
    L, P, run_step = derivatives_near(near, sizes, state, order, N, h, coupling, narrow)
    strain, heat = slice(4 * N, 5 * N), slice(5 * N, 6 * N)
    D = op.matrix(N, h) if conservative else np.eye(N)
    set_free = state.stress / (solid.alpha * solid.m0) * sizes[4] / sizes[5]
    L[heat] -= set_free * D @ L[strain]
    L[near] = P[near] @ L[near]
    root = np.diag(np.outer(sizes * np.sqrt(weights), np.sqrt(h * op.norm_weights(N))).ravel())
    root[strain, strain] = root[strain, strain] @ D
    seen = np.eye(6 * n)
    if conservative:
        stretched, V = np.linalg.svd(D[:, N - n :])[1:]
        seen[4 * n : 5 * n, 4 * n : 5 * n] = V.T * (stretched * h > UNSEEN)
    basis = orth(P[near] @ seen, rcond=1e-9)
    Z, R = np.linalg.qr(root[:, near] @ basis)
    A = Z.T @ root @ L @ basis @ np.linalg.inv(R)
    energy, spectrum = float(np.linalg.eigvalsh((A + A.T) / 2).max()), np.linalg.eigvals(A)
    radius, step = float(np.abs(spectrum).max()), step_limit(spectrum)
    growth = float(spectrum.real.max()) / radius
    return Result(
        order=order,
        coupling=coupling,
        density_ratio=solid.m0 / state.rho,
        stiffness_ratio=solid.K / state.p,
        energy=energy / radius,
        growth=growth,
        step=step,
        step_ratio=step / run_step,
        estimate=energy <= ENERGY_TOLERANCE * radius,
        stable=growth <= MODE_TOLERANCE,
        step_kept=step >= run_step,
    )


def derivatives_near(
    near: Any,
    sizes: Array,
    state: Constant,
    order: int,
    N: int,
    h: float,
    coupling: str,
    narrow: bool,
) -> tuple[Array, Array, float]:
    """(rates, completed unknowns, step of a run [s]) of layers of N points: derivatives of the six
    unknowns of all points, over their sizes, by those of the points ``near``, (6N, 6n)."""
    from mpi4py import MPI

    from fsipetsc.stepping.solve import build_problem, make_state
    from fsipetsc.studies.linear import derivatives

    gas, solid, conservative = state.gas, state.solid, coupling == "conservative"
    end, still = (N - 1) * h, constant(state.rho, 0.0, state.T)
    layers = (
        SolidLayer("solid", solid, (-end, 0.0), state.at_rest),
        FluidLayer("gas", gas, (0.0, end), still),
    )
    case = case_of(Problem(layers, clamped(), Wall(end), units="none"), fsi_h=h, ts_max_time=1.0)
    own = {"fsi_order": order, "fsi_coupling": coupling}
    opt = {**defaults(case), **own, "fsi_viscous": "narrow" if narrow else "wide"}
    with make_state(build_problem(case, opt, MPI.COMM_SELF), opt, MPI.COMM_SELF) as run:
        run.set_initial()
        run.finish()
        y = run.y.array if conservative else run.y
        start, f, step = y.copy(), np.empty_like(y), opt["fsi_cfl"] / float(run.results[RATE])

        def sides(array: Array) -> tuple[Array, Array]:
            """Return the points of gas and solid, from left to right."""
            if conservative:
                return run.layout.owned(1, array), run.layout.owned(0, array)
            return run.layers[1].of(array)[:N], run.layers[0].of(array)

        # from rho, rho u, rho (cv T + u^2/2) to rho, u, T; from u, sigma, T, x to u, e, T
        of_gas = np.diag([1.0, 1.0 / state.rho, 1.0 / (state.rho * gas.cv)])
        of_gas[2, 0] = -state.T / state.rho
        to_gas = np.linalg.inv(of_gas)
        of_solid, of_rates = np.eye(3, 4), np.eye(3, 4)
        of_solid[1, 1], of_rates[1, 1] = 1.0 / state.modulus, state.stretch / solid.K
        if conservative:  # from J, J rho, J rho u, …; from x - X, u, alpha T + u^2/2 to u, x - X, T
            J, rho, _, heat = sides(start)[0][0]
            of_gas = of_gas @ np.column_stack([[-rho / J, 0.0, -heat / J], np.eye(3)]) / J
            to_gas = J * np.vstack([np.zeros(3), to_gas])
            of_solid = of_rates = np.diag([1.0, 1.0, 1.0 / solid.alpha])[[1, 0, 2]]
        to = *(to_gas * sizes[:3]).T, *(np.linalg.pinv(of_solid) * sizes[3:]).T

        def disturbed(i: int, change: float) -> Array:
            """Return rates and completed unknowns, (2, 6N)."""
            y, (k, point) = start.copy(), divmod(int(near[i]), N)
            sides(y)[k // 3][point] += change * to[k]
            run.right_hand_side(y, f)
            run.project(y)
            (gas_t, solid_t), (in_gas, in_solid) = sides(f), sides(y)
            rates = of_gas @ gas_t.T, of_rates @ solid_t.T
            return np.array([[*rates], [of_gas @ in_gas.T, of_solid @ in_solid.T]]).reshape(2, -1)

        found = derivatives(disturbed, np.full(len(near), STEP)) / np.repeat(sizes, N)[:, None]
    return (*found, step)
