"""`python -m fsipetsc` is the same as the installed command `fsipetsc`."""

import sys

from fsipetsc.process.program import end_on_signals


def main() -> int:
    """Run the program; returns its exit status."""
    end_on_signals()
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.reconfigure(errors="replace")  # a letter that a terminal lacks ends no run
    from fsipetsc import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
