"""What several test files need: the program run as a user does, on one rank and on several."""

import csv
import os
import runpy
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from kept_ranks import KEPT

import fsipetsc
from fsipetsc.kernels import build
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.output.differences import compare

REPOSITORY = Path(__file__).resolve().parent.parent
#: seconds after which what should have ended long ago is taken for hung; no test measures time
PATIENCE = 7200

_MPI_ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_btl_base_warn_component_unused": "0",
    "OMPI_MCA_pml": "ob1",  # what drives networks (UCX) takes 0.2 s to load
    "OMPI_MCA_btl": "^tcp",  # all ranks are on this node, and of some networks Open MPI complains
    "OMPI_MCA_hwloc_base_binding_policy": "none",  # two jobs at a time would share the first cores
    "HWLOC_HIDE_ERRORS": "2",  # a bare root may have no /sys
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
#: what a developer may have set for runs of his own, what the program must set itself
#: (fsipetsc.process.launch), and what makes each start compile the sources
_DROPPED = {
    *("PETSC_OPTIONS", "OMPI_MCA_sharedfp", "OMPI_MCA_io", "OMPI_MCA_io_ompio_priority"),
    *("OMPI_MCA_mpi_yield_when_idle", "PYTHONDONTWRITEBYTECODE", "CFLAGS"),
}

Done = subprocess.CompletedProcess[str]
Place = str | os.PathLike[str] | None


def environment() -> dict[str, str]:
    """The environment of a test run: what Open MPI wants, the package importable from anywhere."""
    kept = {key: value for key, value in os.environ.items() if key not in _DROPPED}
    paths = str(REPOSITORY), os.environ.get("PYTHONPATH")
    return {**kept, **_MPI_ENVIRONMENT, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def launch(command: Sequence[str], cwd: Place = None, env: Mapping[str, str] | None = None) -> Done:
    """A command that runs to its end, its output captured as text."""
    done = subprocess.run(
        command,
        cwd=cwd,
        env={**environment(), **(env or {})},
        text=True,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=PATIENCE,
    )
    for name in ("stdout", "stderr"):  # Open MPI 5 ends what it says with a zero
        setattr(done, name, getattr(done, name).replace("\0", ""))
    return done


def run(*args: object, cwd: Place = None, env: Mapping[str, str] | None = None) -> Done:
    """`python *args` without mpiexec. Example: run("-m", "fsipetsc", "rod", "-help")."""
    return launch([sys.executable, *map(str, args)], cwd, env)


def mpirun(n: int, *args: object, cwd: Place = None, env: Mapping[str, str] | None = None) -> Done:
    """`mpiexec -n N python *args`."""
    return launch(["mpiexec", "-n", str(n), sys.executable, *map(str, args)], cwd, env)


def solve(*args: object, cwd: Place = None, ranks: int = 1) -> Done:
    """`python -m fsipetsc *args` by ranks that are there; run, mpirun: processes of their own."""
    words = list(map(str, args))
    (answer,) = KEPT.do(ranks, Path(cwd or "").resolve(), environment(), [words])
    return Done(words, *answer)


def compute(
    n: int, directory: Path, runs: Mapping[str, tuple[str, str]]
) -> dict[str, fsipetsc.Run]:
    """name -> (case, options) gives name -> opened result, NAME.h5 in `directory`."""
    directory.mkdir(parents=True, exist_ok=True)
    lines = [
        [case, *text.split(), "-fsi_quiet", "-fsi_output", f"{name}.h5"]
        for name, (case, text) in runs.items()
    ]
    answers = KEPT.do(n, directory, environment(), lines)
    for name, (status, _, err) in zip(runs, answers, strict=True):
        assert (status, err) == (0, ""), f"{name}: {err}"
    return {name: fsipetsc.open_run(directory / f"{name}.h5") for name in runs}


def computed(folder: Path, name: str, *words: object, ranks: int = 1) -> fsipetsc.Run:
    """The result folder/name of a run of the program on so many ranks, opened."""
    well(solve(*words, "-fsi_output", name, "-fsi_quiet", cwd=folder, ranks=ranks))
    return fsipetsc.open_run(folder / name)


def kept(run: fsipetsc.Run, most: float) -> fsipetsc.Run:
    """A run whose laws hold but for this fraction at most."""
    departures = run.summary["departures"]
    assert departures and all(size <= most for size in departures.values()), departures
    return run


def on_ranks(folder: Path, line: str, *ranks: int) -> fsipetsc.Run:
    """A result on the first number of ranks; on the others fields and steps are the same."""
    one, *others = (computed(folder, f"{n}.h5", *line.split(), ranks=n) for n in ranks)
    for other in others:
        assert_same_fields(one, other)
        assert one.summary["steps"] == other.summary["steps"]
    return one


def rows_of(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file, by names of columns."""
    return list(csv.DictReader(path.read_text().splitlines()))


def files(folder: Path) -> dict[str, bytes]:
    """What the files of a folder hold, by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def assert_same_fields(one: fsipetsc.Run, other: fsipetsc.Run) -> None:
    """All fields of two results have the same bits."""
    for a, b in zip(one.layers, other.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name]), (a.name, name)


#: of what is integrated the last bits depend on the number of ranks
SUMS = {"mass", "momentum", "energy", "entropy", "angular_momentum", "solid_energy", "lost_energy"}
SUMS |= {"momentum_x", "momentum_y", "impulse_x", "impulse_y"}
SUMS |= {"mass_in", "energy_in", "energy_face", "heat_face"}
#: of the summary, on any ranks, or on as many
SUMMED = "status", "t", "steps", "rhs_evaluations", "points", "interfaces"
ON_AS_MANY = "bound", "departures"


def different(a: Path, b: Path, same_ranks: bool) -> list[str]:
    """What has other bits in two results; sums over x count only on as many ranks."""
    found = compare(a, b)
    sums = set() if same_ranks else SUMS
    wrong = [d.name for d in found.differences if d.largest > 0.0 and d.name not in sums]
    with fsipetsc.open_run(a) as one, fsipetsc.open_run(b) as other:
        for mine, yours in zip(one.layers, other.layers, strict=True):
            assert np.array_equal(mine.X, yours.X), mine.name
        names = SUMMED + ON_AS_MANY * same_ranks
        pairs = [(name, one.summary[name], other.summary[name]) for name in names]
        pairs += [("errors", one.errors, other.errors)] * same_ranks
    return [*wrong, *found.notes, *(f"{name}: {x}, {y}" for name, x, y in pairs if x != y)]


def program(name: str, folder: str = "verify") -> SimpleNamespace:
    """A program of a folder; those of `verify` compute references apart from the package."""
    return SimpleNamespace(**runpy.run_path(str(REPOSITORY / folder / f"{name}.py")))


def recorded(function: Any, *records: Any) -> Procedure:
    """A procedure, recorded, compiled and loaded."""
    code = Code()
    found = code.procedure("procedure", function, *records)
    name = build.name_of(code.text)
    if build.found(name) is None:
        build.keep(build.made({name: code.text}))
    code.load(build.loaded(name, {}))
    return found


def well(done: Done) -> Done:
    """What has ended well, and said nothing of errors."""
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done


def message(done: Done, status: int, *words: str) -> str:
    """The program's one message, of this status, with these words; the launcher may say more."""
    assert done.returncode == status, done.stderr
    lines = [line for line in done.stderr.splitlines() if line.startswith("fsipetsc: error: ")]
    assert len(lines) == 1, done.stderr
    for word in ("Traceback", "PETSC ERROR", "Warning"):
        assert word not in done.stderr
    for word in words:
        assert word in lines[0], lines[0]
    return lines[0]


def assert_readable(path: Path, status: str, reached: float) -> None:
    """A result that can be opened, with frames and series up to the end."""
    with fsipetsc.open_run(path) as result:
        assert result.summary["status"] == status and result.time[0] == 0.0
        assert len(result.series["t"]) >= result.summary["steps"] - 1, "all but one that failed"
        assert 0 < result.summary["t"] <= reached
        for layer in result.layers:
            for field in layer.fields:
                assert np.isfinite(layer[field][-1]).sum() > 1
