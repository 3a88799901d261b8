"""`python -m fsipetsc` is the same as the installed command `fsipetsc`."""

import signal
import sys


def main() -> int:
    """Run the program; returns its exit status."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        # Ctrl-C ends the process at once, as SIGTERM does, until a run heeds signals in its own way
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.reconfigure(errors="replace")  # a letter that a terminal lacks ends no run
    from fsipetsc import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
