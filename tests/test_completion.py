"""What the Tab key completes, as bash does it, and where the commands stand beside the program."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import subprocess

import pytest
from helpers import PATIENCE, REPOSITORY

from fsipetsc import cli
from fsipetsc.cases import BUILT_IN


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with the script and some files."""
    folder = tmp_path_factory.mktemp("completion")
    for name in ("a.h5", "own.py", "other.txt"):
        (folder / name).touch()
    for shell in ("bash", "zsh"):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            assert cli.main(["completion", shell]) == 0
        (folder / shell).write_text(said.getvalue())
    return folder


def complete(folder, *words: str) -> set[str]:
    """What bash offers for the last word."""
    text = """set -u; . ./bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _fsipetsc; printf '%s\\n' "${COMPREPLY[@]-}" """
    done = subprocess.run(["bash", "-c", text, "bash", *words], cwd=folder, capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return set(done.stdout.split())


def test_bash(written):
    first = complete(written, "fsipetsc", "")
    assert first == {*BUILT_IN, *cli.COMMANDS, "own.py"}
    assert complete(written, "fsipetsc", "pu") == {"pulse"}
    assert complete(written, "fsipetsc", "rod", "-rod_g") == {"-rod_gravity"}
    assert complete(written, "fsipetsc", "box", "-rod_g") == set()
    assert complete(written, "fsipetsc", "own.py", "-fsi_ord") == {"-fsi_order"}
    assert complete(written, "fsipetsc", "rod", "-fsi_order", "") == {"2", "4", "6", "8"}
    assert complete(written, "fsipetsc", "rod", "-fsi_h", "") == set()
    assert complete(written, "fsipetsc", "convergence", "mms", "-fsi_or") == {"-fsi_order", "-fsi_orders"}
    assert complete(written, "fsipetsc", "info", "") == {"-help", "a.h5"}
    assert complete(written, "fsipetsc", "plot", "-") == {"-help", "-o", "-fields", "-times", "-compare", "-all", "-animate"}
    assert complete(written, "fsipetsc", "plot", "a.h5", "-fields", "") == set()
    assert complete(written, "fsipetsc", "plot", "a.h5", "-a") == {"-all", "-animate"}
    assert "-blocks" in complete(written, "fsipetsc", "new", "-")


def test_zsh(written):
    if shutil.which("zsh"):
        assert subprocess.run(["zsh", "-n", written / "zsh"]).returncode == 0
    assert "bashcompinit" in (written / "zsh").read_text()


def test_other_shells(capsys):
    assert cli.main(["completion", "tcsh"]) == 2 and "bash or zsh" in capsys.readouterr().err
    assert cli.main(["completion"]) == 2


def test_one_rank_runs_the_commands():
    """scripts/run knows them by name."""
    listed = re.search(r"^'' \| -\* \| (.*)\)$", (REPOSITORY / "scripts" / "run").read_text(), re.M)[1]
    assert set(listed.split(" | ")) == set(cli.COMMANDS)
