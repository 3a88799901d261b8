"""The commands `modes ring` and `modes shell`: frequencies of small motions about rest, by the
scheme (fsipetsc.studies.wave_modes) and, where nothing conducts heat, exactly
(fsipetsc.studies.ring_theory).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import PROGRAM, Option, groups
from fsipetsc.process.together import Comm
from fsipetsc.studies.ring_theory import Medium, mode_near
from fsipetsc.studies.tables import begin, on_first, printer, save_csv, text_table

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
    """Heading -> options for -help."""
    name = arguments[0] if arguments and arguments[0] in OPTIONS else "ring"
    return groups(load_case(name), OPTIONS[name])


def _pairs(problem: Any, opt: Mapping[str, Any]) -> list[tuple[complex, complex | None]]:
    """Frequencies of the scheme [1/s], and the exact ones where they are known. InputError."""
    from fsipetsc.stepping.solve import block_form
    from fsipetsc.studies.wave_modes import radial_modes

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
