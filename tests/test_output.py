"""Result files: what the writer writes on any number of ranks is what the reader reads, whatever
happens in between."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np
import output_program as program
import pytest
from helpers import mpirun, run

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.info import info
from fsipetsc.output.pieces import Kept

if TYPE_CHECKING:
    from fsipetsc.output.writer import RunWriter

PROGRAM = Path(program.__file__)
FRAMES = 12


def write(n: int, mode: str, path: Path, *rest: object) -> str:
    done = mpirun(n, PROGRAM, mode, path, *rest)
    assert done.returncode == 0, done.stderr
    return done.stdout


def steps_of(result: fsipetsc.Run) -> int:
    return len(result.series.get("t", ()))


def assert_frames(result: fsipetsc.Run, nframes: int) -> None:
    """The first frames are those of the program, bitwise."""
    assert result.nframes == nframes
    assert np.array_equal(result.time, 0.3 * np.arange(nframes))
    for i, layer in enumerate(result.layers):
        points, names = program.grid(i), layer.fields
        expected = np.stack([program.values(i, frame, points) for frame in range(nframes)])
        assert np.array_equal(layer.X, points * program.H)
        assert layer.h == pytest.approx(program.H)
        for k, name in enumerate(names):
            assert np.array_equal(layer[name], expected[..., k], equal_nan=True)
            assert np.array_equal(layer.frame(-1)[name], expected[-1, :, k], equal_nan=True)
        assert layer.x is layer["x"]


def assert_prefix(result: fsipetsc.Run) -> None:
    """Times, series and frames are those of the program up to somewhere, bitwise."""
    steps = steps_of(result)
    assert steps >= result.nframes * program.SERIES_STEPS
    expected = program.series(0, steps)
    for name in expected.dtype.names if steps else ():
        assert np.array_equal(result.series[name], expected[name])
    if result.nframes:
        assert_frames(result, result.nframes)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A complete result, written by one process."""
    path = tmp_path_factory.mktemp("result") / "demo.h5"
    program.write(str(path), FRAMES, "blocks")
    return path


@pytest.mark.mpi
@pytest.mark.parametrize(("n", "split"), [(2, "layers"), (3, "blocks")])
def test_round_trip(tmp_path: Path, finished: Path, n: int, split: str) -> None:
    write(n, split, tmp_path / "run.h5", FRAMES)
    assert os.listdir(tmp_path) == ["run.h5"]
    with fsipetsc.open_run(tmp_path / "run.h5") as result:
        assert_prefix(result)
        assert result.nframes == FRAMES
    assert fsipetsc.compare(tmp_path / "run.h5", finished).equal


def test_what_else_is_stored(finished: Path) -> None:
    with fsipetsc.open_run(finished) as result:
        assert result.case == "demo" and result.complete
        assert result.options == program.HEADER["options"]
        assert result.interfaces == ("left/rod", "rod/right")
        assert result.summary["steps"] == steps_of(result) == FRAMES * program.SERIES_STEPS
        assert result.summary["versions"] == {"petsc": "3.18.5"}
        assert result.errors["fluid"]["rho"] == 1e-3
        assert list(result.series) == ["t", "dt", "x_interface", "mass", "energy"]
        assert list(result.layers[0]) == ["rho", "u", "T", "p", "x"]
        assert list(result.layers[1]) == ["u", "sigma", "T", "x", "p"]
        assert result.at(0.95) == 3 and result.at(99.0) == FRAMES - 1
        assert "12 frames" in repr(result) and "sigma" in repr(result.layers[1])
    with h5py.File(finished) as file:  # as it is for other programs
        assert file["layer1/T"].shape == (FRAMES, 21) and file["series/x_interface"].shape == (
            36,
            2,
        )


def test_a_result_without_frames_says_so(tmp_path: Path) -> None:
    """As a run leaves it that is killed before its first frame."""
    program.write(str(tmp_path / "run.h5"), 0, "blocks", join=False)
    with fsipetsc.open_run(tmp_path / "run.h5") as result:
        assert result.nframes == 0
        for action in (lambda: result.at(0.0), lambda: result.layers[0].frame(-1)):
            with pytest.raises(FileError, match=r"run\.h5: no frame is saved in it"):
                action()


@pytest.mark.mpi
def test_a_full_disk_fails_on_all_ranks(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    done = mpirun(2, PROGRAM, "full_disk", path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("1 ") and "File too large" in done.stdout
    assert "HDF5-DIAG" not in done.stderr and "Traceback" not in done.stderr
    with fsipetsc.open_run(path) as result:
        assert result.nframes > 20
        assert_prefix(result)


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


def test_info(finished: Path) -> None:
    text = info(finished)
    for part in [
        "demo",
        "complete",
        "12, t = 0 … 3.3 s",
        "-fsi_order",
        "left/rod at x = 35, rod/right at x = 70 at t = 3.5",
        "26 points, X = -0.25 … 1",
        "rho 0.001",
        "wall time of the steps",
    ]:
        assert part in text
    assert "wall_time" not in text


def test_each_change_may_be_the_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before and after every change of the folder all of some piece can be read.

    This is what a kill leaves, too: nothing but these changes is done to what a reader looks at.
    """
    path, seen, early = tmp_path / "run.h5", [], []
    made = {name: getattr(os, name) for name in ("replace", "unlink", "rename", "rmdir")}

    def read() -> None:
        if path.exists() or (tmp_path / "run.parts/header.json").exists():
            with fsipetsc.open_run(path) as result:
                assert_prefix(result)
                assert not seen or seen[-1] <= (result.nframes, steps_of(result)), "went back"
                seen.append((result.nframes, steps_of(result)))
            early.append(fsipetsc.open_run(path))

    def watched(name: str) -> object:
        def work(*args: object, **more: object) -> object:
            read()
            done = made[name](*args, **more)
            read()
            return done

        return work

    with monkeypatch.context() as patch:
        for name in made:
            patch.setattr(os, name, watched(name))
        program.write(str(path), 12, "blocks")
    assert len(set(seen)) > 3 and seen[-1] == (12, 36) and os.listdir(tmp_path) == ["run.h5"]
    with pytest.raises(FileError, match="has changed since it was opened; open it again"):
        next(result for result in early if result.nframes).layers[0]["T"]


def restarted(path: Path, after: Kept) -> RunWriter:
    """A writer that goes on after what is kept."""
    from mpi4py import MPI

    from fsipetsc.output.writer import RunWriter

    points = [program.grid(i) for i in range(3)]
    grids = [{"local": len(p), "n": len(p), "X": p * program.H} for p in points]
    header = {**program.HEADER, "run": "this"}
    return RunWriter(MPI.COMM_SELF, path, header, grids, after)


@pytest.mark.parametrize("whole", [True, False], ids=["joined", "in pieces"])
@pytest.mark.parametrize("kept", [(0, 0), (5, 15), (12, 36)])
def test_a_restart_goes_on_after_its_checkpoint(
    kept: tuple[int, int], whole: bool, tmp_path: Path
) -> None:
    """At the end of a piece or within one: what comes later takes the place of what was there."""
    path, header = tmp_path / "run.h5", {**program.HEADER, "run": "this"}
    program.write(str(path), 12, "blocks", header=header, join=whole)
    for after in (Kept(13, 36, 3.5), Kept(3, 9, 0.5)):
        with pytest.raises(FileError, match="is not what the checkpoint goes on from"):
            restarted(path, after)
        assert path.exists() == whole
    early = fsipetsc.open_run(path)
    writer = restarted(path, Kept(*kept, 0.1 * (kept[1] - 1)))
    assert (writer.nframes, writer.rows) == kept
    new = program.series(kept[1], kept[1] + 2)
    new["energy"] = -1.0
    chunks = iter([new])
    writer.take_series = lambda: next(chunks, None)
    grids = [program.grid(i) for i in range(3)]
    writer.write_frame(9.0, {i: np.full((len(g), 5), 7.0) for i, g in enumerate(grids)})
    writer.flush()
    with pytest.raises(FileError, match="has changed since it was opened; open it again"):
        early.series["energy"]
    for joined in (False, True):
        with fsipetsc.open_run(path) as result:
            assert (result.nframes, steps_of(result)) == (kept[0] + 1, kept[1] + 2)
            assert np.array_equal(result.time, [*(0.3 * np.arange(kept[0])), 9.0])
            energy = [*(7.0 + np.arange(kept[1])), -1.0, -1.0]
            assert np.array_equal(result.series["energy"], energy)
            assert len(result.layers[0].X) == 26
            rod = result.layers[1]["sigma"]
            for frame in range(kept[0]):
                assert np.array_equal(rod[frame], program.values(1, frame, grids[1])[:, 1])
            assert np.all(rod[-1] == 7.0) and result.complete == joined
        if not joined:
            writer.finish({"status": "done"})
    assert os.listdir(tmp_path) == ["run.h5"]


def test_pieces_that_a_kill_has_left_do_not_count_again(tmp_path: Path) -> None:
    """One came while the pieces were cleared: of these some are left, the header is gone."""
    path, header = tmp_path / "run.h5", {**program.HEADER, "run": "this"}
    program.write(str(path), 12, "blocks", header=header, join=False)
    left = {piece.name: piece.read_bytes() for piece in (tmp_path / "run.parts").glob("00000[23]*")}
    program.write(str(tmp_path / "other.h5"), 12, "blocks", header=header)
    for piece in (tmp_path / "run.parts").iterdir():
        piece.unlink()
    (tmp_path / "other.h5").rename(path)
    for name, content in left.items():
        (tmp_path / "run.parts" / name).write_bytes(content)
    restarted(path, Kept(4, 12, 0.1 * 11)).close()
    with fsipetsc.open_run(path) as result:
        assert (result.nframes, steps_of(result)) == (4, 12)


def test_what_a_restart_gives_up_is_gone_when_it_begins(tmp_path: Path) -> None:
    """Though it is killed before it has written anything; and other pieces are set aside."""
    path, header = tmp_path / "run.h5", {**program.HEADER, "run": "this"}
    program.write(str(path), 12, "blocks", header=header)
    program.write(str(tmp_path / "other.h5"), 3, "blocks", join=False)
    (tmp_path / "other.parts").rename(tmp_path / "run.parts")
    writer = restarted(path, Kept(5, 15, 0.1 * 14))
    writer.close()
    assert [new.name for _, new in writer.moved] == ["run.1.parts"]
    for name, frames in (("run.h5", 5), ("run.1.h5", 3)):
        with fsipetsc.open_run(tmp_path / name) as result:
            assert (result.nframes, steps_of(result)) == (frames, 3 * frames)


def test_a_reader_that_comes_while_pieces_are_cleared_sees_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from fsipetsc.output import pieces, reader

    path = tmp_path / "run.h5"
    program.write(str(path), 12, "blocks", join=False)

    def found(folder: Path) -> list[Path]:
        """The pieces, the first of which have just gone: they are one file now."""
        if not path.exists():
            pieces.join(pieces.pieces(folder), path, pieces.read_about(folder), path)
            return []
        return pieces.pieces(folder)

    monkeypatch.setattr(reader, "pieces", found)
    with fsipetsc.open_run(path) as result:
        assert result.nframes == 12


def test_earlier_results_are_kept(tmp_path: Path) -> None:
    """Whole ones, and what a killed run has left; each with its number, by which it is read."""
    path = tmp_path / "run.h5"
    program.write(str(path), 1, "blocks", join=False)
    (tmp_path / "run.1.h5").touch()
    (tmp_path / "run.2.h5").symlink_to("nowhere")
    said = [run(PROGRAM, "blocks", path, n).stdout.split()[2:] for n in (2, 3)]
    assert said == [["run.3.parts"], ["run.4.h5"]]
    for name, n in [("run.3.h5", 1), ("run.4.h5", 2), ("run.h5", 3)]:
        with fsipetsc.open_run(tmp_path / name) as result:
            assert result.nframes == n


def test_a_second_run_of_the_name_is_refused(tmp_path: Path) -> None:
    from mpi4py import MPI

    from fsipetsc.output.writer import RunWriter

    path = tmp_path / "run.h5"
    first = RunWriter(MPI.COMM_SELF, path, program.HEADER, [{"n": 0}] * 3)
    before = sorted(os.listdir(tmp_path / "run.parts"))
    answer = run(PROGRAM, "refuse", path)
    assert answer.stdout.startswith("1 4 ") and "another run is writing it" in answer.stdout, answer
    assert "-fsi_output" in answer.stdout
    assert sorted(os.listdir(tmp_path / "run.parts")) == before
    first.finish({"status": "done"})
    assert run(PROGRAM, "blocks", path, 2).stdout.split()[-1] == "run.1.h5"
