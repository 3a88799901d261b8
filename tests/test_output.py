"""Result files: what the writer writes on any number of ranks is what the reader reads, whatever happens in between."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import output_program as program
import pytest
from helpers import mpirun, run

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.buffers import FrameBuffer
from fsipetsc.output.info import info
from fsipetsc.output.lock import Lock, set_aside
from fsipetsc.output.pieces import Kept

PROGRAM = Path(program.__file__)
FRAMES = 12


def write(n: int, mode: str, path: Path, *rest: object) -> str:
    done = mpirun(n, PROGRAM, mode, path, *rest)
    assert done.returncode == 0, done.stderr
    return done.stdout


def assert_frames(result: fsipetsc.output.reader.Run, nframes: int) -> None:
    """The first frames are bitwise those of the program, on the largest grid; NaN where a frame's grid was smaller."""
    assert result.nframes == nframes
    assert np.array_equal(result.time, 0.3 * np.arange(nframes))
    for i, layer in enumerate(result.layers):
        points = program.grid(i, nframes - 1)
        expected = np.full((nframes, len(points), len(program.LAYERS[i]["fields"]) + 1), np.nan)
        for frame in range(nframes):
            own = program.grid(i, frame)
            expected[frame, np.isin(points, own)] = program.values(i, frame, own)
        assert np.array_equal(layer.X, points * program.H)
        assert layer.h == pytest.approx(program.H)
        for k, name in enumerate(program.LAYERS[i]["fields"]):
            assert np.array_equal(layer[name], expected[..., k], equal_nan=True)
            assert np.array_equal(layer.frame(nframes - 1)[name], expected[-1, :, k], equal_nan=True)
        if layer.kind == "fluid":
            assert np.array_equal(layer.x, expected[..., -1], equal_nan=True)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A complete result, written by one process."""
    path = tmp_path_factory.mktemp("result") / "demo.h5"
    program.write(str(path), FRAMES, "blocks")
    return path


@pytest.mark.mpi
@pytest.mark.parametrize(("n", "split"), [(2, "layers"), (3, "blocks")])
def test_round_trip(tmp_path: Path, n: int, split: str) -> None:
    write(n, split, tmp_path / "run.h5", FRAMES)
    with fsipetsc.open_run(tmp_path / "run.h5") as result:
        assert_frames(result, FRAMES)


def test_what_else_is_stored(finished: Path) -> None:
    with fsipetsc.open_run(finished) as result:
        steps = np.arange(FRAMES * program.SERIES_STEPS)
        assert result.case == "demo" and result.complete
        assert result.options == program.HEADER["options"]
        assert result.interfaces == ("left/rod", "rod/right")
        assert result.summary["steps"] == len(steps) and result.summary["versions"] == {"petsc": "3.18.5"}
        assert result.errors["fluid"]["rho"] == 1e-3
        assert np.array_equal(result.series["t"], 0.1 * steps)
        assert np.array_equal(result.series["x_interface"], np.outer(steps, [1.0, 2.0]))
        assert list(result.series) == ["t", "dt", "x_interface", "mass", "energy"]
        assert result.series["mass"].shape == (len(steps), 1) and np.array_equal(result.series["energy"], 7.0 + steps)
        assert list(result.layers[0]) == ["rho", "u", "T", "p", "x"]
        assert list(result.layers[1]) == ["u", "sigma", "T", "x", "p"]
        assert [layer.name for layer in result.layers] == ["left", "rod", "right"]
        assert result.at(0.95) == 3 and result.at(99.0) == FRAMES - 1
        assert "12 frames" in repr(result) and "sigma" in repr(result.layers[1])


def test_unknown_names_are_answered_with_the_valid_ones(finished: Path) -> None:
    with fsipetsc.open_run(finished) as result:
        for ask, answer in [
            (lambda: result.layers[1]["rho"], "sigma"),
            (lambda: result.series["x"], "x_interface"),
            (lambda: result.options["fsi_H"], "fsi_h"),
            (lambda: result.errors["gas"], "fluid"),
        ]:
            with pytest.raises(KeyError, match=answer):
                ask()
        with pytest.raises(IndexError, match="12"):
            result.layers[0].frame(FRAMES)
    with pytest.raises(FileError, match="closed"):
        result.layers[0]["T"]


@pytest.mark.mpi
@pytest.mark.parametrize("n", [2])
def test_killed_run_is_readable(tmp_path: Path, n: int) -> None:
    path = tmp_path / "run.h5"
    done = mpirun(n, PROGRAM, "kill", path, 9)
    assert done.returncode != 0
    with fsipetsc.open_run(path) as result:
        assert result.nframes >= program.GROWTH  # those before the new grids, at least
        assert_frames(result, result.nframes)
        assert not result.complete
        assert len(result.series["t"]) >= program.SERIES_STEPS * result.nframes
        assert result.summary["ranks"] == 1


def test_what_petsc_says_is_told_without_its_routines() -> None:
    from fsipetsc.errors import petsc_words

    class Said(Exception):
        ierr = 76

    text = "error code 76\n[0] PetscViewerFileSetName() at ./filev.c:603\n[0] Error in external library\n[0] Status -1"
    assert petsc_words(Said(text)) == "PETSc error 76 in PetscViewerFileSetName(): Error in external library; Status -1"


@pytest.mark.parametrize("capacity", [1, 4, 9, 63, 64, 100])
def test_frames_of_a_buffer_stay_apart(capacity: int) -> None:
    """Whatever the buffer makes of its capacity: each frame comes out point by point as it went in."""
    points = (3, 0, 5)
    buffer = FrameBuffer([{"local": n, "X": np.arange(n)} for n in points], 5, capacity)
    assert 0 < buffer.capacity <= capacity and (capacity < 64 or buffer.stride // 8 % 2 == 1)
    frames = np.arange(buffer.capacity * sum(points) * 5.0).reshape(buffer.capacity, -1, 5)
    for k, frame in enumerate(frames):
        values, starts, stride = buffer.slots(k)
        parts = np.split(frame, np.cumsum(points)[:-1])
        for start, part in zip(starts, parts):
            for j, point in enumerate(part):
                values[start + j * stride :][:5] = point
    for count in {1, buffer.capacity}:
        whole = np.concatenate([buffer.part(i, count).reshape(n, count, 5) for i, n in enumerate(points)])
        assert np.array_equal(whole.swapaxes(0, 1), frames[:count])


@pytest.mark.mpi
@pytest.mark.parametrize("n", [2])
@pytest.mark.parametrize(("target", "reason"), [("missing/run.h5", "does not exist")])
def test_unusable_path_fails_on_all_ranks(tmp_path: Path, n: int, target: str, reason: str) -> None:
    answers, status, message = write(n, "refuse", tmp_path / target).split(maxsplit=2)
    assert (answers, status) == ("1", "4")
    assert reason in message


@pytest.mark.mpi
@pytest.mark.parametrize("n", [2])
def test_full_disk_fails_on_all_ranks(tmp_path: Path, n: int) -> None:
    path = tmp_path / "run.h5"
    done = mpirun(n, PROGRAM, "full_disk", path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("1 ") and "File too large" in done.stdout
    assert "HDF5-DIAG" not in done.stderr and "Traceback" not in done.stderr
    with fsipetsc.open_run(path) as result:
        assert result.nframes > 20
        assert_frames(result, result.nframes)


@pytest.mark.mpi
def test_a_semaphore_that_somebody_has_left_is_not_taken(tmp_path: Path) -> None:
    """Open MPI's shared file pointers have one named after the file alone, whoever's it is: an empty one is a SIGBUS.

    The files that MPI opens are pieces in the making.
    """
    pytest.importorskip("petsc4py")
    if not os.access("/dev/shm", os.W_OK):
        pytest.skip("no shared memory that has names")
    left = [Path(f"/dev/shm/sem.OMPIO_{number:06d}.new") for number in (1, 2)]
    left = [path for path in left if not path.exists()]
    for path in left:
        path.touch()
    try:
        done = mpirun(2, "-m", "fsipetsc", *"rod -fsi_h 0.1 -ts_max_steps 2 -fsi_quiet".split(), cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        assert all(path.stat().st_size == 0 for path in left)
    finally:
        for path in left:
            path.unlink(missing_ok=True)


@pytest.mark.parametrize("n", [pytest.param(2, marks=pytest.mark.mpi)])
def test_a_file_that_mpi_cannot_open_is_one_line(tmp_path: Path, n: int) -> None:
    pytest.importorskip("petsc4py")
    line = "rod -fsi_h 0.1 -ts_max_steps 2 -fsi_quiet".split()
    words = {"OMPI_MCA_io": "nosuch", "OMPI_MCA_mca_base_component_show_load_errors": "0"}
    done = mpirun(n, "-m", "fsipetsc", *line, cwd=tmp_path, env=words)
    if done.returncode == 0:
        pytest.skip("this MPI has no such setting")
    assert done.returncode == 4
    (said,) = (text for text in done.stderr.splitlines() if text.startswith("fsipetsc"))
    assert "rod.h5: cannot write: MPI cannot open it" in said
    for word in ("Exception ignored", "Traceback", "Petsc", "PETSc"):
        assert word not in done.stderr


def test_petscs_hdf5_does_not_print_its_errors(tmp_path: Path) -> None:
    """Where MPI-IO cannot open a file, the user reads our message, not fifty lines of HDF5's around it."""
    program_text = """
import sys
from petsc4py import PETSc
from fsipetsc.output import hdf5
if "silent" in sys.argv:
    hdf5.be_silent()
PETSc.Sys.pushErrorHandler("python")
try:
    PETSc.ViewerHDF5().create(sys.argv[1] + "/missing/run.h5", "a")
except PETSc.Error:
    print("raised")
"""
    loud, silent = (run("-c", program_text, tmp_path, word) for word in ("loud", "silent"))
    assert loud.stdout == silent.stdout == "raised\n"
    assert "HDF5-DIAG" in loud.stderr, "else this test shows nothing"
    assert "HDF5-DIAG" not in silent.stderr


def test_reading_needs_numpy_and_h5py_only(finished: Path) -> None:
    program_text = """
import sys
for name in ("petsc4py", "mpi4py", "numba", "scipy", "matplotlib"):
    sys.modules[name] = None
import fsipetsc
assert not {"numpy", "h5py"} & sys.modules.keys()
with fsipetsc.open_run(sys.argv[1]) as run:
    print(run.case, run.layers[0]["rho"].shape, run.layers[1].x.shape)
"""
    done = run("-c", program_text, finished)
    assert done.stdout.split(maxsplit=1) == ["demo", "(12, 26) (12, 21)\n"], done.stderr


def test_unreadable_files(finished: Path, tmp_path: Path) -> None:
    (tmp_path / "text.h5").write_text("not HDF5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = 1
    (tmp_path / "cut.h5").write_bytes(finished.read_bytes()[:20_000])
    with h5py.File(tmp_path / "newer.h5", "w") as file:
        file.attrs.update({"format": "fsipetsc result", "version": 99})
    for name, reason in [
        ("absent.h5", "no such file"),
        (".", "is a directory"),
        ("text.h5", "not an HDF5 file"),
        ("other.h5", "not a result"),
        ("cut.h5", "damaged"),
        ("newer.h5", "newer"),
    ]:
        with pytest.raises(FileError, match=reason) as caught:
            fsipetsc.open_run(tmp_path / name)
        assert caught.value.status == 4


def test_info(finished: Path) -> None:
    text = info(finished)
    for part in [
        "demo",
        "complete",
        "12, t = 0 … 3.3",
        "-fsi_order",
        "left/rod at x = 35, rod/right at x = 70 at t = 3.5",
        "26 points with those in reserve, 20 … 25 active",
        "rho 0.001",
        "time for the steps",
    ]:
        assert part in text
    assert "wall_time" not in text


def assert_prefix(result: fsipetsc.output.reader.Run) -> None:
    """Times, series and frames are those of the program up to somewhere, bitwise."""
    count, steps = result.nframes, len(result.series.get("t", ()))
    assert np.array_equal(result.time, 0.3 * np.arange(count))
    assert steps % program.SERIES_STEPS == 0 and steps >= count * program.SERIES_STEPS
    if steps:
        expected = program.series(0, steps)
        assert all(np.array_equal(result.series[name], expected[name]) for name in expected.dtype.names)
    if count:
        assert_frames(result, count)


def test_each_change_may_be_the_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before and after every change of the folder all of some piece can be read, also by who has opened it before.

    This is what a kill leaves, too: nothing but these changes is ever done to what a reader looks at.
    """
    path, seen, early = tmp_path / "run.h5", [], []
    made = {name: getattr(os, name) for name in ("replace", "unlink", "rename", "rmdir")}

    def look() -> None:
        if path.exists() or (tmp_path / "run.parts/header.json").exists():
            result = fsipetsc.open_run(path)
            early.append(result)
            assert not seen or seen[-1] <= (result.nframes, len(result.series.get("t", ()))), "went back"
            seen.append((result.nframes, len(result.series.get("t", ()))))

    def watched(name: str) -> object:
        def work(*args: object, **more: object) -> object:
            look()
            done = made[name](*args, **more)
            look()
            return done

        return work

    with monkeypatch.context() as patch:
        for name in made:
            patch.setattr(os, name, watched(name))
        program.write(str(path), 12, "blocks")
    assert len(set(seen)) > 3 and seen[-1] == (12, 36)
    for result in early:  # the pieces are gone, and their numbers in the whole result
        with result:
            assert_prefix(result)
    assert not early[0].complete and os.listdir(tmp_path) == ["run.h5"]


def test_frames_do_not_wait_for_a_full_buffer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """None is older than two seconds, unless the next one was late; that one is written at once."""
    from mpi4py import MPI

    from fsipetsc.output import writer

    now, readable = 0.0, []
    monkeypatch.setattr(writer, "time", SimpleNamespace(monotonic=lambda: now))
    result = writer.RunWriter(MPI.COMM_SELF, tmp_path / "run.h5", program.HEADER, settle=lambda _: {}, flush_seconds=2.0)
    result.start_segment([{"local": 9, "n": 9, "X": np.arange(9.0)}] * 3)
    for now in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 100.0, 100.5):
        result.write_frame(now, lambda slots: slots.values.fill(1.0))
        with fsipetsc.open_run(tmp_path / "run.h5") as so_far:
            readable.append(so_far.nframes)
    assert readable == [0, 0, 3, 3, 3, 6, 6, 8, 8]
    result.finish({})


def held(path: Path) -> tuple[list[Path], int, int]:
    """Files, frames and steps of a result."""
    with fsipetsc.open_run(path) as result:
        assert_prefix(result)
        return sorted(path.with_suffix(".parts").glob("0*.h5")), result.nframes, len(result.series.get("t", ()))


@pytest.mark.parametrize("whole", [True, False], ids=["joined", "in pieces"])
@pytest.mark.parametrize("kept", [(0, 0), (4, 12), (5, 15), (9, 28), (12, 36)])
def test_what_is_beyond_a_checkpoint_is_dropped(kept: tuple[int, int], whole: bool, tmp_path: Path) -> None:
    """At the end of a piece or within one; the run goes on behind it."""
    from mpi4py import MPI

    from fsipetsc.output.writer import RunWriter

    path, header = tmp_path / "run.h5", {**program.HEADER, "run": "this"}
    program.write(str(path), 12, "blocks", header=header, join=whole)
    before = held(path)
    assert before[1:] == (12, 36) and bool(before[0]) != whole
    for frames, rows, t in ((13, 36, 3.5), (12, 37, 3.5), (3, 9, 0.5)):
        with pytest.raises(FileError, match="is not what the checkpoint goes on from"):
            RunWriter(MPI.COMM_SELF, path, header, after=Kept(frames, rows, t), settle=lambda _: {})
        assert held(path) == before
    after = Kept(*kept, 0.1 * (kept[1] - 1))
    writer = RunWriter(MPI.COMM_SELF, path, header, after=after, settle=lambda _: {})
    assert (writer.nframes, writer.rows) == kept
    writer.close()
    with fsipetsc.open_run(path) as result:
        assert (result.nframes, len(result.series.get("t", ()))) == kept and not result.complete
        assert_frames(result, kept[0]) if kept[0] else None


def test_earlier_results_are_kept(tmp_path: Path) -> None:
    """Whole ones, and what a killed run has left; each with its number, by which it is read."""
    path = tmp_path / "run.h5"
    program.write(str(path), 1, "blocks", join=False)
    (tmp_path / "run.2.h5").symlink_to("nowhere")
    said = [run(PROGRAM, "blocks", path, n).stdout.split()[2:] for n in (2, 3)]
    assert said == [["run.1.parts"], ["run.3.h5"]]
    for name, n in [("run.1.h5", 1), ("run.3.h5", 2), ("run.h5", 3)]:
        with fsipetsc.open_run(tmp_path / name) as result:
            assert result.nframes == n


def test_what_is_no_file_keeps_its_name(tmp_path: Path) -> None:
    """A pipe, as a device would: neither renamed nor written to."""
    os.mkfifo(tmp_path / "run.h5")
    answer = run(PROGRAM, "refuse", tmp_path / "run.h5")
    assert answer.stdout.startswith("1 4 ") and "exists and is not a regular file" in answer.stdout, answer
    with pytest.raises(FileError, match="not a regular file"):
        set_aside([tmp_path / "run.h5"], "run")
    assert os.listdir(tmp_path) == ["run.h5"]


def test_a_second_run_of_the_name_is_refused(tmp_path: Path) -> None:
    from mpi4py import MPI

    from fsipetsc.output.writer import RunWriter

    path = tmp_path / "run.h5"
    first = RunWriter(MPI.COMM_SELF, path, program.HEADER, settle=lambda _: {})
    before = sorted(os.listdir(tmp_path / "run.parts"))
    answer = run(PROGRAM, "refuse", path)
    assert answer.stdout.startswith("1 4 ") and f"process {os.getpid()} on" in answer.stdout, answer
    assert "-fsi_output" in answer.stdout and sorted(os.listdir(tmp_path / "run.parts")) == before
    first.finish({"status": "done"})
    assert run(PROGRAM, "blocks", path, 2).stdout.split()[-1] == "run.1.h5"


def test_a_lock_is_what_was_locked(tmp_path: Path) -> None:
    """A link is not followed; a lock whose folder has gone or got another name meanwhile is none."""
    folder = tmp_path / "run.parts"
    folder.mkdir()
    (folder / "lock").symlink_to("elsewhere")
    with pytest.raises(OSError, match="symbolic"):
        Lock(folder, "run.h5")
    (folder / "lock").unlink()
    lock = Lock(folder, "run.h5")
    with pytest.raises(FileError, match="another run is writing it"):
        Lock(folder, "run.h5")
    folder.rename(tmp_path / "run.1.parts")
    other = Lock(folder, "run.h5")
    lock.release(remove=True)
    assert (folder / "lock").exists() and (tmp_path / "run.1.parts/lock").exists()
    other.release(remove=True)
    assert not folder.exists()


FLIP = """
import sys
from pathlib import Path
import fsipetsc
from fsipetsc.errors import FileError
content, path = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
fates = []
for at in range(int(sys.argv[3]), len(content), int(sys.argv[4])):
    path.write_bytes(content[:at] + bytes([content[at] ^ (1 << at % 8)]) + content[at + 1:])
    try:
        with fsipetsc.open_run(path) as run:
            for layer in run.layers:
                [layer[name] for name in layer.fields]
            [run.series[name] for name in run.series]
        fates.append(0)
    except FileError:
        fates.append(4)
print(fates.count(0), fates.count(4), set(fates) - {0, 4})
"""


@pytest.mark.parametrize(
    ("first", "every", "least"),
    [(0, 149, 20), *(pytest.param(first, 13, 100, marks=pytest.mark.long) for first in (0, 6))],
)
def test_one_changed_byte_crashes_no_reader(
    first: int, every: int, least: int, finished: Path, tmp_path: Path
) -> None:
    """Each is read, or refused with status 4: metadata has checksums, numbers have none."""
    done = run("-c", FLIP, finished, tmp_path / "run.h5", first, every)
    assert (done.returncode, done.stderr) == (0, "")
    read, refused, other = done.stdout.split(maxsplit=2)
    assert int(read) > least and int(refused) > least and other == "set()\n", done.stdout
