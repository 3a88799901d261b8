"""The commands `modes ring` and `modes shell`: frequencies of small motions about rest, by the
scheme (fsipetsc.analysis.wave_modes) and, where nothing conducts heat, exactly
(fsipetsc.analysis.ring_theory).
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


def modes(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm; rank 0 computes.

    Raises InputError, also for a case that it does not know; FileError.
    """
    if not arguments or arguments[0] not in OPTIONS:
        usage = f"{program()} modes ring|shell [-option value ...]"
        raise InputError(f"the command modes knows the cases ring and shell: {usage}")
    name = arguments[0]
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


def _told(name: str, problem: Any, opt: Mapping[str, Any], path: Path) -> None:
    """Compute, print and save. InputError, FileError."""
    from fsipetsc.analysis.ring_theory import mode_near
    from fsipetsc.analysis.wave_modes import radial_modes
    from fsipetsc.stepping.solve import block_form

    n, media = opt.get("ring_angular", 0), (media_of if name == "ring" else media_of_shell)(opt)
    rows, lines = [], []
    found = radial_modes(problem, opt["fsi_order"], n, block_form(opt))[: opt["modes_count"]]
    for i, omega in enumerate(map(complex, found), 1):
        exact = mode_near(media, n, omega) if media else None
        rows.append((i, omega.real, omega.imag, *((exact.real, exact.imag) if exact else ("", ""))))
        error = f"{abs(omega - exact) / abs(exact):.1e}" if exact else ""
        lines.append((i, _text(omega), _text(exact) if exact else "", error))
    save_csv(path, ("index", "omega_re", "omega_im", "exact", "exact_im"), rows)
    if not opt["fsi_quiet"]:
        grid = f"order {opt['fsi_order']}, h = {opt['fsi_h']:g}"
        of = f", angular number {n}" if name == "ring" else ""
        print(f"modes of {name}{of}, {grid}: exp(-i omega t)")
        print(text_table(("", "omega [1/s]", "exact", "error"), lines))
        print(f"saved {path}", flush=True)


def media_of_shell(opt: Mapping[str, Any]) -> tuple[Medium, ...]:
    """What the equations know of the case shell, from inside; nothing where it conducts heat."""
    from fsipetsc.analysis.ring_theory import RadialMedium
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


def _text(omega: complex) -> str:
    """Real where the other part is round-off."""
    if abs(omega.imag) < 1e-9 * abs(omega):
        return f"{omega.real:.10f}{'':>15}"
    return f"{omega.real:.10f} {omega.imag:+.10f}i"
