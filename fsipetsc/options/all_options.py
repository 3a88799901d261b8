"""The options of all cases, section by section, and those of PETSc that work here."""

from collections.abc import Callable, Sequence
from pathlib import Path

from fsipetsc.options.option import INT_MAX, REQUIRED, Option


def _increasing(times: Sequence[float]) -> str | None:
    rising = all(a < b for a, b in zip(times, times[1:]))
    fits = rising and min(times, default=0) >= 0
    return None if fits else "times that are not negative and increase"


def _file_name(name: str) -> str | None:
    return None if Path(name).name and "\0" not in name else "the name of a file"


def _between(least: float, most: float) -> Callable[[float], str | None]:
    return lambda value: None if least <= value <= most else f"a number from {least} to {most}"


COUPLINGS = ("projection", "energy", "traditional", "conservative")
PARTITIONS = ("auto", "physics", "balanced")
DISCRETISATION = (
    Option("fsi_order", int, 4, "", "interior order of the SBP operators", (2, 4, 6, 8)),
    Option("fsi_h", float, REQUIRED, "m",
        "grid spacing; interfaces, in 2-D ends of panels, must fall on grid points",
        check="positive"),
    Option("fsi_cfl", float, 0.8, "", "Courant number of the time step; -ts_dt replaces it",
        check="positive"),
    Option("fsi_coupling", str, "conservative", "",
        "coupling of gas and solid; all but conservative: the paper's method, in 1-D", COUPLINGS),
    Option("fsi_mapping", str, "auto", "",
        "grids of gases: rigid with the paper's couplings, stretched with conservative; "
        "auto: what the coupling needs", ("auto", "rigid", "stretched")),
    Option("fsi_viscous", str, "wide", "",
        "second derivatives: D twice, or, with the paper's couplings, a narrow stencil",
        ("wide", "narrow")),
    Option("fsi_convection", str, "auto", "",
        "form of convection; entropy: a flux that conserves it; auto: that for perfect and "
        "stiffened gases, divergence for laws of your own and in the paper's method",
        ("auto", "divergence", "entropy")),
    Option("fsi_dissipation", float, 0.0, "",
        "dissipation, times its usual size; 0: 1 where blocks are joined, else none; -1: none",
        check=_between(-1, 3)),
    Option("fsi_shock", float, 0.0, "",
        "dissipation where a sensor sees a shock, times its usual size; 0: none",
        check=_between(0, 2)),
)  # fmt: skip
OUTPUT = (
    Option("fsi_output", str, None, "",
        "result file (HDF5); an earlier result is never destroyed silently", check=_file_name),
    Option("fsi_output_dt", float, None, "s", "interval at which profiles are saved",
        check="positive"),
    Option("fsi_output_times", "floats", None, "s", "times at which profiles are saved: t0,t1,…",
        check=_increasing),
    Option("fsi_probes", str, None, "m",
        "of blocks: places whose nearest nodes are recorded at each step: X,Y;X,Y;…"),
)  # fmt: skip
CHECKPOINTS = (
    Option("fsi_checkpoint", str, None, "",
        "file of checkpoints; NAME.checkpoint.h5 beside the result NAME.h5 if not given"),
    Option("fsi_checkpoint_steps", int, None, "steps", "steps from one checkpoint to the next",
        check="positive"),
    Option("fsi_checkpoint_wall", float, None, "s", "wall time from one checkpoint to the next",
        check="positive"),
    Option("fsi_restart", str, None, "",
        "go on from a checkpoint; auto: from the run's own, if there is one"),
)  # fmt: skip
RUN = (
    Option("fsi_check", float, None, "",
        "stop if mass, momentum, energy or entropy departs from its law by this fraction; "
        "without a value: check the case, and do not run it",
        check="positive"),
    Option("fsi_partition", str, "auto", "", "which ranks own which layers", PARTITIONS),
    Option("fsi_norm", str, "L2", "",
        "norm of the errors against an exact solution; L1 where it jumps", ("L1", "L2")),
    Option("fsi_quiet", bool, False, "", "print nothing but errors"),
    Option("fsi_progress", bool, False, "",
        "print progress from 2 s on, not 10 s, if the output is not a terminal"),
)  # fmt: skip
#: those that belong to one run of the program, not to what is computed: no checkpoint has them
OF_A_RUN = {"fsi_quiet", "fsi_progress", "fsi_restart"}
COMMON: tuple[Option, ...] = DISCRETISATION + OUTPUT + CHECKPOINTS + RUN

_RK_TYPES = ("1fe", "2a", "2b", "3", "3bs", "4", "5f", "5dp", "5bs", "6vr", "7vr", "8vr")
#: PETSc's options for which this program has defaults of its own, or which it must know
PETSC_OPTIONS: tuple[Option, ...] = (
    Option("ts_max_time", float, REQUIRED, "s", "time at which the run ends", check="nonnegative"),
    Option("ts_max_steps", int, INT_MAX, "", "number of steps after which the run ends",
        check="nonnegative"),
    Option("ts_dt", float, None, "s",
        "fixed time step, instead of -fsi_cfl; -ts_time_step is the same", check="positive"),
    Option("ts_type", str, "fused", "", "time integrator; fused: rk of type 4 in one piece",
        ("fused", "rk", "ssp", "euler")),
    Option("ts_rk_type", str, "4", "", "Runge–Kutta method", _RK_TYPES),
    Option("ts_adapt_type", str, "none", "", "steps have the length of -fsi_cfl or -ts_dt",
        ("none",)),
    Option("ts_ssp_type", str, "rks2", "", "method of ssp", ("rks2", "rks3", "rk104")),
)  # fmt: skip
#: other spellings: of another release of PETSc, or deprecated there
ALIASES = {"ts_time_step": "ts_dt", "ts_final_time": "ts_max_time"}

#: options that PETSc follows when it starts or when it ends -> meaning
AT_START = {
    "log_view": "print PETSc's log at the end: times of set-up, loop and output; :FILE writes it",
    "memory_view": "print the memory that was used, at the end",
    "info": "print what PETSc does",
    "malloc_debug": "check the memory that PETSc allocates",
    "malloc_dump": "list memory of PETSc's that was not freed, at the end",
    "options_left": "list options that PETSc did not use, at the end",
}
#: options that PETSc's time integrator follows -> meaning
IN_LOOP = {
    "ts_monitor": "print every step: number, dt, t",
    "ts_view": "print PETSc's method when it ends; with -ts_type rk, ssp or euler",
}
#: all options that PETSc follows and no table of a case has -> meaning
PASSED_ON = {
    "options_file": "read options from a file, one '-name value' a line; FILE.yaml is YAML",
    "options_file_yaml": "the same in YAML, whatever the file's name",
    **IN_LOOP,
    **AT_START,
}
#: beginnings of PETSc's names, which no option of a case may have
PETSCS = ("ts_", "ksp_", "pc_", "snes_", "mat_", "vec_", "dm_", "log_", "malloc_", "options_")
