"""Runs in which a field is driven out of its range, or a function of the case fails.

On 2 and 3 ranks: one message, the same on all; the result opens.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers import REPOSITORY, message, solve

import fsipetsc

pytest.importorskip("petsc4py")

pytestmark = pytest.mark.mpi

CASE = REPOSITORY / "tests" / "going_wrong.py"
RANKS = 2, 3
#: dimension, layers, number of the driven one, its unknown, its rate -> words
DRIVEN = {
    (1, "gsg", 0, "e", -1e6): "T = -",
    (1, "gsg", 0, "rho", -1e6): "rho = -",
    (1, "gsg", 1, "x", -1e6): "J = -",
    (1, "sgs", 2, "T", -1e6): "T = -",
    (2, "gsg", 0, "rho v", 1e308): "v = ",
    (2, "gsg", 2, "e", 1e308): "T = 6.66667e+303, too large to go on with,",
    (2, "sgs", 0, "y", -1e6): "J = -",
    (2, "gsg", 0, "place", 2000): "J",
}
#: functions that fail, and whether they are compiled; on all ranks, or on the last of three alone
FAILING = {("edge", 0), ("initial", 0), ("forcing", 1), ("jumps", 0), ("T", 0)}


def runs(ranks: int) -> dict[str, list[str]]:
    """Name -> words of the command line."""
    found = {}
    for k, (d, layers, number, field, rate) in enumerate(DRIVEN):
        time = 0.0101 if field == "place" else 0.01
        text = f"-mad_dimension {d} -mad_layers {layers} -mad_layer {number}"
        text += f" -mad_rate {rate} -mad_time {time}"
        found[f"driven {k}"] = [*text.split(), "-mad_field", field]
    for name, compiled in sorted(FAILING):
        rank = ranks - 1 if name == "initial" else -1
        text = f"-mad_function {name} -mad_compiled {compiled} -mad_rank {rank} -mad_time 0.0105"
        layers = "sg" if name == "edge" else "gsg"
        found[f"failing {name}"] = f"{text} -mad_layers {layers} -ts_max_steps 20".split()
    for name, words in found.items():
        words[:0] = [str(CASE), "-fsi_quiet", "-fsi_output", f"{name.replace(' ', '_')}.h5"]
    return found


@pytest.fixture(scope="module", params=RANKS)
def said(request, tmp_path_factory) -> tuple[Path, dict[str, tuple[int, str]]]:
    """Folder, and name -> (status, message) of all runs."""
    where, texts = tmp_path_factory.mktemp(f"on{request.param}"), {}
    for name, words in runs(request.param).items():
        done = solve(*words, cwd=where, ranks=request.param)
        texts[name] = done.returncode, message(done, done.returncode)
    return where, texts


def test_what_went_wrong_is_named_and_what_helps(said):
    """Field, layer, place, time, step; what usually helps; a result that opens."""
    where, texts = said
    for k, ((_, layers, number, _, _), words) in enumerate(DRIVEN.items()):
        status, text = texts[f"driven {k}"]
        layer = f"layer '{'gas' if layers[number] == 'g' else 'bar'} {number}'"
        for word in (
            f"error: {words}",
            layer,
            " at x = ",
            ", t = 0.01",
            ", step 1",
            "what usually helps: ",
        ):
            assert status == 3 and word in text, (k, word, text)
        with fsipetsc.open_run(where / f"driven_{k}.h5") as result:
            assert result.summary["status"] == "failed" and result.summary["steps"] >= 10


def test_an_error_of_a_function_ends_all_with_its_place(said):
    where, texts = said
    for name, _ in FAILING:
        status, text = texts[f"failing {name}"]
        for word in ("going_wrong.py, line ", "ValueError: nothing is known"):
            assert status == 2 and word in text, (name, text)
        if name != "initial":
            with fsipetsc.open_run(where / f"failing_{name}.h5") as result:
                assert result.summary["status"] == "failed"
                steps = result.summary["steps"]
                assert result.series["t"].size == steps, "no step that was good is lost"
                # the acceleration of an end is a difference in time, some steps to either side
                assert steps >= (5 if name == "edge" else 10)


def test_the_same_is_said_on_any_number_of_ranks(said, tmp_path_factory):
    where, texts = said
    kept = tmp_path_factory.getbasetemp() / "said.json"
    text = {
        name: text.replace(str(where), "")
        for name, (_, text) in texts.items()
        if name.startswith("driven")
    }
    if not kept.exists():
        kept.write_text(json.dumps(text))
    assert json.loads(kept.read_text()) == text
