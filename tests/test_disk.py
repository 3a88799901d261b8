"""Disks that are full, read-only or in use: status 4, one message on all ranks, and nothing that was there is harmed.

Where a user may mount file systems of his own (unshare), they are real ones that are full; everywhere the system refuses files
beyond a size.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import PATIENCE, REPOSITORY, environment
from test_restart import differences

import fsipetsc
from fsipetsc.output import checkpoint_file

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

PROGRAM = REPOSITORY / "tests" / "disk_program.py"
#: sizes [kB]: of results, and of checkpoints, of which there are three while one is written, each of 18 kB
MOUNTS = """
mount -t tmpfs -o size=3500k none tiny1 && mount -t tmpfs -o size=44k none tiny2 || exit 77
mount -t tmpfs -o ro,size=10k none fixed || exit 77
exec "$@"
"""
FULL, LARGE = "No space left on device", "File too large"
SAID = {
    **{f"limit {size}": (LARGE, f"limit{size}.h5: cannot write: ") for size in (1, 200_000, 3_500_000)},
    "limit blast": (LARGE, "blast.h5: cannot write: "),
    **{f"output {place}": ("exists and is not a regular file", place) for place in ("/dev/full", "/dev/null")},
    **{f"checkpoint {place}": ("exists and is not a regular file", place) for place in ("/dev/full", "/dev/null")},
    **{f"restart {place}": ("is not a checkpoint of fsipetsc", place) for place in ("/dev/full", "/dev/null")},
    "output /proc/x.h5": ("cannot write: No such file", "/proc/x.h5"),
    "checkpoint /proc/x.h5": ("the checkpoint cannot be written: No such file", "what was computed before is in"),
    "restart /proc/x.h5": ("there is no such file", "/proc/x.h5"),
    "output no/where.h5": ("does not exist", "no/where.h5"),
    "checkpoint no/where.h5": ("does not exist", "no/where.h5"),
    "restart no/where.h5": ("there is no such file", "no/where.h5"),
    "output fixed": ("is not writable", "fixed/a.h5"),
    "checkpoint fixed": ("is not writable", "fixed/a.h5"),
    "full result": (FULL, "tiny1/a.h5: cannot write: "),
    "full blast": (FULL, "tiny1/b.h5: cannot write: "),
    "full checkpoint": (
        f"the checkpoint cannot be written: {FULL}; the one before is kept in ",
        "what was computed before is in",
    ),
}


@pytest.fixture(scope="module", params=[1, 3])
def found(request, tmp_path_factory) -> tuple[Path, dict[str, list]]:
    """(folder, name -> [status, what was said])."""
    where = tmp_path_factory.mktemp(f"disk{request.param}")
    command = ["mpiexec", "-n", str(request.param), sys.executable, str(PROGRAM)]
    env = environment({"PYTHONPATH": f"{REPOSITORY / 'tests'}:{REPOSITORY}"})
    for way in (["unshare", "-rm", "sh", "-c", MOUNTS, "sh"], []):
        for folder in ("out", *(("tiny1", "tiny2", "fixed") if way else ())):
            (where / folder).mkdir(exist_ok=True)
        if way and not shutil.which("unshare"):
            continue
        done = subprocess.run([*way, *command], cwd=where, env=env, text=True, capture_output=True, timeout=PATIENCE)
        if done.returncode in (0,):
            break
        for folder in ("tiny1", "tiny2", "fixed"):  # it may not mount anything
            (where / folder).exists() and os.rmdir(where / folder)
    assert (done.returncode, done.stderr, done.stdout) == (0, "", "")
    first, *others = json.loads((where / "found.json").read_text())
    assert all(other[name] == [status, ""] for other in others for name, (status, _) in first.items())
    return where, first


def test_what_cannot_be_written_or_read_is_said_once(found):
    _, answers = found
    assert len(answers) > 18
    for name, (status, text) in answers.items():
        assert status == (4 if name in SAID else 0) and text.count("\n") == (status != 0), (name, status, text)
        assert all(word in text for word in SAID.get(name, ())), (name, text)


def test_what_was_written_before_can_be_read(found):
    where, answers = found
    for path in (where / "limit3500000.h5", where / "blast.h5", *(where / "out").glob("full-*/[ab].h5")):
        with fsipetsc.open_run(path) as result:  # of blast the first frames to be written may be too many
            assert result.nframes >= (100 if path.name in ("limit3500000.h5", "a.h5") else 0), path
    if "full checkpoint" in answers:  # the earlier ones are whole, and the run goes on from the newest
        kept = [
            checkpoint_file.read(path).header["memory"]["steps"] for path in sorted((where / "out/full-checkpoint").glob("c*"))
        ]
        assert kept == [40, 20]
        assert differences(where / "whole.h5", where / "kept.h5", same_ranks=False) == []
    assert not list(where.glob(".*new")) and not (where / "limit1.h5").exists()


def test_files_that_somebody_has_open_are_gone_on_with(found):
    where, _ = found
    assert differences(where / "whole.h5", where / "used0.h5", same_ranks=True) == []
