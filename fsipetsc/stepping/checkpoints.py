"""The checkpoints of a run: what is in them, and where they are."""

from __future__ import annotations

import datetime
import os
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import InputError
from fsipetsc.output import checkpoint_file
from fsipetsc.output.checkpoint_file import Checkpoint
from fsipetsc.output.file_layout import describe
from fsipetsc.output.lock import set_aside
from fsipetsc.output.pieces import Kept, folder_of
from fsipetsc.process.together import together
from fsipetsc.stepping.restart import Past, check_unchanged, checkpoint_name, described, is_of_another, remove_abandoned
from fsipetsc.stepping.state import State
from fsipetsc.stepping.versions import versions


class CheckpointKeeper:
    """Writes the checkpoints of a run. Collective on comm. FileError, InputError where none could be written.

    Two runs with results of different names and one name for their checkpoints are the user's to avoid.

    path: of the file. past: what the run goes on from. run: what the header of the result says of the run: "run", by which
    result and checkpoint know each other, when it was "created", and the "restarts" since. arrays: of the checkpoint that it
    goes on from. kept: on rank 0, lines on what has got another name.
    """

    def __init__(self, comm: MPI.Comm, name: str, opt: Mapping[str, Any], state: State, past: Past | None) -> None:
        self._comm, self._name, self._opt, self._state, self.past = comm, name, opt, state, past
        self.path = checkpoint_name(opt["fsi_checkpoint"], opt["fsi_output"])
        self.kept: list[str] = []
        together(comm, self._check)
        self.run = self._begin() if past is None else self._go_on(past)
        self.arrays = {} if past is None else dict(past.arrays)
        if past is not None and past.options["fsi_partition"] != opt["fsi_partition"]:
            self.arrays.pop("shares", None)

    def _check(self) -> None:
        if self._comm.rank > 0:
            return
        result = os.path.realpath(self._opt["fsi_output"])
        if result in map(os.path.realpath, (self.path, checkpoint_file.previous(self.path))):
            raise InputError(f"-fsi_checkpoint {self.path}: that is where the result goes; give it another name")
        if any(self._opt[name] for name in ("fsi_checkpoint", "fsi_checkpoint_steps", "fsi_checkpoint_wall")):
            checkpoint_file.check_place(self.path)

    def _begin(self) -> dict[str, Any]:
        created = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
        return {"run": uuid.uuid4().hex, "created": created}

    def _go_on(self, past: Past) -> dict[str, Any]:
        """The same run: only its restarts are noted."""
        memory, run = past.header["memory"], past.header["run"]
        this = {"t": memory["t"], "step": memory["steps"], "ranks": self._comm.size, "versions": versions()}
        return {**run, "restarts": [*run.get("restarts", []), this]}

    @property
    def written_before(self) -> Kept | None:
        """What the result had at the checkpoint; None if the run begins."""
        if self.past is None:
            return None
        frames, rows = self.past.header["result"]
        return Kept(int(frames), int(rows), float(self.past.header["memory"]["t"]))

    def settle(self, earlier: list[Path]) -> dict[Path, Path]:
        """From now on there is nothing beyond the checkpoint that the run goes on from, nor one of another run in the way.

        earlier: what there is of a result of this name that is to be kept: it gets the same number as checkpoints that
        are named after it. Returns old -> new names. On rank 0, when no other run may write the result. FileError.
        """
        if self._opt["fsi_restart"]:  # who had the right until now may have written
            check_unchanged(self.past, self._opt["fsi_restart"], self.path)
        if self.past is not None:
            remove_abandoned(self.past, self.path)
        result, newest = (Path(os.path.realpath(path)) for path in (self._opt["fsi_output"], self.path))
        checkpoint_file.draft_of(newest).unlink(missing_ok=True)  # of a run that was killed
        own = [newest, checkpoint_file.previous(newest)]
        others = [file for file in own if is_of_another(file, self.past)]
        if newest.parent == result.parent and newest.name.startswith(f"{result.stem}."):
            names = set_aside([*earlier, *others], result.stem, [result, folder_of(result), *own])
        else:
            names = set_aside(earlier, result.stem, [result, folder_of(result)]) | set_aside(others, newest.stem, own)
        if earlier:
            kept = names[earlier[0]].with_suffix(result.suffix)
            self.kept.append(f"kept the earlier {self._opt['fsi_output']} as {kept}")
        if others:
            self.kept.append(f"kept earlier checkpoints as {', '.join(str(names[file]) for file in others)}")
        return names

    def lines(self) -> list[str]:
        """What is to be said of the checkpoint that the run goes on from."""
        if self.past is None:
            return []
        memory, s = self.past.header["memory"], self._state.problem.unit("s")
        lines = [*self.past.notes, f"goes on from {self.past.path}: step {memory['steps']}, t = {memory['t']:.6g}{s}"]
        changed = [
            f"{name} {was}, now {now}"
            for (name, was), now in ((item, versions().get(item[0])) for item in self.past.header["versions"].items())
            if was != now
        ]
        return lines + ([f"note: it was written by others: {'; '.join(changed)}"] if changed else [])

    def write(self, memory: Mapping[str, Any]) -> None:
        """Write a checkpoint of the state as it is. memory: what else there is to know. CheckpointError."""
        arrays = self._state.capture()
        together(self._comm, lambda: self._write(memory, arrays))

    def _write(self, memory: Mapping[str, Any], arrays: dict[str, np.ndarray] | None) -> None:
        if arrays is None:
            return
        header = {
            **{"case": self._name, "options": dict(self._opt), "versions": versions(), "ranks": self._comm.size},
            **{"problem": described(self._state.problem), "columns": describe(self._state.journal.dtype)},
            **{"run": self.run, **memory},
        }
        checkpoint_file.write(self.path, checkpoint_file.pack(Checkpoint(header, arrays)))
