"""Checkpoints of a run: which one it goes on from, and what may have changed since.

Options that are not given are those of the checkpoint. Those of FREE may be others: they change
nothing that is computed, or only how long steps are and by which method they are made.
"""

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import FileError, InputError
from fsipetsc.options import CHECKPOINTS, OUTPUT, PETSC_OPTIONS, RUN, groups, read_table
from fsipetsc.output.file_layout import CHECKPOINT, beside, check_folder, opened, read_checkpoint
from fsipetsc.process.together import together
from fsipetsc.state import State

FREE = {option.name for option in (*PETSC_OPTIONS, *OUTPUT, *CHECKPOINTS, *RUN)}
FREE = FREE - {"fsi_probes"} | {"fsi_cfl"}


class Past(NamedTuple):
    """What a run goes on from. Its options are taken over where they are not given."""

    path: str
    header: dict[str, Any]
    arrays: dict[str, np.ndarray]

    def check(self, now: Mapping[str, str]) -> None:
        """InputError for what must be as it was, and is not. Options may have come or gone."""
        before = self.header["facts"]
        for name in {**now, **before}:
            a, b = (known.get(name, "not there") for known in (now, before))
            if a != b and not (name.startswith("-") and "not there" in (a, b)):
                raise InputError(
                    f"{name} {a}: it was {b} when {self.path} was written, and cannot change at a "
                    "restart; options that are left out are those of the checkpoint"
                )

    def check_options(self, opt: Mapping[str, Any]) -> None:
        """The same for options alone, before they make a grid, which may be none."""
        self.check({**self.header["facts"], **_options(opt)})


def _options(opt: Mapping[str, Any]) -> dict[str, str]:
    lists = {name: list(of) if isinstance(of, tuple) else of for name, of in opt.items()}
    return {f"-{name}": str(of) for name, of in lists.items() if name not in FREE}


def facts(state: State, opt: Mapping[str, Any]) -> dict[str, str]:
    """What must be the same at a restart, in words -> as text."""
    found = {**_options(opt), "the record of a step": str(state.journal.dtype)}
    for layer, shape in zip(state.problem.layers, state.shapes, strict=True):
        known = {"kind": layer.kind, "shape": shape, **vars(layer.material)}
        plain = {k: str(of) for k, of in known.items() if isinstance(of, (str, int, float, tuple))}
        found |= {f"{name} of '{layer.name}'": text for name, text in plain.items()}
    return found


def checkpoint_name(opt: Mapping[str, Any]) -> str:
    """Return -fsi_checkpoint; if not given, NAME.checkpoint.h5 beside the result NAME.h5."""
    return opt["fsi_checkpoint"] or str(beside(opt["fsi_output"], ".checkpoint.h5"))


def find_past(case: Any, given: Mapping[str, str], comm: MPI.Comm) -> Past | None:
    """Return what -fsi_restart asks for, if anything. Collective. FileError, InputError."""
    if "fsi_restart" not in given:
        return None
    opt = read_table(groups(case), given)
    path = opt["fsi_restart"]
    if path == "auto":
        path = checkpoint_name(opt)
        if not comm.bcast(os.path.exists(path)):
            return None
    header, arrays = together(comm, lambda: read_checkpoint(path))
    if header["case"] != case.NAME:
        what = f"is a checkpoint of the case {header['case']}, not of {case.NAME}"
        raise InputError(f"-fsi_restart: {path} {what}")
    return Past(path, header, arrays)


def other_checkpoint(path: str, opt: Mapping[str, Any], past: Past | None) -> Path | None:
    """A checkpoint at this name that is not the past one. InputError, FileError."""
    there = Path(os.path.realpath(path))
    if str(there) == os.path.realpath(opt["fsi_output"]):
        what = "that is where the result goes; give it another name"
        raise InputError(f"-fsi_checkpoint {path}: {what}")
    for file in (opt["fsi_output"], path):
        check_folder(file)
    if not there.exists() or (past is not None and there.samefile(past.path)):
        return None
    with suppress(FileError), opened(there, {"format": CHECKPOINT["format"]}):
        return there
    what = "no checkpoint of fsipetsc, or one that is damaged or of another version"
    raise FileError(f"{path}: exists, and is {what}: rename it, or remove it")
