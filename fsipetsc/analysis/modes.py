"""The commands `modes ring` and `modes shell`: frequencies of small motions about rest, by the
scheme and exactly.

The scheme's right-hand side is linearised about rest and, for a ring, split by angular numbers
(fsipetsc.analysis.wave_modes, shell_modes). Beside its modes stand those of the equations, where
they are known (ring_theory, shell_theory): where nothing conducts heat.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsipetsc.analysis.tables import csv_target, save_csv, text_table
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import Option, groups, read_options
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep
from fsipetsc.usage import program

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.analysis.ring_theory import Medium

_COUNT = Option("modes_count", int, 10, "", "modes that are told, slowest first", check="positive")
_ANGULAR = Option(
    "ring_angular", int, 2, "", "angular number, waves around it", check="nonnegative"
)
#: case -> the command's options beside those of the case, and options that keep it at rest
OPTIONS = {"ring": (_ANGULAR, _COUNT), "shell": (_COUNT,)}
_AT_REST = {"ring": {"ring_pulse": 0.0}, "shell": {"shell_charge": 0.0, "fsi_shock": 0.0}}
#: omega of a mode of the scheme [1/s], and of that of the equations next to it, if it is known
Mode = tuple[complex, complex | None]


def modes(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm; rank 0 computes.

    Raises InputError, also for a case that it does not know; FileError.
    """
    name = _case_of(arguments)
    case, given = load_case(name), start_petsc(arguments[1:], comm)
    from fsipetsc.stepping.solve import build_problem, check_begin

    opt = {**read_options(case, given, OPTIONS[name]), **_AT_REST[name]}
    check_begin(opt)
    path = csv_target(opt["fsi_output"] if "fsi_output" in given else "modes")
    problem = build_problem(case, opt, comm)
    together(comm, lambda: None if comm.rank else _told(name, problem, opt, path))
    wait_asleep(comm)


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    name = arguments[0] if arguments and arguments[0] in OPTIONS else "ring"
    return groups(load_case(name), OPTIONS[name])


def _case_of(arguments: Sequence[str]) -> str:
    """The case that is named first. InputError."""
    if not arguments or arguments[0] not in OPTIONS:
        usage = f"{program()} modes ring|shell [-option value ...]"
        raise InputError(f"the command modes knows the cases ring and shell: {usage}")
    return arguments[0]


def _told(name: str, problem: Any, opt: Mapping[str, Any], path: Path) -> None:
    """Compute, print and save. InputError, FileError."""
    found = compared(name, problem, opt)
    rows = []
    for i, (omega, exact) in enumerate(found, 1):
        known = ("", "") if exact is None else (exact.real, exact.imag)
        rows.append((i, omega.real, omega.imag, *known))
    save_csv(path, ("index", "omega_re", "omega_im", "exact", "exact_im"), rows)
    if not opt["fsi_quiet"]:
        grid = f"order {opt['fsi_order']}, h = {opt['fsi_h']:g}"
        of = f", angular number {opt['ring_angular']}" if name == "ring" else ""
        print(f"modes of {name}{of}, {grid}: exp(-i omega t)")
        print(f"{_table(found)}\nsaved {path}", flush=True)


def compared(name: str, problem: Any, opt: Mapping[str, Any]) -> list[Mode]:
    """The slowest modes of a case at rest, for the options in force. InputError."""
    from fsipetsc.analysis.ring_theory import mode_near
    from fsipetsc.analysis.shell_modes import shell_modes
    from fsipetsc.analysis.wave_modes import ring_modes
    from fsipetsc.stepping.solve import block_form

    order, form, n = opt["fsi_order"], block_form(opt), opt.get("ring_angular", 0)
    if name == "ring":
        media, found = media_of(opt), ring_modes(problem, order, n, form)
    else:
        media, found = media_of_shell(opt), shell_modes(problem, order, form)
    numbers = [complex(omega) for omega in found[: opt["modes_count"]]]
    return [(omega, mode_near(media, n, omega) if media else None) for omega in numbers]


def media_of_shell(opt: Mapping[str, Any]) -> tuple[Medium, ...]:
    """What the equations know of the case shell, from inside; nothing where it conducts heat."""
    from fsipetsc.analysis.shell_theory import RadialMedium
    from fsipetsc.cases.common import gas_of
    from fsipetsc.cases.shell import radii_of, solid_of

    gas, solid, kappa = gas_of(opt), solid_of(opt), opt["shell_kappa"]
    core, inner, outer, vessel = radii_of(opt)
    elastic = solid.m0, solid.lambda_e, solid.mu_e, 0.0
    shell = RadialMedium(inner, outer, *elastic, kappa=kappa)
    if opt["shell_gas"] == "none":
        return (shell,)
    if gas.kappa > 0.0:
        return ()
    of_gas = 1.0, gas.gamma, 0.0, gas.mu
    inside = RadialMedium(core, inner, *of_gas, kappa=kappa)
    return inside, shell, RadialMedium(outer, vessel, *of_gas, kappa=kappa)


def media_of(opt: Mapping[str, Any]) -> tuple[Medium, ...]:
    """What the equations know of the case ring, from inside; nothing where it conducts heat."""
    from fsipetsc.analysis.ring_theory import Medium
    from fsipetsc.cases.common import gas_of
    from fsipetsc.cases.ring import CORE, INNER, OUTER, VESSEL, solid_of

    gas, solid = gas_of(opt), solid_of(opt)
    ring = Medium(INNER, OUTER, solid.m0, solid.lambda_e, solid.mu_e)
    if not opt["ring_gas"]:
        return (ring,)
    if gas.kappa > 0.0:
        return ()
    inside, outside = (
        Medium(*radii, 1.0, gas.gamma, 0.0, gas.mu) for radii in ((CORE, INNER), (OUTER, VESSEL))
    )
    return inside, ring, outside


def _table(found: Sequence[Mode]) -> str:
    """With errors over |omega|."""
    rows = []
    for i, (omega, exact) in enumerate(found, 1):
        error = "" if exact is None else f"{abs(omega - exact) / abs(exact):.1e}"
        rows.append((i, _text(omega), "" if exact is None else _text(exact), error))
    return text_table(("", "omega [1/s]", "exact", "error"), rows)


def _text(omega: complex) -> str:
    """Real where the other part is round-off."""
    if abs(omega.imag) < 1e-9 * abs(omega):
        return f"{omega.real:.10f}{'':>15}"
    return f"{omega.real:.10f} {omega.imag:+.10f}i"
