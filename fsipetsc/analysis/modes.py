"""The commands `modes ring` and `modes shell`: frequencies of small motions about rest, by the
scheme (fsipetsc.analysis.wave_modes) and, where nothing conducts heat, exactly
(fsipetsc.analysis.ring_theory).
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fsipetsc.analysis.ring_theory import Medium, mode_near
from fsipetsc.analysis.tables import begin, save_csv, text_table
from fsipetsc.cases import load_case
from fsipetsc.cases.common import gas_of
from fsipetsc.errors import InputError
from fsipetsc.options import Option, groups
from fsipetsc.process.together import Comm, together
from fsipetsc.usage import PROGRAM

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
    opt, _, path = begin(case, arguments[1:], comm, OPTIONS[name], "modes")
    from fsipetsc.stepping.solve import build_problem

    opt |= _AT_REST[name]
    problem = build_problem(case, opt, comm)
    together(comm, lambda: None if comm.rank else _told(case, problem, opt, path), asleep=True)


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    name = arguments[0] if arguments and arguments[0] in OPTIONS else "ring"
    return groups(load_case(name), OPTIONS[name])


def _told(case: Any, problem: Any, opt: Mapping[str, Any], path: Path) -> None:
    """Compute, print and save. InputError, FileError."""
    from fsipetsc.analysis.wave_modes import radial_modes
    from fsipetsc.stepping.solve import block_form

    n, media = opt.get("ring_angular", 0), media_of(case, opt)
    rows, lines = [], []
    found = radial_modes(problem, opt["fsi_order"], n, block_form(opt))[: opt["modes_count"]]
    for i, omega in enumerate(map(complex, found), 1):
        exact = mode_near(media, n, omega) if media else None
        rows.append((i, omega.real, omega.imag, *((exact.real, exact.imag) if exact else ("", ""))))
        error = f"{abs(omega - exact) / abs(exact):.1e}" if exact else ""
        lines.append((i, f"{omega:.10f}", f"{exact:.10f}" if exact else "", error))
    save_csv(path, ("index", "omega_re", "omega_im", "exact", "exact_im"), rows)
    if not opt["fsi_quiet"]:
        grid = f"order {opt['fsi_order']}, h = {opt['fsi_h']:g}"
        of = f", angular number {n}" if case.NAME == "ring" else ""
        print(f"modes of {case.NAME}{of}, {grid}: exp(-i omega t)")
        print(text_table(("", "omega [1/s]", "exact", "error"), lines))
        print(f"saved {path}", flush=True)


def media_of(case: Any, opt: Mapping[str, Any]) -> tuple[Medium, ...]:
    """What the equations know of the case ring or shell, from inside; nothing where its gas
    conducts heat.
    """
    gas, solid, kappa = gas_of(opt), case.solid_of(opt), opt.get("shell_kappa", 0)
    core, inner, outer, vessel = case.radii_of(opt)
    body = Medium(inner, outer, solid.m0, solid.lambda_e, solid.mu_e, kappa=kappa)
    if opt.get("ring_gas") is False or opt.get("shell_gas") == "none":
        return (body,)
    of_gas = 1.0, gas.gamma, 0.0, gas.mu, kappa
    air = Medium(core, inner, *of_gas), Medium(outer, vessel, *of_gas)
    return () if gas.kappa > 0.0 else (air[0], body, air[1])
