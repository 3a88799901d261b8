"""`python -m fsipetsc` is the same as the installed command `fsipetsc`."""

import sys

from fsipetsc.cli import main

if __name__ == "__main__":
    sys.exit(main())
