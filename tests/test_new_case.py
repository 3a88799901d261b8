"""The command `new`: a case file that runs as it is, and is never put in the place of another."""

from __future__ import annotations

import os
import re

import pytest
from helpers import assert_same_fields, solve

import fsipetsc
from fsipetsc.cases import template_text
from fsipetsc.errors import FileError, InputError
from fsipetsc.output.new_case import new_case

pytest.importorskip("petsc4py")


def test_the_case_runs_and_does_what_it_says(tmp_path):
    """The plate swings with the amplitude and the period of the file's own words."""
    made = solve("new", "my_case.py", cwd=tmp_path, ranks=2)
    assert (made.returncode, made.stderr, made.stdout.count("wrote")) == (0, "", 1)
    assert "python -m fsipetsc my_case.py" in made.stdout
    text = (tmp_path / "my_case.py").read_text()
    assert "FILE.py" not in text and "NAME.h5" not in text and "plot my_case.h5" in text
    assert text.splitlines()[15:] == template_text().splitlines()[15:], "but for its own name"

    done = solve("my_case.py", "-fsi_check", 1e-3, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "my_case.h5") as result:
        assert result.complete and result.nframes == 41
        t, way = result.series["t"], result.series["x_interface"][:, 0] - 0.4
    swing = r"it goes ([\d.]+) m to the right and comes back; the period is ([\d.]+) s"
    told = re.search(swing, text)
    assert way.max() == pytest.approx(float(told[1]), rel=0.02)
    assert 2 * (t[way.argmin()] - t[way.argmax()]) == pytest.approx(float(told[2]), rel=0.02)


def test_blocks(tmp_path):
    """A ring that widens under the gas in it, what is kept of it; on three ranks as on two."""
    made = solve("new", "my_ring.py", "-blocks", cwd=tmp_path)
    assert (made.returncode, made.stderr) == (0, "")
    text, template = (tmp_path / "my_ring.py").read_text(), template_text(True)
    assert "FILE" not in text and "NAME." not in text and "my_ring.xdmf" in text
    assert text.splitlines()[12:] == template.splitlines()[12:]
    words = "my_ring.py", "-fsi_h", 0.04, "-ts_max_time", 0.004, "-fsi_check", 1e-9
    for name, ranks in (("two.h5", 2), ("three.h5", 3)):
        done = solve(*words, "-fsi_output", name, cwd=tmp_path, ranks=ranks)
        assert (done.returncode, done.stderr) == (0, "")
    two, three = (fsipetsc.open_run(tmp_path / name) for name in ("two.h5", "three.h5"))
    assert two.complete and two.dimension == 2 and two.nframes == 11
    moved = two.interface("gas | ring").displacement[-1]
    assert 1e-3 < moved.mean() < 6e-3 and moved.max() < 2e-2
    assert_same_fields(two, three)


def test_what_is_there_stays(tmp_path):
    (tmp_path / "mine.py").write_text("precious")
    (tmp_path / "link.py").symlink_to("nowhere")
    for name in ("mine.py", "link.py"):
        with pytest.raises(FileError, match=f"{name}: exists already"):
            new_case(str(tmp_path / name), ())
    assert (tmp_path / "mine.py").read_text() == "precious"
    assert sorted(os.listdir(tmp_path)) == ["link.py", "mine.py"]


NAMES = {
    "rod.py": "'rod' is the name of a built-in case",
    "numpy.py": "a Python module, which this file would hide",
    "run.h5": "expected one that ends in .py",
}


@pytest.mark.parametrize("name", NAMES)
def test_a_name_that_would_not_do(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=re.escape(NAMES[name])):
        new_case(name, ("info", "plot"))
    assert os.listdir(tmp_path) == []
