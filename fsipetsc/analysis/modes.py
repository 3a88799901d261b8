"""The command `modes ring`: frequencies of small motions about rest, by the scheme and exactly.

The scheme's right-hand side is linearised about rest and split by angular numbers
(fsipetsc.analysis.wave_modes). Beside its modes stand those of the equations, where they are known
(fsipetsc.analysis.ring_theory): where nothing conducts heat.
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

OPTIONS = (
    Option("ring_angular", int, 2, "", "angular number, waves around it", check="nonnegative"),
    Option("modes_count", int, 10, "", "modes that are told, the slowest first", check="positive"),
)
#: omega of a mode of the scheme [1/s], and of that of the equations next to it, if it is known
Mode = tuple[complex, complex | None]


def modes(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm; rank 0 computes.

    Raises InputError, also for a case that it does not know; FileError.
    """
    if arguments[:1] != ["ring"]:
        usage = f"{program()} modes ring [-option value ...]"
        raise InputError(f"the command modes knows the case ring: {usage}")
    case, given = load_case("ring"), start_petsc(arguments[1:], comm)
    from fsipetsc.stepping.solve import build_problem, check_begin

    opt = {**read_options(case, given, OPTIONS), "ring_pulse": 0.0}
    check_begin(opt)
    path = csv_target(opt["fsi_output"] if "fsi_output" in given else "modes")
    problem = build_problem(case, opt, comm)
    together(comm, lambda: None if comm.rank else _told(problem, opt, path))
    wait_asleep(comm)


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    return groups(load_case("ring"), OPTIONS)


def _told(problem: Any, opt: Mapping[str, Any], path: Path) -> None:
    """Compute, print and save. InputError, FileError."""
    found = compared(problem, opt)
    rows = []
    for i, (omega, exact) in enumerate(found, 1):
        known = ("", "") if exact is None else (exact.real, exact.imag)
        rows.append((i, omega.real, omega.imag, *known))
    save_csv(path, ("index", "omega_re", "omega_im", "exact", "exact_im"), rows)
    if not opt["fsi_quiet"]:
        grid = f"order {opt['fsi_order']}, h = {opt['fsi_h']:g}"
        print(f"modes of ring, angular number {opt['ring_angular']}, {grid}: exp(-i omega t)")
        print(f"{_table(found)}\nsaved {path}", flush=True)


def compared(problem: Any, opt: Mapping[str, Any]) -> list[Mode]:
    """The slowest modes of the ring at rest, for the options in force. InputError."""
    from fsipetsc.analysis.ring_theory import mode_near
    from fsipetsc.analysis.wave_modes import ring_modes
    from fsipetsc.stepping.solve import block_form

    n, media = opt["ring_angular"], media_of(opt)
    found = ring_modes(problem, opt["fsi_order"], n, block_form(opt))[: opt["modes_count"]]
    numbers = [complex(omega) for omega in found]
    return [(omega, mode_near(media, n, omega) if media else None) for omega in numbers]


def media_of(opt: Mapping[str, Any]) -> tuple[Medium, ...]:
    """What the equations know of the case ring, from inside; nothing where it conducts heat."""
    from fsipetsc.analysis.ring_theory import Medium
    from fsipetsc.cases.ring import CORE, INNER, OUTER, VESSEL, gas_of, solid_of

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
