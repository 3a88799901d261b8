"""Options from wherever they may come, whatever is written there: read as meant, or refused in one
message.
"""

from __future__ import annotations

import pytest

from fsipetsc.errors import InputError
from fsipetsc.options.sources import given_options

pytest.importorskip("petsc4py")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def texts(*words, environment=""):
    return {
        name: one.text for name, one in given_options(words, {"PETSC_OPTIONS": environment}).items()
    }


def test_the_command_line_comes_last_and_files_where_they_are_named(here):
    (here / "a.opts").write_text("! a comment\n-a 1 # more\n\n-b 'x y'\n-c\n")
    assert texts("-a", "-3", environment="-a 2 -d") == {"a": "-3", "d": ""}
    assert texts("-a", "2", "-options_file", "a.opts") == {"a": "1", "b": "x y", "c": ""}
    assert texts("-A", "1", "-help") == {"a": "1"}


def test_yaml(here):
    (here / "a.yaml").write_text(
        "fsi:\n  h: 0.1\n  output: {dt: 1e-3}\ntimes: [1, 2.50]\nquiet:\ntext: 'a: b'\n"
    )
    expected = {
        "fsi_h": "0.1",
        "fsi_output_dt": "1e-3",
        "times": "1,2.50",
        "quiet": "",
        "text": "a: b",
    }
    assert texts("-options_file", "a.yaml") == texts("-options_file_yaml", "a.yaml") == expected


FAULTY = {
    "itself.opts": ("-options_file itself.opts\n", "names itself"),
    "there.opts": ("-options_file back.opts\n", "names itself"),
    "back.opts": ("-options_file there.opts\n", "names itself"),
    "itself.yaml": ("options_file: itself.yaml\n", "names itself"),
    "quote.opts": ("-a 1\n-b 'x\n", "line 2"),
    "list.yaml": ("- 1\n", "'name: value' is expected"),
    "three.opts": ("-a 1\n-b 2 -c\n", "three.opts, line 2"),
    "deep.yaml": ("a: [[1]]\n", "list of numbers or words"),
    "key.yaml": ("1 2: 3\n", "name of an option"),
    "brace.yaml": ("a: {\n", "brace.yaml.*line 2"),
    "alias.opts": ("alias -a -b\n", "not 'alias -a -b'"),
}


@pytest.mark.parametrize("name", FAULTY)
def test_faulty_file(name, here):
    for file, (text, _) in FAULTY.items():
        (here / file).write_text(text)
    with pytest.raises(InputError, match=FAULTY[name][1]) as caught:
        texts("-options_file", name)
    assert "\n" not in str(caught.value)


def test_a_quotation_mark_that_stands_alone(here):
    assert texts("-fsi_output", "a 'b", "-fsi_order", "6") == {
        "fsi_output": "a 'b",
        "fsi_order": "6",
    }
    with pytest.raises(InputError, match="never closed in PETSC_OPTIONS"):
        texts(environment="-fsi_output 'a b -fsi_order 6")
