"""Formulas as machine code: what is recorded, printed, compiled, and what is refused by name."""

import ctypes
import math
import re
import signal
import stat
import subprocess
import sys
import time
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest
from helpers import PATIENCE, REPOSITORY, environment, message, mpirun, recorded, solve, well

from fsipetsc.errors import InputError
from fsipetsc.kernels import build
from fsipetsc.kernels.kernel import PLANES, Kernel
from fsipetsc.kernels.loops import each, number, otherwise, pick, stop, variable, when, whole
from fsipetsc.kernels.procedure import unit
from fsipetsc.kernels.symbols import MADE, Record, derivatives, exact, replay


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A folder of libraries of its own."""
    monkeypatch.delenv("CFLAGS", raising=False)
    monkeypatch.setenv("FSIPETSC_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(build, "_loaded", {})
    known = build.folder, build._processor
    for one in known:
        one.cache_clear()
    yield tmp_path / "cache"
    monkeypatch.undo()
    for one in known:
        one.cache_clear()


def every_operation(a, b, c):
    first = np.where((a > b) & ~(c < 0.3), a * b + c, a / b - c) ** 3
    second = np.sqrt(abs(a - b)) + np.maximum(a, b * c) - np.minimum(2.0, c) ** 0.5
    return -first + second * np.log(a) + np.sign(c - b) * 2.0**-3 + 1.0 / (a + b) ** 2


def in_C(formula, x):
    """The formula of the numbers x[0], x[1] … as a procedure."""

    def compute(x, out):
        for i in each(out.shape[0], vector=True):
            out[i] = formula(*(x[k, i] for k in range(count)))

    count, out = len(x), np.empty(x.shape[1])
    recorded(compute, x, out)()
    return out


def test_a_recorded_formula_computes_what_it_does_in_python():
    x = np.random.default_rng(1).uniform(0.1, 2.0, (3, 1003))
    np.testing.assert_allclose(in_C(every_operation, x), every_operation(*x), 1e-14, 1e-14)


def test_functions_that_are_made_of_others():
    x = np.random.default_rng(1).uniform(0.5, 1.0, (1, 1003))
    assert MADE[np.cbrt](-8.0) == pytest.approx(-2.0, rel=1e-15)
    for function, formula in MADE.items():
        np.testing.assert_allclose(formula(*x), function(*x), rtol=1e-13)
        np.testing.assert_allclose(in_C(function, x), function(*x), rtol=1e-13)


def test_equal_operations_are_done_once_and_products_are_fused():
    kernel = Kernel("some", "Some.")
    a, b, c = kernel.read("x", PLANES, 3)
    kernel.store("out", PLANES, [a * b + c, b * a - c, (a + b) * (b + a), c - a * c])
    text = kernel.text
    assert text.count(" * t") == 2, "a b, which two sums take, and the square"
    assert text.count("fma(") == 1
    assert Record().apply("*", 1e300, 1e300).value == np.inf  # without a warning


def test_derivatives_are_those_of_the_formula():
    at, record = (1.3, 0.7, 0.9), Record()
    x = [record.given(f"x{k}") for k in range(3)]
    for k in range(3):
        (found,) = derivatives([every_operation(*x)], x[k])
        h = 1e-6 * (np.arange(3) == k)
        slope = (every_operation(*(at + h)) - every_operation(*(at - h))) / 2e-6
        (value,) = replay([found])(dict(zip(x, at)))
        assert value == pytest.approx(slope, rel=1e-8), k


REFUSED = {
    "branches on a value": lambda a: a if a > 0.0 else 0.0,
    "the functions of math take no symbols": lambda a: math.sqrt(a),
    "np.sinc cannot be recorded": lambda a: np.sinc(a),
    "np.sum cannot be recorded": lambda a: np.sum(a),
    "divides by a constant 0": lambda a: a / 0.0,
    "is no number": lambda a: abs(np.complex64(3 + 4j) * a),
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_recorded_is_refused_with_its_line(words):
    formula = REFUSED[words]
    with pytest.raises(InputError) as error:
        formula(Record().given("x"))
    said, code = str(error.value), formula.__code__
    assert words in said
    assert f"{code.co_name}, {code.co_filename}:{code.co_firstlineno}: " in said


def simple():
    text = unit("double twice(double x) { return 2.0 * x; }")
    return {build.name_of(text): text}


def twice(library):
    library.twice.argtypes, library.twice.restype = [ctypes.c_double], ctypes.c_double
    return library.twice(21.0)


def test_a_library_is_kept_and_a_damaged_one_is_not_taken(cache):
    ((name, content),) = build.made(simple()).items()
    flipped = bytearray(content)
    flipped[len(content) // 2] ^= 1
    for damaged in (b"no library", content[:-1], content[: len(content) // 2], bytes(flipped)):
        build.keep({name: damaged})
        assert build.found(name) is None
    build.keep({name: content})
    assert stat.S_IMODE(cache.stat().st_mode) == 0o700
    assert twice(build.found(name)) == 42.0


def test_flags_that_change_bits_are_refused(cache, monkeypatch):
    monkeypatch.setattr(build, "Path", lambda p: Path(p.replace("cpuinfo", "none")))  # as elsewhere
    for flag in ("-ffast-math", "-Ofast", "-ffp-contract=fast"):
        monkeypatch.setenv("CFLAGS", f"-O1 {flag}")
        with pytest.raises(InputError, match=f"CFLAGS has {flag}: "):
            build.made(simple())
    monkeypatch.setenv("CFLAGS", "-O1 -ffinite-loops -fno-signed-char -funsafe-loop-optimizations")
    assert build.made(simple())
    for name in ("CFLAGS", "CC"):
        monkeypatch.setenv(name, "'open")
        with pytest.raises(InputError, match=f'{name} is "\'open": no closing quotation'):
            build.made(simple())


def test_a_missing_compiler_is_told_and_not_needed_for_what_is_kept(cache, monkeypatch):
    build.keep(build.made(simple()))
    monkeypatch.setenv("PATH", str(cache))
    monkeypatch.setattr(build, "find_spec", lambda module: None)
    assert twice(build.found(*simple())) == 42.0
    assert build.made({}) == {}
    with pytest.raises(InputError, match="no C compiler was found"):
        build.made(simple())
    monkeypatch.setenv("CC", "no-such-compiler -x")
    with pytest.raises(InputError, match="CC is 'no-such-compiler -x': no such program"):
        build.made(simple())


PROGRAM = """
import ctypes, os, sys
sys.path[:0] = [{tests!r}, {root!r}]
from fsipetsc.process.launch import start_mpi
comm = start_mpi()
from test_kernels import simple
from fsipetsc.errors import FsiError
from fsipetsc.kernels import build
from fsipetsc.kernels.procedure import unit
from fsipetsc.process.together import libraries
for kind in ("apart", "failing", "open"):
    os.environ["FSIPETSC_CACHE"] = f"{{kind}}{{comm.rank}}"
    os.environ["CFLAGS"] = f"-DRANK={{comm.rank}}.0"  # as if each had a processor of its own
    build.folder.cache_clear()
    build._loaded.clear()
    if comm.rank == 1:
        build.keep(build.made(simple()))
    comm.Barrier()
    texts = [*simple().values(), unit("double own(void) {{ return RANK; }}")]
    said = []
    if kind == "failing" and comm.rank == 0:
        texts[1] = "no C"
    try:
        found = libraries(comm, texts, said.append)
    except FsiError as error:
        told = error.status, str(error).split()[0]
    else:
        found[1].own.restype = ctypes.c_double
        told = found[1].own() == comm.rank, len(found), len(said)
    with open(f"told{{comm.rank}}", "a") as file:
        print(*told, file=file)
"""


def test_ranks_agree_on_who_compiles(tmp_path):
    """One of three ranks has one of the libraries; each makes those of its own flags. Then a
    compiler fails on one rank; then others can write to the folder of one rank."""
    (tmp_path / "open2").mkdir()
    (tmp_path / "open2").chmod(0o777)
    text = PROGRAM.format(tests=str(REPOSITORY / "tests"), root=str(REPOSITORY))
    (tmp_path / "program.py").write_text(text)
    well(mpirun(3, "program.py", cwd=tmp_path))
    told = [(tmp_path / f"told{rank}").read_text().splitlines() for rank in range(3)]
    apart, *failed = zip(*told, strict=True)
    assert apart == ("True 2 2", "True 2 0", "True 2 0")
    assert failed == [("2 compiling",) * 3, ("2 others",) * 3]


#: a compiler that answers questions, and does not compile
COMPILER = """#!/bin/sh
case "$*" in *--version*) exec cc "$@";; esac
{}
"""
RUN = "-m", "fsipetsc", "blast", "-fsi_h", "0.0625", "-ts_max_steps", "1"


def compiler_that(does, folder):
    """The environment of a compiler of this shell code, and of an empty cache."""
    (folder / "compiler").write_text(COMPILER.format(does))
    (folder / "compiler").chmod(0o755)
    return {"CC": str(folder / "compiler"), "FSIPETSC_CACHE": str(folder / "cache")}


def test_a_compiler_that_fails_ends_all_ranks_once(tmp_path):
    does = "echo 'a note' >&2; echo 'kernels.c:7: error: no such luck' >&2; exit 1"
    done = mpirun(3, *RUN, cwd=tmp_path, env=compiler_that(does, tmp_path))
    message(done, 2, "compiling kernels failed: kernels.c:7: error: no such luck (the command was")


def test_a_home_that_cannot_be_written_costs_a_warning(tmp_path):
    """One; what is compiled is sent, and the run goes on."""
    env = {"HOME": "/proc/none", "XDG_CACHE_HOME": "", "FSIPETSC_CACHE": "", "CFLAGS": "-O0"}
    line = "-m fsipetsc compile rod -fsi_coupling projection -fsi_debug".split()
    done = mpirun(3, *line, cwd=tmp_path, env=env)
    assert done.returncode == 0 and "C text" not in done.stdout, done.stderr
    assert done.stderr.count("warning: cannot keep compiled kernels in /proc/none/.cache") == 1


def test_the_text_of_kernels_is_kept_and_found(tmp_path):
    said = well(solve("compile", "rod", "-fsi_debug", cwd=tmp_path)).stdout
    paths = re.findall("C text of kernels: (.*)", said)
    assert any("gas_near(" in Path(path).read_text() for path in paths)


def test_two_runs_at_once_with_an_empty_cache(tmp_path):
    env = {**environment(), "FSIPETSC_CACHE": str(tmp_path / "cache"), "CFLAGS": "-O0"}
    line = "-m fsipetsc rod -fsi_coupling projection -fsi_h 0.1 -ts_max_steps 1 -fsi_quiet"
    command = [sys.executable, *line.split(), "-fsi_output"]
    both = [subprocess.Popen([*command, f"{k}.h5"], cwd=tmp_path, env=env) for k in range(2)]
    assert [process.wait() for process in both] == [0, 0]
    assert [path.suffix for path in (tmp_path / "cache").iterdir()] == [".so"]


def test_a_signal_during_compilation_is_answered_at_once(tmp_path):
    """The compiler here takes longer than a test may."""
    does = f"touch {tmp_path}/started; exec sleep 60"
    env = {**environment(), **compiler_that(does, tmp_path)}
    process = subprocess.Popen([sys.executable, *RUN], cwd=tmp_path, env=env)
    while not (tmp_path / "started").exists():
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=PATIENCE) == -signal.SIGTERM  # 143 in a shell


@pytest.mark.long
@pytest.mark.parametrize("ranks", [2, 4])
def test_twenty_cold_starts(ranks, tmp_path):
    for k in range(20):
        env = {"FSIPETSC_CACHE": str(tmp_path / f"cache{k}")}
        done = well(mpirun(ranks, "-m", "fsipetsc", "compile", "rod", cwd=tmp_path, env=env))
        assert done.stdout.splitlines()[-1] == "the kernels of rod are ready"


# procedures: loops that are recorded and printed as C


Inner, Part = namedtuple("Inner", "table scale"), namedtuple("Part", "inner at first doubles")
PART = Part(Inner(np.arange(15.0).reshape(5, 3), 0.5), np.array([4, 0, 2]), 1, True)


def test_branches_variables_and_reading_again():
    def count(part, y):
        """A running sum until it is beyond 10; how often numbers were above 1."""
        total, often = variable(0.0), variable(0.0)
        for i in each(y.size):
            with when((y[i] > 1.0) & (i < 6)):
                often.value += 1.0
                y[i] = -y[i]
            with otherwise():
                y[i] = 100.0
            total.value += y[i] * y[i]
            stop(total.value > 50.0)
        y[0] = total.value
        y[1] = often.value
        y[-1] = number(pick(often.value > 2.0, part.first + 6, part.at[0]) % 3)
        y[-2] = number(part.at[whole(often.value) - 4])

    y = np.array([2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    recorded(count, PART, y)()
    assert y.tolist() == [54.0, 4.0, -4.0, -5.0, 6.0, 7.0, 4.0, 7 % 3]


def test_exact_sums_are_not_fused():
    def mean(part, y):
        """The same sum of two products, seen from both sides, and fused."""
        a, b = part.inner.table, part.inner.scale
        for i in each(1, vector=True):
            y[0] = exact(a[0, 1] * b + a[0, 2] * a[1, 0])
            y[1] = exact(a[0, 2] * a[1, 0] + a[0, 1] * b)
            y[2] = a[1, 1] * a[1, 2] + y[i]
            y[3] = y[i] + exact(a[0, 1] * a[1, 1])

    assert recorded(mean, PART).text.count("fma") == 1
    assert exact(2.0) == 2.0 and exact((1.0, 2.0)) == (1.0, 2.0)


def test_a_procedure_that_cannot_be_recorded_is_refused_with_its_line():
    def branches(part, y):
        if part.first > 0:
            y[0] = 1.0

    def beyond(part, y):
        y[1:3] = 1.0, 2.0, 3.0

    def many(part, y):
        y.reshape(-1, 2)

    for function in (branches, beyond, many):
        with pytest.raises(InputError, match=rf"{function.__name__}, .*test_kernels.py:\d+"):
            recorded(function, PART)
