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

_EXPLICIT = "all methods are explicit: there is no system to solve"
_OWN_LAYOUT = "the program lays out vectors and grids itself"
_SAVED = "profiles are saved with -fsi_output_dt or -fsi_output_times"
_CONTROL = (
    "the error control is the program's own; of PETSc's options it follows -ts_adapt_type, _dt_min, _dt_max, _clip, "
    "_safety and _reject_safety"
)
#: beginning of a name (the first that fits counts) -> why it is refused
_REFUSED = {
    "ts_adjoint": "there is no adjoint of this problem",
    "ts_eval_times": "the times of output are set by -fsi_output_dt or -fsi_output_times",
    "ts_time_span": "the times of output are set by -fsi_output_dt or -fsi_output_times",
    "ts_fd_color": "there is no Jacobian: all methods are explicit",
    "ts_rk_multirate": "the right-hand side is not split into slow and fast parts",
    "ts_use_splitrhsfunction": "the right-hand side is not split into slow and fast parts",
    "ts_init_time": "every run begins at t = 0, or where a frame (-fsi_initial) or a checkpoint (-fsi_restart) was written",
    "ts_exact_final_time": "every run ends exactly at -ts_max_time",
    "ts_monitor_": f"of PETSc's monitors only -ts_monitor works; {_SAVED}",
    "ts_view_": "of PETSc's views of the method only -ts_view works",
    "ts_trajectory": _SAVED,
    "ts_save_trajectory": _SAVED,
    "ts_adapt_": _CONTROL,
    "ts_max_reject": _CONTROL,
    "ts_max_step_rejections": _CONTROL,
    "ts_event_": "nothing looks for events",
    "options_left": "every option that is accepted has an effect",
    "options_view": "`fsipetsc info` shows the options of a result",
    "options_monitor": "`fsipetsc info` shows the options of a result",
    "options_string": "give the options themselves, or a file with -options_file",
    "prefix_": "options have no prefixes here",
    "python": "the program starts PETSc from Python",
    **dict.fromkeys(("ksp_", "pc_", "snes_", "mat_", "matstash_", "ts_max_snes"), _EXPLICIT),
    **dict.fromkeys(
        ("vec_", "vecload_", "vecscatter_", "vecstash_", "is_", "sf_", "petscsf_", "dm_", "da_", "layout_"), _OWN_LAYOUT
    ),
    "log_": "of PETSc's logs only -log_view works",
    "malloc": "of PETSc's checks of memory only -malloc_debug, -malloc_dump and -malloc_view work",
    **dict.fromkeys(("viewer_", "draw_", "saws", "nox", "display", "x_virtual"), "PETSc draws nothing here"),
}
#: other names and beginnings of names that are PETSc's
_OTHERS = (
    *("ts_", "options_", "device_", "root_device_", "random_", "hdf5_", "cuda_", "hip_", "kokkos_", "object_", "objects_"),
    *("on_error_", "error_output_", "start_in_debugger", "stop_for_debugger", "debug_terminal", "debugger_", "fp_trap"),
    *("check_pointer_intensity", "checkfunctionlist", "checkstack", "citations", "default_device_type", "get_total_flops"),
    *("history", "mpi_return_on_error", "mpidump", "not_shared_tmp", "shared_tmp", "petsc_", "splitreduction_", "tmp"),
    *("use_gpu_aware_mpi", "viewfromoptions", "info_exclude"),
)
_SHORT = ("v", "help", "version")


def is_family_name(name: str) -> bool:
    """True if a name (lower case, without dash) is one of PETSc's or starts like some of PETSc's."""
    here = {option.name for option in AT_START + IN_LOOP + IN_SOURCES}
    return name in here or name in _SHORT or name.startswith((*_REFUSED, *_OTHERS))


def is_start_name(name: str) -> bool:
    """True if PETSc looks at an option (lower case, without dash) only when it starts or ends."""
    return name in ("options_left", "skip_petscrc") or any(option.name == name for option in AT_START)


def why_refused(name: str) -> str | None:
    """Why an option of PETSc's (lower case, without dash) is not taken; None if it is no name of PETSc's."""
    reasons = [reason for start, reason in _REFUSED.items() if name.startswith(start)]
    if reasons:
        return reasons[0]
    return "PETSc has options of such names, but none that works here" if name.startswith(_OTHERS) else None
