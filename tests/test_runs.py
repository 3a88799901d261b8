"""runs/*.opts: each is read, and what its first lines say to run can be built. PETSc's habits."""

from __future__ import annotations

import re
import shlex

import pytest
from helpers import REPOSITORY, run

pytest.importorskip("petsc4py")

RUNS = sorted((REPOSITORY / "runs").rglob("*.opts"))


def commands(path):
    """The words after `python -m fsipetsc` of the commands in comments that name this file."""
    name = path.relative_to(REPOSITORY).as_posix()
    for line in path.read_text().splitlines():
        found = re.fullmatch(r"#\s+(?:mpiexec -n \d+ )?python -m fsipetsc (.*?)(?: && .*)?", line)
        if found and name in line:
            yield shlex.split(found[1])


@pytest.mark.parametrize("path", RUNS, ids=lambda path: path.stem)
def test_each_file_of_options_can_be_run(path, monkeypatch):
    """All but the steps: options, problem, grids."""
    from fsipetsc.analysis.convergence import sections
    from fsipetsc.cases import load_case
    from fsipetsc.options import read_options
    from fsipetsc.process.launch import start_mpi, start_petsc
    from fsipetsc.stepping.solve import build_problem, make_state

    monkeypatch.chdir(REPOSITORY)
    (words,) = commands(path)
    lines = path.read_text().splitlines()
    assert lines[0].startswith("# ") and lines[0].endswith("."), "what it is, in a line"
    comm = start_mpi()
    if words[0] == "convergence":
        own = {option.name for group in sections(["mms"]).values() for option in group}
        assert set(start_petsc(words[2:], comm)) <= own
        return
    case, given = load_case(words[0]), start_petsc(words[1:], comm)
    opt = read_options(case, given)
    set_here = {line.split()[0][1:] for line in lines if line.startswith("-")}
    assert set_here and set_here <= set(opt)
    with make_state(build_problem(case, opt, comm), opt, comm) as state:
        assert state.points > 50


def test_every_case_has_its_options():
    from fsipetsc.cases import BUILT_IN

    assert set(BUILT_IN) <= {words[0] for path in RUNS for words in commands(path)}


def test_petscs_own_options_behave_as_in_its_examples(tmp_path):
    (tmp_path / "a.yaml").write_text("fsi:\n  h: 0.1\nts:\n  type: rk\n  rk_type: 3bs\n")
    (tmp_path / "b.opts").write_text("-ts_max_steps 3\n-ts_monitor\n")
    words = "-options_file_yaml a.yaml -options_file b.opts -ts_view -log_view :log.txt"
    done = run("-m", "fsipetsc", "rod", *words.split(), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    steps = re.findall(r"^(\d+) TS dt (\S+) time (\S+)$", done.stdout, re.M)
    assert [int(number) for number, *_ in steps] == [0, 1, 2, 3], done.stdout
    assert "RK type 3bs" in done.stdout
    assert re.search(r"^TSStep +3 ", (tmp_path / "log.txt").read_text(), re.M)
