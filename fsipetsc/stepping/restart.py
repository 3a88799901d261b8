"""Checkpoints of a run: which one it goes on from, what may have changed since, how they are
written.

Options that are not given are those of the checkpoint. Some may be others: those of FREE change
nothing that is computed, those of STEPS only how long steps are and by which method they are made.
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
from fsipetsc.output import checkpoint_file
from fsipetsc.output.file_layout import beside, check_folder
from fsipetsc.process.together import together
from fsipetsc.state import State

FREE = OF_A_RUN | {
    *("fsi_output", "fsi_output_dt", "fsi_output_times", "ts_max_time", "ts_max_steps"),
    *("fsi_checkpoint", "fsi_checkpoint_steps", "fsi_checkpoint_wall"),
    *("fsi_partition", "fsi_norm", "fsi_check"),
}
STEPS = ({option.name for option in PETSC_OPTIONS} | {"fsi_cfl"}) - FREE


class Past(NamedTuple):
    """What a run goes on from; the same on all ranks. notes: lines that are to be said."""

    path: str
    header: dict[str, Any]
    arrays: dict[str, np.ndarray]
    notes: list[str]

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

    past = together(comm, lambda: Past(path, *checkpoint_file.read(path), []))
    if past.header["case"] != case.NAME:
        other = past.header["case"]
        raise InputError(
            f"-fsi_restart: {past.path} is a checkpoint of the case {other}, not of {case.NAME}"
        )
    return past


def check_options(past: Past, opt: Mapping[str, Any], given: Mapping[str, str]) -> None:
    """InputError for an option that cannot change at a restart; notes what may and does."""
    for name, now in opt.items():
        before = past.options.get(name, now)
        before = tuple(before) if isinstance(before, list) else before
        one = given.get(name.lower())
        if before == now or one is None or name in FREE:
            continue
        text = f"{before:g}" if isinstance(before, float) else str(before)
        was = "was not given" if before is None else f"was {text}"
        what = f"-{name} {one}: it {was} when {past.path} was written"
        leave = "leave it out: what is not given is taken from the checkpoint"
        if name not in STEPS:
            raise InputError(f"{what}, and cannot change at a restart; {leave}")
        past.notes.append(f"{what}; the steps are others from now on")


def described(problem: Any) -> list[dict[str, Any]]:
    """Return name, kind and numbers of each layer, by which another case is recognised."""
    plain = (bool, int, float, str)
    return [
        {"name": layer.name, "kind": layer.kind}
        | {k: v for k, v in vars(layer.material).items() if isinstance(v, plain)}
        for layer in problem.layers
    ]


def columns_of(state: State) -> list[list[Any]]:
    """Return name and shape of each column of the records of steps."""
    record = state.journal.dtype
    return [[name, list(record[name].shape)] for name in record.names]


def check_problem(past: Past, state: State) -> None:
    """InputError if the problem, or what is recorded of a step, is not that of the checkpoint."""
    when = f"when the checkpoint {past.path} was written"
    now, before = described(state.problem), past.header["problem"]
    if len(now) != len(before):
        raise InputError(f"-fsi_restart: the case had {len(before)} layers {when}, now {len(now)}")
    for k, about in enumerate(state.header()["layers"]):
        layer = {**now[k], "nodes": about["shape"][::-1]}
        other = {**before[k], "nodes": list(past.arrays[f"layer{k}"].shape[-2::-1])}
        for name, value in layer.items():
            if value != other.get(name):
                now_is = f"{name} of '{layer['name']}' is {value}"
                raise InputError(f"-fsi_restart: {now_is}, and was {other.get(name)} {when}")
    if columns_of(state) != past.header["columns"]:
        raise InputError(f"-fsi_restart: other quantities of steps were recorded {when}")


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
        if not checkpoint_file.is_one(there):
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
    header = {"case": name, "options": dict(opt), "problem": described(state.problem)}
    header |= {"columns": columns_of(state), **more}

    def write() -> None:
        if arrays is not None:
            checkpoint_file.write(path, header, arrays)

    together(state.comm, write)
