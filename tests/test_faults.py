"""Computations that go wrong, each field in each kind of layer, by what a case gives or by an error that its functions raise.

All on 1 and on 3 ranks, in one dimension and in two: one message, the same on all.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from helpers import REPOSITORY, mpirun
from said import parted

import fsipetsc

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

CASE = REPOSITORY / "tests" / "going_wrong.py"
RANKS = 1, 3
#: of a layer: unknown that is driven, its rate -> what is found
LOST, HOT = "T is not a finite number", "T = 6.66667e+303, too large to go on with,"
GAS = {("rho", -1e6): "rho = -", ("rho u", 1e308): LOST, ("e", -1e6): "T = -", ("e", 1e308): HOT}
BAR = {("u", 1e308): "", ("T", -1e6): "T = -", ("T", 1e308): "", ("x", -1e6): "J = -"}
PLANE_GAS = {**GAS, ("rho v", 1e308): LOST}
PLATE = {("u", 1e308): "", ("v", 1e308): "", ("T", -1e6): "T = -", ("T", 1e308): "", ("y", -1e6): "J = -"}


def _faults() -> dict[str, tuple[str, str]]:
    """name -> (options, words of the message): each layer first, in the middle and last, and a boundary that jumps."""
    found = {}
    for plane, kinds in ((0, (GAS, BAR)), (1, (PLANE_GAS, PLATE))):
        for layers in ("gsg", "sgs"):
            for k, kind in enumerate(layers):
                for number, ((field, rate), words) in enumerate(kinds[kind == "s"].items()):
                    if (k + number) % 2 and k:  # each field in the first layer, half of them in the others
                        continue
                    text = f"-mad_plane {plane} -mad_layers {layers} -mad_layer {k} -mad_rate {rate} -mad_field"
                    layer = f"'{'gas' if kind == 'g' else 'bar'} {k}'"
                    found[f"{plane}_{layers}_{k}_{number}"] = f"{text}|{field}", f"{words}|{layer if words else ''}"
    found["1_J"] = "-mad_plane 1 -mad_rate 2000 -mad_time 0.0101 -mad_field|place", "J |'gas 0'"
    found["0_J"] = "-mad_rate 2000 -mad_time 0.0101 -mad_field|place", "J |'gas 0'"
    return found


FAULTS = _faults()
#: functions that fail: on one rank, and on the last of three alone, where not all are asked for
FUNCTIONS = {
    f"{plane}_{name}_{rank}_{compiled}": f"-mad_plane {plane} -mad_function {name} -mad_rank {rank} -mad_compiled {compiled}"
    for plane, compiled in ((0, 0), (1, 0))
    for rank in (-1, 2)
    for name in ("initial", "exact", "forcing", "edge", "place", "T", "jumps")
}
#: others: status, line
MORE = {
    "traceback": (2, f"{CASE} -fsi_quiet -fsi_debug -mad_plane 1 -mad_function edge -fsi_output debug.h5"),
}
#: of FUNCTIONS, what the last of three ranks never calls
FOUND_ELSEWHERE = {f"{plane}_{name}_2_0" for plane in (0, 1) for name in ("forcing", "place", "T", "jumps")}


def lines(name: str) -> list[str]:
    if name in MORE:
        return MORE[name][1].split()
    words = [CASE, "-fsi_quiet", "-fsi_output", f"{name}.h5"]
    if name in FAULTS:
        text, field = FAULTS[name][0].split("|")
        return [*map(str, words), *text.split(), field]
    layers = "gs" if name.startswith("0_edge") else "gsg"
    layer = 1 if "forcing" in name else 0
    more = FUNCTIONS[name], f"-mad_layers {layers} -mad_layer {layer} -mad_time 0.0105 -ts_max_steps 20"
    return [*map(str, words), *" ".join(more).split()]


PROGRAM = """
import json, sys
from mpi4py import MPI
from many_runs_program import answer
said = {name: answer(words) for name, words in json.load(open("runs.json")).items()}
everybody = MPI.COMM_WORLD.gather(said)
if everybody:
    json.dump(everybody, open("said.json", "w"))
"""


@pytest.fixture(scope="module", params=RANKS)
def said(request, tmp_path_factory) -> tuple[int, Path, dict[str, str]]:
    """(ranks, folder, name -> what is said): all runs in one process for each rank, which are not to fail apart."""
    where = tmp_path_factory.mktemp(f"on{request.param}")
    faults, functions = list(FAULTS), [name for name in FUNCTIONS if ("_-1_" in name) == (request.param == 1)]
    names = [*(faults[::2] if request.param == 1 else faults[::6]), *functions, *MORE]  # fewer where each costs thrice as much
    runs = {name: lines(name) for name in names}
    runs["traceback"] += ["-mad_rank", str(request.param - 1)]
    (where / "runs.json").write_text(json.dumps(runs))
    path = {"PYTHONPATH": f"{REPOSITORY / 'tests'}:{REPOSITORY}"}
    done = mpirun(request.param, "-c", PROGRAM, cwd=where, env=path)
    assert (done.returncode, done.stderr, done.stdout) == (0, "", "")
    first, *others = json.loads((where / "said.json").read_text())
    for name, (status, text) in first.items():
        expected = MORE[name][0] if name in MORE else 3 if name in FAULTS else 0 if name in FOUND_ELSEWHERE else 2
        assert status == expected, (name, status, text)
        assert name == "traceback" or parted(text)[1].count("\n") == (status != 0), (name, text)
        assert all(other[name] == [status, ""] for other in others), name
    return request.param, where, {name: text for name, (_, text) in first.items()}


def test_what_went_wrong_is_named_and_what_helps(said):
    """Field, layer, place, time, step; what usually helps; a result that opens."""
    _, where, texts = said
    for name in texts.keys() & FAULTS.keys():
        words = FAULTS[name][1]
        what, layer = words.split("|")
        place = f" in layer {layer}", " at x = ", ", t = 0.01", ", step 1"
        for word in (f"fsipetsc: error: {what}", *place, "what usually helps: "):
            assert word in texts[name], (name, word, texts[name])
        with fsipetsc.open_run(where / f"{name}.h5") as result:
            summary = result.summary
        assert summary["status"] == "failed" and summary["steps"] >= 10


def test_the_same_is_said_on_any_number_of_ranks(said, tmp_path_factory):
    """As said of one rank; where several layers are lost at once, each rank tells of its own, and the first one counts."""
    ranks, where, texts = said
    kept = tmp_path_factory.getbasetemp() / "said.json"
    text = {name: texts[name].replace(str(where), "") for name in texts.keys() & FAULTS.keys()}
    if ranks == RANKS[0]:
        kept.write_text(json.dumps(text))
        return
    one = json.loads(kept.read_text())
    assert {name: one[name] for name in text} == text and len(text) > 5


def test_an_error_of_a_function_ends_all_with_its_place(said):
    _, where, texts = said
    for name in texts.keys() & FUNCTIONS.keys() - FOUND_ELSEWHERE:
        for word in ("going_wrong.py, line ", "ValueError: nothing is known"):
            assert word in parted(texts[name])[1], (name, texts[name])
        traceback = parted(texts[name])[0]
        assert re.match(r'  File "[^"]*/going_wrong.py", line \d+, in called\n', traceback), (name, traceback)
        assert traceback.count("nothing is known\n") == traceback.count("in refuse\n") == 1, traceback
        if "initial" not in name:
            early = "place" in name or name.startswith("0_edge")  # rates of motion take it at later times
            with fsipetsc.open_run(where / f"{name}.h5") as result:
                assert result.summary["status"] == "failed" and result.summary["steps"] >= (0 if early else 10)


def test_the_traceback_is_that_of_the_rank_that_failed_once(said):
    text = said[2]["traceback"]
    assert text.count("\nValueError: nothing is known\n") == 1 and text.count("in refuse\n") == 1, text
    assert text.count("fsipetsc: error: ") == 1
