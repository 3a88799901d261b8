"""Tests while gcc's sanitizers watch the kernels: no access beyond what was allocated or after that
was freed, no overflow of whole numbers, shifts or pointers, nothing else that C leaves undefined.

Python and numpy are not watched. But numpy has the memory of its arrays from malloc, which is: what
is beyond an array is found, at once if it is near. What is within one is not, as one part of it
that is taken for another, nor the up to 64 bytes that ``fsipetsc.kernels.memory.aligned`` leaves
beside an array. New memory is full of nan: who reads before anything is stored there fails.
A finding does not end a test; all are said at the end.

scripts/soak sanitize calls this: sanitizers.py [ARGUMENTS OF PYTEST]. tests/test_sanitize.py has
the functions from here.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from helpers import REPOSITORY, environment

#: tests of what computes, in one process. Not test_kernels:
#: it has compilers of its own, and damages a library that is loaded
TESTS = (
    *("block_conditions", "block_layers", "block_ledgers", "block_monitor", "block_oracle"),
    *("elementary", "gravity", "paper_rates", "procedures", "radial"),
    *("recorded_data", "solid_laws", "solid_part"),
    *("where_faces_meet",),
)
#: without optimization all checks are made, and compiling takes a quarter of the time
FLAGS = "-O0 -g -fsanitize=address,undefined -fsanitize-recover=address,undefined"
NAN_IN_NEW_MEMORY = "max_malloc_fill_size=1000000000:malloc_fill_byte=255"
#: a compiler that is not watched itself, and keeps each text, which findings name with their lines
COMPILER = """#!/bin/sh
unset LD_PRELOAD
for word; do
    shift
    case $word in */kernels.c)
        kept=$(dirname "$0")/texts/$(cksum <"$word" | tr ' ' -).c
        cp "$word" "$kept" && word=$kept ;;
    esac
    set -- "$@" "$word"
done
exec {compiler} "$@"
"""


@cache
def libraries() -> str:
    """The sanitizers' libraries, as LD_PRELOAD has them; empty where the compiler has none."""
    found = []
    for name in ("libasan.so", "libubsan.so"):
        try:
            asked = ("gcc", f"-print-file-name={name}")
            path = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()
        except (OSError, subprocess.CalledProcessError):
            return ""
        if not os.path.isabs(path):
            return ""
        found.append(path)
    return " ".join(found)


def home() -> Path:
    """Where libraries are kept, and their texts."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(cache) / "fsipetsc" / "sanitized"


def watched(folder: Path) -> dict[str, str]:
    """The environment; what is found comes to files found.* of the folder."""
    libraries_kept, texts, compiler = home() / "libraries", home() / "texts", home() / "compiler"
    for part in (libraries_kept, texts):
        part.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle, made = tempfile.mkstemp(dir=home())
    os.write(handle, COMPILER.format(compiler=shutil.which("gcc")).encode())
    os.close(handle)
    os.chmod(made, 0o700)
    os.replace(made, compiler)
    told = f"log_path={folder / 'found'}:print_stacktrace=1:halt_on_error=0"
    return {
        **environment(),
        "CC": str(compiler),
        "CFLAGS": FLAGS,
        "FSIPETSC_CACHE": str(libraries_kept),
        "LD_PRELOAD": libraries(),
        "PYTHONMALLOC": "malloc",  # else Python's own small blocks lie side by side
        "ASAN_OPTIONS": f"{told}:detect_leaks=0:{NAN_IN_NEW_MEMORY}",
        "UBSAN_OPTIONS": told,
    }


def findings(folder: Path) -> list[str]:
    """What the sanitizers said."""
    return [path.read_text() for path in sorted(folder.glob("found.*"))]


def main(words: list[str]) -> int:
    """Exit status: pytest's, 1 if anything was found."""
    if not libraries():
        print("gcc's libasan and libubsan are missing", file=sys.stderr)
        return 2
    folder = home()
    for old in folder.glob("found.*"):
        old.unlink()
    tests = [] if any(word.startswith("tests/") for word in words) else TESTS
    files = [str(REPOSITORY / "tests" / f"test_{name}.py") for name in tests]
    command = (sys.executable, "-m", "pytest", "-q", "-n", "2", "-m", "not long", *files, *words)
    status = subprocess.run(command, cwd=REPOSITORY, env=watched(folder)).returncode
    found = findings(folder)
    print("\n".join(found) or "the sanitizers found nothing")
    return status or bool(found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
