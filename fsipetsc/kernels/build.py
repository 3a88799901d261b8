"""How printed kernels become a library: which compiler, which flags, where libraries are kept.

A library is named by hashes of all that its bits depend on: its text, the processor, the flags, and
what the compiler says of itself and of the instruction set that -march=native stands for. So a
folder that several machines share holds a library for each. Behind a library in its file stand the
bytes of a hash of it: a file that is damaged is made anew.

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
import stat
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from fsipetsc.errors import FileError, InputError

#: nothing here lets a compiler change the order of operations, fuse them, or leave any out
FLAGS = (
    "-std=gnu11 -O3 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math "
    "-fopenmp-simd -fPIC -shared -Werror=implicit-function-declaration"
).split()
#: of processors with vectors of 512 bits, which compilers use half of if nobody asks
WIDE = "-mprefer-vector-width=512"
#: of gcc, which else moves selections of elementary functions so that loops are no vector code; and
#: with such vectors: gcc 12 tunes for other processors and reads numbers twice rather than keeping
#: them in one of the 32 registers
OF_GCC, TUNED = "-fno-tree-pre", "-mtune=skylake-avx512"
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

#: whether this process says that it cannot keep libraries; of several ranks the first one does
tells = True
#: whether the first rank keeps the texts in C, too, and says where (-fsi_debug)
keeps_text = False
_loaded: dict[str, ctypes.CDLL] = {}


def _compiler(given: str) -> tuple[str, ...]:
    """Return the command of the C compiler; given: CC. InputError if there is none."""
    if given:
        command = _words("CC", given)
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


def _words(name: str, given: str) -> list[str]:
    """The words of a variable of the environment. InputError for an open quote."""
    try:
        return shlex.split(given)
    except ValueError as error:
        raise InputError(f"{name} is {given!r}: {str(error).lower()}") from error


def _environment() -> tuple[str, str]:
    return os.environ.get("CC", ""), os.environ.get("CFLAGS", "")


@cache
def _target(cc: str, cflags: str) -> tuple[tuple[str, ...], str]:
    """Return the command of the compiler with all flags, those of CFLAGS last, and a hash of what
    it depends on: the compiler's version, the instruction set of this machine. InputError for flags
    that would change bits, and without a compiler.
    """
    command, own = _compiler(cc), _words("CFLAGS", cflags)
    for name, given in (("CC", command[1:]), ("CFLAGS", own)):
        for flag in given:
            if flag.startswith(REFUSED):
                raise InputError(f"{name} has {flag}: results would depend on the compiler")
    asked = (*(flag for flag in FLAGS if flag != "-shared"), *own, "-E", "-dM", "-xc", os.devnull)
    (known,) = _run([(*command, *asked)], "asking the C compiler for its target")
    gcc = b"__GNUC__" in known and b"__clang__" not in known
    of_gcc = [OF_GCC, *[TUNED] * (b"__AVX512F__" in known)] if gcc else []
    flags = (*command[1:], *FLAGS, *of_gcc, *[WIDE] * (b"__x86_64__" in known), *own)
    return (command[0], *flags), _hash(known, " ".join(flags).encode())[:8].hex()


@cache
def _processor() -> str:
    """Return a text that tells apart processors with different instruction sets."""
    known = None
    with suppress(OSError):
        known = re.search("^(flags|Features).*", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return f"{platform.machine()} {known and known[0]}"


def name_of(text: str) -> str:
    """The file's name of the library of a text in C. Without a compiler that of the last library
    which was made of it for this processor. InputError if there is none, either.
    """
    cc, cflags = _environment()
    begin = _hash(text.encode(), _processor().encode(), cflags.encode()).hex()[:32]
    try:
        return f"{begin}-{_target(cc, cflags)[1]}.so"
    except InputError:
        found = [] if cc else [*folder().glob(f"{begin}-*.so")]
        if not found:
            raise
        return max(found, key=os.path.getmtime).name


def _hash(*parts: bytes) -> bytes:
    sized = (len(part).to_bytes(8, "little") + part for part in parts)
    return hashlib.sha256(b"".join(sized)).digest()


@cache
def folder() -> Path:
    """Where libraries are kept. InputError for a folder that others can write to."""
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    place = Path(os.environ.get("FSIPETSC_CACHE") or f"{home}/fsipetsc/libraries")
    with suppress(OSError):
        found = place.stat()
        if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) or found.st_uid != os.getuid():
            raise InputError(
                f"others can write to {place}, where compiled kernels are kept: take that right "
                "away (chmod go-w), or name another folder by the variable FSIPETSC_CACHE"
            )
    return place


def kept(name: str) -> Path | None:
    """The library of this name, if it is there and whole."""
    path = folder() / name
    with suppress(OSError):
        content = path.read_bytes()
        if content[-32:] == _hash(content[:-32]):
            return path
    return None


def keep(name: str, content: bytes) -> Path | None:
    """Write a file where libraries are kept, and return where: who reads it has the old content or
    the new one. None, with a warning, if it cannot be written.
    """
    path = folder() / name
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as place:
            Path(place, name).write_bytes(content)
            os.replace(Path(place, name), path)
    except OSError as error:
        _warn(f"cannot keep compiled kernels in {path.parent} ({error.strerror})")
        return None
    return path


@cache
def _warn(text: str) -> None:
    if tells:
        print(f"fsipetsc: warning: {text}", file=sys.stderr)


def made(texts: Sequence[str]) -> list[bytes]:
    """Compile texts in C, which takes seconds, and return the bytes of their libraries, as they are
    kept. InputError, FileError.
    """
    if not texts:  # needs no compiler
        return []
    try:
        with tempfile.TemporaryDirectory(prefix="fsipetsc-") as place:
            paths = [os.path.join(place, f"kernels{k}") for k in range(len(texts))]
            for path, text in zip(paths, texts):
                Path(f"{path}.c").write_text(text)
            command, _ = _target(*_environment())
            _run([(*command, f"{p}.c", "-o", f"{p}.so", "-lm") for p in paths], "compiling kernels")
            libraries = [Path(f"{path}.so").read_bytes() for path in paths]
    except OSError as error:
        raise FileError(f"compiling kernels failed: {error.filename}: {error.strerror}") from error
    return [library + _hash(library) for library in libraries]


def lacks(name: str) -> bool:
    """Whether this process must be given the library of this name."""
    return name not in _loaded and kept(name) is None


def loaded(name: str, given: Mapping[str, bytes]) -> ctypes.CDLL:
    """The library of this name, from where it is kept or from what is given by name. FileError."""
    try:
        if name not in _loaded and (path := kept(name)):
            _loaded[name] = ctypes.CDLL(str(path))
        elif name not in _loaded:
            with tempfile.NamedTemporaryFile(prefix="fsipetsc-", suffix=".so") as file:
                file.write(given[name])
                file.flush()
                _loaded[name] = ctypes.CDLL(file.name)
    except KeyError as error:  # it was there when the ranks agreed on who lacks what
        raise FileError(f"compiled kernels are gone: {folder() / name}") from error
    except OSError as error:
        raise FileError(f"compiled kernels cannot be loaded: {error}") from error
    return _loaded[name]


def _run(commands: Sequence[Sequence[str]], doing: str) -> list[bytes]:
    """What commands print; at most two for each core run at once. InputError with the first error
    on stderr of one that fails; the others are told to end, what they have started may run on.

    With close_fds=False Python starts them without a copy of this process: MPI could not bear one.
    """
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    running, printed = list[subprocess.Popen[bytes]](), list[bytes]()
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    try:
        for k, command in enumerate(commands):
            for other in commands[len(running) : k + 2 * cores]:
                running.append(subprocess.Popen(other, close_fds=False, **pipes))
            out, said = running[k].communicate()
            printed.append(out)
            if running[k].returncode != 0:
                lines = said.decode(errors="replace").strip().splitlines() or ["no message"]
                first = next((line for line in lines if "error" in line), lines[0])
                first += f" (the command was: {shlex.join(command)})"
                raise InputError(f"{doing} failed: {first}")
    except OSError as error:
        raise InputError(f"{doing} failed: {commands[0][0]}: {error.strerror}") from error
    finally:
        for process in running:
            process.terminate()  # not killed: gcc removes its temporary files
    return printed
