"""Disks that are full, read-only or in use: status 4, one message on all ranks, and nothing that was there is harmed.

Where a user may mount file systems of his own (unshare), they are real ones that are full; everywhere the system refuses files
beyond a size.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest
from helpers import PATIENCE, REPOSITORY, mpirun
from test_restart import differences

import fsipetsc
from fsipetsc.output import checkpoint_file

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

PROGRAM = REPOSITORY / "tests" / "disk_program.py"
#: sizes [kB]: of results, and of checkpoints, of which there are three while one is written, each of 18 kB
MOUNTED, REFUSED = ("tiny1", "tiny2", "fixed"), 77
MOUNTS = f"""
mount -t tmpfs -o size=3500k none tiny1 && mount -t tmpfs -o size=44k none tiny2 || exit {REFUSED}
mount -t tmpfs -o ro,size=10k none fixed || exit {REFUSED}
exec "$@"
"""
OWN = ["unshare", "-rm"]
FULL, LARGE = "No space left on device", "File too large"
SAID = {
    **{f"limit {size}": (LARGE, f"limit{size}.h5: cannot write: ") for size in (1, 200_000, 3_500_000)},
    "limit blast": (LARGE, "blast.h5: cannot write: "),
    **{f"{what} pipe.h5": ("exists and is not a regular file", "pipe.h5") for what in ("output", "checkpoint")},
    "restart pipe.h5": ("is not a checkpoint of fsipetsc", "pipe.h5"),
    "output /proc/x.h5": ("cannot write: No such file", "/proc/x.h5"),
    "checkpoint /proc/x.h5": ("no checkpoint can be written there: No such file", "/proc/x.h5"),
    "restart /proc/x.h5": ("there is no such file", "/proc/x.h5"),
    "output no/where.h5": ("does not exist", "no/where.h5"),
    "checkpoint no/where.h5": ("does not exist", "no/where.h5"),
    "restart no/where.h5": ("there is no such file", "no/where.h5"),
    "output fixed": ("is not writable", "fixed/a.h5"),
    "checkpoint fixed": ("no checkpoint can be written there: Read-only", "fixed/a.h5"),
    "full result": (FULL, "tiny1/a.h5: cannot write: "),
    "full blast": (FULL, "tiny1/b.h5: cannot write: "),
    "full checkpoint": (
        f"the checkpoint cannot be written: {FULL}; the one before is kept in ",
        "what was computed before is in",
    ),
}


def may_unshare() -> bool:
    """Whether a user may have mounts of his own here; what he may mount is another question."""
    if not shutil.which(OWN[0]):
        return False
    return subprocess.run([*OWN, "true"], capture_output=True, timeout=PATIENCE).returncode == 0


class Found(NamedTuple):
    """answers: name -> [status, what was said]; mounted: the file systems were there."""

    where: Path
    answers: dict[str, list]
    mounted: bool


@pytest.fixture(scope="module", params=[2])
def found(request, tmp_path_factory) -> Found:
    where = tmp_path_factory.mktemp(f"disk{request.param}")
    (where / "out").mkdir()
    kept, mounted = {"cwd": where, "env": {"PYTHONPATH": f"{REPOSITORY / 'tests'}:{REPOSITORY}"}}, may_unshare()
    if mounted:
        for folder in MOUNTED:
            (where / folder).mkdir()
        done = mpirun(request.param, PROGRAM, **kept, under=[*OWN, "sh", "-c", MOUNTS, "sh"])
        mounted = done.returncode != REFUSED
    if not mounted:
        for folder in MOUNTED:  # by which the program knows what there is
            (where / folder).exists() and os.rmdir(where / folder)
        done = mpirun(request.param, PROGRAM, **kept)
    assert (done.returncode, done.stderr, done.stdout) == (0, "", "")
    first, *others = json.loads((where / "found.json").read_text())
    assert all(other[name] == [status, ""] for other in others for name, (status, _) in first.items())
    return Found(where, first, mounted)


def test_what_cannot_be_written_or_read_is_said_once(found):
    answers = found.answers
    assert len(answers) > (15 if found.mounted else 11)
    for name, (status, text) in answers.items():
        assert status == (4 if name in SAID else 0) and text.count("\n") == (status != 0), (name, status, text)
        assert all(word in text for word in SAID.get(name, ())), (name, text)


def test_what_was_written_before_can_be_read(found):
    """All of it where each piece has room, but not one file of them all; else the pieces before."""
    where = found.where
    folders = where / "limit3500000.parts", where / "blast.parts", *(where / "out").glob("full-*/[ab].parts")
    for path in folders:
        with fsipetsc.open_run(path) as result:  # of blast the first frames to be written may be too many
            assert result.complete or path.name[0] == "b", path
            assert result.nframes >= (100 if path.name in ("limit3500000.parts", "a.parts") else 0), path
    assert len(folders) == (4 if found.mounted else 2)
    assert not list(where.rglob("*.new")) and not (where / "limit1.h5").exists()


def test_checkpoints_before_the_disk_was_full_are_whole(found):
    """And the run goes on from the newest."""
    if not found.mounted:
        pytest.skip("no file systems can be mounted here: none is full or read-only")
    assert {name for name in SAID if name.startswith("full ") or name.endswith(" fixed")} <= set(found.answers)
    folder = found.where / "out/full-checkpoint"
    assert [checkpoint_file.read(path).header["memory"]["steps"] for path in sorted(folder.glob("c*"))] == [40, 20]
    assert differences(found.where / "whole.h5", found.where / "kept.h5", same_ranks=False) == []


def test_files_that_somebody_has_open_are_gone_on_with(found):
    where = found.where
    assert differences(where / "whole.h5", where / "used0.h5", same_ranks=True) == []
