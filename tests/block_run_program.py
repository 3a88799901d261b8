"""Runs of block_case.py with stub_scheme.py, one after the other in one start: JOBS.json.

JOBS.json: list of [ranks, options]. Says, as JSON, of each its status and the message of an error.
"""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path

from mpi4py import MPI
from stub_scheme import StubScheme

import fsipetsc
from fsipetsc.blockrun import block_state
from fsipetsc.errors import FsiError
from fsipetsc.process.together import wait_asleep

HERE = Path(__file__).resolve().parent


def main():
    block_state.make_scheme = StubScheme
    block_state.first_notes = lambda state: []  # its pressures mean nothing
    world, said = MPI.COMM_WORLD, []
    for ranks, options in json.loads(Path(sys.argv[1]).read_text()):
        comm = world.Split(0 if world.rank < ranks else MPI.UNDEFINED, world.rank)
        if comm != MPI.COMM_NULL:
            status, message = 0, ""
            try:
                fsipetsc.run(str(HERE / "block_case.py"), comm=comm, **options).close()
            except FsiError as error:
                status, message = error.status, str(error)
            except BaseException:
                traceback.print_exc()
                world.Abort(1)
            said.append([status, message])
            comm.Free()
        wait_asleep(world)
    if world.rank == 0:
        print(json.dumps(said))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
