"""The command `modes CASE`: small motions about a steady state, by the scheme
(fsipetsc.studies.linear); beside them exact ones where references have them.
"""

from functools import partial
from typing import Any

import numpy as np

from fsipetsc.cases import case_after, options_after
from fsipetsc.options import Option
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.tables import Study
from fsipetsc.studies.trials import reference

_NEXT = "real angular frequency to be near; ring, shell: the slowest"
OPTIONS = (
    Option("ring_angular", int, 2, "", "waves around a ring", check="nonnegative"),
    Option("modes_count", int, 10, "", "how many modes, slowest first", check="positive"),
    Option("modes_near", float, 1.0, "1/s", _NEXT, check="positive"),
)
#: case -> options that keep it in a steady state
STEADY = {
    "ring": {"ring_pulse": 0.0},
    "shell": {"shell_charge": 0.0, "fsi_shock": 0.0},
    "panel": {"panel_push": 0.0},
}
#: options of a case, whose others are those of STEADY or defaults, and the column of the reference
EXACT = (
    ({"ring_gas": True, "ring_angular": 2}, "ring"),
    ({"ring_gas": False, "ring_angular": 2}, "ring in vacuum"),
    ({"shell_gas": "centre", "shell_kappa": 1}, "cylinder"),
    ({"shell_gas": "centre", "shell_kappa": 2}, "sphere"),
)
#: how far from an exact frequency one of the scheme is taken for it, over its size
NEAR = 0.03
sections = partial(options_after, extra=OPTIONS)


def modes(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm; rank 0 computes.

    Raises InputError, also where the case is not in a steady state at first; FileError.
    """
    from mpi4py import MPI

    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.stepping.run import block_form, build_problem
    from fsipetsc.studies.linear import modes_near, radial_modes

    case, name = together(comm, lambda: case_after("modes", arguments)), arguments[0]
    study = Study(comm, arguments[1:], OPTIONS, "modes", case)
    opt = {**study.opt, **STEADY.get(name, {})}
    order, count, n = opt["fsi_order"], opt["modes_count"], opt["ring_angular"] * (name == "ring")
    how = build_problem(case, opt, comm), order
    usual = {o.name: o.default for o in case.OPTIONS if o.name != "ring_around"}
    usual |= STEADY.get(name, {})
    columns = [column for own, column in EXACT if {**usual, **own}.items() <= opt.items()]
    known = [omega for of in columns for omega in reference("normal_modes")[f"{of} imag"]]

    def found() -> Any:
        if name in ("ring", "shell"):
            return radial_modes(*how, n, block_form(opt))[:count]
        with BlockState(MPI.COMM_SELF, *how, block_form(opt)) as state:
            omega = 1j * modes_near(state, -1j * opt["modes_near"], count)
        return omega[np.argsort(np.abs(omega))]

    rows, omegas = [], study.on_first(found)
    for i, omega in enumerate(omegas if comm.rank == 0 else (), 1):
        apart = {float(abs(omega / exact - 1.0)): float(exact) for exact in known}
        error = min(apart, default=1.0)
        beside = (apart[error], error) if error < NEAR else ("", "")
        rows.append((i, omega.real, omega.imag, *beside))
    of = f", angular number {n}" if name == "ring" else ""
    study.say(f"modes of {case.NAME}{of}, order {order}, h = {opt['fsi_h']:g}: exp(-i omega t)")
    study.table(("index", "omega_re", "omega_im", "exact", "error"), rows, ".12g")
