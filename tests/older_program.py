"""The program with the older state in place of the paper's: the arguments are those of
``python -m fsipetsc``."""

from __future__ import annotations

import sys

if __name__ == "__main__":
    from fsipetsc import cli
    from fsipetsc.stepping import solve

    solve.is_of_paper = lambda problem, opt: False
    sys.exit(cli.main())
