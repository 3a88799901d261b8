"""The commands `modes ring` and `modes shell`: frequencies of small motions about rest, by the
scheme (fsipetsc.studies.linear) and, where nothing conducts heat, exactly by Bessel functions.

Displacements grad phi + curl psi, proportional to exp(i n theta - i omega t), obey Lame's equations
with phi = J_n(k r) or H_n(k r), k = omega / c_p, and psi likewise with c_s. A gas that conducts no
heat is such a medium, too: lambda = gamma p + 2/3 i omega mu' and mu = -i omega mu', mu' its
viscosity. Without viscosity it has no psi, and slips. What is innermost and outermost is held if it
is gas, and free if it is solid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import newton
from scipy.special import h1vp, jvp, spherical_jn, spherical_yn

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import PROGRAM, Option, groups
from fsipetsc.process.together import Comm
from fsipetsc.studies.tables import begin, on_first, printer, save_csv, text_table

Complex = NDArray[np.complex128]
#: how far from where it begins a search may end, over |omega|; when it ends, and steps it may take;
#: what counts as singular
NEAR, CLOSE, STEPS, SINGULAR = 0.03, 1e-12, 40, 1e-8
_COUNT = Option("modes_count", int, 10, "", "how many modes, slowest first", check="positive")
_ANGULAR = Option(
    "ring_angular", int, 2, "", "angular number: waves around the ring", check="nonnegative"
)
#: case -> the command's options beside those of the case, and options that keep it at rest
OPTIONS = {"ring": (_ANGULAR, _COUNT), "shell": (_COUNT,)}
_AT_REST = {"ring": {"ring_pulse": 0.0}, "shell": {"shell_charge": 0.0, "fsi_shock": 0.0}}


def modes(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm; rank 0 computes.

    Raises InputError, also for a case that it does not know; FileError.
    """
    if not arguments or arguments[0] not in OPTIONS:
        usage = f"{PROGRAM} modes ring|shell [-option value ...]"
        raise InputError(f"the command modes knows the cases ring and shell: {usage}")
    name = arguments[0]
    case = load_case(name)
    opt, path = begin(case, arguments[1:], comm, OPTIONS[name], "modes")
    from fsipetsc.stepping.solve import build_problem

    opt |= _AT_REST[name]
    problem, say = build_problem(case, opt, comm), printer(comm, opt)
    found = on_first(comm, lambda: _pairs(problem, opt)) or []
    rows, lines = [], []
    for i, (omega, exact) in enumerate(found, 1):
        rows.append((i, omega.real, omega.imag, *((exact.real, exact.imag) if exact else ("", ""))))
        error = f"{abs(omega - exact) / abs(exact):.1e}" if exact else ""
        lines.append((i, f"{omega:.10f}", f"{exact:.10f}" if exact else "", error))
    of = f", angular number {opt['ring_angular']}" if name == "ring" else ""
    grid = f"order {opt['fsi_order']}, h = {opt['fsi_h']:g}"
    say(f"modes of {name}{of}, {grid}: exp(-i omega t)")
    say(text_table(("", "omega [1/s]", "exact", "error"), lines))
    save_csv(comm, path, ("index", "omega_re", "omega_im", "exact", "exact_im"), rows)
    say(f"saved {path}")


def sections(command: str, arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Return heading -> options for -help."""
    name = arguments[0] if arguments and arguments[0] in OPTIONS else "ring"
    return groups(load_case(name), OPTIONS[name])


def _pairs(problem: Any, opt: Mapping[str, Any]) -> list[tuple[complex, complex | None]]:
    """Frequencies of the scheme [1/s], and the exact ones where they are known. InputError."""
    from fsipetsc.stepping.solve import block_form
    from fsipetsc.studies.linear import radial_modes

    n, media = opt.get("ring_angular", 0), media_of(problem)
    found = radial_modes(problem, opt["fsi_order"], n, block_form(opt))[: opt["modes_count"]]
    return [(omega, mode_near(media, n, omega) if media else None) for omega in map(complex, found)]


def media_of(problem: BlockProblem) -> tuple[Medium, ...]:
    """What the equations know of the case ring or shell at rest, from inside; nothing where its gas
    conducts heat.
    """
    media = []
    for block in problem.layers:
        at, material = np.zeros((2, block.dimension)), block.material
        at[1, 0] = 1.0
        inner, outer = np.linalg.norm([block.map(tuple(xi)) for xi in at], axis=1)
        if isinstance(problem.faces.get((block.name, 0, 0)), Centre):
            inner = 0.0  # its first node is half a spacing away
        if block.kind == "solid":
            laws = material.m0, material.lambda_e, material.mu_e, 0.0
        elif material.kappa > 0.0:
            return ()
        else:
            laws = 1.0, material.gamma, 0.0, material.mu  # of density and pressure 1
        media.append(Medium(float(inner), float(outer), *laws, kappa=problem.symmetry))
    return tuple(media)


@dataclass(frozen=True)
class Medium:
    """A ring or shell between two radii [m], of a density [kg/m3] and Lame's constants [Pa]; of a
    gas lame = gamma p, shear = 0, and the viscosity [Pa s].

    kappa: 0 in the plane; 1, 2 of what moves along the radius alone, around an axis or a centre,
    where n is 0 and psi too; around a centre the Bessel functions are spherical. At r = 0 only the
    first of them is finite.
    """

    inner: float
    outer: float
    density: float
    lame: float
    shear: float = 0.0
    viscosity: float = 0.0
    kappa: int = 0

    @property
    def sticks(self) -> bool:
        """It has tangential stresses."""
        return self.kappa == 0 and (self.shear > 0.0 or self.viscosity > 0.0)

    def fields(self, n: int, omega: complex, r: float) -> Complex:
        """(4, 2 or 4): displacements and stresses u_r, u_theta, s_rr, s_rtheta at r of each
        function."""
        mu = self.shear - 1j * omega * self.viscosity
        lame = self.lame + 2j / 3 * omega * self.viscosity
        if r == 0.0:
            return np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]], complex)
        k = omega / np.sqrt((lame + 2.0 * mu) / self.density)
        found = []
        for f in (spherical_jn, spherical_yn) if self.kappa == 2 else (jvp, h1vp):
            p, dp = (k**m * f(n, k * r, m) for m in (0, 1))
            ddp = ((n / r) ** 2 - k**2) * p - max(self.kappa, 1) / r * dp
            turning = 2j * n * mu * (dp / r - p / r**2)
            found.append([dp, 1j * n / r * p, 2.0 * mu * ddp - lame * k**2 * p, turning])
        k = omega / np.sqrt(mu / self.density) if self.sticks else 0.0
        for f in (jvp, h1vp) if self.sticks else ():
            p, dp, ddp = (k**m * f(n, k * r, m) for m in range(3))
            turning = mu * (dp / r - ddp - n**2 / r**2 * p)
            found.append([1j * n / r * p, -dp, 2j * n * mu * (dp / r - p / r**2), turning])
        return np.array(found, complex).T


def conditions(media: Sequence[Medium], n: int, omega: complex) -> Complex:
    """The square matrix, of all conditions on all potentials, that is singular for a mode."""
    width = [4 if medium.sticks else 2 for medium in media]
    potentials = np.split(np.eye(sum(width)), np.cumsum(width)[:-1])
    rows: list[Complex] = []

    def at(k: int, r: float) -> Complex:
        return media[k].fields(n, omega, r) @ potentials[k]

    last = len(media) - 1
    for k, r in ((0, media[0].inner), (last, media[last].outer)):
        fixed, free = ((0, 1), (2, 3)) if media[k].sticks else ((0,), (2,))
        rows += list(at(k, r)[list(free if media[k].shear else fixed)])
    for k, (one, other) in enumerate(zip(media, media[1:])):
        a, b = at(k, one.outer), at(k + 1, other.inner)
        if one.sticks and other.sticks:
            rows += list(a - b)
        else:
            rows += [a[0] - b[0], a[2] - b[2]]
            rows += [of[3] for of, medium in ((a, one), (b, other)) if medium.sticks]
    return np.array(rows)


@np.errstate(all="ignore")
def mode_near(media: Sequence[Medium], n: int, omega: complex) -> complex | None:
    """The angular frequency [1/s] of the mode of angular number n next to an expected one.

    None where a secant search does not find one near it, or Bessel functions are too large for
    numbers, as with a viscosity that is very small.
    """
    first = conditions(media, n, omega)
    if not np.isfinite(first).all() or not first.any(axis=0).all():
        return None
    columns = np.abs(first).max(axis=0)
    rows = np.abs(first / columns).max(axis=1)[:, None]

    def scaled(at: complex) -> Complex:
        return conditions(media, n, at) / columns / rows

    def misfit(at: complex) -> complex:
        return complex(np.linalg.det(scaled(at)))

    about = {"x1": omega * (1.0 + 1e-4), "tol": CLOSE * abs(omega), "maxiter": STEPS}
    root, result = newton(misfit, omega, **about, full_output=True, disp=False)
    if not result.converged or abs(root - omega) > NEAR * abs(omega):
        return None
    singular = np.linalg.svd(scaled(root), compute_uv=False)[-1] < SINGULAR
    return complex(root) if singular else None
