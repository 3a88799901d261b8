"""`python -m fsipetsc` is the same as the installed command `fsipetsc`."""

import sys

from fsipetsc.process.at_start import end_on_signals


def main() -> int:
    """Run the program; returns its exit status."""
    end_on_signals()
    from fsipetsc import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
