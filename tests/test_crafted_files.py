"""Checkpoints and results whose content was tampered with (crafted_files.py): each is used, or
refused with one message and status 4, and then nothing is left behind.
"""

import random
import shutil

import numpy as np
import pytest
from crafted_files import ARRAYS, crafted_checkpoint, crafted_result
from helpers import message, solve

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output import checkpoint_file
from fsipetsc.output.info import info
from fsipetsc.output.plots.page import plot
from fsipetsc.output.structure import ANYTHING, COUNT, NUMBER, TEXT, check

NAN = float("nan")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with rod.h5 and rod.checkpoint.h5."""
    folder = tmp_path_factory.mktemp("whole")
    words = "-fsi_coupling projection -fsi_h 0.05 -ts_max_steps 6 -fsi_output_dt 1e-4 -fsi_quiet"
    words += " -fsi_checkpoint_steps 6"
    done = solve("rod", *words.split(), cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def contents(folder):
    return {path.name: path.is_file() and path.read_bytes() for path in folder.iterdir()}


def gone_on(folder):
    """What a run says that goes on from c.h5 with the result that is there."""
    return solve("rod", *"-fsi_restart c.h5 -ts_max_steps 7 -fsi_quiet".split(), cwd=folder)


def test_what_fits_and_what_does_not():
    pattern = {"a": TEXT, "b?": [COUNT], "c": {str: (NUMBER, NUMBER)}, "d": ANYTHING}
    good = {"a": "x", "c": {"y": [1, 2.5]}, "d": None, "e": 3}
    check(good, pattern, "it")
    check({**good, "b": [0, 3]}, pattern, "it")
    for changed, said in (
        ({"a": 3}, "'a' of it is 3: expected a text"),
        ({"b": [0, -1]}, "entry 1 of 'b' of it is -1"),
        ({"b": [True]}, "entry 0 of 'b' of it is True"),
        ({"b": [float("inf")]}, "is inf"),
        ({"c": {"y": [1, NAN]}}, "entry 1 of 'y' of 'c' of it is nan: expected a finite number"),
        ({"c": {"y": [1]}}, "expected a list of 2"),
        ({"c": []}, "expected a table"),
    ):
        with pytest.raises(ValueError, match=said):
            check({**good, **changed}, pattern, "it")
    with pytest.raises(ValueError, match="it has no 'c'"):
        check({"a": "x", "d": 1}, pattern, "it")


#: place of an entry of a checkpoint's header -> what stands there instead; ...: nothing
HEADERS = [
    *((key, ...) for key in ("case", "options", "problem", "columns", "run", "memory", "ledgers")),
    *(("saved_at", ...), ("result", ...), ("result", [1]), ("result", [1, 1.5]), ("run", 3)),
    *(("saved_at", NAN), ("saved_at", 1e9), ("columns", 3), ("problem", [3]), ("options", [])),
    *(("memory/t", NAN), ("memory/t", -1.0), ("memory/steps", ""), ("memory/initial", {})),
    *(("memory/initial/mass", [1.0]), ("memory/beyond", None), ("ledgers/energies", [0.0])),
    *(("ledgers/drifts", None), ("options/fsi_h", "x"), ("options/fsi_order", 5)),
]


def test_entries_of_the_header_of_a_checkpoint(whole, tmp_path):
    """Each on all ranks, before anything is written: the result stays as it is."""
    shutil.copy(whole / "rod.h5", tmp_path)
    for number, (place, value) in enumerate(HEADERS):
        header, arrays = checkpoint_file.read(whole / "rod.checkpoint.h5")
        *above, last = place.split("/")
        table = header
        for key in above:
            table = table[key]
        del table[last]
        if value is not ...:
            table[last] = value
        checkpoint_file.write(tmp_path / "c.h5", header, arrays)
        before = contents(tmp_path)
        ranks = 2 if number % 8 == 0 else 1
        words = "-fsi_restart c.h5 -ts_max_steps 7 -fsi_quiet".split()
        message(solve("rod", *words, cwd=tmp_path, ranks=ranks), 4, "c.h5: ", last)
        assert contents(tmp_path) == before, place


#: what is done to arrays of a checkpoint
WRONG = "longer", "shorter", "empty", "of one more axis", "one number", "of float32", "complex"
WRONG += "of texts", "NaN", "with a NaN", "with an inf"


def test_arrays_of_a_checkpoint(whole, tmp_path):
    """Of another length or type, or with NaN, but for what was recorded of the last step; points of
    a gas that are not those of its interface."""
    shutil.copy(whole / "rod.h5", tmp_path)
    header, arrays = checkpoint_file.read(whole / "rod.checkpoint.h5")
    tried = [(name, what) for name in arrays for what in WRONG]
    tried = [pair for pair in tried if pair[0] != "latest" or "N" not in pair[1]][::3]
    tried += [("lo", "-1"), ("hi", "backwards"), ("x_interface", "backwards")]
    for name, what in tried:
        changed = ARRAYS[what](arrays[name])
        checkpoint_file.write(tmp_path / "c.h5", header, {**arrays, name: changed})
        before = contents(tmp_path)
        # with another number of points it may be a checkpoint of another case
        other = name.startswith("layer") and what in ("longer", "shorter", "empty")
        words = "nodes of" if other else name
        message(gone_on(tmp_path), 2 if other else 4, words)
        assert contents(tmp_path) == before, (name, what)


@pytest.mark.parametrize("count", [25, pytest.param(250, marks=pytest.mark.long)])
def test_crafted_checkpoints(count, whole, tmp_path):
    refused = 0
    for number in range(count):
        shutil.copy(whole / "rod.h5", tmp_path)
        done = crafted_checkpoint(
            random.Random(number), whole / "rod.checkpoint.h5", tmp_path / "c.h5"
        )
        before, run = contents(tmp_path), gone_on(tmp_path)
        assert run.returncode in (0, 2, 3, 4), (done, run.stderr)
        if run.returncode:
            message(run, run.returncode)
        if run.returncode in (2, 4):
            assert contents(tmp_path) == before, done
            refused += 1
    assert refused > count / 2


def read_wholly(path):
    with fsipetsc.open_run(path) as run:
        for layer in run.layers:
            assert all(len(layer[name]) == run.nframes for name in layer)
        for name in ("t", "dt"):
            assert np.isfinite(run.series.get(name, 0.0)).all()


@pytest.mark.parametrize(
    ("count", "drawn"), [(60, 2), pytest.param(250, 250, marks=pytest.mark.long)]
)
def test_crafted_results(count, drawn, whole, tmp_path):
    """They are read, or all commands refuse them in one line; some of the former are drawn."""
    path, read, refused = tmp_path / "r.h5", 0, 0
    for number in range(count):
        done = crafted_result(random.Random(number), whole / "rod.h5", path)
        commands = [lambda: info(path), lambda: plot(str(path), {"-o": str(tmp_path / "r.png")})]
        try:
            read_wholly(path)
        except FileError as error:
            assert "\n" not in str(error) and str(path) in str(error), done
            refused += 1
            for command in commands:
                with pytest.raises(FileError):
                    command()
        else:
            read += 1
            for command in commands[: 2 if read <= drawn else 1]:
                command()
    assert read > count / 10 and refused > count / 2
