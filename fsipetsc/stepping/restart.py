"""Checkpoints of a run: which one it goes on from, what may have changed since, how they are
written.

Options that are not given are those of the checkpoint. Those of FREE may be others: they change
nothing that is computed, or only how long steps are and by which method they are made.
"""

import os
import platform
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.errors import FileError, InputError
from fsipetsc.options import OF_A_RUN, PETSC_OPTIONS, groups, read_table
from fsipetsc.output import file_layout
from fsipetsc.output.file_layout import beside, check_folder
from fsipetsc.process.together import together
from fsipetsc.state import State

FREE = {
    *(option.name for option in PETSC_OPTIONS),
    *("fsi_output", "fsi_output_dt", "fsi_output_times", "ts_max_time", "ts_max_steps"),
    *("fsi_checkpoint", "fsi_checkpoint_steps", "fsi_checkpoint_wall"),
    *("fsi_partition", "fsi_norm", "fsi_check", "fsi_cfl", *OF_A_RUN),
}


class Past(NamedTuple):
    """What a run goes on from; the same on all ranks."""

    path: str
    header: dict[str, Any]
    arrays: dict[str, np.ndarray]

    @property
    def options(self) -> dict[str, Any]:
        """Return those that are taken over where they are not given."""
        return {k: v for k, v in self.header["options"].items() if k not in OF_A_RUN}


def versions() -> dict[str, str]:
    """Return versions of the program and of what it runs on."""
    packages = "fsipetsc", "petsc4py", "mpi4py", "numpy"
    return {
        **{name: import_module(name).__version__ for name in packages},
        "python": platform.python_version(),
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "mpi": MPI.Get_library_version().split(",")[0].split("\n")[0],
    }


def checkpoint_name(checkpoint: str | None, output: str) -> str:
    """Return -fsi_checkpoint; if not given, NAME.checkpoint.h5 beside the result NAME.h5."""
    return checkpoint or str(beside(output, ".checkpoint.h5"))


def find_past(case: Any, given: Mapping[str, str], comm: MPI.Comm) -> Past | None:
    """Return what -fsi_restart asks for, if anything. Collective. FileError, InputError."""
    if "fsi_restart" not in given:
        return None
    opt = read_table(groups(case), given)
    path = opt["fsi_restart"]
    if path == "auto":
        path = checkpoint_name(opt["fsi_checkpoint"], opt["fsi_output"])
        if not comm.bcast(os.path.exists(path)):
            return None

    past = together(comm, lambda: Past(path, *file_layout.read_checkpoint(path)))
    if (other := past.header["case"]) != case.NAME:
        what = f"is a checkpoint of the case {other}, not of {case.NAME}"
        raise InputError(f"-fsi_restart: {past.path} {what}")
    return past


def check_options(past: Past, opt: Mapping[str, Any], given: Mapping[str, str]) -> None:
    """InputError for an option that cannot change at a restart."""
    for name, now in opt.items():
        before = past.options.get(name, now)
        before = tuple(before) if isinstance(before, list) else before
        if name.lower() in given and name not in FREE and before != now:
            text = f"{before:g}" if isinstance(before, float) else str(before)
            raise InputError(
                f"-{name} {given[name.lower()]}: it was {text} when {past.path} was written, and "
                "cannot change at a restart; leave it out: what is not given is taken from the "
                "checkpoint"
            )


def facts(state: State) -> dict[str, Any]:
    """What must be the same at a restart, in words -> value, as JSON has it."""
    found: dict[str, Any] = {"the quantities recorded of a step": str(state.journal.dtype)}
    for layer, about in zip(state.problem.layers, state.header()["layers"], strict=True):
        of = f"of '{layer.name}'"
        found |= {f"kind {of}": layer.kind, f"nodes {of}": [*about["shape"][::-1]]}
        for name, value in vars(layer.material).items():
            if isinstance(value, (str, int, float)):
                found[f"{name} {of}"] = value
        found[f"force {of}"] = np.atleast_1d(layer.material.force).tolist()
    return found


def check_problem(past: Past, state: State) -> None:
    """InputError if the problem, or what is recorded of a step, is not that of the checkpoint."""
    now, before = facts(state), past.header["facts"]
    for name in {**now, **before}:
        a, b = now.get(name, "not there"), before.get(name, "not there")
        if a != b:
            when = f"when the checkpoint {past.path} was written"
            raise InputError(f"-fsi_restart: {name} is {a}, and was {b} {when}")


def check_place(
    comm: MPI.Comm, path: str, opt: Mapping[str, Any], past: Past | None
) -> Path | None:
    """Return a checkpoint at this name that is not the one the run goes on from, if there is one;
    on rank 0. InputError or FileError where no checkpoint can be written. Collective.
    """
    there = Path(os.path.realpath(path))

    def check() -> Path | None:
        if str(there) == os.path.realpath(opt["fsi_output"]):
            what = "that is where the result goes; give it another name"
            raise InputError(f"-fsi_checkpoint {path}: {what}")
        check_folder(path)
        if comm.rank > 0 or not there.exists():
            return None
        if not file_layout.is_checkpoint(there):
            raise FileError(f"{path}: exists and is not a checkpoint of fsipetsc")
        return None if past is not None and there.samefile(past.path) else there

    return together(comm, check)


def write_checkpoint(
    state: State, path: str, name: str, opt: Mapping[str, Any], more: Mapping[str, Any]
) -> None:
    """Write a checkpoint of the state as it is; more: entries of the header. Collective.
    CheckpointError.
    """
    arrays = state.capture()
    header = {"case": name, "options": dict(opt), "facts": facts(state), **more}

    def write() -> None:
        if arrays is not None:
            file_layout.write_checkpoint(path, header, arrays)

    together(state.comm, write)
