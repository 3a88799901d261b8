"""What a run goes on from: the checkpoint of -fsi_restart, its options, and what may be others now.

Options that are not given are those of the checkpoint. Of those that are given, some may change what is computed from now on
only if the command line itself says so, not a file of options of former days (STEPS); some change nothing that is computed
(FREE); all others, those of the case among them, must be what they were.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import FileError, InputError
from fsipetsc.options import OF_A_RUN, PETSC_OPTIONS, spelt, table
from fsipetsc.options.sources import Given
from fsipetsc.output import checkpoint_file
from fsipetsc.output.checkpoint_file import Checkpoint
from fsipetsc.process.together import together

FREE = OF_A_RUN | {
    *("fsi_output", "fsi_output_dt", "fsi_output_times", "fsi_checkpoint", "fsi_checkpoint_steps", "fsi_checkpoint_wall"),
    *("fsi_burst", "fsi_partition", "fsi_norm", "fsi_check", "ts_max_time", "ts_max_steps"),
}
STEPS = ({option.name for option in PETSC_OPTIONS} | {"fsi_cfl"}) - FREE
AUTO = "auto"
_Found = tuple[str, Checkpoint, list[str]]  # path, content, notes


class Past(NamedTuple):
    """What a run goes on from; the same on all ranks. notes: lines that are to be said."""

    path: str
    header: dict[str, Any]
    arrays: dict[str, np.ndarray]
    notes: list[str]

    @property
    def options(self) -> dict[str, Any]:
        """Those that are taken over where they are not given."""
        return {name: value for name, value in self.header["options"].items() if name not in OF_A_RUN}


def checkpoint_name(checkpoint: str | None, output: str) -> str:
    """The file of -fsi_checkpoint; where it is not given NAME.checkpoint.h5 beside the result NAME.h5."""
    return checkpoint or str(Path(output).with_name(f"{Path(output).stem}.checkpoint.h5"))


def find_past(case: Any, given: Mapping[str, Given], comm: MPI.Comm) -> Past | None:
    """What -fsi_restart asks for, if anything. Collective. FileError, InputError."""
    asked = given.get("fsi_restart")
    if asked is None:
        return None
    options = table(case)
    values = {
        name: options[name].parse(given[name].text) if name in given else options[name].default
        for name in ("fsi_restart", "fsi_checkpoint", "fsi_output")
    }
    own = checkpoint_name(values["fsi_checkpoint"], values["fsi_output"])
    found = together(comm, lambda: _find(values["fsi_restart"], own) if comm.rank == 0 else None)
    past = _known_to_all(found, comm)
    if past is not None and past.header["case"] != case.NAME:
        raise InputError(f"-fsi_restart: {past.path} is a checkpoint of the case {past.header['case']}, not of {case.NAME}")
    return past


def _find(asked: str, own: str) -> _Found | None:
    """What -fsi_restart asks for; own: where the run will write its checkpoints."""
    return _newest(own) if asked == AUTO else _named(asked)


def check_unchanged(past: Past | None, asked: str, own: str) -> None:
    """FileError if another run has written checkpoints since those were looked for that this one goes on from.

    past: None if -fsi_restart auto has found none. On rank 0, when no other run may write there any more.
    """
    found = _find(asked, own)
    now, before = found and _identity(found[1].header), past and _identity(past.header)
    if now != before:
        changed = own if past is None else past.path
        raise FileError(f"{changed}: has changed since it was read: another run has gone on; start again")


def _identity(header: Mapping[str, Any]) -> tuple[Any, ...]:
    return _run(header), header["memory"]["steps"], header["memory"]["t"]


def remove_abandoned(past: Past, path: str) -> None:
    """Remove checkpoints of the same run beyond the one that it goes on from: -fsi_restart auto would take them for the newest.

    path: where the run will write its own; what else there is of it elsewhere is not touched. On rank 0. FileError.
    """
    memory = past.header["memory"]
    for file in (Path(path), checkpoint_file.previous(path)):
        good, _ = _good(file)
        if good is None or _run(good.header) != _run(past.header):
            continue
        steps, t = good.header["memory"]["steps"], good.header["memory"]["t"]
        if steps > memory["steps"] or (steps == memory["steps"] and t != memory["t"]):
            try:
                file.unlink()
            except OSError as error:
                raise FileError(f"{file}: of steps that are given up, cannot be removed: {error.strerror}") from None


def is_of_another(path: Path, past: Past | None) -> bool:
    """Whether there is a checkpoint of another run than the one that goes on from this; past: None if one begins. On rank 0.

    Of a damaged one nobody can go on, nor tell whose it is: a run that goes on takes it for its own.
    """
    if past is None:
        return checkpoint_file.is_one(path)
    good, _ = _good(path)
    return good is not None and _run(good.header) != _run(past.header)


def _named(name: str) -> _Found:
    """The checkpoint of a file. FileError, which names the one before it if that is whole."""
    try:
        return name, checkpoint_file.read(name), []
    except FileError as error:
        before = checkpoint_file.previous(name)
        if "damaged" in str(error) and _good(before)[0] is not None:
            raise FileError(f"{error}; the one before it is whole: {before}") from None
        raise


def _newest(name: str) -> _Found | None:
    """The newest good one of this name, None if there is none: of two runs that of the one which has written last."""
    found: list[tuple[int, str, Checkpoint]] = []
    notes = []
    for path in (Path(name), checkpoint_file.previous(name)):
        good, why = _good(path)
        if good is not None:
            found.append((good.header["memory"]["steps"], str(path), good))
        elif path.exists():
            notes.append(why)
    if not found:
        if notes:
            raise FileError(f"{'; '.join(notes)}; without them -fsi_restart auto begins anew")
        return None
    same = len({_run(entry[2].header) for entry in found}) == 1
    _, path, good = max(found, key=lambda entry: entry[0]) if same else found[0]
    return path, good, [f"note: {why}" for why in notes]


def _run(header: Mapping[str, Any]) -> str | None:
    return header.get("run", {}).get("run")


def _good(path: Path) -> tuple[Checkpoint | None, str]:
    try:
        return checkpoint_file.read(path), ""
    except FileError as error:
        return None, str(error)


def _known_to_all(found: _Found | None, comm: MPI.Comm) -> Past | None:
    """What rank 0 has found. Collective."""
    shapes = None
    if found is not None:
        shapes = {name: (array.shape, array.dtype.str) for name, array in found[1].arrays.items()}
    told = comm.bcast(None if found is None else (found[0], found[1].header, found[2], shapes))
    if told is None:
        return None
    path, header, notes, shapes = told
    arrays = {}
    for name, (shape, kind) in shapes.items():
        arrays[name] = np.ascontiguousarray(found[1].arrays[name]) if found is not None else np.empty(shape, kind)
        comm.Bcast(arrays[name].view(np.uint8).reshape(-1) if arrays[name].size else np.empty(0, np.uint8))
    return Past(path, header, arrays, notes)


def check_options(past: Past, opt: Mapping[str, Any], given: Mapping[str, Given]) -> None:
    """InputError for an option that cannot change at a restart, or not so; notes what does. Not collective."""
    for name, now in opt.items():
        before = past.options.get(name, now)
        before = tuple(before) if isinstance(before, list) else before
        one = spelt(given, name)
        if before == now or one is None:
            continue
        was = "it was not given" if before is None else f"it was {_text(before)}"
        what = f"-{one.name} {one.text}{one.where}: {was} when the checkpoint {past.path} was written"
        leave = "leave it out: what is not given is taken from the checkpoint"
        if name == "fsi_check" and (before is None or now is None):
            raise InputError(f"{what}, and a check of conservation begins at t = 0; {leave}")
        if name in STEPS and one.where:
            raise InputError(f"{what}; {leave}; or say it on the command line, if the steps are to be others from now on")
        if name in STEPS:
            past.notes.append(f"note: {what}; the steps are others from now on")
        elif name not in FREE:
            raise InputError(f"{what}, and cannot change at a restart; {leave}")


def _text(value: Any) -> str:
    return ",".join(map(_text, value)) if isinstance(value, tuple) else f"{value:g}" if isinstance(value, float) else str(value)


def described(problem: Any) -> list[dict[str, Any]]:
    """What a checkpoint says of each layer of a problem, so that another one is recognised; as JSON has it."""
    found = []
    for layer in problem.layers:
        numbers = {"name": layer.name, "kind": layer.kind}
        for name in ("X", "Y"):
            if getattr(layer, name, None) is not None:
                numbers[name] = list(getattr(layer, name))
        if is_dataclass(layer.material):
            values = {entry.name: getattr(layer.material, entry.name) for entry in fields(layer.material)}
            numbers |= {name: value for name, value in values.items() if isinstance(value, (bool, int, float, str))}
        found.append(numbers)
    return found


def check_problem(past: Past, problem: Any, columns: list[list[Any]]) -> None:
    """InputError if the problem, or what is recorded of a step, is not that of the checkpoint. Not collective."""
    now, before = described(problem), past.header["problem"]
    if [layer["name"] for layer in now] != [layer["name"] for layer in before]:
        raise InputError(f"-fsi_restart: the case has other layers than the checkpoint {past.path}")
    for layer, other in zip(now, before, strict=True):
        for name in sorted(layer.keys() | other.keys()):
            if layer.get(name) != other.get(name):
                what = f"{name} of layer '{layer['name']}' is {layer.get(name)}, and was {other.get(name)}"
                raise InputError(f"-fsi_restart: {what} when the checkpoint {past.path} was written")
    if columns != past.header["columns"]:
        raise InputError(f"-fsi_restart: other quantities are recorded than when the checkpoint {past.path} was written")
