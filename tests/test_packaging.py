"""What wheel and sdist hold, and that what is said twice is the same: versions, dependencies."""

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
    packaged = re.search(r"^\[tool.setuptools.package-data\]\nfsipetsc = (\[.*\])$", PROJECT, re.M)[1]
    patterns = [f"fsipetsc/{pattern}" for pattern in re.findall(r'"([^"]+)"', packaged)]
    data = [name for name in known_files() if name.startswith("fsipetsc/") and not name.endswith(".py")]
    assert data and all(any(fnmatch.fnmatch(name, pattern) for pattern in patterns) for name in data)


def test_the_sdist_has_all_but_hidden_files():
    lines = [line.split() for line in (REPOSITORY / "MANIFEST.in").read_text().splitlines()]
    folders = {words[1] for words in lines if words[0] == "graft"} | {"fsipetsc"}
    included = {name for words in lines if words[0] == "include" for name in words[1:]} | ALWAYS
    left = [name for name in known_files() if name.split("/")[0] not in folders and name not in included]
    assert all(name.startswith(".") for name in left), left


def test_nothing_large_or_made_is_kept():
    """A build, an environment or a result that came in by accident shows by its size, or by its name."""
    names = known_files()
    made = re.compile(r"(^|/)(site-packages|__pycache__|build|dist|site)/|\.(so|h5|whl|nbi|nbc)$")
    assert not list(filter(made.search, names))
    assert sum((REPOSITORY / name).stat().st_size for name in names if (REPOSITORY / name).exists()) < 12e6


def test_versions_agree():
    version = re.search(r'^version = "(.*)"', PROJECT, re.M)[1]
    assert fsipetsc.__version__ == version
    assert re.search(r"^version: (.*)$", (REPOSITORY / "CITATION.cff").read_text(), re.M)[1] == version
    assert f"## {version}" in (REPOSITORY / "CHANGELOG.md").read_text()


def test_conda_asks_for_what_pip_does():
    """Of the extras solver and plot, and what tests need."""
    listed = set(re.findall(r"^  - ([\w-]+)", (REPOSITORY / "environment.yml").read_text(), re.M))
    extras = dict(re.findall(r"^(solver|plot) = \[(.*)\]$", PROJECT, re.M))
    wanted = {re.match(r"[\w-]+", name)[0] for text in extras.values() for name in re.findall(r'"([^"]+)"', text)}
    assert wanted <= listed and {"pytest", "pytest-xdist", "ruff", "mypy"} <= listed
