"""Compiled kernels are kept between runs, and never survive a change of the sources that they were compiled from."""

from __future__ import annotations

import ast
import importlib
import os
import shutil
import time
from pathlib import Path
from types import SimpleNamespace

import conftest
import pytest
from helpers import REPOSITORY, run

numba = pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from fsipetsc.operators import cache

PROGRAM = """
import sys, time
sys.path.insert(0, sys.argv[1])
import numpy as np
from fsipetsc.operators import packed
from fsipetsc.operators.kernels import derivative
rows = np.ones(100)
derivative(packed(2), rows, 10, 0, 60, 0, 0, 20, 0, 19, 1.0)
print(rows[65], sum(derivative.stats.cache_hits.values()))
"""
#: kernels are not found where it is asked whether to say it, and are found when they are loaded, or made
COLD = """
import sys
from contextlib import contextmanager
from pathlib import Path
from fsipetsc.operators import cache

there, compiling = cache.cache_folder, cache.compiling

@contextmanager
def cold(function, announce):
    cache.cache_folder = lambda: Path("no such folder")
    with compiling(function, announce):
        cache.cache_folder = there
        yield

cache.compiling = cold
from fsipetsc.cli import main
sys.exit(main())
"""

#: the cache is lost while a kernel is being compiled, and cut off while it is loaded
LOSS = """
import shutil, sys
import numba
from numba.core.caching import IndexDataCacheFile
from fsipetsc.operators import cache

cache.use_cache_folder()
save = IndexDataCacheFile.save
def lose(self, key, data):
    shutil.rmtree(cache.cache_folder())  # another process tidied up, between the look at the folder and the writing
    save(self, key, data)
IndexDataCacheFile.save = lose

@numba.njit(cache=True)
def twice(x):
    return 2 * x

print(twice(21), cache.cache_folder().exists())
IndexDataCacheFile.save = save
print(twice(21.0), len(list(cache.cache_folder().rglob("*.nb?"))))
for path in cache.cache_folder().rglob("*.nbi"):
    path.write_bytes(path.read_bytes()[:-7])

@numba.njit(cache=True)
def twice(x):
    return 2 * x

print(twice(4))
"""


def compiled_functions():
    """Every compiled function of the package that is cached."""
    for folder in cache.COMPILED:
        for path in (REPOSITORY / "fsipetsc" / folder).glob("*.py"):
            module = importlib.import_module(f"fsipetsc.{folder}.{path.stem}")
            for value in vars(module).values():
                if hasattr(value, "py_func") and value.__module__ == module.__name__ and value.stats.cache_path:
                    yield value


def test_all_kernels_are_kept_in_the_folder_of_this_state_of_the_sources():
    functions = list(compiled_functions())
    assert {"run_task", "derivative"} <= {function.__name__ for function in functions}
    for function in functions:
        assert Path(function.stats.cache_path).is_relative_to(numba.config.CACHE_DIR), function


def test_every_file_with_kernels_counts():
    """A folder that is not listed could change without a new compilation.

    Except analysis, bench and cases: no kernel calls what is compiled there, and a change in its own file numba notices.
    """
    with_kernels = {
        path.relative_to(REPOSITORY / "fsipetsc").parts[0]
        for path in (REPOSITORY / "fsipetsc").rglob("*.py")
        if "@njit" in path.read_text()
    }
    assert with_kernels <= {*cache.COMPILED, "analysis", "bench", "cases"}


def test_a_change_in_a_source_file_is_noticed(tmp_path):
    shutil.copytree(REPOSITORY / "fsipetsc", tmp_path / "fsipetsc", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "program.py").write_text(PROGRAM)
    env = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "PYTHONPATH": str(tmp_path)}

    def answer():
        done = run(tmp_path / "program.py", tmp_path, env=env, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    assert answer() == ["0.0", "0"]
    assert answer() == ["0.0", "1"], "the second time it is not compiled"
    source = tmp_path / "fsipetsc" / "operators" / "kernels.py"
    text = source.read_text()
    head, tail = text.split("def interior_stencil", 1)  # which the compiled function calls
    source.write_text(head + "def interior_stencil" + tail.replace("    return d\n", "    return d + 1.0\n", 1))
    assert answer() == ["1.0", "0"]
    # in a file that the compiled function's own file imports
    other = tmp_path / "fsipetsc" / "operators" / "sbp.py"
    os.utime(other, ns=(1, 1))
    assert answer() == ["1.0", "0"]


def test_what_tests_have_compiled_is_of_one_python_numba_and_processor(monkeypatch):
    files = {conftest.done_file(k) for k in (0, 1)}
    assert {conftest.done_file(0)} < files and len({path.parent for path in files}) == 1
    for name, value in {
        "sys.version": "3.0",
        "numba.__version__": "0.0",
        "llvmlite.binding.get_host_cpu_name": lambda: "another",
        "numba.config.CPU_NAME": "generic",
        "numba.config.CPU_FEATURES": "+sse2",
    }.items():
        with monkeypatch.context() as patch:
            patch.setattr(name, value)
            files.add(conftest.done_file(0))
    assert len(files) == 7


def test_many_tests_have_processors_of_their_own_and_few_have_all(monkeypatch):
    """A session of one file has one process that is busy."""
    bound = []
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 3}, raising=False)
    monkeypatch.setattr(os, "sched_setaffinity", lambda _, processors: bound.append(processors), raising=False)
    one_of_two = SimpleNamespace(workerinput={"workerid": "gw1", "workercount": 2})
    for config, tests in ((one_of_two, 10), (SimpleNamespace(), 5000), (one_of_two, 5000)):
        conftest.pytest_collection_finish(SimpleNamespace(config=config, items=[None] * tests))
    assert bound == [{1, 3}]


def test_a_cache_that_is_lost_ends_no_run(tmp_path):
    (tmp_path / "program.py").write_text(LOSS)
    done = run(tmp_path / "program.py", env={"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["42", "False", "42.0", "2", "8"]


def test_nowhere_to_write(tmp_path):
    """Not even a temporary folder: the kernels are compiled, and not kept."""
    (tmp_path / "file").touch()
    closed = f"{tmp_path}/file/none"
    (tmp_path / "program.py").write_text(f"import tempfile\ntempfile.tempdir = '{closed}'\n{PROGRAM}")
    env = {"NUMBA_CACHE_DIR": closed, "HOME": closed, "XDG_CACHE_HOME": closed}
    done = run(tmp_path / "program.py", REPOSITORY, env=env, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["0.0", "0"]


def test_folders_in_use_are_kept(monkeypatch, tmp_path):
    """Those of other checkouts and runs, however many; of what has not been used for a day, the last ones."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    now, ages = time.time(), {f"kernels-{i}": 3600 * i for i in range(1, 31)}  # hours
    for name, age in ages.items():
        (tmp_path / "kernels" / name).mkdir(parents=True)
        os.utime(tmp_path / "kernels" / name, (now - age, now - age))
    own = cache.use_cache_folder()
    kept = {path.name for path in (tmp_path / "kernels").iterdir()}
    assert kept == {own.name, *(name for name, age in ages.items() if age < 86400)}
    os.utime(own, (0, 0))
    assert cache.use_cache_folder() == own and own.stat().st_mtime >= now - 1, "its use is noted"
    shutil.rmtree(tmp_path / "kernels")
    for i in range(6):
        (tmp_path / "kernels" / f"kernels-{i}").mkdir(parents=True)
        os.utime(tmp_path / "kernels" / f"kernels-{i}", (1e9 + i, 1e9 + i))
    assert cache.use_cache_folder() == own
    kept = {path.name for path in (tmp_path / "kernels").iterdir()}
    assert kept == {own.name, *(f"kernels-{i}" for i in (3, 4, 5))}


def in_base(monkeypatch, tmp_path, wanted):
    """The folder that is taken when NUMBA_CACHE_DIR is `wanted`; the user's own cache is tmp_path/home/.cache."""
    (tmp_path / "home").mkdir(exist_ok=True)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(wanted))
    monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)
    return cache.use_cache_folder()


@pytest.mark.parametrize(("mode", "taken"), [(0o700, True), (0o755, True), (0o777, False), (0o1777, False), (0o757, False)])
def test_a_folder_open_to_others_is_passed_over(monkeypatch, tmp_path, mode, taken):
    """Kernels are pickles: whoever can write there could run code here."""
    open_to_all = tmp_path / "open"
    open_to_all.mkdir()
    open_to_all.chmod(mode)
    folder = in_base(monkeypatch, tmp_path, open_to_all)
    assert folder.is_relative_to(open_to_all) == taken
    assert folder.is_relative_to(tmp_path / "home" / ".cache" / "fsipetsc") != taken
    assert folder.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(("mode", "taken"), [(0o755, True), (0o777, False), (0o1777, True)])
def test_a_folder_above_counts_unless_sticky(monkeypatch, tmp_path, mode, taken):
    above = tmp_path / "above"
    (above / "mine").mkdir(parents=True, mode=0o700)
    above.chmod(mode)
    assert in_base(monkeypatch, tmp_path, above / "mine").is_relative_to(above) == taken


@pytest.mark.skipif(os.getuid() != 0, reason="only root can make files of others")
def test_what_belongs_to_another_user_is_not_loaded(monkeypatch, tmp_path):
    theirs = tmp_path / "theirs"
    theirs.mkdir(mode=0o755)
    os.chown(theirs, 12345, 12345)
    assert not in_base(monkeypatch, tmp_path, theirs).is_relative_to(theirs)
    mine = tmp_path / "mine"
    folder = in_base(monkeypatch, tmp_path, mine)
    planted = folder / "scheme" / "planted.nbc"
    planted.parent.mkdir()
    planted.write_bytes(b"a pickle")
    os.chown(planted, 12345, 12345)
    assert in_base(monkeypatch, tmp_path, mine) == folder and not planted.exists()


def test_files_that_others_could_change_are_not_loaded(monkeypatch, tmp_path):
    folder = in_base(monkeypatch, tmp_path, tmp_path / "mine")
    kept, open_to_all = folder / "kept.nbc", folder / "open.nbc"
    for path in (kept, open_to_all):
        path.write_bytes(b"a pickle")
    open_to_all.chmod(0o666)
    assert in_base(monkeypatch, tmp_path, tmp_path / "mine") == folder and kept.exists(), "the folder itself is closed"
    folder.chmod(0o755)
    assert in_base(monkeypatch, tmp_path, tmp_path / "mine") == folder and not kept.exists()


def test_nowhere_to_keep_kernels(monkeypatch, tmp_path):
    """Every usual place is open to others: a new one is made, for this process."""
    places = [tmp_path / name for name in ("wanted", "home/.cache/fsipetsc", f"tmp/fsipetsc-{os.getuid()}")]
    for place in places:
        place.mkdir(parents=True)
        place.chmod(0o777)
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path / "tmp"))
    folder = in_base(monkeypatch, tmp_path, places[0])
    assert folder.parent.parent == tmp_path / "tmp" and folder.parent not in places
    assert folder.parent.stat().st_mode & 0o777 == 0o700


def test_no_home(monkeypatch, tmp_path):
    """A user without an entry in the list of users, and no HOME: nothing is made where the program happens to run."""
    monkeypatch.setattr(cache.os.path, "expanduser", lambda name: name)
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path / "tmp"))
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert cache._base() == tmp_path / "tmp" / f"fsipetsc-{os.getuid()}"
    assert not list((tmp_path / "here").iterdir())


def test_who_waits_for_the_compiler_is_told_so(monkeypatch, tmp_path):
    """Once, and once more if it takes long; not where the kernels are on disk."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    said: list[str] = []
    for seconds in (60.0, 0.01):
        monkeypatch.setattr(cache, "_LONG", seconds)
        with cache.compiling(compiled_functions, said.append):
            time.sleep(0.2)
    assert [text.split()[0] for text in said] == ["compiling", "compiling", "still"]
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "some.compiled_functions-27.py311.nbi").touch()
    with cache.compiling(compiled_functions, said.append):
        time.sleep(0.1)
    assert len(said) == 3


@pytest.mark.parametrize(
    "line",
    [
        "rod -fsi_h 0.1 -ts_max_steps 2",
        "convergence mms -fsi_hs 0.05 -fsi_orders 2",
        "bench -bench_points 480 -bench_orders 4 -bench_repeats 1 -bench_seconds 0.001 -bench_more no -bench_dimensions 1",
    ],
)
def test_every_command_that_compiles_says_so_first(line, tmp_path):
    """The kernels are on disk here, but are not found when it is asked whether to say it."""
    (tmp_path / "cold.py").write_text(COLD)
    done = run("cold.py", *line.split(), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    words = done.stdout.split("compiling the kernels, once after installation")
    assert len(words) == 2
    assert "0.05 " not in words[0], "before the first row"


def test_no_kernel_has_constants_of_mpi_in_it():
    """They differ from library to library, and the kernels on disk are the same for all: so they are passed as data."""
    for path in (REPOSITORY / "fsipetsc" / "parallel").glob("*.py"):
        tree = ast.parse(path.read_text())
        of_mpi = {"MPI"}  # and what a module makes of it
        for node in tree.body:
            if isinstance(node, ast.Assign) and names(node.value) & of_mpi:
                of_mpi |= {name for target in node.targets for name in names(target)}
        kernels = [node for node in tree.body if isinstance(node, ast.FunctionDef) and "njit" in decorators(node)]
        for kernel in kernels:
            assert not names(kernel) & of_mpi, (path.name, kernel.name)


def names(tree: ast.AST) -> set[str]:
    """All names in a piece of source."""
    return {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


def decorators(function: ast.FunctionDef) -> set[str]:
    """Names in the decorators of a function."""
    return {name for decorator in function.decorator_list for name in names(decorator)}
