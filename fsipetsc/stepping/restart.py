"""Checkpoints of a run: which one it goes on from, what may have changed since, how it writes them.

Options that are not given are those of the checkpoint. Some may be others: those of FREE change
nothing that is computed, those of STEPS only how long steps are and by which method they are made.
"""

from __future__ import annotations

import datetime
import os
import platform
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

import fsipetsc
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import OF_A_RUN, PETSC_OPTIONS, spelt, table
from fsipetsc.output import checkpoint_file
from fsipetsc.output.checkpoint_file import Checkpoint
from fsipetsc.output.file_layout import describe
from fsipetsc.output.lock import set_aside
from fsipetsc.output.pieces import Kept, beside, folder_of
from fsipetsc.process.together import together
from fsipetsc.stepping.state import State

FREE = OF_A_RUN | {
    *("fsi_output", "fsi_output_dt", "fsi_output_times", "ts_max_time", "ts_max_steps"),
    *("fsi_checkpoint", "fsi_checkpoint_steps", "fsi_checkpoint_wall"),
    *("fsi_partition", "fsi_norm", "fsi_check"),
}
STEPS = ({option.name for option in PETSC_OPTIONS} | {"fsi_cfl"}) - FREE
AUTO = "auto"


class Past(NamedTuple):
    """What a run goes on from; the same on all ranks. notes: lines that are to be said."""

    path: str
    header: dict[str, Any]
    arrays: dict[str, np.ndarray]
    notes: list[str]

    @property
    def options(self) -> dict[str, Any]:
        """Those that are taken over where they are not given."""
        return {k: v for k, v in self.header["options"].items() if k not in OF_A_RUN}


def versions() -> dict[str, str]:
    """Versions of the program and of what it runs on."""
    import mpi4py
    import numba
    import petsc4py

    return {
        "fsipetsc": fsipetsc.__version__,
        "python": platform.python_version(),
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "petsc4py": petsc4py.__version__,
        "mpi4py": mpi4py.__version__,
        "mpi": MPI.Get_library_version().split(",")[0].split("\n")[0],
        "numba": numba.__version__,
        "numpy": np.__version__,
    }


# the checkpoint to go on from


def checkpoint_name(checkpoint: str | None, output: str) -> str:
    """The file of -fsi_checkpoint; NAME.checkpoint.h5 beside the result NAME.h5 if not given."""
    return checkpoint or str(beside(output, ".checkpoint.h5"))


def find_past(case: Any, given: Mapping[str, str], comm: MPI.Comm) -> Past | None:
    """What -fsi_restart asks for, if anything. Collective. FileError, InputError."""
    if "fsi_restart" not in given:
        return None
    options = table(case)
    names = "fsi_restart", "fsi_checkpoint", "fsi_output"
    asked, *files = (
        options[name].parse(given[name]) if name in given else options[name].default
        for name in names
    )

    def find() -> Past | None:
        if comm.rank > 0:
            return None
        auto = asked == AUTO
        return _newest(checkpoint_name(*files)) if auto else Past(asked, *_read(asked), [])

    past = _known_to_all(together(comm, find), comm)
    if past is not None and past.header["case"] != case.NAME:
        other = past.header["case"]
        raise InputError(
            f"-fsi_restart: {past.path} is a checkpoint of the case {other}, not of {case.NAME}"
        )
    return past


def _newest(name: str) -> Past | None:
    """The newest good one of this name; None if there is none. FileError if all are damaged."""
    whys = []
    for path in (Path(name), checkpoint_file.previous(name)):
        if path.exists():
            try:
                return Past(str(path), *_read(path), [f"note: {why}" for why in whys])
            except FileError as error:
                whys.append(str(error))
    if whys:
        raise FileError(f"{'; '.join(whys)}; without them -fsi_restart auto begins anew")
    return None


def _read(path: str | os.PathLike[str]) -> Checkpoint:
    """The checkpoint in a file, with all that is relied on before the run goes on. FileError."""
    found = checkpoint_file.read(path)
    header = found.header
    try:
        frames, rows = header["result"]
        relied_on = [header["case"], header["run"]["run"], header["problem"][0]["name"]]
        numbers = [header["memory"]["t"], header["memory"]["steps"], frames, rows]
        good = "fsi_partition" in header["options"] and isinstance(header["columns"], list)
        good = good and isinstance(header["options"], dict) and isinstance(header["memory"], dict)
        good = good and all(isinstance(text, str) for text in relied_on)
        good = good and all(isinstance(number, (int, float)) for number in numbers)
    except (KeyError, TypeError, ValueError, IndexError):
        good = False
    if not good:
        what = "its header does not tell case, run, options and result"
        raise FileError(f"{os.fspath(path)}: is not a checkpoint of fsipetsc: {what}")
    return found


def _known_to_all(found: Past | None, comm: MPI.Comm) -> Past | None:
    """What rank 0 has found. Collective. Arrays are sent one by one: they may be large."""
    told = None
    if found is not None:
        told = found._replace(arrays={k: (a.shape, a.dtype) for k, a in found.arrays.items()})
    past = comm.bcast(told)
    if past is None:
        return None
    for name, (shape, kind) in past.arrays.items():
        array = np.empty(shape, kind) if found is None else found.arrays[name].copy()
        comm.Bcast(array.reshape(-1).view(np.uint8))
        past.arrays[name] = array
    return past


# what may have changed


def check_options(past: Past, opt: Mapping[str, Any], given: Mapping[str, str]) -> None:
    """InputError for an option that cannot change at a restart; notes what may and does."""
    for name, now in opt.items():
        before = past.options.get(name, now)
        before = tuple(before) if isinstance(before, list) else before
        one = spelt(given, name)
        if before == now or one is None or name in FREE:
            continue
        was = "was not given" if before is None else f"was {_text(before)}"
        what = f"-{name} {one}: it {was} when {past.path} was written"
        leave = "leave it out: what is not given is taken from the checkpoint"
        if name not in STEPS:
            raise InputError(f"{what}, and cannot change at a restart; {leave}")
        past.notes.append(f"note: {what}; the steps are others from now on")


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def described(problem: Any) -> list[dict[str, Any]]:
    """Names and numbers of each layer, by which another case is recognised; as JSON has them."""
    plain = (bool, int, float, str)
    return [
        {"name": layer.name, "kind": layer.kind, "X": _ends(layer)}
        | ({"nodes": list(layer.shape)} if hasattr(layer, "shape") else {})
        | {k: v for k, v in vars(layer.material).items() if isinstance(v, plain)}
        for layer in problem.layers
    ]


def _ends(layer: Any) -> list[float]:
    """X of the ends of a layer, or of the corners of a block, to nine digits of its size."""
    if hasattr(layer, "X"):
        X = np.array(layer.X)
    else:
        corners = np.indices((2,) * layer.dimension)
        X = layer.places([i * (n - 1) for i, n in zip(corners, layer.shape, strict=True)])
    digits = 9 - int(np.log10(np.ptp(X)))
    return (X.ravel().round(digits) + 0.0).tolist()


def check_problem(past: Past, problem: Any, columns: list[list[Any]]) -> None:
    """InputError if the problem, or what is recorded of a step, is not that of the checkpoint."""
    when = f"when the checkpoint {past.path} was written"
    now, before = described(problem), past.header["problem"]
    if len(now) != len(before):
        raise InputError(f"-fsi_restart: the case had {len(before)} layers {when}, now {len(now)}")
    for layer, other in zip(now, before, strict=True):
        for name in sorted(layer.keys() | other.keys()):
            if layer.get(name) != other.get(name):
                kind, was = "block" if "nodes" in layer else "layer", other.get(name)
                of = f"of {kind} '{layer['name']}'"
                if name == "X" and len(layer["X"]) > 2:
                    raise InputError(f"-fsi_restart: the corners {of} were at other places {when}")
                now_is = f"{name} {of} is {layer.get(name)}"
                raise InputError(f"-fsi_restart: {now_is}, and was {was} {when}")
    if columns != past.header["columns"]:
        raise InputError(f"-fsi_restart: other quantities of steps were recorded {when}")


class CheckpointKeeper:
    """Writes the checkpoints of a run. Collective. FileError, InputError where none can be written.

    path: of the file. past: what the run goes on from. run: what the header of the result says of
    the run: "run", by which result and checkpoint know each other, "created", and the "restarts"
    since. arrays: of the checkpoint that it goes on from. kept: on rank 0, lines on what has got
    another name.
    """

    def __init__(
        self, comm: MPI.Comm, name: str, opt: Mapping[str, Any], state: State, past: Past | None
    ) -> None:
        self._comm, self._name, self._opt, self._state = comm, name, opt, state
        self.past, self.kept = past, []
        self.path = checkpoint_name(opt["fsi_checkpoint"], opt["fsi_output"])
        together(comm, self._check)
        self.arrays = {} if past is None else dict(past.arrays)
        if past is None:
            created = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
            self.run: dict[str, Any] = {"run": uuid.uuid4().hex, "created": created}
            return
        if past.options["fsi_partition"] != opt["fsi_partition"]:
            self.arrays.pop("shares", None)
        memory, run = past.header["memory"], past.header["run"]
        this = {"t": memory["t"], "step": memory["steps"], "ranks": comm.size}
        self.run = {**run, "restarts": [*run.get("restarts", []), {**this, "versions": versions()}]}

    def _check(self) -> None:
        if self._comm.rank > 0:
            return
        result = os.path.realpath(self._opt["fsi_output"])
        if result in map(os.path.realpath, (self.path, checkpoint_file.previous(self.path))):
            what = "that is where the result goes; give it another name"
            raise InputError(f"-fsi_checkpoint {self.path}: {what}")
        names = "fsi_checkpoint", "fsi_checkpoint_steps", "fsi_checkpoint_wall"
        if any(self._opt[name] for name in names):
            checkpoint_file.check_place(self.path)

    @property
    def written_before(self) -> Kept | None:
        """What the result had at the checkpoint; None if the run begins."""
        if self.past is None:
            return None
        frames, rows = self.past.header["result"]
        return Kept(int(frames), int(rows), float(self.past.header["memory"]["t"]))

    def settle(self, earlier: list[Path]) -> dict[Path, Path]:
        """Move what other runs have left out of the way; drop own checkpoints beyond this one.

        earlier: what there is of a result of this name that is to be kept. Returns old -> new
        names. On rank 0, when no other run may write the result. FileError.
        """
        names = self._opt["fsi_output"], self.path
        result, newest = (Path(os.path.realpath(path)) for path in names)
        checkpoint_file.draft_of(newest).unlink(missing_ok=True)  # of a run that was killed
        own = [newest, checkpoint_file.previous(newest)]
        whose = {file: self._whose(file) for file in own}
        others = [file for file in own if whose[file] == "another"]
        for file in own:
            if whose[file] == "abandoned":  # -fsi_restart auto would take it
                try:
                    file.unlink()
                except OSError as error:
                    what = "of steps that are given up, cannot be removed"
                    raise FileError(f"{file}: {what}: {error.strerror}") from None
        stem = beside(result, "").name
        moved = set_aside(earlier, stem, [result, folder_of(result)])
        moved |= set_aside(others, newest.stem, own)
        if earlier:
            kept = moved[earlier[0]].name.removesuffix(".parts").removesuffix(".h5")
            kept = result.with_name(kept + result.name.removeprefix(stem))
            self.kept.append(f"kept the earlier {self._opt['fsi_output']} as {kept}")
        if others:
            listed = ", ".join(str(moved[file]) for file in others)
            self.kept.append(f"kept earlier checkpoints as {listed}")
        return moved

    def _whose(self, file: Path) -> str:
        """"another" run's, or "abandoned": of this run, beyond the checkpoint that it goes on from.

        Of a damaged one nobody can tell: a run that goes on takes it for its own.
        """
        if self.past is None:
            try:
                return "another" if checkpoint_file.is_one(file) else ""
            except OSError as error:
                raise FileError(f"{file}: cannot be read: {error.strerror}") from None
        try:
            header = _read(file).header
        except FileError:
            return ""
        if header["run"]["run"] != self.run["run"]:
            return "another"
        later = header["memory"]["steps"] > self.past.header["memory"]["steps"]
        return "abandoned" if later else ""

    def lines(self) -> list[str]:
        """What is to be said of the checkpoint that the run goes on from."""
        if self.past is None:
            return []
        memory, s = self.past.header["memory"], self._state.problem.unit("s")
        when = f"step {memory['steps']}, t = {memory['t']:.6g}{s}"
        return [*self.past.notes, f"goes on from {self.past.path}: {when}"]

    def write(self, memory: Mapping[str, Any]) -> None:
        """Write a checkpoint of the state as it is, with what else there is to know.

        CheckpointError.
        """
        arrays = self._state.capture()
        together(self._comm, lambda: self._write(memory, arrays))

    def _write(self, memory: Mapping[str, Any], arrays: dict[str, np.ndarray] | None) -> None:
        if arrays is None:
            return
        header = {
            "case": self._name,
            "options": dict(self._opt),
            "versions": versions(),
            "ranks": self._comm.size,
            "problem": described(self._state.problem),
            "columns": describe(self._state.journal.dtype),
            "run": self.run,
            **memory,
        }
        checkpoint_file.write(self.path, checkpoint_file.pack(Checkpoint(header, arrays)))
