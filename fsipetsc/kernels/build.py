"""How printed kernels become a library: which compiler, which flags, where libraries are kept.

A library is named by a hash of all that its bits depend on: its text, the flags, and what the
compiler says of itself and of the instruction set that -march=native stands for on this machine. So
a folder that several machines share holds a library for each. Behind a library in its file stand
the bytes of a hash of it: a file that is damaged is made anew.

The environment: CC names the compiler, CFLAGS are more flags for it. FSIPETSC_CACHE names the
folder; else it is ``fsipetsc/libraries`` in XDG_CACHE_HOME or in the user's .cache.
"""

import atexit
import ctypes
import hashlib
import os
import platform
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fsipetsc.errors import FileError, InputError

#: nothing here lets a compiler change the order of operations, fuse them, or leave any out
FLAGS = (
    *("-std=gnu11", "-O3", "-march=native", "-ffp-contract=off", "-fno-math-errno"),
    *("-fno-trapping-math", "-fopenmp-simd", "-fPIC", "-shared"),
    "-Werror=implicit-function-declaration",
)
#: of processors with vectors of 512 bits, which compilers use half of if nobody asks
WIDE = "-mprefer-vector-width=512"
#: of gcc, which else moves selections of elementary functions so that loops are no vector code; and
#: with such vectors: gcc 12 tunes for other processors and reads numbers twice rather than keeping
#: them in one of the 32 registers
OF_GCC, TUNED = "-fno-tree-pre", "-mtune=skylake-avx512"
#: flags that let results depend on the compiler
REFUSED = (
    *("-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-fassociative-math"),
    *("-freciprocal-math", "-ffinite-math-only", "-fno-signed-zeros", "-mrecip"),
    *("-ffp-contract=fast", "-ffp-contract=on", "-ffp-model", "-fapprox-func", "-mdaz-ftz"),
    *("-fno-honor-nans", "-fno-honor-infinities", "-fdenormal-fp-math", "-mfpmath"),
    "-fsingle-precision-constant",
)
MISSING = (
    "no C compiler was found, which computing needs: install gcc or clang (Debian: apt-get install "
    "gcc libc6-dev; conda: c-compiler; pip: ziglang), or name one by the variable CC"
)


#: whether this process says that it cannot keep libraries; of several ranks the first one does
tells = True
#: folders of this process
_instead: list[Path] = []
#: compilers at work
_running: set[subprocess.Popen[bytes]] = set()


def of_environment(function: Callable[[], Any]) -> Any:
    """Return the function with a cache: it finds an answer once for each CC and CFLAGS."""
    cached = cache(lambda compiler, flags: function())
    found = wraps(function)(lambda: cached(os.environ.get("CC"), os.environ.get("CFLAGS")))
    found.cache_clear = cached.cache_clear  # type: ignore[attr-defined]
    return found


@of_environment
def compiler() -> tuple[str, ...]:
    """Return the command of the C compiler. InputError if there is none."""
    given = os.environ.get("CC")
    if given:
        command = shlex.split(given)
        found = shutil.which(command[0]) if command else None
        if found is None:
            raise InputError(f"CC is {given!r}: no such program was found")
        return (found, *command[1:])
    found = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
    if found:
        return (found,)
    if find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    raise InputError(MISSING)


@of_environment
def flags() -> tuple[str, ...]:
    """Return our flags, then those of CFLAGS. InputError for flags that would change bits, and
    without a compiler.
    """
    known = _macros()
    gcc = b"__GNUC__" in known and b"__clang__" not in known
    of_gcc = [OF_GCC, *[TUNED] * (b"__AVX512F__" in known)] if gcc else []
    return (*FLAGS, *of_gcc, *[WIDE] * (b"__x86_64__" in known), *_own_flags())


def _own_flags() -> list[str]:
    """Return the flags of CFLAGS. InputError for those that would change bits."""
    cc, own = (shlex.split(os.environ.get(name, "")) for name in ("CC", "CFLAGS"))
    for name, given in (("CC", cc[1:]), ("CFLAGS", own)):
        for flag in given:
            if flag.startswith(REFUSED):
                raise InputError(f"{name} has {flag}: results would depend on the compiler")
    return own


@of_environment
def _macros() -> bytes:
    """The macros that the compiler defines: its version, and the instruction set of this machine.
    InputError without a compiler.
    """
    asked = (*(flag for flag in FLAGS if flag != "-shared"), *_own_flags(), "-E", "-dM", "-xc")
    return _run((*compiler(), *asked, os.devnull), "asking the C compiler for its target")


@of_environment
def _target() -> bytes:
    """A hash of what the compiler says of itself and its target, and of its flags. It is kept, so
    that where there is no compiler any more the last one counts. InputError without a compiler, now
    and before.
    """
    note = folder() / f"target-{_hash(_processor(), ' '.join(_own_flags()).encode()).hex()[:16]}"
    try:
        compiler()
    except InputError:
        if note.is_file() and not os.environ.get("CC"):
            return note.read_bytes()
        raise
    found = _hash(_macros(), " ".join((*compiler()[1:], *flags())).encode())
    if not note.is_file() or note.read_bytes() != found:
        with suppress(OSError):  # machines without a compiler alone need it
            _write(note, found)
    return found


def _processor() -> bytes:
    """Return a text that tells apart processors with different instruction sets."""
    lines = list[str]()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    known = next((line for line in lines if line.startswith(("flags", "Features"))), "")
    return f"{platform.machine()} {platform.processor()} {known}".encode()


def name_of(text: str) -> str:
    """The file's name of the library of a text in C. InputError without a compiler."""
    return f"{_hash(text.encode(), _target()).hex()[:32]}.so"


def _hash(*parts: bytes) -> bytes:
    sized = (len(part).to_bytes(8, "little") + part for part in parts)
    return hashlib.sha256(b"".join(sized)).digest()


@cache
def folder() -> Path:
    """Where libraries are kept: the user's folder, or one for this process, with a warning, where
    there can be none. InputError for a folder that others can write to.
    """
    given = os.environ.get("FSIPETSC_CACHE")
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    place = Path(given) if given else Path(home) / "fsipetsc" / "libraries"
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = place.stat()
    except OSError as error:
        return _temporary(place, error.strerror)
    if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) or found.st_uid != os.getuid():
        raise InputError(
            f"others can write to {place}, where compiled kernels are kept: take that right away "
            "(chmod go-w), or name another folder by the variable FSIPETSC_CACHE"
        )
    return place


@cache
def _temporary(place: Path, why: object) -> Path:
    """A folder for this process alone, with a warning."""
    _instead.append(made := Path(tempfile.mkdtemp(prefix="fsipetsc-")))
    atexit.register(shutil.rmtree, made, True)
    if tells:
        print(
            f"fsipetsc: warning: cannot keep compiled kernels in {place} ({why})", file=sys.stderr
        )
    return made


def kept(name: str) -> Path | None:
    """The library of this name, if it is there and whole."""
    for path in (place / name for place in (folder(), *_instead)):
        with suppress(OSError):
            content = path.read_bytes()
            if content[-32:] == _hash(content[:-32]):
                return path
    return None


def made(text: str) -> bytes:
    """The bytes of the library of a text in C, as they are kept; it takes seconds. InputError,
    FileError.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="fsipetsc-") as place:
            source, result = os.path.join(place, "kernels.c"), os.path.join(place, "kernels.so")
            Path(source).write_text(text)
            _run((*compiler(), *flags(), source, "-o", result, "-lm"), "compiling kernels")
            library = Path(result).read_bytes()
            return library + _hash(library)
    except OSError as error:
        raise FileError(f"compiling kernels failed: {error.filename}: {error.strerror}") from error


def end_compilers() -> None:
    """End the compilers that are at work."""
    for process in tuple(_running):
        process.kill()


def keep(name: str, content: bytes) -> Path:
    """Write a file where libraries are kept, and return where; where the folder can only be read,
    in one for this process. FileError.
    """
    place = folder()
    if not os.access(place, os.W_OK | os.X_OK):
        place = _temporary(place, "it cannot be written")
    try:
        _write(place / name, content)
    except OSError as error:
        raise FileError(f"cannot keep compiled kernels in {place}: {error.strerror}") from error
    return place / name


def _write(path: Path, content: bytes) -> None:
    """Write a file under another name first: who reads it has the old content or the new one."""
    handle, part = tempfile.mkstemp(dir=path.parent, prefix=f"{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(part, path)
    except OSError:
        os.unlink(part)
        raise


@cache
def loaded(path: Path) -> ctypes.CDLL:
    """Load the library in a file. FileError."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise FileError(f"compiled kernels cannot be loaded from {path}: {error}") from error


def _run(command: tuple[str, ...], doing: str) -> bytes:
    """What a command prints. InputError with its first line on stderr if it fails.

    With close_fds=False Python starts it without a copy of this process, which MPI could not bear.
    """
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    try:
        ended = subprocess.Popen(command, close_fds=False, **pipes)
    except OSError as error:
        raise InputError(f"{doing} failed: {command[0]}: {error.strerror}") from error
    _running.add(ended)
    try:
        out, said = ended.communicate()
    except BaseException:
        ended.kill()
        raise
    finally:
        _running.discard(ended)
    if ended.returncode != 0:
        lines = said.decode(errors="replace").strip().splitlines() or ["no message"]
        first = next((line for line in lines if "error" in line), lines[0])
        raise InputError(f"{doing} failed: {first} (the command was: {shlex.join(command)})")
    return out
