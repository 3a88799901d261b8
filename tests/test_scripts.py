"""The scripts' words to who runs them on a machine that lacks something; the whole way is tried by
scripts/bare-machine.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from helpers import PATIENCE, REPOSITORY


def script(
    name: str, *arguments: str, root: Path = REPOSITORY, **env: str
) -> subprocess.CompletedProcess[str]:
    """A script of ours with nothing of the environment but PATH and what is given."""
    return subprocess.run(
        ["bash", str(root / "scripts" / name), *arguments],
        env={"PATH": os.environ["PATH"], **env},
        text=True,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=PATIENCE,
    )


def stand_in(folder: Path, name: str, commands: str) -> Path:
    """A program of that name in folder."""
    folder.mkdir(exist_ok=True)
    path = folder / name
    path.write_text(f"#!/bin/sh\n{commands}\n")
    path.chmod(0o755)
    return path


@pytest.mark.parametrize("path", sorted(REPOSITORY.glob("scripts/*")), ids=lambda path: path.name)
def test_syntax(path):
    text = path.read_text()
    if text.startswith("#!/usr/bin/env python3"):
        compile(text, path, "exec")
        return
    assert subprocess.run(["bash", "-n", path]).returncode == 0


def test_a_user_who_may_not_install_is_told_whom_to_ask(tmp_path):
    root, bin = tmp_path / "a checkout", tmp_path / "bin"
    shutil.copytree(REPOSITORY / "scripts", root / "scripts")
    shutil.copy(REPOSITORY / "pyproject.toml", root)
    stand_in(bin, "id", "echo 1000")
    for name in ("sudo", "python3", "dpkg-query"):
        stand_in(bin, name, "exit 1")
    stand_in(bin, "apt-get", f"touch '{tmp_path}/installed'")
    done = script("setup", root=root, PATH=f"{bin}:/usr/bin:/bin")
    assert (done.returncode, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 2
    for word in ("administrator", "apt-get install ", "python3-petsc4py-real", "openmpi-bin"):
        assert word in done.stderr
    assert "sudo" not in done.stderr
    assert not (tmp_path / "installed").exists() and not (root / ".venv").exists()
