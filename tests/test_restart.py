"""A run that goes on from a checkpoint is in all the run that was not stopped."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers import REPOSITORY, compute, different

import fsipetsc
from fsipetsc.output.file_layout import read_checkpoint

PISTON = str(REPOSITORY / "runs" / "piston.py")
_PAPER = "-fsi_coupling projection"
_ROD = f"{_PAPER} -fsi_h 0.025 -ts_max_time 0.08 -fsi_output_dt 0.02"
#: name -> case, options, steps after which the checkpoint is written that the run goes on from
RUNS = {
    "rod": ("rod", _ROD, 400),
    "5dp": ("rod", f"{_PAPER} -fsi_h 0.05 -ts_max_time 0.1 -ts_rk_type 5dp", 50),
    "mms": ("mms", "-fsi_h 0.025 -fsi_order 6 -ts_max_time 0.1 -fsi_output_dt 0.02", 8),
    "piston": (PISTON, "-ts_max_time 0.048", 300),
    "driven": ("piston", "-fsi_h 0.025 -ts_max_time 0.02", 6),
    "blast": ("blast", "-fsi_h 0.125 -fsi_order 2 -ts_max_time 0.3 -fsi_output_dt 0.05", 6),
}
#: ranks on which the runs are begun; ranks -> what goes on there
RANKS = 2
ON = {RANKS: list(RUNS), 3: list(RUNS)[1::2]}


@pytest.fixture(scope="module")
def begun(tmp_path_factory) -> Path:
    """Each run whole, NAME.h5, and stopped, NAME.cut.h5, with a checkpoint in its middle."""
    folder, runs, later = tmp_path_factory.mktemp("begun"), {}, {}
    for name, (case, text, steps) in RUNS.items():
        runs[name] = case, text
        runs[f"{name}.cut"] = case, f"{text} -ts_max_steps {steps} -fsi_checkpoint_steps {steps}"
        restart = f"-fsi_restart {folder}/{name}.cut.checkpoint.h5 -ts_max_steps {2 * steps}"
        later[f"{name}.cut"] = case, f"{restart} -fsi_checkpoint {folder}/unused.h5"
    below = compute(RANKS, folder, runs)["rod"].series["mass"][:, 0]
    assert np.ptp(below) < 1e-3 * below[0]
    compute(RANKS, folder, later)
    return folder


@pytest.mark.parametrize("ranks", ON)
def test_the_same_bits(ranks, begun, tmp_path):
    runs = {}
    for name in ON[ranks]:
        case, _, steps = RUNS[name]
        header, arrays = read_checkpoint(begun / f"{name}.cut.checkpoint.h5")
        assert header["memory"]["steps"] == steps and np.isfinite(arrays["results"]).all()
        cut, whole = (fsipetsc.open_run(begun / f"{name}{end}.h5") for end in (".cut", ""))
        reached = len(cut.series["t"])
        assert reached == 2 * steps < whole.summary["steps"], "nothing to cut off, or to go on with"
        shutil.copy(cut.path, tmp_path / f"{name}.h5")
        restart = f"-fsi_restart {begun}/{name}.cut.checkpoint.h5 -ts_max_steps 1000000000"
        runs[name] = case, restart
    compute(ranks, tmp_path, runs)
    for name in runs:
        assert different(begun / f"{name}.h5", tmp_path / f"{name}.h5", ranks == RANKS) == [], name
