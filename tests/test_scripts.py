"""The scripts, and what setup says on a machine that lacks something; the whole way is tried by
scripts/bare-machine.
"""

import shutil
import subprocess

from helpers import PATIENCE, REPOSITORY


def test_syntax():
    for path in REPOSITORY.glob("scripts/*"):
        if path.read_text().startswith("#!/usr/bin/env python3"):
            compile(path.read_text(), path, "exec")
        else:
            assert subprocess.run(["bash", "-n", path]).returncode == 0, path


def test_a_user_who_may_not_install_is_told_whom_to_ask(tmp_path):
    root, bin = tmp_path / "a checkout", tmp_path / "bin"
    shutil.copytree(REPOSITORY / "scripts", root / "scripts")
    shutil.copy(REPOSITORY / "pyproject.toml", root)
    bin.mkdir()
    stand_ins = {"id": "echo 1000", "apt-get": f"touch '{tmp_path}/installed'"}
    for name in ("id", "apt-get", "sudo", "python3", "dpkg-query"):
        (bin / name).write_text(f"#!/bin/sh\n{stand_ins.get(name, 'exit 1')}\n")
        (bin / name).chmod(0o755)
    done = subprocess.run(
        ["bash", root / "scripts" / "setup"],
        env={"PATH": f"{bin}:/usr/bin:/bin"},
        text=True,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=PATIENCE,
    )
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 2)
    for word in ("administrator", "apt-get install ", "python3-petsc4py-real", "openmpi-bin"):
        assert word in done.stderr
    assert "sudo" not in done.stderr
    assert not (tmp_path / "installed").exists() and not (root / ".venv").exists()
