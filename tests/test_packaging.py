"""What wheel and sdist hold; what is said twice is the same: versions, dependencies, Python."""

from __future__ import annotations

import fnmatch
import re
import subprocess

import pytest
from helpers import REPOSITORY

import fsipetsc

PROJECT = (REPOSITORY / "pyproject.toml").read_text()
#: what every sdist has
ALWAYS = {"pyproject.toml", "README.md", "LICENSE", "MANIFEST.in"}


def known_files() -> list[str]:
    """What git knows."""
    done = subprocess.run(["git", "ls-files"], cwd=REPOSITORY, capture_output=True, text=True)
    if done.returncode or not done.stdout:
        pytest.skip("no checkout")
    return done.stdout.splitlines()


def test_the_wheel_has_what_the_package_reads():
    package_data = r"^\[tool.setuptools.package-data\]\nfsipetsc = (\[.*\])$"
    patterns = re.findall(r'"([^"]+)"', re.search(package_data, PROJECT, re.M)[1])
    data = [name[9:] for name in known_files() if re.match(r"fsipetsc/.*(?<!\.py)$", name)]
    assert data and all(any(fnmatch.fnmatch(name, p) for p in patterns) for name in data)


def test_the_sdist_has_all_but_hidden_files():
    lines = [line.split() for line in (REPOSITORY / "MANIFEST.in").read_text().splitlines()]
    folders = {words[1] for words in lines if words[0] == "graft"} | {"fsipetsc"}
    files = {name for words in lines if words[0] == "include" for name in words[1:]} | ALWAYS
    left = [n for n in known_files() if n.split("/")[0] not in folders and n not in files]
    assert all(name.startswith(".") for name in left), left


def test_nothing_large_or_made_is_kept():
    names = known_files()
    made = r"(^|/)(site-packages|__pycache__|build|dist|site)/|\.(so|h5|whl|nbi|nbc)$"
    assert not [name for name in names if re.search(made, name)]
    paths = [REPOSITORY / name for name in names]
    assert sum(path.stat().st_size for path in paths if path.exists()) < 12e6


def test_versions_agree():
    version = re.search(r'^version = "(.*)"', PROJECT, re.M)[1]
    assert fsipetsc.__version__ == version
    citation = (REPOSITORY / "CITATION.cff").read_text()
    assert re.search(r"^version: (.*)$", citation, re.M)[1] == version
    assert f"## {version}" in (REPOSITORY / "CHANGELOG.md").read_text()
