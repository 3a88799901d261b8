"""Which of PETSc's own options work here; all others are refused, because PETSc would pass over them without a word.

Those of the time integrator that the program knows by value are in fsipetsc.options; here are the rest, and why what is
in neither list is not taken.
"""

from __future__ import annotations

import os
import re

from fsipetsc.options.option import Option

#: what -log_view writes into a file, by PETSc's names
_LOG_FORMATS = ("ascii_xml", "ascii_flamegraph", "ascii_info_detail", "ascii_csv")


def _file_of_log(text: str) -> str | None:
    """None if a text is "", or ":FILE" or ":FILE:FORMAT" with a file that can be written; else what is expected."""
    if not text:
        return None
    found = re.fullmatch(r":([^:]+)(?::(\w+))?", text)
    if not found or found[2] not in (None, *_LOG_FORMATS):
        return f":FILE or :FILE:FORMAT, a format being one of {', '.join(_LOG_FORMATS)}"
    path = os.path.expanduser(found[1])
    try:
        existed = os.path.lexists(path)
        with open(path, "ab"):
            pass
        if not existed:
            os.remove(path)
    except OSError as error:
        return f":FILE with a file that can be written ({error.strerror})"
    return None


def _nothing(text: str) -> str | None:
    return "no value" if text else None


#: options that PETSc follows when it starts or when it ends
AT_START = (
    Option("log_view", "optional", None, ":FILE", "print where the time went, at the end, or write it", check=_file_of_log),
    Option("log_view_memory", bool, None, "", "with -log_view: memory, too"),
    Option("memory_view", "optional", None, "", "print the memory that was used, at the end", check=_nothing),
    Option("info", "optional", None, "", "print what PETSc does", check=_nothing),
    Option("malloc_debug", bool, None, "", "check the memory that PETSc allocates"),
    Option("malloc_dump", "optional", None, "", "list memory of PETSc's that was not freed, at the end", check=_nothing),
    Option("malloc_view", "optional", None, "", "list the memory that PETSc allocated, at the end", check=_nothing),
    Option("no_signal_handler", bool, None, "", "leave signals to the program; always so"),
)
#: options that PETSc's time integrator follows
IN_LOOP = (
    Option("ts_monitor", "optional", None, "", "print every step: number, dt, t", check=_nothing),
    Option("ts_view", "optional", None, "", "print PETSc's method when it ends, at the end of each grid", check=_nothing),
)
#: options that are followed where the options are read
IN_SOURCES = (
    Option("options_file", str, None, "", "read options from a file, one '-name value' a line; FILE.yaml is read as YAML"),
    Option("options_file_yaml", str, None, "", "the same in YAML, whatever the file's name"),
    Option("skip_petscrc", bool, None, "", "do not read .petscrc, petscrc and ~/.petscrc"),
)

#: beginnings of names of PETSc's solvers
_SOLVERS = ("ksp_", "pc_", "snes_", "mat_", "ts_max_snes")
#: beginnings of other names of PETSc's
_OTHERS = (
    *("ts_", "vec_", "vecscatter_", "is_", "sf_", "petscsf_", "dm_", "da_", "options_", "prefix_"),
    *("log_", "malloc", "viewer_", "draw_", "device_", "random_", "hdf5_", "cuda_", "hip_", "kokkos_"),
    *("object", "on_error_", "start_in_debugger", "stop_for_debugger", "debug_terminal", "debugger_"),
    *("fp_trap", "check_pointer_intensity", "citations", "petsc_", "shared_tmp", "not_shared_tmp", "saws"),
)
_SHORT = ("v", "help", "version")


def is_family_name(name: str) -> bool:
    """True if a name (lower case, without dash) is one of PETSc's or starts like some of PETSc's."""
    here = {option.name for option in AT_START + IN_LOOP + IN_SOURCES}
    return name in here or name in _SHORT or name.startswith((*_SOLVERS, *_OTHERS))


def is_start_name(name: str) -> bool:
    """True if PETSc looks at an option (lower case, without dash) only when it starts or ends."""
    return name in ("options_left", "skip_petscrc") or any(option.name == name for option in AT_START)


def why_refused(name: str) -> str | None:
    """Why an option of PETSc's (lower case, without dash) is not taken; None if it is no name of PETSc's."""
    if name.startswith(_SOLVERS):
        return "all methods are explicit: there is no system to solve"
    if name.startswith(_OTHERS):
        return "it would have no effect; -help lists the options of PETSc's that have one"
    return None
