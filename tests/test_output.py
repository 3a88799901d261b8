"""Result files: what a run writes is what the reader reads, whatever happens in between; damaged
ones are read, or refused with one message and status 4."""

import os
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import run, well

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output import writer
from fsipetsc.output.file_layout import open_h5, pieces
from fsipetsc.output.info import info
from fsipetsc.output.writer import lock


def made(path, frames=12):
    """A short run in this process with so many frames after the first one."""
    more = {"max_time": 1e-3 * frames, "output_dt": 1e-3, "coupling": "projection"}
    return fsipetsc.run("rod", h=0.1, output=path, **more)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return made(tmp_path_factory.mktemp("result") / "rod.h5")


@pytest.fixture
def left(tmp_path, monkeypatch):
    """What a run leaves that is killed before it joins its pieces, of four frames each."""
    monkeypatch.setattr(writer, "FRAMES", 4)
    with monkeypatch.context() as patch:
        patch.setattr(writer.RunWriter, "finish", lambda of, *_, **__: (of.flush(), of.close()))
        made(tmp_path / "run.h5")
    assert len(pieces(tmp_path / "run.parts")) == 4
    return tmp_path / "run.h5"


def beginning(path, whole):
    """Numbers of frames and steps of a result that is the beginning of another, bit for bit."""
    with fsipetsc.open_run(path) as result:
        frames, steps = result.nframes, len(result.series.get("t", ()))
        assert steps >= np.searchsorted(whole.series["t"], whole.time[:frames]).max(initial=0)
        for name in result.series:
            assert np.array_equal(result.series[name], whole.series[name][:steps])
        assert np.array_equal(result.time, whole.time[:frames])
        for layer, other in zip(result.layers, whole.layers) if frames else ():
            assert np.array_equal(layer.X, other.X) and layer.x is layer["x"]
            for name in other:
                assert np.array_equal(layer[name], other[name][:frames], equal_nan=True)
                assert np.array_equal(layer.frame(-1)[name], layer[name][-1], equal_nan=True)
    return frames, steps


def test_what_is_stored_and_told(whole):
    assert whole.case == "rod" and whole.complete and whole.options["fsi_h"] == 0.1
    assert np.array_equal(whole.time, 1e-3 * np.arange(13)) and whole.nframes == 13
    assert whole.interfaces == ("below | rod", "rod | above")
    assert whole.summary["steps"] == len(whole.series["t"]) > 12 and whole.summary["ranks"] == 1
    assert {"petsc", "numpy", "fsipetsc"} <= set(whole.summary["versions"])
    known = {"dt", "x_interface", "u_interface", "T_interface", "sigma_interface", "mass", "energy"}
    assert known <= set(whole.series) and whole.series["mass"].shape[1] == 2
    assert [layer.kind for layer in whole.layers] == ["fluid", "solid", "fluid"]
    assert {"rho", "u", "T", "p", "x"} <= set(whole.layers[0])
    assert list(whole.layers[1]) == ["u", "sigma", "T", "x", "p"]
    assert whole.layers[1].X == pytest.approx(np.linspace(1, 2, 11))
    assert whole.at(0.0031) == 3 and whole.at(99.0) == 12
    with open_h5(whole.path) as file:  # as it is for other programs
        assert file["layer1/T"].shape == (13, 11)
        assert file["series/x_interface"].shape == (len(whole.series["t"]), 2)
    text = info(whole.path)
    parts = "complete", "13, t = 0 … 0.012 s", "-fsi_order", "rod | above at x = ", "wall_time"
    assert all(part in text for part in (*parts, "11 points, X = 1 … 2")), text


def test_each_change_may_be_the_last(tmp_path, monkeypatch, whole):
    """A kill may come after any change of the folder: before and after it pieces can be read."""
    path, parts, seen, early = tmp_path / "run.h5", tmp_path / "run.parts", [], []

    def read():
        assert pieces(parts) == sorted(parts.glob("*.h5")), "a gap"
        if path.exists() or pieces(parts):
            seen.append(beginning(path, whole))
            early.append(fsipetsc.open_run(path))

    def watched(work):
        def watching(*args, **more):
            read()
            done = work(*args, **more)
            read()
            return done

        return watching

    with monkeypatch.context() as patch:
        patch.setattr(writer, "FRAMES", 4)
        for name in ("replace", "unlink", "rename", "rmdir"):
            patch.setattr(os, name, watched(getattr(os, name)))
        made(path)
    assert seen == sorted(seen) and len(set(seen)) > 3
    assert seen[-1] == (13, len(whole.series["t"])) and os.listdir(tmp_path) == ["run.h5"]
    with pytest.raises(FileError, match="has changed since it was opened; open it again"):
        next(result for result in early if result.nframes).layers[0]["T"]


def test_earlier_results_are_kept_and_a_second_run_of_the_name_is_refused(left):
    """Whole ones, and what a killed run has left; each with its number, by which it is read."""
    folder = left.parent
    (folder / "run.1.h5").touch()
    (folder / "run.2.h5").symlink_to("nowhere")
    held, before = lock(folder / "run.parts", "run.h5"), sorted(os.listdir(folder))
    with pytest.raises(FileError, match=r"another run is writing it; .* -fsi_output") as caught:
        made(left)
    assert caught.value.status == 4 and sorted(os.listdir(folder)) == before
    held.close()
    for frames in (2, 3):
        made(left, frames)
        (damaged := folder / "run.parts").mkdir()
        shutil.copy(left, damaged / "000003.h5")  # no run goes on from it
    for name, frames in (("run.3.h5", 12), ("run.4.h5", 2), ("run.h5", 3)):
        assert fsipetsc.open_run(folder / name).nframes == frames + 1
    (damaged / "000001.h5").touch()
    (folder / "run.h5").unlink()
    made(left, 1)
    assert (folder / "run.5.parts/000001.h5").exists() and fsipetsc.open_run(left).nframes == 2


WITHOUT = """
import sys
for name in ("petsc4py", "mpi4py", "scipy", "matplotlib"):
    sys.modules[name] = None
import fsipetsc
assert not {"numpy", "h5py"} & sys.modules.keys()
with fsipetsc.open_run(sys.argv[1]) as run:
    print(run.case, run.layers[1]["T"].shape, run.layers[1].x.shape)
"""


def test_reading_needs_numpy_and_h5py_only(whole):
    done = run("-c", WITHOUT, whole.path)
    assert done.stdout == "rod (13, 11) (13, 11)\n", done.stderr


def readable(path):
    """Whether all of it can be read; the error that is raised else has one line."""
    try:
        info(path)
        with fsipetsc.open_run(path) as result:
            for layer in result.layers:
                assert all(len(layer[name]) == result.nframes for name in layer.fields)
                layer.frame(-1)
            steps = len(result.series.get("t", ()))
            assert all(len(values) == steps for values in result.series.values())
    except FileError as error:
        assert error.status == 4 and "\n" not in str(error) and str(path) in str(error), error
        return False
    return True


#: flips one bit of every so many bytes; in a process of its own, as a reader might crash
FLIP = """
import sys
from pathlib import Path
from test_output import readable
content, path = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
fates = []
for at in range(0, len(content), int(sys.argv[3])):
    path.write_bytes(content[:at] + bytes([content[at] ^ (1 << at % 8)]) + content[at + 1:])
    fates.append(readable(path))
print(fates.count(True), fates.count(False))
"""


@pytest.mark.parametrize(
    ("every", "least"), [(797, 4), pytest.param(13, 100, marks=pytest.mark.long)]
)
def test_one_changed_byte_crashes_no_reader(every, least, whole, tmp_path):
    """Metadata has checksums, numbers have none."""
    words = "-c", FLIP, whole.path, tmp_path / "run.h5", every
    done = well(run(*words, cwd=Path(__file__).parent))
    assert min(map(int, done.stdout.split())) > least


@pytest.mark.parametrize("name", ["about", "time", "series/t", "layer1/X"])
def test_what_is_missing_or_of_another_type_or_shape(name, whole, tmp_path):
    for value in (None, "text", np.zeros((2, 2, 2)), np.full(5, 1j)):
        path = shutil.copy(whole.path, tmp_path / "run.h5")
        with h5py.File(path, "r+") as file:
            del file[name]
            if value is not None:
                file[name] = value
        assert not readable(path)
    path.write_bytes(Path(whole.path).read_bytes()[:20_000])
    assert not readable(path)
