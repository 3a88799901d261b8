"""The command `bench`: that it measures and tells what it says; not how fast anything is."""

from __future__ import annotations

import pytest
from helpers import run, solve

pytest.importorskip("petsc4py")

from fsipetsc.bench.cost_model import Model
from fsipetsc.bench.table import BenchStudy, Row

_QUICK = "-bench_orders 4 -bench_points 480,1000 -bench_seconds 0.01 -bench_repeats 2 -bench_more false".split()
_QUICK += "-bench_dimensions", "1"
TRUE = Model(overhead=5.0, work={4: 0.01, 8: 0.02}, overlap=0.3, latency=1.2, error=0.0)


def study() -> BenchStudy:
    """What TRUE would have measured."""
    facts = {f"triad {ranks} {1 << k}": 80.0 / (k - 10) / ranks for ranks in (1, 2) for k in (14, 20, 26)}
    made = BenchStudy([], facts, {"processor": "none"})
    for order in TRUE.work:
        for points in (500, 5000, 50_000):
            for ranks in (1, 2):
                share, reductions = points // ranks, 0 if ranks == 1 else 5
                step = TRUE.step(made, order, share, ranks)
                nothing = dict.fromkeys(("inner", "ends", "exchange", "reduction", "petsc", "call", "bound"), 0.1)
                counts = {"sends": 4 * (ranks - 1), "reductions": reductions, "doubles": 20 * points}
                made.rows.append(Row(order, 6 / points, points, ranks, share, 100, step, step, **nothing, **counts))
    return made


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("-bench_ranks", 3), "mpiexec -n 3"),
        (("-bench_yardstick", "."), "rod"),
        (("-bench_orders", 5), "2, 4, 6, 8"),
    ],
)
def test_bad_input(tmp_path, options, word):
    done = solve("bench", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert word in done.stderr
    assert done.stderr.count("\n") == 1


def test_phases_in_the_summary_and_the_log(tmp_path):
    options = "-fsi_h 0.1 -ts_max_steps 20 -fsi_output_dt 1 -log_view".split()
    done = run("-m", "fsipetsc", "rod", *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for phase in ("set-up", "time loop", "output"):
        assert f"{phase} " in next(line for line in done.stdout.splitlines() if line.startswith("phases: "))
        assert any(f" {phase}: " in line for line in done.stdout.splitlines()), "a stage of PETSc's log"
    steps = next(line for line in done.stdout.splitlines() if line.startswith("fsi step"))
    assert steps.split()[2] == "20"
    assert float(steps.split()[6]) > 20 * 4 * 60 * 50, "floating-point operations"
