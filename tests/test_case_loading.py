"""Case files that are loaded, or cannot be: the message names the file, the line and what was
expected.
"""

from __future__ import annotations

import sys

import pytest
from stub_case import CASE

from fsipetsc.cases import BUILT_IN, load_case
from fsipetsc.errors import InputError

FAULTY_FILES = {
    "syntax": ("x = 1\nx = = 2\n", ["line 2", "invalid syntax"]),
    "import": ("import math\nimport no_such_module\n", ["line 2", "no_such_module"]),
    "ours": (
        "from fsipetsc.materials.nothing import x\n",
        ["line 1", "No module named 'fsipetsc.materials.nothing'"],
    ),
    "name": ("\n\nundefined\n", ["line 3", "NameError", "undefined"]),
    "no options": (CASE.replace("OPTIONS =", "OPTION ="), ["does not define", "OPTIONS"]),
    "own names": (CASE.replace("solid_force", "fsi_h"), ["exists already"]),
    "beside": ("import beside_a_faulty_case\n", ["beside_a_faulty_case.py, line 3: case file "]),
    "no name": ("OPTIONS = ()\ndef build(opt): ...\nNAME = ''\n", ["line 3", "NAME", "a text"]),
}


@pytest.mark.parametrize("name", FAULTY_FILES)
def test_faulty_case_file(name, here):
    text, words = FAULTY_FILES[name]
    (here / "faulty.py").write_text(text)
    (here / "beside_a_faulty_case.py").write_text("def f():\n    x = 1\n    undefined\n\nf()\n")
    with pytest.raises(InputError) as caught:
        load_case("faulty.py")
    for word in ["case file faulty.py", *words]:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (here / "__pycache__").exists()


def test_case_file_finds_its_neighbours_from_any_directory(here, monkeypatch):
    (here / "neighbour_of_stub.py").write_text("NUMBER = 5\n")
    (here / "stub.py").write_text(CASE + "\nfrom neighbour_of_stub import NUMBER\n")
    monkeypatch.chdir(here.parent)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert load_case(str(here / "stub.py")).NUMBER == 5


def test_unknown_name_lists_the_cases():
    with pytest.raises(InputError, match=", ".join(BUILT_IN)):
        load_case("xyzzy")
