"""The command `modes CASE`: small motions about a steady state, by the scheme
(fsipetsc.studies.linear).

Rings and shells at rest have frequencies that are known exactly, where the gas neither conducts
heat nor is viscous. Displacements grad phi + curl psi, proportional to exp(-i omega t), obey Lame's
equations with phi = f(k r) cos(n theta), k = omega / c_p, f a Bessel function, and psi likewise
with sin(n theta) and c_s. A gas is such a medium without shear: lambda = gamma p. It has no psi,
and slips. What is innermost and outermost is held if it is gas, and free if it is solid.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import newton
from scipy.special import jvp, spherical_jn, spherical_yn, yvp

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre
from fsipetsc.cases import case_after, options_after
from fsipetsc.checks import Array
from fsipetsc.options import Option
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.tables import Study

#: how far from where it begins a search may end, over omega; when it ends, and steps it may take
NEAR, CLOSE, STEPS = 0.03, 1e-12, 40
_AROUND = "angular number of a ring: waves around it"
_NEXT = "angular frequency next to which modes are, for cases but ring and shell"
OPTIONS = (
    Option("ring_angular", int, 2, "", _AROUND, check="nonnegative"),
    Option("modes_count", int, 10, "", "how many modes, slowest first", check="positive"),
    Option("modes_near", float, 1.0, "1/s", _NEXT),
)
#: case -> options that keep it in a steady state
STEADY = {
    "ring": {"ring_pulse": 0.0},
    "shell": {"shell_charge": 0.0, "fsi_shock": 0.0},
    "panel": {"panel_push": 0.0},
}
sections = partial(options_after, extra=OPTIONS)


def modes(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm; rank 0 computes.

    Raises InputError, also where the case is not in a steady state at first; FileError.
    """
    from mpi4py import MPI

    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.stepping.solve import block_form, build_problem
    from fsipetsc.studies.linear import modes_near, radial_modes

    case, name = together(comm, lambda: case_after("modes", arguments)), arguments[0]
    study = Study(comm, arguments[1:], OPTIONS, "modes", case)
    opt = {**study.opt, **STEADY.get(name, {})}
    order, count, n = opt["fsi_order"], opt["modes_count"], opt["ring_angular"] * (name == "ring")
    problem: Any = build_problem(case, opt, comm)
    how, known = (problem, order), name in ("ring", "shell")

    def found() -> Any:
        if known:
            return radial_modes(*how, n, block_form(opt))[:count]
        with BlockState(MPI.COMM_SELF, *how, block_form(opt)) as state:
            omega = 1j * modes_near(state, -1j * opt["modes_near"], count)
        return omega[np.argsort(omega.real)]

    rows, media = [], media_of(problem) if known else ()
    omegas = study.on_first(found)
    for i, omega in enumerate(omegas if comm.rank == 0 else (), 1):
        exact = mode_near(media, n, omega.real) if media else None
        beside = (exact, float(abs(omega / exact - 1.0))) if exact else ("", "")
        rows.append((i, omega.real, omega.imag, *beside))
    of = f", angular number {n}" if name == "ring" else ""
    study.say(f"modes of {case.NAME}{of}, order {order}, h = {opt['fsi_h']:g}: exp(-i omega t)")
    study.table(("index", "omega_re", "omega_im", "exact", "error"), rows, ".10g")


class Medium(NamedTuple):
    """A ring or shell between two radii [m], of a density [kg/m3] and Lame's constants [Pa]; a gas
    has no shear.

    kappa: 0 in the plane; 1, 2 of what moves along the radius alone, around an axis or a centre,
    where n is 0 and psi too; around a centre the Bessel functions are spherical. At r = 0 only the
    first of them is finite.
    """

    inner: float
    outer: float
    density: float
    lame: float
    shear: float
    kappa: int

    @property
    def sticks(self) -> bool:
        """It has tangential stresses."""
        return self.shear > 0.0 and self.kappa == 0

    def fields(self, n: int, omega: float, r: float) -> Array:
        """(functions, 4): of each function u_r and s_rr at r, and, but for factors cos(n theta) and
        sin(n theta), u_theta and s_rtheta."""
        mu = self.shear
        if r == 0.0:
            return np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]])
        k, found = omega / np.sqrt((self.lame + 2.0 * mu) / self.density), []
        for f in (spherical_jn, spherical_yn) if self.kappa == 2 else (jvp, yvp):
            p, dp = (k**m * f(n, k * r, m) for m in (0, 1))
            ddp = ((n / r) ** 2 - k**2) * p - max(self.kappa, 1) / r * dp
            turning = -2.0 * n * mu * (dp / r - p / r**2)
            found.append([dp, 2.0 * mu * ddp - self.lame * k**2 * p, -n / r * p, turning])
        for f in (jvp, yvp) if self.sticks else ():
            k = omega / np.sqrt(mu / self.density)
            p, dp, ddp = (k**m * f(n, k * r, m) for m in range(3))
            turning = mu * (dp / r - ddp - (n / r) ** 2 * p)
            found.append([n / r * p, 2.0 * n * mu * (dp / r - p / r**2), -dp, turning])
        return np.array(found)


def media_of(problem: BlockProblem) -> tuple[Medium, ...]:
    """What the equations know of the case ring or shell at rest, from inside; nothing where its gas
    conducts heat or is viscous.
    """
    media = []
    for block in problem.layers:
        at, material = np.zeros((2, block.dimension)), block.material
        at[1, 0] = 1.0
        inner, outer = np.linalg.norm([block.map(tuple(xi)) for xi in at], axis=1)
        if isinstance(problem.faces.get((block.name, 0, 0)), Centre):
            inner = 0.0  # its first node is half a spacing away
        if block.kind == "solid":
            laws = material.m0, material.lambda_e, material.mu_e
        elif material.kappa > 0.0 or material.mu > 0.0:
            return ()
        else:
            laws = 1.0, material.gamma, 0.0  # of density and pressure 1
        media.append(Medium(float(inner), float(outer), *laws, problem.symmetry))
    return tuple(media)


def conditions(media: Sequence[Medium], n: int, omega: float) -> Array:
    """The square matrix, of all conditions on all functions, that is singular for a mode."""
    fields = [[of.fields(n, omega, r) for r in (of.inner, of.outer)] for of in media]
    starts = np.cumsum([0, *(len(inner) for inner, _ in fields)])
    # each condition: (medium, side, quantity), of which one vanishes or two are the same
    demands = [[(k, side, 3)] for k, of in enumerate(media) if of.sticks for side in (0, 1)]
    for k, side in ((0, 0), (len(media) - 1, 1)):
        demands.append([(k, side, 1 if media[k].shear else 0)])
    for k in range(len(media) - 1):
        demands += [[(k, 1, quantity), (k + 1, 0, quantity)] for quantity in (0, 1)]
    rows = np.zeros((len(demands), starts[-1]))
    for row, demand in zip(rows, demands):
        for (k, side, quantity), sign in zip(demand, (1.0, -1.0)):
            row[starts[k] : starts[k + 1]] = sign * fields[k][side][:, quantity]
    return rows


def mode_near(media: Sequence[Medium], n: int, omega: float) -> float | None:
    """The angular frequency [1/s] of the mode of angular number n next to an expected one; None
    where a secant search does not find one near it.
    """
    first = conditions(media, n, omega)
    columns = np.abs(first).max(axis=0)
    rows = np.abs(first / columns).max(axis=1)[:, None]

    def misfit(at: float) -> float:
        return float(np.linalg.det(conditions(media, n, at) / columns / rows))

    about = {"x1": omega * (1.0 + 1e-4), "tol": CLOSE * omega, "maxiter": STEPS}
    root, result = newton(misfit, omega, **about, full_output=True, disp=False)
    return float(root) if result.converged and abs(root - omega) <= NEAR * omega else None
