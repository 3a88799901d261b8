"""Where compiled kernels are kept between runs.

numba renews a cached function when the file of that function changes, but not when a function that it calls lives
in another file that changed. So the folder is named after the state of all source files of the package: kernels
of an older state are never picked up. NUMBA_CACHE_DIR, if set, is the place for all of it, if only its user can write there.

Several checkouts and several runs share the place, and whoever keeps it small must not take away what another one uses. A
cache that vanishes nevertheless, or cannot be written, costs the time of compiling and nothing else.
"""

from __future__ import annotations

import atexit
import gc
import hashlib
import os
import pickle
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numba
from numba.core.caching import FunctionCache

from fsipetsc.operators import trust

#: folders of the package that hold compiled code
COMPILED = ("operators", "physics", "coupling", "boundaries", "parallel", "scheme", "paper")
#: folders of other states of the sources that are kept however long they have not been used, and the time in which a
#: folder counts as used [s]
_KEPT, _IN_USE = 3, 86400.0
#: what numba raises where a file of its cache is gone, cannot be written, or was cut off
_LOST = OSError, EOFError, pickle.UnpicklingError
#: seconds of compiling after which a second word is due
_LONG = 30.0


def source_digest() -> str:
    """Digest of names, sizes and times of the source files that are compiled."""
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256(str(package).encode())
    files = (path for folder in COMPILED for path in (package / folder).rglob("*.py"))
    for path in sorted(files):
        stat = path.stat()
        digest.update(f"{path.relative_to(package)} {stat.st_size} {stat.st_mtime_ns}\n".encode())
    return digest.hexdigest()[:16]


def _base() -> Path:
    """A folder that can be written to, by this user alone: numba's own, the user's cache, or a temporary one.

    A place where others could have put kernels is passed over (see `trust`); in the end a new folder is made, for this
    process only, and removed with it.
    """
    homes = os.environ.get("XDG_CACHE_HOME") or "", os.path.join(os.path.expanduser("~"), ".cache")
    home = next((h for h in homes if os.path.isabs(h)), "")  # "~" stays where a user has no home: no folder of that name
    temporary = os.path.join(tempfile.gettempdir(), f"fsipetsc-{os.getuid()}")
    for place in (os.environ.get("NUMBA_CACHE_DIR"), home and os.path.join(home, "fsipetsc"), temporary):
        if place:
            try:
                os.makedirs(place, mode=0o700, exist_ok=True)
                if os.access(place, os.W_OK) and trust.trusted(Path(place)):
                    return Path(place)
            except OSError:
                continue
    return _new_base()


def _new_base() -> Path:
    """A folder for this process only."""
    own = tempfile.mkdtemp(prefix="fsipetsc-")
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return Path(own)


def _make(folder: Path) -> bool:
    """Make the folder of the kernels, empty if others could have put something there; whether it can be trusted now."""
    for _ in range(2):
        folder.mkdir(mode=0o700, exist_ok=True)
        if trust.trusted(folder) and trust.content_trusted(folder):
            return True
        shutil.rmtree(folder, ignore_errors=True)
    return False


def cache_folder() -> Path:
    """The folder that is in use."""
    return Path(numba.config.CACHE_DIR)


@contextmanager
def garbage_waiting() -> Iterator[None]:
    """Collect garbage seldom: the compiler makes millions of objects that live on, and looking for others takes it 8 %."""
    before = gc.get_threshold()
    gc.set_threshold(100_000, 50, 50)
    try:
        yield
    finally:
        gc.set_threshold(*before)


@contextmanager
def compiling(function: Callable[..., object], announce: Callable[[str], None]) -> Iterator[None]:
    """Within, a function (numba's) may be compiled: say so if it is not on disk, and once more if it takes long."""
    own = Path(getattr(getattr(function, "stats", None), "cache_path", None) or "").parent.name
    own = own if own.startswith("laws-") else ""  # the folder of make_folder that it is kept in, if any
    if any((cache_folder() / own).glob(f"*/*.{function.__name__}[-.]*.nbi")):
        yield
        return
    once = "for the laws of this case" if own else "after installation"
    announce(f"compiling the kernels, once {once}: about 25 s on a quiet machine")
    more = threading.Timer(_LONG, announce, ("still compiling the kernels: other programs slow it down",))
    more.daemon = True
    more.start()
    try:
        yield
    finally:
        more.cancel()


@contextmanager
def _forgiving(cache: FunctionCache) -> Iterator[None]:
    """Takes the place of numba's own guard around loading and saving a kernel, which forgives on Windows only."""
    with suppress(*_LOST):
        yield


def use_cache_folder() -> Path | None:
    """Point numba at the folder for this state of the sources and drop what is stale; before any kernel is defined.

    None where no place can be written to: numba then refuses to define kernels that are to be kept.
    """
    FunctionCache._guard_against_spurious_io_errors = _forgiving
    name = f"kernels-{source_digest()}"
    for place in (_base, _base, _new_base):  # several ranks may tidy up at once
        try:
            folder = place() / name
            if _make(folder):
                tempfile.TemporaryFile(dir=folder).close()  # a full disk, or a file where the folder should be
                numba.config.CACHE_DIR = str(folder)
                _tidy_up(folder)
                return folder
        except OSError:
            continue
    return None


def make_folder(name: str) -> Path | None:
    """A folder for more kernels of this state of the sources, named prefix-…; None where it cannot be had."""
    folder = cache_folder() / name
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
    except OSError:
        return None
    _tidy_up(folder)
    return folder


def _tidy_up(folder: Path) -> None:
    """Note that `folder` is used, and remove those beside it that have not been for long, but for the last few."""
    try:
        os.utime(folder)
        alike = folder.parent.glob(f"{folder.name.split('-')[0]}-*")
        others = [(path.stat().st_mtime, path) for path in alike if path != folder]
    except OSError:
        return  # several ranks tidy up at once
    for used, path in sorted(others, reverse=True)[_KEPT:]:
        if used < time.time() - _IN_USE:
            shutil.rmtree(path, ignore_errors=True)
