"""Runs several cases one after the other in one process, as the command line would: DIRECTORY RUNS.json.

RUNS.json: name -> [case, "options as on the command line"]; options that begin with "tiles" ask for tiles on grids that
are too coarse for them to pay. Each leaves NAME.h5 in DIRECTORY; what fails leaves
NAME.txt with the error instead. Started by helpers.compute under mpiexec: much cheaper than a process for each.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

from fsipetsc.process.launch import start_mpi, start_petsc


def main(directory: str, runs: str) -> None:
    comm = start_mpi()
    start_petsc([], comm)
    from fsipetsc.cases import load_case
    from fsipetsc.errors import FsiError
    from fsipetsc.options.sources import given_options
    from fsipetsc.scheme import plan
    from fsipetsc.stepping.run import run_given

    least = (plan.LEAST_MIDDLE, plan.LEAST_TILED, plan.MOST_WAITING)
    for name, (case_name, text) in json.loads(Path(runs).read_text()).items():
        case, tiles = load_case(case_name), text.startswith("tiles ")
        plan.LEAST_MIDDLE, plan.LEAST_TILED, plan.MOST_WAITING = (16, 0, math.inf) if tiles else least
        text = text.removeprefix("tiles ")
        given = given_options([*text.split(), "-fsi_quiet", "-fsi_output", f"{directory}/{name}.h5"], {})
        try:
            run_given(case, given, comm)
        except FsiError as error:
            if comm.rank == 0:
                Path(directory, f"{name}.txt").write_text(f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:])
