"""Case files changed at random: whatever a user writes, a run ends with 0, 2 or 3, one message and its traceback at most."""

from __future__ import annotations

import ast
import copy
import json
import random
import re
from collections.abc import Callable

import pytest
from helpers import REPOSITORY, mpirun
from said import parted

pytest.importorskip("petsc4py")

PISTON = (REPOSITORY / "runs" / "piston.py").read_text()
SEEDS = range(200, 248)  # of 216 the energy is beyond all numbers
_VALUES = (float("inf"), 0, -1.0, 1e300, None, "text", 1j, (), True)


def _numbers(tree: ast.AST) -> list[ast.Constant]:
    return [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, (int, float))]


def _name(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def number(tree: ast.Module, rng: random.Random) -> None:
    """A number becomes something else."""
    rng.choice(_numbers(tree)).value = rng.choice(_VALUES)


def no_number(tree: ast.Module, rng: random.Random) -> None:
    """A function that returns a list gets nan or inf in it, or an entry of another kind."""
    returns = [node.value for node in ast.walk(tree) if isinstance(node, ast.Return)]
    values = rng.choice([node for node in returns if isinstance(node, ast.List)])
    values.elts[rng.randrange(len(values.elts))] = _name(rng.choice(("np.nan * X", "np.inf", "X[1:]", "'text'", "gas", "None")))


def returned(tree: ast.Module, rng: random.Random) -> None:
    """Something else is returned."""
    node = rng.choice([node for node in ast.walk(tree) if isinstance(node, ast.Return)])
    node.value = _name(rng.choice(("None", "7", "'text'", "[]", "{}", "np.zeros(3)", "iter(())")))


def argument(tree: ast.Module, rng: random.Random) -> None:
    """An argument is missing."""
    call = rng.choice([node for node in ast.walk(tree) if isinstance(node, ast.Call) and (node.args or node.keywords)])
    words = call.keywords if call.keywords and (rng.random() < 0.5 or not call.args) else call.args
    words.pop(rng.randrange(len(words)))


def statement(tree: ast.Module, rng: random.Random) -> None:
    """A line is missing, or changes its place with the next one."""
    bodies = [node.body for node in ast.walk(tree) if isinstance(node, (ast.Module, ast.FunctionDef)) and len(node.body) > 1]
    body = rng.choice(bodies)
    i = rng.randrange(len(body) - 1)
    if rng.random() < 0.5:
        body[i], body[i + 1] = body[i + 1], body[i]
    else:
        del body[i]


def names(tree: ast.Module, rng: random.Random) -> None:
    """Two names change places."""
    one, other = rng.sample([node for node in ast.walk(tree) if isinstance(node, ast.Name)], 2)
    one.id, other.id = other.id, one.id


KINDS: tuple[Callable[[ast.Module, random.Random], None], ...] = (number, no_number, returned, argument, statement, names)


def mutants() -> dict[str, str]:
    """Name -> text of the case file; the same ones every time."""
    found: dict[str, str] = {}
    for seed in SEEDS:
        tree, change = copy.deepcopy(ast.parse(PISTON)), KINDS[seed % len(KINDS)]
        change(tree, random.Random(seed))
        found[f"{change.__name__} {seed}"] = ast.unparse(ast.fix_missing_locations(tree))
    return found


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_no_change_of_a_case_file_is_more_than_one_message(ranks, tmp_path):
    runs, texts = [], list(mutants().values())[:: 3 * ranks - 2]
    for n, text in enumerate(texts):
        (tmp_path / f"m{n}").mkdir()
        (tmp_path / f"m{n}" / "mutant.py").write_text(text)
        runs.append([[0, 2, 3], f"m{n}/mutant.py -ts_max_steps 3 -fsi_quiet -fsi_output m{n}/r.h5"])
    (tmp_path / "runs.json").write_text(json.dumps(runs))
    done = mpirun(ranks, REPOSITORY / "tests" / "many_runs_program.py", "runs.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout.splitlines()[-1])
    assert answer["wrong"] == []
    assert len([text for text in answer["said"] if text]) > len(texts) / 3, "most changes are faults"
    tracebacks, messages = zip(*map(parted, answer["said"]), strict=True)
    assert not [text for text in messages if "unexpected" in text]
    assert any(tracebacks) and all(not text or re.match(r'  File "[^"]*/mutant.py"', text) for text in tracebacks)
