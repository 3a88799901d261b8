"""The command `modes ring`: frequencies of small motions about rest, by the scheme and exactly.

The scheme's right-hand side is linearised about rest and split by angular numbers
(fsipetsc.analysis.ring_modes). Beside its modes stand those of the equations, where they are known
(fsipetsc.analysis.ring_theory): where nothing conducts heat.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsipetsc.cases import load_case
from fsipetsc.errors import FileError, InputError
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
    case = together(comm, lambda: _case(arguments))
    given = start_petsc(arguments[1:], comm)
    from fsipetsc.stepping.solve import build_problem, check_begin

    opt = read_options(case, given, OPTIONS)
    check_begin(opt)
    if "ring_pulse" in given:
        raise InputError("-ring_pulse: modes are of small motions about rest, without a pulse")
    opt["ring_pulse"] = 0.0
    path = Path(opt["fsi_output"] if "fsi_output" in given else "modes.csv").with_suffix(".csv")
    problem = build_problem(case, opt, comm)
    together(comm, lambda: None if comm.rank else _told(problem, opt, path))
    wait_asleep(comm)


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    return groups(load_case("ring"), OPTIONS)


def _case(arguments: Sequence[str]) -> Any:
    if not arguments or arguments[0] != "ring":
        found = f"not {arguments[0]}" if arguments else "none was given"
        usage = f"{program()} modes ring [-option value ...]"
        raise InputError(f"the command modes knows the case ring, {found}: {usage}")
    return load_case("ring")


def _told(problem: Any, opt: Mapping[str, Any], path: Path) -> None:
    """Compute, print and save. InputError, FileError."""
    found = compared(problem, opt)
    if not opt["fsi_quiet"]:
        print(table(found, opt))
    try:
        save(found, path)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from None
    if not opt["fsi_quiet"]:
        print(f"saved {path}", flush=True)


def compared(problem: Any, opt: Mapping[str, Any]) -> list[Mode]:
    """The slowest modes of the ring at rest, for the options in force. InputError."""
    from fsipetsc.analysis.ring_modes import ring_modes
    from fsipetsc.analysis.ring_theory import mode_near
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


def table(found: Sequence[Mode], opt: Mapping[str, Any]) -> str:
    """The modes as text, with errors over |omega|."""
    grid = f"order {opt['fsi_order']}, h = {opt['fsi_h']:g}"
    lines = [
        f"modes of ring, angular number {opt['ring_angular']}, {grid}: exp(-i omega t)",
        f"{'':>5}{'omega [1/s]':>30}{'exact':>30}{'error':>10}",
    ]
    for i, (omega, exact) in enumerate(found, 1):
        error = 0.0 if exact is None else abs(omega - exact) / abs(exact)
        known = "" if exact is None else f"{_text(exact):>30}{error:>10.1e}"
        lines.append(f"{i:>5}{_text(omega):>30}{known}")
    return "\n".join(lines)


def _text(omega: complex) -> str:
    """Real where the other part is round-off."""
    if abs(omega.imag) < 1e-9 * abs(omega):
        return f"{omega.real:.10f}{'':>15}"
    return f"{omega.real:.10f} {omega.imag:+.10f}i"


def save(found: Sequence[Mode], path: Path) -> None:
    """The modes as CSV; exact and exact_im are empty where they are not known. OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("index", "omega_re", "omega_im", "exact", "exact_im"))
        for i, (omega, exact) in enumerate(found, 1):
            known = ("", "") if exact is None else (exact.real, exact.imag)
            writer.writerow((i, omega.real, omega.imag, *known))
