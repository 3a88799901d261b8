"""The command `stability`: whether couplings keep what docs/couplings.md promises (Theorem 4.1).

The solver's own right-hand side is linearised about a solid beside a gas at rest, whose density,
temperature and pressure are 1. Disturbances obey (4.2), of (rho, u, T) in the gas and (u, e, T) in
the solid. The strain is e = S/K^, where K^ = K + p_s and S = sigma - x_X' dp_s/dx_X stands for
stress and strain, which act as this sum alone. With the conservative coupling the unknown is the
displacement, and e its derivative. The heat that a stress sigma^ != 0 sets free in alpha m0 T_t =
... + sigma^ u_X is left out: without it the equations are symmetric in the energy E = h sum_j a_j
(W q^2)_j, which has the weights of fsipetsc.paper.coupling.

Layers are longer than the n points next to the interface that are disturbed, and rates are
projected on these, orthogonally in E. So outer ends neither add nor take energy.

What the conditions make of q is P q, and L q are the rates of that. w = root q has the energy
w^T w / 2; Z is an orthonormal basis of the w that are disturbed and fulfil the conditions, B are
their q. The modes are the eigenvalues of A = Z^T root P L B, and the energy grows at most by the
largest one of its symmetric part.
"""

from collections.abc import Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import orth

from fsipetsc import ComputationError, Fluid, FluidLayer, Problem, Solid, SolidLayer, Wall, clamped
from fsipetsc.cases import case_of
from fsipetsc.cases.common import constant, gas_of, line_at_rest, materials
from fsipetsc.checks import Array
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import Option, defaults
from fsipetsc.process.together import Comm
from fsipetsc.scheme.plan import RATE
from fsipetsc.studies.modes import NUDGE, alone, derivatives, step_limit
from fsipetsc.studies.trials import USUAL, Study

#: growth over the largest |lambda| that counts as round-off: of the energy, of a mode (an
#: eigenvalue of a matrix that is not normal is less certain)
ENERGY_TOLERANCE, MODE_TOLERANCE = 1e-10, 1e-9
COUPLINGS, ORDERS = ("conservative", "energy", "projection", "traditional"), tuple(OPERATORS)
_ABOVE = {"check": "positive"}
OPTIONS = (
    *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4),
    *materials(solid_alpha=2.5, solid_kappa=0.02),
    Option("solid_eos", str, "ideal", "", "p = G rho epsilon, or p = 0", ("ideal", "elastic")),
    Option("density_ratios", "floats", (1.0,), "", "density of the solid over the gas's", **_ABOVE),
    Option("stiffness_ratios", "floats", (1.0,), "", "K over the gas's pressure", **_ABOVE),
    Option("fsi_coupling", str, "energy", "", "treatment of the interface", COUPLINGS),
    Option("fsi_viscous", str, "wide", "", "D twice, or narrow ones", ("wide", "narrow")),
    Option("fsi_orders", "ints", ORDERS, "", "interior orders", ORDERS),
    Option("fsi_h", float, 0.03125, "m", "grid spacing", **_ABOVE),
    Option("stability_points", int, 32, "", "points of each layer", check="above 15"),
    *USUAL,
)  # fmt: skip


def stability(arguments: list[str], comm: Comm) -> None:
    """Run the command. Collective, rank 0 computes; InputError; ComputationError if a promise is
    not kept."""
    study = Study(comm, arguments, OPTIONS, "stability")
    opt, coupling = study.opt, study.opt["fsi_coupling"]
    grid = opt["stability_points"], opt["fsi_h"]
    G = 1.0 / opt["solid_alpha"] if opt["solid_eos"] == "ideal" else 0.0

    def one(order: int, density: float, stiffness: float) -> Result:
        numbers = stiffness, opt["solid_kappa"], density, opt["solid_alpha"] / density
        solid = Solid(*numbers, gruneisen=G)
        return measure(gas_of(opt), solid, order, *grid, coupling, opt["fsi_viscous"])

    tasks = product(opt["fsi_orders"], opt["density_ratios"], opt["stiffness_ratios"])
    results = comm.bcast(study.on_first(lambda: [one(*task) for task in tasks]))
    study.say(f"{coupling}: solid | gas at rest, linearised: growth over the largest |lambda|")
    study.table(Result._fields, results, ".4g")
    most = ENERGY_TOLERANCE if coupling in ("conservative", "energy") else np.inf
    kept = [r.energy <= most and r.growth <= MODE_TOLERANCE and r.step_ratio >= 1 for r in results]
    broken = [result for result, fine in zip(results, kept) if not fine]
    if broken:
        said = f"{coupling} breaks its promise in {len(broken)} of {len(results)} rows"
        raise ComputationError(f"{said}, first at order {broken[0].order}; see {study.path}")


class Result(NamedTuple):
    """energy, growth: rates of the energy and of the fastest mode, over the largest |lambda|. step:
    that RK4 can take [s], step_ratio: over that of a run.
    """

    order: int
    density_ratio: float
    stiffness_ratio: float
    energy: float
    growth: float
    step: float
    step_ratio: float


def measure(
    gas: Fluid, solid: Solid, order: int, n: int, h: float, coupling: str, viscous: str = "wide"
) -> Result:
    """Disturb n points of spacing h [m] in each layer. The solid's pressure p_s is that of the gas,
    or 0. n: at least 16. InputError where the coupling has no such second derivatives.
    """
    op, conservative = OPERATORS[order], coupling == "conservative"
    N = n + 3 * op.rows  # outer ends do not reach what is disturbed
    p_s, capacity = round(float(solid.pressure(1.0, 1.0)), 12), solid.alpha * solid.m0
    weights = np.array([1.0, 1.0, gas.cv, solid.m0, solid.K + p_s, capacity])
    sizes = np.sqrt(1.0 / weights)
    sizes[4] = min(sizes[4], 1.0) * (h if conservative else 1.0)
    own = {"fsi_order": order, "fsi_coupling": coupling, "fsi_h": h, "fsi_viscous": viscous}
    L, P, run_step = derivatives_near(gas, solid, p_s, sizes, n, N, {**own, "ts_max_time": 1.0})
    near = np.concatenate([np.arange(n) + k * N + (N - n) * (k > 2) for k in range(6)])
    strain, heat = slice(4 * N, 5 * N), slice(5 * N, 6 * N)
    root = np.diag(np.outer(sizes * np.sqrt(weights), np.sqrt(h * op.norm_weights(N))).ravel())
    D, seen = np.eye(N), np.eye(6 * n)
    if conservative:
        D = op.matrix(N).astype(float) / h
        root[strain, strain] = root[strain, strain] @ D
        # without displacements of 1 that strain the solid by less than 0.01/h: 8/4 has one
        stretched, V = np.linalg.svd(D[:, N - n :])[1:]
        seen[4 * n : 5 * n, 4 * n : 5 * n] = V.T * (stretched * h > 1e-2)
    L[heat] -= (p_s - 1.0) / capacity * sizes[4] / sizes[5] * D @ L[strain]
    L[near] = P[near] @ L[near]
    basis = orth(P[near] @ seen, rcond=1e-9)
    Z, R = np.linalg.qr(root[:, near] @ basis)
    A = Z.T @ root @ L @ basis @ np.linalg.inv(R)
    spectrum = np.linalg.eigvals(A)
    radius, step = float(np.abs(spectrum).max()), step_limit(spectrum)
    energy = float(np.linalg.eigvalsh((A + A.T) / 2).max()) / radius
    growth = float(spectrum.real.max()) / radius
    return Result(order, solid.m0, solid.K, energy, growth, step, step / run_step)


def derivatives_near(
    gas: Fluid, solid: Solid, p_s: float, sizes: Array, n: int, N: int, own: Mapping[str, Any]
) -> tuple[Array, Array, float]:
    """(rates, completed unknowns, step of a run [s]) of layers of N points: derivatives of the six
    unknowns of all points, over their sizes, by those of the n next to the interface; own: options.
    """
    from mpi4py import MPI

    from fsipetsc.stepping.run import build_problem

    end = (N - 1) * own["fsi_h"]
    left = SolidLayer("solid", solid, (-end, 0.0), line_at_rest(p_s - 1.0, 1.0))
    layers = left, FluidLayer("gas", gas, (0.0, end), constant(1.0, 0.0, 1.0))
    case = case_of(Problem(layers, clamped(), Wall(end), units="none"), **own)
    opt = defaults(case)
    with alone(build_problem(case, opt, MPI.COMM_SELF), opt) as run:
        run.finish()
        step, start = opt["fsi_cfl"] / float(run.results[RATE]), run.solution.array
        numbers, J = np.arange(start.size), 1.0
        if opt["fsi_coupling"] == "conservative":
            in_gas, in_solid = run.layout.owned(1, numbers), run.layout.owned(0, numbers)
            J = start[in_gas[0, 0]]
            # from x - X, u, alpha T + u^2/2 to u, x - X, T
            of_solid = of_rates = np.diag([1.0, 1.0, 1.0 / solid.alpha])[[1, 0, 2]]
        else:
            in_gas, in_solid = run.layers[1].of(numbers).T[:N], run.layers[0].of(numbers).T
            # from u, sigma, T, x to u, e, T
            of_solid, of_rates = np.eye(3, 4), np.eye(3, 4)
            of_solid[1, 1], of_rates[1, 1] = 1.0 / (solid.K + p_s), 1.0 / solid.K
        # from J, unless it is 1 always, J rho, J rho u, J rho (cv T + u^2/2) to rho, u, T
        of_gas = np.array([[-1, 1, 0, 0], [0, 0, 1, 0], [0, -1, 0, 1 / gas.cv]]) / J
        of_gas = of_gas[:, -in_gas.shape[1] :]
        to = *np.linalg.inv(of_gas[:, -3:]).T, *np.linalg.pinv(of_solid).T
        each = zip([in_gas[:n, -3:]] * 3 + [in_solid[N - n :]] * 3, sizes, to)
        changes = ((at, NUDGE * size * change) for points, size, change in each for at in points)
        rates, kept = (of.toarray() / NUDGE for of in derivatives(run, changes))
    found = []
    for of, matrix in ((of_rates, rates), (of_solid, kept)):
        pairs = (of_gas, in_gas), (of, in_solid)
        parts = [np.tensordot(to_six, matrix[points], (1, 1)) for to_six, points in pairs]
        found.append(np.concatenate(parts).reshape(6 * N, -1) / np.repeat(sizes, N)[:, None])
    return (*found, step)
