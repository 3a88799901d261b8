"""The same bits and libraries with any flags, compiler, numpy's loops, numbers, sizes and ranks."""

import os
import shlex
import shutil
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import launch, well

#: name -> command line, steps; all but the first few are for long tests
RUNS = {
    "paper": ("rod -fsi_coupling projection -fsi_h 0.1", 6),
    "blast": ("blast -fsi_h 0.0625", 6),
    "box": ("box -fsi_h 0.1", 6),
    "three dimensions": ("box_mms -box_dimension 3 -fsi_h 0.125", 2),
    "disc": ("blast -blast_kind shock -fsi_shock 1 -fsi_dissipation 1 -fsi_h 0.0625", 6),
    "ring": ("ring -fsi_h 0.05", 6),
    "shell": ("shell -fsi_h 0.05", 6),
    "shock": ("shock -fsi_h 0.02", 6),
    "a wall that moves": ("piston -fsi_h 0.025", 6),
    "three dimensions, sides": (
        "box_mms -box_dimension 3 -box_periodic false -fsi_h 0.125 -fsi_order 2",
        2,
    ),
    "rod": ("rod -fsi_h 0.1", 6),
}
SHORT = {"paper": ["AVX2", "O1"], "blast": ["plain"], "three dimensions": ["O0"]}
#: vector loops of numpy that another machine may not have
WITHOUT = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX2 FMA3"
OTHERS = {
    "plain": {"CFLAGS": "-march=x86-64"},
    "AVX2": {"CFLAGS": "-march=x86-64-v3"},
    "O1": {"CFLAGS": "-O1"},
    "O0": {"CFLAGS": "-O0"},  # as most tests have it (conftest.py)
    "clang": {},
}
long = pytest.mark.long
X86 = os.uname().machine == "x86_64"


def environment_of(name: str) -> dict[str, str]:
    """What is set for it; skips the test where it is not there."""
    if name == "clang":
        zig = shlex.join([sys.executable, "-m", "ziglang", "cc"]) if find_spec("ziglang") else None
        if not (command := shutil.which("clang") or zig):
            pytest.skip("no clang")
        return {"CC": command}
    if "x86" in OTHERS[name].get("CFLAGS", "") and not X86:
        pytest.skip("another kind of processor")
    return OTHERS[name]


#: does command lines one after the other in one process
LINES = """
import shlex, sys
from fsipetsc.process.program import end_on_signals
end_on_signals()
from fsipetsc import cli
sys.exit(max(cli.main(shlex.split(line)) for line in sys.argv[1:]))
"""


def do(lines: list[str], folder: Path, ranks: int = 1, **env: str) -> None:
    folder.mkdir(exist_ok=True)
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    well(launch([*start, sys.executable, "-c", LINES, *lines], folder, env))


def run_of(line: str, steps: int, folder: Path, **env: str) -> dict[str, bytes]:
    """All numbers that a run leaves, by the names of their arrays."""
    do([f"{line} -ts_max_steps {steps} -fsi_output run.h5 -fsi_quiet"], folder, **env)
    found: dict[str, bytes] = {}

    def note(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fi":
            found[name] = np.asarray(item[()]).tobytes()

    with h5py.File(folder / "run.h5") as file:
        file.visititems(note)
    (folder / "run.h5").unlink()
    assert any(name.endswith("/u") for name in found) and any("series" in name for name in found)
    return found


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """What runs leave with the usual compiler and flags; each is made once."""
    folder = tmp_path_factory.mktemp("usual") / "runs"
    return cache(lambda run: run_of(*RUNS[run], folder)), folder


def different(one: dict[str, bytes], other: dict[str, bytes]) -> list[str]:
    assert one.keys() == other.keys()
    return [name for name in one if one[name] != other[name]]


def cases(short: dict[str, list[str]], others: list[str]) -> list[object]:
    """A run and what it is made with; most are long."""
    pairs = [(run, other) for run in RUNS for other in others]
    return [
        pytest.param(run, other, marks=() if other in short.get(run, ()) else long)
        for run, other in pairs
    ]


@pytest.mark.parametrize(("run", "other"), cases(SHORT, list(OTHERS)))
def test_flags_and_compilers_do_not_change_bits(run, other, usual, tmp_path):
    """Of fields, interfaces and what is recorded at each step."""
    env = environment_of(other)
    assert different(usual[0](run), run_of(*RUNS[run], tmp_path / "other", **env)) == []


@pytest.mark.skipif(not X86, reason="another kind of processor")
@pytest.mark.parametrize(
    "run", [pytest.param(r, marks=() if r in ("paper", "blast", "box") else long) for r in RUNS]
)
def test_loops_of_numpy_do_not_change_bits(run, usual):
    """numpy with the loops of a machine that has neither AVX2 nor AVX-512."""
    one, folder = usual[0](run), usual[1]
    env = {"NPY_DISABLE_CPU_FEATURES": WITHOUT, "OPENBLAS_CORETYPE": "Prescott"}
    assert different(one, run_of(*RUNS[run], folder, PYTHONWARNINGS="ignore", **env)) == []


# libraries

SWEEPS = {
    "rod -fsi_coupling projection": ["-fluid_mu {}", "-solid_modulus {}e6"],
    "blast": ["-fluid_mu {}e-3", "-solid_modulus {}0"],
    "shell": ["-solid_mu {}"],
    "piston": ["-piston_time 0.0{}"],
    "box_mms -box_dimension 3": ["-fluid_mu {}e-2"],
    "rod": ["-fluid_mu {}"],
}
SIZES = {
    "rod": ("0.1", "0.05"),
    "blast": ("0.0625", "0.05"),
    "shell": ("0.05", "0.025"),
    "piston": ("0.025", "0.02"),
    "box_mms -box_dimension 3": ("0.125", "0.1"),
    "rod -fsi_coupling projection": ("0.1", "0.05"),
}


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=long if number > 1 else ()) for number, c in enumerate(SWEEPS)]
)
def test_other_numbers_sizes_and_ranks_need_no_other_library(case, tmp_path):
    """`compile` on one rank makes all that runs on 1, 2 and 3 ranks need: these may not compile."""
    first, second = (f"{case} -fsi_h {h}" for h in SIZES[case])

    def run(lines, ranks=1):
        some = [f"{line} -ts_max_steps 1 -fsi_quiet -fsi_output run.h5" for line in lines]
        do(some, tmp_path, ranks, **own)
        return sorted(path.name for path in cache.iterdir())

    cache = tmp_path / "cache"
    own = {"FSIPETSC_CACHE": str(cache), "CFLAGS": "-O0"}
    do([f"compile {first} -fsi_quiet"], tmp_path, **own)
    made = sorted(path.name for path in cache.iterdir())
    assert made
    sweep = [f"{first} {line.format(n)}" for line in SWEEPS[case] for n in (1, 5)]
    assert run([*sweep, second]) == made
    for ranks in (2, 3):
        assert run([first, second], ranks) == made
