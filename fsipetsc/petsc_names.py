"""Names of PETSc's own options, so that a misspelt one is not silently ignored.

PETSc cannot say which names it knows. Those that start with -ts_ or -log_ and the ones without a family are listed,
all those of PETSc 3.18 that make sense here and what is known of later ones; of the other families any name is taken.
"""

from __future__ import annotations

#: release of PETSc up to which the lists are complete
NEWEST_LISTED = (3, 18)

_TS = """
adapt_always_accept adapt_clip adapt_dsp_alpha adapt_dsp_filter adapt_dsp_kbeta adapt_dsp_pid adapt_dt_max
adapt_dt_min adapt_max_ignore adapt_monitor adapt_reject_safety adapt_safety adapt_scale_solve_failed
adapt_time_step_increase_delay adapt_type adapt_view adapt_wnormtype atol convergence_estimate dt error_if_step_fails
event_dt_min event_monitor event_post_event_step event_post_event_second_step event_recorder_initial_size event_tol
exact_final_time final_time init_time max_reject max_snes_failures max_step_rejections max_steps max_time monitor
monitor_cancel monitor_dmda_ray monitor_draw_error monitor_draw_solution monitor_draw_solution_function
monitor_draw_solution_initial monitor_draw_solution_phase monitor_draw_solution_show_time monitor_envelope
monitor_error monitor_extreme monitor_frequency monitor_lg_dmda_ray monitor_lg_error monitor_lg_solution
monitor_lg_solution_semilogy monitor_lg_solution_variables monitor_lg_timestep monitor_lg_timestep_log monitor_python
monitor_solution monitor_solution_skip_initial monitor_solution_vtk monitor_solution_vtk_interval
monitor_wall_clock_time rk_type rtol run_steps save_trajectory ssp_nstages ssp_type time_step trajectory_dirname
trajectory_file_template trajectory_keep_files trajectory_monitor trajectory_solution_only trajectory_stride
trajectory_type trajectory_view type view view_pre view_solution
"""
_LOG = """
all exclude exclude_actions exclude_objects mpe nvtx perfstubs roctx summary sync threshold trace view
view_gpu_energy view_gpu_energy_meter view_gpu_time view_memory
"""
_OPTIONS = """
file file_yaml gui left monitor monitor_cancel string_yaml suppress_deprecated_warnings view
"""
_SINGLE = """
check_pointer_intensity checkfunctionlist checkstack citations debug_terminal debugger_nodes debugger_pause
debugger_ranks default_device_type display error_output_none error_output_stdout fp_trap get_total_flops help history
info info_exclude memory_view mpi_return_on_error mpidump no_signal_handler not_shared_tmp nox nox_warning
objects_dump on_error_abort on_error_attach_debugger on_error_emacs on_error_malloc_dump on_error_mpiabort petsc_ci
petsc_ci_portable_error_output petsc_sleep prefix_pop prefix_push python shared_tmp skip_petscrc splitreduction_async
start_in_debugger stop_for_debugger tmp use_gpu_aware_mpi v version viewfromoptions x_virtual
"""

#: -ts_… options that change what a run means in a way this program does not follow, and why
REFUSED = {
    "ts_adjoint_solve": "there is no adjoint of this problem",
    "ts_eval_times": "the times of output are set by -fsi_output_dt or -fsi_output_times",
    "ts_fd_color": "there is no Jacobian: all methods are explicit",
    "ts_rk_multirate": "the right-hand side is not split into slow and fast parts",
    "ts_time_span": "the times of output are set by -fsi_output_dt or -fsi_output_times",
    "ts_use_splitrhsfunction": "the right-hand side is not split into slow and fast parts",
}

#: every name that is known exactly
KNOWN = frozenset(
    [f"ts_{name}" for name in _TS.split()]
    + [f"log_{name}" for name in _LOG.split()]
    + [f"options_{name}" for name in _OPTIONS.split()]
    + _SINGLE.split()
)

#: options that PETSc follows when it starts or when it ends; those taken out mean nothing, or always the same, here
_AT_START = frozenset(
    [f"log_{name}" for name in _LOG.split()]
    + [f"options_{name}" for name in ("gui", "left", "monitor", "monitor_cancel", "view")]
    + _SINGLE.split()
).difference(("help", "no_signal_handler", "prefix_pop", "prefix_push", "skip_petscrc"))

#: families whose names are all in KNOWN
_LISTED = ("ts_", "log_", "options_")
#: families of which any name is taken
_OPEN = (
    *("malloc", "vec_", "vecload_", "vecscatter_", "vecstash_", "is_", "sf_", "dm_", "da_", "mat_", "ksp_", "pc_"),
    *("snes_", "viewer_", "draw_", "device_", "root_device_", "saws", "random_", "hdf5_", "cuda_", "hip_", "kokkos_"),
    *("petscsf_", "object_", "on_error_", "matstash_", "layout_"),
)


def is_family_name(name: str) -> bool:
    """True if a name (lower case, without dash) starts like one of PETSc's, spelt rightly or not."""
    return name in KNOWN or name.startswith(_LISTED + _OPEN)


def is_open_family_name(name: str) -> bool:
    """True if a name belongs to a family of PETSc's of which this module does not know every name."""
    return name.startswith(_OPEN)


def is_start_name(name: str) -> bool:
    """True if PETSc looks at an option (lower case, without dash) only when it starts or ends."""
    return name in _AT_START or name.startswith(("malloc", "on_error_"))
