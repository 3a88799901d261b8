"""The same bits and libraries with any flags, compiler, numpy's loops, numbers, sizes and ranks."""

import os
import shlex
import shutil
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import h5py
import pytest
from helpers import REPOSITORY, launch, well

#: name -> command line
RUNS = {
    "paper": "rod -fsi_coupling projection -fsi_h 0.1 -ts_max_steps 6",
    "blast": "blast -fsi_h 0.0625 -ts_max_steps 6",
    "box": "box -fsi_h 0.1 -ts_max_steps 6",
    "three": "box_mms -box_dimension 3 -fsi_h 0.125 -ts_max_steps 2",
    "cylinder": "cylinder -fsi_h 0.0625 -ts_max_steps 6",
    "ring": "ring -fsi_h 0.05 -ts_max_steps 6",
    "shell": "shell -fsi_h 0.05 -ts_max_steps 6",
    "shock": "shock -fsi_h 0.02 -ts_max_steps 6",
    "wall": "piston -fsi_h 0.025 -ts_max_steps 6",
    "sides": "box_mms -box_dimension 3 -box_periodic false -fsi_h 0.125 -fsi_order 2 "
    "-ts_max_steps 2",
    "rod": "rod -fsi_h 0.1 -ts_max_steps 6",
    "nozzle": "nozzle -ts_max_steps 2",
}
#: vector loops of numpy that another machine may not have
WITHOUT = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX2 FMA3"
ZIG = shlex.join([sys.executable, "-m", "ziglang", "cc"]) if find_spec("ziglang") else None
#: name -> the runs that are not for long tests, what is set in the environment
OTHERS = {
    "AVX2": ("paper", {"CFLAGS": "-march=x86-64-v3"}),
    "plain": ("blast", {"CFLAGS": "-march=x86-64"}),
    "O1": ("", {"CFLAGS": "-O1"}),
    "O0": ("three", {"CFLAGS": "-O0"}),  # as most tests have it (conftest.py)
    "clang": ("", {"CC": shutil.which("clang") or ZIG}),
    "numpy": (
        "paper blast three box nozzle",
        {"NPY_DISABLE_CPU_FEATURES": WITHOUT, "OPENBLAS_CORETYPE": "Prescott"},
    ),
}
OF_X86 = "AVX2", "plain", "numpy"
long = pytest.mark.long
#: does command lines one after the other in one process
LINES = """
import shlex, sys
from fsipetsc import cli
sys.exit(max(cli.main(shlex.split(line)) for line in sys.argv[1:]))
"""


def do(lines: list[str], folder: Path, ranks: int = 1, **env: str) -> None:
    folder.mkdir(exist_ok=True)
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    quiet = [f"{line} -fsi_quiet" for line in lines]
    well(launch([*start, sys.executable, "-W", "ignore", "-c", LINES, *quiet], folder, env))


def made(names: str, folder: Path, **env: str) -> dict[str, bytes]:
    """All numbers that runs leave, by the names of runs and arrays; one process makes them."""
    runs, found = names.split(), {}
    do([f"{RUNS[run]} -fsi_output {run}.h5" for run in runs], folder, **env)
    for run in runs:
        with h5py.File(folder / f"{run}.h5") as file:
            arrays = []
            file.visititems(lambda name, item, of=arrays: of.append((name, item)))
            sets = [(name, item) for name, item in arrays if isinstance(item, h5py.Dataset)]
            found |= {f"{run}: {n}": x[()].tobytes() for n, x in sets if x.dtype.kind in "fi"}
    assert any(name.endswith("/u") for name in found) and any("series" in name for name in found)
    return found


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """What runs leave with the usual compiler and flags; each is made once."""
    folder = tmp_path_factory.mktemp("usual")
    one = cache(lambda run: made(run, folder / "runs"))
    return lambda runs: {key: value for run in runs.split() for key, value in one(run).items()}


@pytest.mark.parametrize(
    ("other", "runs"),
    [
        *((other, runs) for other, (runs, _) in OTHERS.items() if runs),
        *(pytest.param(other, " ".join(RUNS), marks=long) for other in OTHERS),
    ],
)
def test_flags_compilers_and_loops_of_numpy_do_not_change_bits(other, runs, usual, tmp_path):
    """Of fields, interfaces and what is recorded at each step."""
    if (other == "clang" and not OTHERS[other][1]["CC"]) or (
        other in OF_X86 and os.uname().machine != "x86_64"
    ):
        pytest.skip("no clang, or another kind of processor")
    found, known = made(runs, tmp_path, **OTHERS[other][1]), usual(runs)
    assert found.keys() == known.keys()
    assert [name for name in found if found[name] != known[name]] == []


#: case -> options whose numbers change, two spacings
SWEEPS = {
    "rod -fsi_coupling projection": ("-fluid_mu {} -solid_modulus {}e6", "0.1 0.05"),
    "blast": ("-fluid_mu {}e-3 -solid_modulus {}0", "0.0625 0.05"),
    "shell": ("-solid_mu {}", "0.05 0.025"),
    "piston": ("-fluid_mu 0.0{}", "0.025 0.02"),
    "box_mms -box_dimension 3": ("-fluid_mu {}e-2", "0.125 0.1"),
    "rod": ("-fluid_mu {}", "0.1 0.05"),
    "box -fsi_dissipation 1": ("-fluid_mu 0.{0} -fluid_kappa {0} -fluid_gamma 1.{0}", "0.1 0.05"),
    # of three ranks none has all the conditions, whose data depend on time
    f"{REPOSITORY}/tests/timed.py -timed_kind ends": ("", "0.125 0.1"),
}
OFTEN = "blast", "box", f"{REPOSITORY}/tests/timed.py"


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=() if case.split()[0] in OFTEN else long) for case in SWEEPS]
)
def test_other_numbers_sizes_and_ranks_need_no_other_library(case, tmp_path):
    """`compile` on one rank makes all that runs on 1 and 3 ranks need: these may not compile."""
    options, sizes = SWEEPS[case]
    first, second = (f"{case} -fsi_h {h}" for h in sizes.split())
    cache = tmp_path / "cache"
    own = {"FSIPETSC_CACHE": str(cache), "CFLAGS": "-O0"}
    do([f"compile {first}"], tmp_path, **own)
    libraries = sorted(path.name for path in cache.iterdir())
    assert libraries
    lines = [f"{first} {options.format(n, n)}" for n in (1, 5)]
    for ranks, some in ((1, [*lines, second]), (3, [first, second])):
        do([f"{x} -ts_max_steps 2 -fsi_output x.h5" for x in some], tmp_path, ranks, **own)
        assert sorted(path.name for path in cache.iterdir()) == libraries
