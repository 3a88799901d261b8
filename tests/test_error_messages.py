"""Every kind of error is one message and its exit status, whatever the number of ranks; tracebacks
are for who asks.
"""

from __future__ import annotations

import pytest
from helpers import message, solve
from stub_case import run_stub, start_stub

RAISED = {
    "from fsipetsc.errors import ComputationError as E; raise E('T <= 0')": (3, ["T <= 0"]),
    "open('/no/such/file')": (4, ["/no/such/file: No such file"]),
    "raise KeyboardInterrupt": (130, ["stopped by SIGINT"]),
    "import no_such_package": (2, ["needs the Python package no_such_package"]),
    "case.build(options)": (2, ["stub.py, line 10", "KeyError"]),
    "1 / 0": (1, ["ZeroDivisionError", "-fsi_debug"]),
    "from petsc4py import PETSc; PETSc.TS().create().setType('nix')": (
        1,
        ["PETSc error 86", "Unknown TS type: nix"],
    ),
}


@pytest.mark.parametrize("code", RAISED)
def test_every_kind_of_error_is_one_message_and_its_status(code, here):
    status, words = RAISED[code]
    own = "petsc4py" in code  # where PETSc waits for all ranks that there are
    message((start_stub if own else run_stub)("-do", code), status, *words)


def test_debug_shows_the_traceback(here):
    done = run_stub("-do", "1 / 0", "-fsi_debug")
    assert done.returncode == 1
    assert done.stderr.startswith("Traceback")
    assert done.stderr.splitlines()[-1].startswith("fsipetsc: error: ")


def test_a_bad_value_of_it_is_a_bad_value(here):
    message(solve("rod", "-fsi_debug", "7x"), 2, "7x", "-fsi_debug")


@pytest.mark.mpi
class TestOnTwoRanks:
    """Nobody waits for a rank that has gone."""

    @pytest.mark.parametrize(
        "code", ["1 / 0", "from fsipetsc.errors import ComputationError as E; raise E('T <= 0')"]
    )
    def test_all_ranks_fail(self, code, here):
        done = run_stub("-do", f"comm.barrier(); {code}", ranks=2)
        message(done, 3 if "Computation" in code else 1)
        assert "MPI_ABORT" not in done.stderr, "an error of all ranks ends in order"

    def test_ranks_disagree_about_the_error(self, here):
        code = "from fsipetsc.errors import *; E = (FileError, InputError)[comm.rank]"
        code += "; raise E('rank %d' % comm.rank)"
        message(run_stub("-do", code, ranks=2), 4, "rank 0")
