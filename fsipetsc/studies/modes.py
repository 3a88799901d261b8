"""The commands `modes ring`, `modes shell` and `flutter`: small motions about a steady state, by
the scheme (fsipetsc.studies.linear).

**Rings and shells** at rest have frequencies that are known exactly, where the gas neither conducts
heat nor is viscous. Displacements grad phi + curl psi, proportional to exp(-i omega t), obey Lame's
equations with phi = f(k r) cos(n theta), k = omega / c_p, f a Bessel function, and psi likewise
with sin(n theta) and c_s. A gas is such a medium without shear: lambda = gamma p. It has no psi,
and slips. What is innermost and outermost is held if it is gas, and free if it is solid.

**Flutter** is of the case ``panel`` in the flow over the flat panel. The ranks share Mach numbers
and lambdas; the two modes that flutter are computed for each, and the lambda of each Mach number at
which the growth becomes positive. Lengths are over the panel's, velocities over the speed of sound,
densities over that of the flow; the stiffness is D = M^2 / (lambda sqrt(M^2 - 1)). A thin clamped
panel without damping flutters from lambda = 636.57 on, whatever its mass, a hinged one from 343.36
on (E. H. Dowell, Aeroelasticity of Plates and Shells, 1975); verify/beams.py derives both.
"""

from collections.abc import Mapping, Sequence
from itertools import groupby, product
from math import nan, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, newton
from scipy.special import jvp, spherical_jn, spherical_yn, yvp

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre
from fsipetsc.cases import load_case, options_after
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.options import PROGRAM, Option, groups
from fsipetsc.process.together import Comm
from fsipetsc.studies.tables import Study, text_table

#: how far from where it begins a search may end, over omega; when it ends, and steps it may take
NEAR, CLOSE, STEPS = 0.03, 1e-12, 40
_AROUND = "angular number of a ring: waves around it"
OPTIONS = (
    Option("ring_angular", int, 2, "", _AROUND, check="nonnegative"),
    Option("modes_count", int, 10, "", "how many modes, slowest first", check="positive"),
)
#: case -> options that keep it at rest
_AT_REST = {"ring": {"ring_pulse": 0.0}, "shell": {"shell_charge": 0.0, "fsi_shock": 0.0}}
#: lambda at which a thin panel flutters without damping, its frequency there over sqrt(D/m)
CRITICAL = {"clamped": 636.57, "hinged": 343.36}
FREQUENCY = {"clamped": 52.0, "hinged": 32.0}
#: columns of the table: the faster mode, and both by frequency
HEAD = "mach lambda growth frequency growth_1 frequency_1 growth_2 frequency_2".split()
MACHS, LAMBDAS = (1.5, 2.0, 2.5, 3.0, 4.0), (500.0, 600.0, 700.0, 800.0)
OF_FLUTTER = (
    Option("flutter_machs", "floats", MACHS, "", "Mach numbers",
        check=lambda values: None if min(values) > 1 else "Mach numbers above 1"),
    Option("flutter_lambdas", "floats", LAMBDAS, "", "lambdas", check="positive"),
)  # fmt: skip
PANEL = load_case("panel")


def sections(command: str, arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Return heading -> options for -help."""
    if command == "flutter":
        return groups(PANEL, OF_FLUTTER)
    return options_after(command, arguments, OPTIONS)


def modes(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm; rank 0 computes.

    Raises InputError, also for a case that it does not know; FileError.
    """
    from fsipetsc.stepping.solve import block_form, build_problem
    from fsipetsc.studies.linear import radial_modes

    name = arguments[0] if arguments else ""
    if name not in _AT_REST:
        usage = f"{PROGRAM} modes ring|shell [-option value ...]"
        raise InputError(f"the command modes knows the cases ring and shell: {usage}")
    case = load_case(name)
    study = Study(comm, arguments[1:], OPTIONS, "modes", case)
    opt = {**study.opt, **_AT_REST[name]}
    problem, n = build_problem(case, opt, comm), opt["ring_angular"] if name == "ring" else 0
    media, order = media_of(problem), opt["fsi_order"]
    found = study.on_first(lambda: radial_modes(problem, order, n, block_form(opt)))
    rows, lines = [], []
    for i, omega in enumerate(found[: opt["modes_count"]] if comm.rank == 0 else (), 1):
        exact = mode_near(media, n, omega.real) if media else None
        known = (f"{exact:.10f}", f"{abs(omega / exact - 1.0):.1e}") if exact else ("", "")
        rows.append((i, omega.real, omega.imag, *((exact, 0.0) if exact else ("", ""))))
        lines.append((i, f"{omega:.10f}", *known))
    of = f", angular number {n}" if name == "ring" else ""
    study.say(f"modes of {name}{of}, order {order}, h = {opt['fsi_h']:g}: exp(-i omega t)")
    study.say(text_table(("", "omega [1/s]", "exact", "error"), lines))
    study.save(("index", "omega_re", "omega_im", "exact", "exact_im"), rows)
    study.say(f"saved {study.path}")


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


def flutter(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; FileError; ComputationError.
    """
    study = Study(comm, arguments, OF_FLUTTER, "flutter", PANEL)
    opt, say = study.opt, study.say
    mass, ends = opt["panel_mass"], opt["panel_ends"]
    several = (("panel_mach", "flutter_machs"), ("panel_lambda", "flutter_lambdas"))
    lists = [[opt[one]] if one in study.given else opt[many] for one, many in several]
    tasks = list(product(*(sorted({*values}) for values in lists)))
    lines, onsets = [], []
    found = zip(tasks, study.share(tasks, lambda task: modes_at(opt, *task)))
    for mach, group in groupby(found, lambda one: one[0][0]):
        of_mach = [(dynamic, pair) for (_, dynamic), pair in group]
        for dynamic, pair in of_mach:
            modes = max(pair, key=lambda s: s.real), *pair
            numbers = [f"{x:.6g}" for s in modes for x in (s.real, s.imag)]
            lines.append([f"{mach:g}", f"{dynamic:g}", *numbers])
        onset, s = crossing(mach, mass, *zip(*of_mach))
        cells = f"{onset:.1f}", f"{s.imag / (2.0 * pi):.4f}", f"{onset / CRITICAL[ends]:.3f}"
        onsets.append([f"{mach:g}", *cells])
    facts = f"mass {mass:g}, thickness {opt['panel_thickness']:g}"
    say(f"panel, {facts}: growth and angular frequency of its modes\n\n{text_table(HEAD, lines)}")
    say("\nonset of flutter: lambda, and frequency f in cycles per unit of time")
    say(text_table(["M", "lambda", "f", f"of {CRITICAL[ends]}"], onsets))
    study.save(HEAD, lines)
    say(f"\nsaved {study.path}")


def unit_of(mach: float, mass: float, dynamic: float) -> float:
    """sqrt(D / mass), unit of frequencies, at lambda = dynamic; mass: over density and length."""
    return float(np.sqrt(mach**2 / (dynamic * np.sqrt(mach**2 - 1.0)) / mass))


def modes_at(opt: Mapping[str, Any], mach: float, dynamic: float) -> list[complex]:
    """s [unit of velocity over the panel's length] of the modes at a Mach number and lambda =
    dynamic, by this rank alone, the slower one first. InputError, also where the flow is not
    steady, as that of a viscous gas.
    """
    from mpi4py import MPI

    from fsipetsc.stepping.solve import build_problem, make_state
    from fsipetsc.studies.linear import modes_near

    own = {**opt, "panel_mach": mach, "panel_lambda": dynamic, "panel_push": 0.0}
    frequency = FREQUENCY[opt["panel_ends"]] * unit_of(mach, opt["panel_mass"], dynamic)
    with make_state(build_problem(PANEL, own, MPI.COMM_SELF), own, MPI.COMM_SELF) as state:
        s = modes_near(state, 1j * frequency, 2)
    return [complex(one) for one in s[np.argsort(s.imag)]]


def crossing(
    mach: float, mass: float, dynamic: Sequence[float], pairs: Sequence[Sequence[complex]]
) -> tuple[float, complex]:
    """(lambda, s) where the growth of the faster of two modes becomes positive, from their s at
    some lambda; NaN if it does not change its sign between these.

    The growth has a kink where the frequencies meet, but over ``unit_of`` the coefficients of
    (s - s1)(s - s1*)(s - s2)(s - s2*) are smooth: parabolas are laid through them. These are over
    lambda^2, as the last coefficient is linear in it where pressure is steady. From two lambdas
    that are 17 % apart the onset is 0.1 to 0.2 % too low.
    """
    x = np.asarray(dynamic, float) ** 2
    scaled = [np.asarray(s) / unit_of(mach, mass, at) for s, at in zip(pairs, dynamic, strict=True)]
    found = np.array([np.poly(np.concatenate([pair, pair.conj()])).real for pair in scaled])
    centre = 0.5 * (x.min() + x.max())
    fits = np.polynomial.polynomial.polyfit(x - centre, found, min(len(x) - 1, 2))

    def fastest(at: float) -> complex:
        roots = np.roots(np.polynomial.polynomial.polyval(at * at - centre, fits))
        s = roots[np.argmax(roots.real)]
        return complex(s.real, abs(s.imag))

    fine = np.linspace(min(dynamic), max(dynamic), 401)
    first = int(np.argmax([fastest(at).real > 0.0 for at in fine]))
    if first == 0:
        return nan, complex(nan, nan)
    at = float(brentq(lambda at: fastest(at).real, fine[first - 1], fine[first]))
    return at, unit_of(mach, mass, at) * fastest(at)
