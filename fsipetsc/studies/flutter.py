"""The command `flutter`: how a small motion of the panel grows, and where it begins to.

Of the case ``panel``, linearised about the flow over the flat panel, the two modes that flutter are
computed (fsipetsc.studies.linear). The ranks share Mach numbers and lambdas; each is computed
by one rank alone. The result is the lambda of each Mach number at which the growth becomes
positive.

Lengths are over the panel's, velocities over the speed of sound, densities over that of the flow;
the stiffness is D = M^2 / (lambda sqrt(M^2 - 1)). A thin clamped panel without damping flutters
from lambda = 636.57 on, whatever its mass, a hinged one from 343.36 on (E. H. Dowell,
Aeroelasticity of Plates and Shells, 1975); verify/beams.py derives both.
"""

from collections.abc import Mapping, Sequence
from itertools import groupby, product
from math import nan, pi
from typing import Any

import numpy as np
from scipy.optimize import brentq

from fsipetsc.cases import load_case
from fsipetsc.options import Option, groups
from fsipetsc.process.together import Comm
from fsipetsc.studies.tables import Study, text_table

#: lambda at which a thin panel flutters without damping, its frequency there over sqrt(D/m)
CRITICAL = {"clamped": 636.57, "hinged": 343.36}
FREQUENCY = {"clamped": 52.0, "hinged": 32.0}
#: columns of the table: the faster mode, and both by frequency
HEAD = "mach lambda growth frequency growth_1 frequency_1 growth_2 frequency_2".split()
MACHS, LAMBDAS = (1.5, 2.0, 2.5, 3.0, 4.0), (500.0, 600.0, 700.0, 800.0)
OPTIONS = (
    Option("flutter_machs", "floats", MACHS, "", "Mach numbers",
        check=lambda values: None if min(values) > 1 else "Mach numbers above 1"),
    Option("flutter_lambdas", "floats", LAMBDAS, "", "lambdas", check="positive"),
)  # fmt: skip
CASE = load_case("panel")
SECTIONS = groups(CASE, OPTIONS)


def flutter(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; FileError; ComputationError.
    """
    study = Study(comm, arguments, OPTIONS, "flutter", CASE)
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
    with make_state(build_problem(CASE, own, MPI.COMM_SELF), own, MPI.COMM_SELF) as state:
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
