"""How printed kernels become a library: which compiler, which flags, where libraries are kept.

A library is named by a hash of its text, of what the environment says, and of the instruction set
of the processor. So a folder that several machines share holds a library for each, and a machine
without a compiler loads what another of its kind has made. A file that is damaged is made anew.

The environment: CC names the compiler, CFLAGS are more flags for it. FSIPETSC_CACHE names the
folder; else it is ``fsipetsc/libraries`` in XDG_CACHE_HOME or in the user's .cache.
"""

import ctypes
import hashlib
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory, gettempdir

from fsipetsc.errors import FileError, InputError

#: nothing here lets a compiler change the order of operations, fuse them, or leave any out
FLAGS = (
    "-std=gnu11 -O3 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math "
    "-fopenmp-simd -fPIC -shared -Werror=implicit-function-declaration"
).split()
#: of gcc, which else moves selections of elementary functions so that loops are no vector code, or
#: takes parts of a vector one by one, and calls memcpy and memset for a few numbers
OF_GCC = ["-fno-tree-pre", "-fno-split-loops"]
OF_GCC += ["-fno-tree-loop-distribution", "-fno-tree-loop-distribute-patterns"]
#: with vectors of 512 bits, of which compilers use half if nobody asks. gcc 12 tunes for other
#: processors and reads numbers twice rather than keeping them in one of the 32 registers
WIDE = ["-mprefer-vector-width=512", "-mtune=skylake-avx512"]
#: how flags begin that let results depend on the compiler
REFUSED = tuple(
    "-ffast-math -Ofast -funsafe-math-optimizations -fassociative-math -freciprocal-math -mrecip "
    "-ffinite-math-only -fno-signed-zeros -ffp-contract=fast -ffp-contract=on -ffp-model "
    "-fapprox-func -mdaz-ftz -fno-honor-nans -fno-honor-infinities -fdenormal-fp-math -mfpmath "
    "-fsingle-precision-constant".split()
)
MISSING = (
    "no C compiler was found, which computing needs: install gcc or clang (Debian: apt-get install "
    "gcc libc6-dev; conda: c-compiler; pip: ziglang), or name one by the variable CC"
)
#: how many compilers a rank starts at once, which each need some 100 MB
MOST_AT_ONCE = 8

#: whether the first rank keeps the texts in C, too, and says where (-fsi_debug)
keeps_text = False
_loaded: dict[str, ctypes.CDLL] = {}


@cache
def _processor() -> str:
    """Return a text that tells apart processors with different instruction sets."""
    known = None
    with suppress(OSError):
        known = re.search("^(flags|Features).*", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return f"{platform.machine()} {known[0] if known else platform.node()}"


def name_of(text: str) -> str:
    """The file's name of the library of a text in C."""
    given = (os.environ.get(name, "") for name in ("CC", "CFLAGS"))
    of = "\0".join([text, *given, *FLAGS, *OF_GCC, *WIDE, _processor()])
    return f"{hashlib.sha256(of.encode()).hexdigest()[:40]}.so"


@cache
def folder() -> Path:
    """Where libraries are kept. InputError for a folder that others can write to."""
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    place = Path(os.environ.get("FSIPETSC_CACHE") or f"{home}/fsipetsc/libraries").absolute()
    with suppress(OSError):
        found = place.stat()
        if found.st_mode & 0o022 or found.st_uid != os.getuid():
            raise InputError(
                f"others can write to {place}, where compiled kernels are kept: take that right "
                "away (chmod go-w), or name another folder by the variable FSIPETSC_CACHE"
            )
    return place


def found(name: str) -> ctypes.CDLL | None:
    """The library of this name, if it is kept, whole, and can be loaded."""
    if name not in _loaded:
        with suppress(OSError):
            content = (path := folder() / name).read_bytes()
            if hashlib.sha256(content[:-32]).digest() == content[-32:]:
                _loaded[name] = ctypes.CDLL(str(path))
    return _loaded.get(name)


def loaded(name: str, given: Mapping[str, bytes]) -> ctypes.CDLL:
    """The library of this name, from where it is kept or from its bytes by name. FileError."""
    if library := found(name):
        return library
    try:
        with NamedTemporaryFile(prefix="fsipetsc-", suffix=".so") as file:
            file.write(given[name])
            file.flush()
            return _loaded.setdefault(name, ctypes.CDLL(file.name))
    except OSError as error:
        raise FileError(f"compiled kernels cannot be loaded: {error}") from error


def keep(files: Mapping[str, bytes]) -> str:
    """Write files, content by name, where libraries are kept: who reads one has the old content or
    the new one. Returns why they cannot be kept, "" if they are.
    """
    place = folder()
    try:
        if files:
            place.mkdir(mode=0o700, parents=True, exist_ok=True)
            with TemporaryDirectory(dir=place) as beside:
                for name, content in files.items():
                    Path(beside, name).write_bytes(content)
                    os.replace(Path(beside, name), place / name)
    except OSError as error:
        return f"cannot keep compiled kernels in {place} ({error.strerror})"
    return ""


def made(texts: Mapping[str, str]) -> dict[str, bytes]:
    """Compile texts in C, by name, which takes seconds. Returns the bytes of the files of their
    libraries. InputError where there is no compiler, or it fails; FileError.
    """
    if not texts:  # needs no compiler
        return {}
    from concurrent.futures import ThreadPoolExecutor

    command = _command()

    def one(name: str) -> bytes:
        path = os.path.join(place, name)
        Path(f"{path}.c").write_text(texts[name])
        _run([*command, f"{path}.c", "-o", path, "-lm"])
        library = Path(path).read_bytes()
        return library + hashlib.sha256(library).digest()

    try:
        with TemporaryDirectory(prefix="fsipetsc-") as place:
            with ThreadPoolExecutor(MOST_AT_ONCE) as pool:
                return dict(zip(texts, pool.map(one, texts)))
    except OSError as error:
        raise FileError(f"cannot compile kernels in {gettempdir()}: {error.strerror}") from error


def _command() -> list[str]:
    """The C compiler with all flags, those of CFLAGS last. InputError."""
    given, own = (_words(name) for name in ("CC", "CFLAGS"))
    path = next(filter(None, map(shutil.which, given[:1] or ("cc", "gcc", "clang"))), None)
    if path is None and given:
        raise InputError(f"CC is {shlex.join(given)!r}: no such program was found")
    if path is None and find_spec("ziglang") is None:
        raise InputError(MISSING)
    command = [path, *given[1:]] if path else [sys.executable, "-m", "ziglang", "cc"]
    gcc = b"Free Software Foundation" in _run([*command, "--version"])
    wide = "avx512f" in _processor()
    return [*command, *FLAGS, *OF_GCC * gcc, *WIDE[: wide * (1 + gcc)], *own]


def _words(name: str) -> list[str]:
    """The words of a variable of the environment. InputError for flags that would change bits."""
    given = os.environ.get(name, "")
    try:
        words = shlex.split(given)
    except ValueError as error:
        raise InputError(f"{name} is {given!r}: {str(error).lower()}") from error
    for flag in words:
        parts = flag.replace("--optimize=", "-O", 1).split(",")  # as of -Wp,FLAG
        parts += [part.replace("--", "-f", 1) for part in parts]
        in_file = flag.startswith("@")  # of which nobody knows what is in it
        if in_file or any(part.startswith(REFUSED) for part in parts):
            raise InputError(f"{name} has {flag}: results would depend on the compiler")
    return words


def _run(command: Sequence[str]) -> bytes:
    """What a command prints. InputError with its first error on stderr if it fails."""
    # with close_fds=False Python starts it without a copy of this process: MPI could not bear one
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, close_fds=False)
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
        first = next((line for line in lines if "error" in line), lines[0])
        said = f"{first} (the command was: {shlex.join(command)})"
        raise InputError(f"compiling kernels failed: {said}")
    return done.stdout
