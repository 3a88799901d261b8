"""Faults of case files: status 2 and one message that names file and line, or layer and field, and what was expected."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

import pytest
from faulty_cases import ALONE, FAULTS, LATER, RAISING, RIGHT, alone, faulty
from helpers import REPOSITORY, mpirun, solve
from said import parted

import fsipetsc
from fsipetsc.blame import call
from fsipetsc.errors import InputError

pytest.importorskip("petsc4py")


def answers(ranks: int, where: Path, texts: dict[str, str], status: int | None = 2) -> dict[str, str]:
    """What is said about each of the case files, all run in one process; each must end with the status, or with any."""
    runs = []
    for number, text in enumerate(texts.values()):
        (where / f"case{number}").mkdir()
        (where / f"case{number}" / "faulty.py").write_text(text)
        runs.append([status, f"case{number}/faulty.py -fsi_quiet -fsi_output case{number}/faulty.h5"])
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


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_compiled_functions_are_taken_like_those_of_python(ranks, tmp_path):
    """All that a case may define, by numba, cached and not: the same numbers to the last bit."""
    tuples = RIGHT.replace("0 * X, 0.0, np.zeros(X.shape)", "0 * X, 0 * X, np.zeros(X.shape)")
    tuples = tuples.replace("0 * X, np.full", "-0.5 * X, np.full")
    compiled = tuples.replace("    def ", "    @njit\n    def ").replace("return g_initial(X)", "return whole(g_initial(X))")
    compiled = compiled.replace("def build(", "@njit(cache=True)\ndef whole(fields):\n    return fields\n\ndef build(")
    assert compiled.count("@njit") == 9
    (tmp_path / "python.py").write_text(tuples)
    (tmp_path / "compiled.py").write_text(compiled)
    (tmp_path / "runs.json").write_text(json.dumps([[0, f"{name}.py -fsi_quiet"] for name in ("python", "compiled")]))
    done = mpirun(ranks, REPOSITORY / "tests" / "many_runs_program.py", "runs.json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["wrong"] == []
    with fsipetsc.open_run(tmp_path / "python.h5") as one, fsipetsc.open_run(tmp_path / "compiled.h5") as other:
        assert one.errors == other.errors and one.summary["steps"] == 4
        for a, b in zip(one.layers, other.layers, strict=True):
            assert all(a[field].tobytes() == b[field].tobytes() for field in a.fields)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_one_message_that_says_where_and_what(name, said):
    for word in ["fsipetsc: error: ", *faulty(name)[1]]:
        assert word in parted(said[name])[1]
    assert parted(said[name])[1].count("\n") == 1
    assert "unexpected" not in said[name]


def test_the_traceback_of_a_function_that_raises_begins_in_the_case_file(said):
    """And there is none of anything else that is wrong."""
    found = {name: traceback for name, text in said.items() if (traceback := parted(text)[0])}
    assert found.keys() == RAISING
    for name, text in found.items():
        assert re.match(r'  File "[^"]*/faulty.py", line \d+, in ', text), (name, text)
        kind = text.splitlines()[-1].split(":")[0].split(".")[-1]
        assert kind in parted(said[name])[1], (name, text)


#: bodies of functions, and the beginnings of the lines that say which errors there were, in their order
CHAINS = {
    "a library's own alone": ("ChainMap().pop(1)", ["KeyError: 'Key not"]),
    "before a library's own": (
        "try: 1 / 0\n    except ZeroDivisionError: ChainMap().pop(1)",
        ["ZeroDivisionError", "KeyError: 1", "KeyError: 'Key not"],
    ),
    "after a library's own": (
        "try: ChainMap().pop(1)\n    except KeyError: 1 / 0",
        ["KeyError: 'Key not", "ZeroDivisionError"],
    ),
    "named, never raised": ("raise ValueError from TypeError('text')", ["TypeError: text", "ValueError"]),
    "hidden": ("try: 1 / 0\n    except ZeroDivisionError: raise ValueError from None", ["ValueError"]),
    "in a ring": (
        "a, b = ValueError(), TypeError()\n    a.__cause__, b.__cause__ = b, a\n    raise a",
        ["TypeError", "ValueError"],
    ),
}


@pytest.mark.parametrize("name", CHAINS)
def test_errors_before_the_last_begin_with_the_first_of_the_user_s(name, tmp_path):
    """What a library has dealt with before that is its own affair."""
    body, kinds = CHAINS[name]
    (tmp_path / "chains.py").write_text(f"from collections import ChainMap\ndef function():\n    {body}\n")
    spec = importlib.util.spec_from_file_location("chains", tmp_path / "chains.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    with pytest.raises(InputError) as caught:
        call(module.function, (), "what it is")
    text = caught.value.users
    said = re.findall(r"^(?!Traceback|The above|During)\S.*", text, re.M)
    assert [line.startswith(kind) for line, kind in zip(said, kinds, strict=True)] == [True] * len(kinds), text
    places = re.findall(r'^Traceback .*\n  File "(.*)", line', text, re.M)
    assert places[0] == str(tmp_path / "chains.py") and "fsipetsc/" not in text.replace(str(tmp_path), ""), text


def test_a_result_is_left_only_by_what_was_computed(where, said):
    for number, name in enumerate(FAULTS):
        path = where / f"case{number}" / "faulty.h5"
        assert path.exists() == (name in LATER), name
        if name in LATER:
            with fsipetsc.open_run(path) as result:
                assert result.summary["status"] == "failed"
                assert len(result.series["t"]) == result.summary["steps"] >= 1
                assert result.nframes >= 1


@pytest.mark.mpi
def test_a_fault_on_one_rank_alone_ends_all_with_it(tmp_path):
    """Whatever one of two ranks does, at any time: both end with 2 and nobody waits."""
    for name, text in answers(2, tmp_path, {name: alone(name)[0] for name in ALONE}).items():
        for word in alone(name)[1]:
            assert word in text, name
