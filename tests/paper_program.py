"""The program with the paper's method in place of the older one: the arguments are those of
``python -m fsipetsc``."""

from __future__ import annotations

import sys


def use_paper() -> None:
    """Let all states be of fsipetsc.paper."""
    from fsipetsc.paper.state import make_paper_state
    from fsipetsc.stepping import run, solve

    run.make_state = solve.make_state = make_paper_state


if __name__ == "__main__":
    from fsipetsc import cli

    use_paper()
    sys.exit(cli.main())
