"""Results that are read while they are written, or whose run is killed: a reader finds what was flushed, and nothing else."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import output_program as program
import pytest

import fsipetsc
from fsipetsc.output import commits
from fsipetsc.output.reader import Run

pytest.importorskip("petsc4py")

PROGRAM = Path(program.__file__)


def assert_prefix(result: Run, numbers: list[int]) -> None:
    """Times and series, and the frames of these numbers from the first or the last, are those of the program, bitwise."""
    count, steps = result.nframes, len(result.series.get("t", ()))
    assert np.array_equal(result.time, 0.3 * np.arange(count))
    assert steps % program.SERIES_STEPS == 0 and steps >= count * program.SERIES_STEPS
    if steps:
        expected = program.series(0, steps)
        assert all(np.array_equal(result.series[name], expected[name]) for name in expected.dtype.names)
    for frame in {number % count for number in numbers} if count else ():
        for i, layer in enumerate(result.layers):
            own = program.grid(i, frame)
            at = np.rint(layer.X / program.H).astype(int)
            expected_frame = program.values(i, frame, own)
            found = layer.frame(frame)
            for k, name in enumerate(layer.fields):
                assert np.array_equal(found[name][np.isin(at, own)], expected_frame[:, k], equal_nan=True)
                assert np.isnan(found[name][~np.isin(at, own)]).all()


def test_each_write_may_be_the_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before every change of the file, and in the middle of it, all of some flush can be read; also by who opened it then.

    This is what a kill leaves, too: nothing but these changes is ever done.
    """
    path, seen, early = tmp_path / "run.h5", [], []
    made = {name: getattr(os, name) for name in ("pwrite", "ftruncate", "link", "unlink", "rename")}

    def look() -> None:
        if path.exists():
            result = fsipetsc.open_run(path)
            assert_prefix(result, [0, -1])
            assert not seen or seen[-1] <= (result.nframes, len(result.series.get("t", ()))), "went back"
            seen.append((result.nframes, len(result.series.get("t", ()))))
            if len(seen) % 10 == 0:
                early.append(result)
            else:
                result.close()

    def watched(name: str) -> Callable[..., object]:
        def work(*args: object) -> object:
            look()
            if name == "pwrite" and len(bytes(args[1])) > 1:
                half = len(args[1]) // 2
                made[name](args[0], bytes(args[1])[:half], args[2])
                look()
            return made[name](*args)

        return work

    with monkeypatch.context() as patch:
        for name in made:
            patch.setattr(os, name, watched(name))
        program.write(str(path), 12, "blocks")
    assert len(set(seen)) > 4 and seen[-1] == (12, 36)
    for result in early:
        with result:
            assert not result.complete
            assert_prefix(result, list(range(result.nframes)))
    with fsipetsc.open_run(path) as result:
        assert result.complete
        assert_prefix(result, list(range(12)))
    assert os.listdir(tmp_path) == ["run.h5"]


def test_frames_do_not_wait_for_a_full_buffer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """None is older than two seconds, unless the next one was late; that one is written at once."""
    from mpi4py import MPI

    from fsipetsc.output import writer

    now, readable = 0.0, []
    monkeypatch.setattr(writer, "time", SimpleNamespace(monotonic=lambda: now))
    result = writer.RunWriter(MPI.COMM_SELF, tmp_path / "run.h5", program.HEADER, flush_seconds=2.0)
    result.start_segment([{"local": 9, "n": 9, "X": np.arange(9.0)}] * 3)
    for now in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 100.0, 100.5):
        result.write_frame(now, lambda slots: slots.values.fill(1.0))
        with fsipetsc.open_run(tmp_path / "run.h5") as so_far:
            readable.append(so_far.nframes)
    assert readable == [0, 0, 3, 3, 3, 6, 6, 8, 8]
    result.finish({})


def test_a_damaged_commit_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the two places that tell what was written one may be half written; a damaged record is an error."""
    path, whole = tmp_path / "run.h5", tmp_path / "copy.h5"
    end = commits.Log.end
    monkeypatch.setattr(commits.Log, "end", lambda log, write: (whole.write_bytes(path.read_bytes()), end(log, write)))
    program.write(str(path), 12, "blocks")
    content = whole.read_bytes()
    place = content.index(commits.MAGIC) + len(commits.MAGIC)
    with whole.open("rb") as file:
        newest = commits.newest(file.fileno())
    counts = []
    for damaged in range(2):
        copy = bytearray(content)
        copy[place + 32 * damaged] ^= 1
        (tmp_path / "damaged.h5").write_bytes(copy)
        with fsipetsc.open_run(tmp_path / "damaged.h5") as result:
            assert_prefix(result, [0, -1])
            counts.append(len(result.series["t"]))
    assert sorted(counts)[0] < sorted(counts)[1] == 36
    copy = bytearray(content)
    copy[newest.offset + newest.length - 3] ^= 1
    (tmp_path / "damaged.h5").write_bytes(copy)
    with pytest.raises(fsipetsc.errors.FileError, match="damaged"):
        fsipetsc.open_run(tmp_path / "damaged.h5")
