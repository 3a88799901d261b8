"""The options as the user gave them: from PETSC_OPTIONS, the command line and options files.

They are read here, in the format of PETSc, and not by PETSc: that answers a missing or malformed
file with a page of its own and, on several ranks, by waiting for ever, and passes silently over
words that belong to no option. PETSc gets what has been checked, name by name.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from fsipetsc.errors import FileError, InputError
from fsipetsc.options.option import brief

HELP_FLAGS = ("-h", "-help", "--help")
_FILE_OPTIONS = ("options_file", "options_file_yaml")
_YAML_SUFFIXES = (".yaml", ".yml", ".json")


class Given(NamedTuple):
    """An option as it was given: name without dash as spelt, text ("" without a value), and where,
    as " in …" or ""."""

    name: str
    text: str
    where: str


def is_option(word: str) -> bool:
    """PETSc's rule: a dash, or two, and a letter. -10, -.5 and -inf are values."""
    number = word.lower() in ("-inf", "-infinity", "-nan")
    return re.match(r"--?[A-Za-z]", word) is not None and not number


def given_options(
    arguments: Sequence[str], environment: Mapping[str, str] | None = None
) -> dict[str, Given]:
    """Name in lower case -> option, the last of those given more than once.

    The command line overrides PETSC_OPTIONS. arguments: the words behind the case's name.
    environment: os.environ if None. Options files are read where they are named. InputError for a
    word that belongs to no option and for a malformed file, FileError for one that cannot be read;
    both name file and line.
    """
    words = (os.environ if environment is None else environment).get("PETSC_OPTIONS", "")
    where = " in PETSC_OPTIONS"
    found = [*_of_words(_cut(words, where), where), *_of_words(list(arguments), "")]
    return {option.name.lower(): option for option in found}


def _cut(text: str, where: str) -> list[str]:
    """A text cut at blanks, except within quotation marks, which are taken off."""
    lexer = shlex.shlex(text, posix=True)
    lexer.whitespace_split, lexer.commenters, lexer.escape = True, "#", ""
    try:
        return list(lexer)
    except ValueError:
        what = f"a quotation mark that is never closed{where}"
        raise InputError(f"{what}: {brief(text)}") from None


def _of_words(words: Sequence[str], where: str, depth: int = 0) -> Iterator[Given]:
    """The options that words stand for; depth: of options files within options files."""
    waiting = list(words)
    while waiting:
        word = waiting.pop(0)
        if not is_option(word):
            what = f"unexpected argument '{brief(word)}'{where}"
            raise InputError(f"{what}: a value stands right behind its option")
        value = waiting.pop(0) if waiting and not is_option(waiting[0]) else ""
        if word in HELP_FLAGS:
            continue  # it is answered before options are read
        if word.startswith("--"):
            what = f"unknown option {brief(word)}{where}"
            raise InputError(f"{what}: write {brief(word[1:])}, with one dash")
        yield from _resolved(Given(word[1:], value, where), depth)


def _resolved(option: Given, depth: int) -> Iterator[Given]:
    """An option itself, or those in the file that it names."""
    lower = option.name.lower()
    if lower not in _FILE_OPTIONS:
        yield option
        return
    if not option.text:
        raise InputError(f"-{option.name}{option.where} needs the name of a file")
    if depth > 20:
        raise InputError(f"options file {option.text} names itself, or a file that names it")
    path = os.path.expanduser(option.text)
    text = _read(path)
    if lower.endswith("yaml") or path.endswith(_YAML_SUFFIXES):
        for one in _of_table(_parsed(path, text), "", f" (options file {path})"):
            yield from _resolved(one, depth + 1)
        return
    for number, line in enumerate(text.splitlines(), 1):
        where = f" (options file {path}, line {number})"
        words = [] if line.lstrip().startswith("!") else _cut(line, where)
        if len(words) > 2:
            found = f"not '{brief(' '.join(words))}'{where}"
            raise InputError(f"one option and its value a line, {found}")
        yield from _of_words(words, where, depth + 1)


def _read(path: str) -> str:
    try:
        if os.path.exists(path) and not os.path.isfile(path):
            raise FileError(f"options file {path}: not a regular file")  # a pipe would wait
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", error)
        raise FileError(f"options file {path}: {reason}") from None


def _parsed(path: str, text: str) -> Any:
    """What a YAML text says."""
    try:
        import yaml
    except ModuleNotFoundError:
        what = "YAML needs the Python package PyYAML; or write lines '-name value', in another file"
        raise InputError(f"options file {path}: {what}") from None
    try:
        # numbers stay as they are written
        return yaml.load(text, Loader=yaml.BaseLoader) or {}
    except (yaml.YAMLError, RecursionError) as error:
        raise InputError(f"options file {path}: {' '.join(str(error).split())}") from None


def _of_table(found: Any, name: str, where: str) -> Iterator[Given]:
    """The options in a YAML tree: names of nested tables are joined with _, lists get commas."""
    if isinstance(found, dict):
        for key, value in found.items():
            if not isinstance(key, str) or not re.fullmatch(r"[A-Za-z]\w*", key):
                raise InputError(f"a name of an option is expected, not {key!r}{where}")
            yield from _of_table(value, f"{name}_{key}" if name else key, where)
    elif not name:
        raise InputError(f"'name: value' is expected{where}")
    elif isinstance(found, list) and all(isinstance(item, str) for item in found):
        yield Given(name, ",".join(found), where)
    elif isinstance(found, str):
        yield Given(name, found, where)
    else:
        raise InputError(f"a list of numbers or words is expected for {name}{where}")
