"""Where numba keeps compiled kernels: a folder named by a hash of the package's sources.

numba renews a cached function when its own file changes, not when a formula in another file does.
So kernels of other sources are in another folder: below NUMBA_CACHE_DIR, if that is set, else in
the user's cache folder. Where none can be written to, numba compiles anew in each process.
"""

import hashlib
import os
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numba

#: folders of the package with compiled code or formulas
COMPILED = ("operators", "equations", "materials", "blocks", "scheme", "paper")


#: seconds of compiling after which a word is due
PATIENCE = 2.0


@contextmanager
def announced(announce: Callable[[str], None]) -> Iterator[None]:
    """Say that kernels are being compiled if what is done within takes longer."""
    words = "compiling the kernels for the materials of this case"
    timer = threading.Timer(PATIENCE, announce, (words,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def source_hash() -> str:
    """Of the sources that are compiled."""
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for folder in COMPILED:
        for path in sorted((package / folder).glob("*.py")):
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def use_kernel_cache() -> Path:
    """Let numba keep kernels in a folder of these sources, from now on; the folder."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = (Path(given) if given else Path(home) / "fsipetsc") / source_hash()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"fsipetsc-{os.getuid()}" / folder.name
        folder.mkdir(parents=True, exist_ok=True)
    numba.config.CACHE_DIR = str(folder)
    return folder
