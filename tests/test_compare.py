"""Pages of two results: what is drawn of both, of what one of them has not, and of damaged ones."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import output_program as program
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("petsc4py")

import fsipetsc
from fsipetsc.cli import main
from fsipetsc.errors import FileError
from fsipetsc.output.places import check_folder, writing
from fsipetsc.output.plots import command, compare
from fsipetsc.output.plots.frames import apart, outside

STEPS, MOVED, FIELDS = "time step", "position x of the interface", "temperature T"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Two results, one without steps, and one whose steps are at no time."""
    where = tmp_path_factory.mktemp("compared")
    for name, frames in (("long", 12), ("short", 9)):
        program.write(str(where / f"{name}.h5"), frames, "blocks")

    def without(file: h5py.File) -> None:
        del file["series"]

    def damage(file: h5py.File) -> None:
        rows = file["series"][...]
        rows["t"] = np.inf
        del file["series"]
        file["series"] = rows

    changes: dict[str, Callable[[h5py.File], None]] = {"still": without, "damaged": damage}
    for name, change in changes.items():
        (where / f"{name}.h5").write_bytes((where / "long.h5").read_bytes())
        with h5py.File(where / f"{name}.h5", "r+") as file:
            change(file)
    return where


def drawn(folder: Path, a: str, b: str, *words: str, status: int = 0) -> str:
    """The page as SVG."""
    target = folder / f"{a}-{b}.svg"
    assert main(["plot", str(folder / f"{a}.h5"), "-compare", str(folder / f"{b}.h5"), *words, "-o", str(target)]) == status
    return target.read_text()


def test_two_results(folder, capsys):
    page = drawn(folder, "long", "short")
    assert "long.h5 (lines) and short.h5 (dashed)" in page
    for text in (STEPS, MOVED, FIELDS, "largest difference", "equal, bit for bit"):
        assert (text in page) == (text != "largest difference"), text  # what both have are the same numbers
    page = drawn(folder, "long", "short", "-fields", "p")
    assert FIELDS not in page and "pressure" in page
    assert capsys.readouterr().err == ""


def test_times_that_a_result_does_not_have_are_said(folder, capsys, monkeypatch):
    """By the page of a run, of two and by all pictures."""
    ends = {name: fsipetsc.open_run(folder / f"{name}.h5").time[-1] for name in ("long", "short")}
    assert ends["short"] < ends["long"]
    told = {name: f"{name}.h5 ends at t = {t:g} s; its last frame is drawn" for name, t in ends.items()}
    monkeypatch.setattr(command, "plot", lambda *arguments: [Path("all.png")])
    for words, names in (((), ["long"]), (("-compare", str(folder / "short.h5")), ["long", "short"]), (("-all",), ["long"])):
        where = folder if words == ("-all",) else folder / "drawn.svg"
        assert main(["plot", str(folder / "long.h5"), "-o", str(where), "-times", "77", *words]) == 0
        *said, _ = capsys.readouterr().out.splitlines()
        assert said == [f"note: -times 77: {told[name]}" for name in names]


def test_which_times_are_said():
    a, b = (SimpleNamespace(path=f"/x/{name}.h5", time=np.array(t), nframes=2, header={}) for name, t in (
        ("a", [0.5, 1.0]), ("b", [0.5, 0.75]),
    ))  # fmt: skip
    assert list(outside(a, [0.5, 0.7, 1.0 + 1e-12])) == []
    assert list(outside(a, [0.0, 1.5, 0.7, 2.0])) == [
        "note: -times 0: a.h5 begins at t = 0.5 s; its first frame is drawn",
        "note: -times 1.5,2: a.h5 ends at t = 1 s; its last frame is drawn",
    ]
    assert list(outside(SimpleNamespace(nframes=0), [1.0])) == []
    assert list(apart(a, b, [(0, 0), (1, 1)])) == ["note: a.h5 and b.h5 are at other times: t = 1 and 0.75 s"]
    assert list(apart(a, b, [(0, 0)])) == []


@pytest.mark.parametrize("names", [("still", "long"), ("long", "still"), ("still", "still")])
def test_results_without_steps(folder, names, capsys):
    """Frames alone, as of a run that was to make none: what both have is drawn."""
    page = drawn(folder, *names)
    assert FIELDS in page and STEPS not in page and MOVED not in page
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("words", ["plot {} -o text/a.png", "plot {} -o text", "plot {} -animate -o text", "report {} -o text"])
def test_a_file_where_a_directory_should_be(words, folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("a text")
    monkeypatch.setattr(command.page, "draw", lambda *_, **__: None)  # what is drawn does not matter here
    monkeypatch.setattr("fsipetsc.output.report._page", lambda *_: "")
    assert main(words.format(folder / "short.h5").split()) == 4
    said = capsys.readouterr().err
    assert "cannot write the " in said and said.endswith(": text is not a directory\n") and said.count("\n") == 1, said


@pytest.mark.parametrize("where", ["x" * 300, "closed/in", "there/in"])
def test_a_directory_that_cannot_be_looked_for(where, tmp_path, monkeypatch):
    """A name that is too long; below a directory that may not be looked into, at which the system's calls are as for a user."""
    stat = os.stat

    def refuse(path, *more, **words):
        if os.fspath(path).startswith(str(tmp_path / "closed" / "in")):
            raise PermissionError(13, "Permission denied", os.fspath(path))
        return stat(path, *more, **words)

    monkeypatch.setattr(os, "stat", refuse)
    target, parent = tmp_path / where / "a.png", tmp_path / where
    reason = "File name too long" if where == "x" * 300 else "Permission denied"
    with pytest.raises(FileError, match=f"cannot write the picture: {reason}"), writing(target):
        raise PermissionError(13, "Permission denied", str(target))
    if not where.startswith("there"):
        with pytest.raises(FileError, match=re.escape(f"a.png: {parent}: {reason}")):
            check_folder(target, parent)


@pytest.mark.parametrize("names", [("damaged", "long"), ("damaged", "damaged")])
def test_damaged_results(folder, names, capsys):
    """What can be drawn is; the one message names both, and what could not be drawn."""
    page = drawn(folder, *names, status=4)
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "the result is damaged, not drawn: " in said and "the rest is in " in said, said
    assert all(f"{name}.h5" in said for name in names) and FIELDS in page


def test_maps_are_subtracted_where_layers_are_the_same():
    """By name, kind and points: gases have other fields than solids."""

    def run(*layers: tuple[str, str, int]) -> SimpleNamespace:
        made = [SimpleNamespace(name=name, kind=kind, shape=(3, n)) for name, kind, n in layers]
        return SimpleNamespace(layers=made)

    one = run(("a", "fluid", 5), ("b", "solid", 5))
    assert compare.alike(one, run(("a", "fluid", 5), ("b", "solid", 5)))
    for other in (
        run(("a", "fluid", 5), ("b", "fluid", 5)),
        run(("a", "fluid", 5), ("c", "solid", 5)),
        run(("a", "fluid", 5), ("b", "solid", 6)),
        run(("a", "fluid", 5)),
    ):
        assert not compare.alike(one, other) and not compare.alike(other, one)


def test_options_of_one_run_of_the_program_are_not_listed(monkeypatch):
    """The same ones that no checkpoint keeps."""
    options = {"fsi_h": (0.1, 0.2), "fsi_quiet": (True, False), "fsi_restart": (None, "auto"), "fsi_wall_limit": (None, 5.0)}
    found = SimpleNamespace(differences=(), notes=(), options=options)
    monkeypatch.setattr(compare, "compare", lambda a, b: found)
    written: list[str] = []
    axes = SimpleNamespace(axis=lambda how: None, transAxes=None, text=lambda x, y, text, **look: written.append(text))
    compare._differences(axes, [SimpleNamespace(path="a"), SimpleNamespace(path="b")])
    assert "-fsi_h: 0.1, 0.2" in written[0] and written[0].count("-fsi_") == 1
