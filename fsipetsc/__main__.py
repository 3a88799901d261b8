"""`python -m fsipetsc` is the same as the installed command `fsipetsc`."""

import signal
import sys

_ignored = signal.getsignal(signal.SIGINT) is not signal.default_int_handler
if not _ignored:
    # nothing is under way yet: no traceback out of an import
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from fsipetsc.cli import main  # noqa: E402

if not _ignored:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if __name__ == "__main__":
    sys.exit(main())
