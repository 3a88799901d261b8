"""What wheel and sdist hold, versions, scripts; the whole way: scripts/bare-machine."""

import fnmatch
import re
import subprocess

import pytest
from helpers import REPOSITORY

import fsipetsc

PROJECT = (REPOSITORY / "pyproject.toml").read_text()


def test_wheel_and_sdist_have_what_they_should():
    """The wheel what the package reads, the sdist all that git knows but hidden files."""
    done = subprocess.run(["git", "ls-files"], cwd=REPOSITORY, capture_output=True, text=True)
    if done.returncode or not done.stdout:
        pytest.skip("no checkout")
    names = done.stdout.splitlines()
    package_data = r"^\[tool.setuptools.package-data\]\nfsipetsc = (\[.*\])$"
    patterns = re.findall(r'"([^"]+)"', re.search(package_data, PROJECT, re.M)[1])
    data = [name[9:] for name in names if re.match(r"fsipetsc/.*(?<!\.py)$", name)]
    assert data and all(any(fnmatch.fnmatch(name, p) for p in patterns) for name in data)
    lines = [line.split() for line in (REPOSITORY / "MANIFEST.in").read_text().splitlines()]
    folders = {words[1] for words in lines if words[0] == "graft"} | {"fsipetsc"}
    files = {name for words in lines if words[0] == "include" for name in words[1:]}
    files |= {"pyproject.toml", "README.md", "LICENSE", "MANIFEST.in"}  # every sdist has them
    left = [name for name in names if name.split("/")[0] not in folders and name not in files]
    assert all(name.startswith(".") for name in left), left


def test_versions_agree():
    version = re.search(r'^version = "(.*)"', PROJECT, re.M)[1]
    assert fsipetsc.__version__ == version
    citation = (REPOSITORY / "CITATION.cff").read_text()
    assert re.search(r"^version: (.*)$", citation, re.M)[1] == version
    date = re.search(r"^date-released: (.*)$", citation, re.M)[1]
    assert f"## {version} – {date}\n" in (REPOSITORY / "CHANGELOG.md").read_text()


def test_syntax():
    for path in (path for path in REPOSITORY.glob("scripts/**/*") if path.is_file()):
        if path.read_text().startswith("#!/usr/bin/env python3"):
            compile(path.read_text(), path, "exec")
        else:
            assert subprocess.run(["bash", "-n", path]).returncode == 0, path
