"""Faults of case files: status 2 and one message that names file and line, or layer and field, and
what was expected.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from faulty_cases import FAULTS, LATER, RIGHT, faulty
from helpers import REPOSITORY, mpirun, solve

import fsipetsc

pytest.importorskip("petsc4py")


def answers(
    ranks: int, where: Path, texts: dict[str, str], status: int | None = 2
) -> dict[str, str]:
    """What is said about each of the case files, all run in one process; each must end with the
    status, or with any.
    """
    runs = []
    for number, text in enumerate(texts.values()):
        (where / f"case{number}").mkdir()
        (where / f"case{number}" / "faulty.py").write_text(text)
        runs.append(
            [status, f"case{number}/faulty.py -fsi_quiet -fsi_output case{number}/faulty.h5"]
        )
    (where / "runs.json").write_text(json.dumps(runs))
    done = mpirun(ranks, REPOSITORY / "tests" / "many_runs_program.py", "runs.json", cwd=where)
    assert (done.returncode, done.stderr) == (0, "")
    answer = json.loads(done.stdout)
    assert answer["wrong"] == []
    return dict(zip(texts, answer["said"], strict=True))


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    return tmp_path_factory.mktemp("faulty")


@pytest.fixture(scope="module")
def said(where):
    return answers(1, where, {name: faulty(name)[0] for name in FAULTS})


def test_the_case_that_the_faulty_ones_are_made_of_is_right(tmp_path):
    (tmp_path / "right.py").write_text(RIGHT)
    done = solve("right.py", "-fsi_quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_one_message_that_says_where_and_what(name, said):
    for word in ["fsipetsc: error: ", *faulty(name)[1]]:
        assert word in said[name]
    assert said[name].count("\n") == 1
    assert "unexpected" not in said[name]


def test_a_result_is_left_only_by_what_was_computed(where, said):
    for number, name in enumerate(FAULTS):
        path = where / f"case{number}" / "faulty.h5"
        assert path.exists() == (name in LATER), name
        if name in LATER:
            with fsipetsc.open_run(path) as result:
                assert result.summary["status"] == "failed"
                assert len(result.series["t"]) == result.summary["steps"] >= 1
                assert result.nframes >= 1
