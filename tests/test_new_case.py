"""The command `new`: a case file that runs as it is, and is never put in the place of another."""

import re

import numpy as np
import pytest
from helpers import computed, kept, on_ranks, solve, well


def written(folder, name, *words, ranks=1):
    """The text of the case file that `new` writes, with its names."""
    made = well(solve("new", name, *words, cwd=folder, ranks=ranks))
    assert made.stdout.count("wrote") == 1 and f"python -m fsipetsc {name}" in made.stdout
    text = (folder / name).read_text()
    assert name in text and "FILE.py" not in text and "NAME." not in text
    return text


def test_the_case_runs_and_does_what_it_says(tmp_path):
    """The plate swings with the amplitude and the period of the file's own words."""
    text = written(tmp_path, "my_case.py", ranks=2)
    result = kept(computed(tmp_path, "a.h5", "my_case.py", ranks=2), 1e-3)
    assert result.complete and result.nframes == 41
    t, way = result.series["t"], result.series["x_interface"][:, 0] - 0.4
    swing = r"it goes ([\d.]+) m to the right and comes back; the period is ([\d.]+) s"
    told = re.search(swing, text)
    assert way.max() == pytest.approx(float(told[1]), rel=0.02)
    assert 2 * (t[way.argmin()] - t[way.argmax()]) == pytest.approx(float(told[2]), rel=0.02)


def test_blocks(tmp_path):
    """The built-in case ring, as a file: the same numbers, on three ranks as on two."""
    written(tmp_path, "my_ring.py", "-blocks")
    line = "-fsi_order 4 -fsi_h 0.1 -ring_around 32 -ts_max_time 0.1"
    result = kept(on_ranks(tmp_path, f"my_ring.py {line}", 2, 3), 1e-9)
    ring = computed(tmp_path, "ring.h5", "ring", *line.split())
    assert result.complete and result.case == "my_ring"
    assert np.array_equal(result.layers[1]["x"], ring.layers[1]["x"])
    moved = result.interface("inside | ring").displacement[-1]
    assert np.array_equal(moved, ring.interface("inside | ring").displacement[-1])


def test_plate(tmp_path):
    """Without air the plate goes to twice its static deflection and is back after a period."""
    text = written(tmp_path, "my_plate.py", "-plate")
    line = "my_plate.py -plate_air false -ts_max_time 3.8e-4"
    result = computed(tmp_path, "a.h5", *line.split())
    t, way = result.series["t"], result.series["y_point"][:, 0]
    w, period = map(float, re.search(r"= ([\d.]+) um,.* a period of ([\d.]+) ms", text).groups())
    assert way.max() == pytest.approx(2 * 1.034 * 1e-6 * w, rel=0.03)
    back = t > 0.7e-3 * period
    assert t[back][way[back].argmin()] == pytest.approx(1e-3 * period, rel=0.03)


@pytest.mark.parametrize("kind", ["water", "channel"])
def test_other_templates(kind, tmp_path):
    written(tmp_path, "mine.py", f"-{kind}")
    run = kept(computed(tmp_path, "a.h5", "mine.py", "-ts_max_steps", 3), 1e-9)
    assert run.summary["steps"] == 3
