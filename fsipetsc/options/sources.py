"""The options as the user gave them: from files for all runs, PETSC_OPTIONS, the command line and options files.

They are read here, in the format of PETSc, and not by PETSc: that answers a missing or malformed file with a page of its
own and, on several ranks, by waiting for ever, cuts values at blanks, and passes silently over words that belong to no
option. PETSc gets what has been checked, name by name.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from fsipetsc.errors import FileError, InputError
from fsipetsc.options.option import brief

HELP_FLAGS = ("-h", "-help", "--help")
_FILE_OPTIONS = ("options_file", "options_file_yaml")
_YAML_SUFFIXES = (".yaml", ".yml", ".json", ":yaml")
#: files that PETSc reads in every run, in this order
RC_FILES = ("~/.petscrc", ".petscrc", "petscrc")
_SKIP_RC = "skip_petscrc"


class Given(NamedTuple):
    """An option as it was given: name without dash as spelt, text ("" if it has no value), and where, as " in …" or ""."""

    name: str
    text: str
    where: str


def is_option(word: str) -> bool:
    """PETSc's rule: one or two dashes and a letter. -10, -.5 and -inf are values."""
    return re.match(r"--?[A-Za-z]", word) is not None and word.lower() not in ("-inf", "-infinity", "-nan")


def given_options(arguments: Sequence[str], environment: Mapping[str, str] | None = None) -> dict[str, Given]:
    """Name in lower case -> option, of those given more than once the last; the command line comes last of all.

    arguments: the words behind the case's name. environment: os.environ if None, for PETSC_OPTIONS. Options files are
    opened where they are named. Raises InputError for a word that belongs to no option and for a malformed file, and
    FileError for a file that cannot be read, naming file and line.
    """
    words = (os.environ if environment is None else environment).get("PETSC_OPTIONS", "")
    found: list[Given] = []
    if f"-{_SKIP_RC}" not in arguments:
        for name in RC_FILES:
            if os.path.isfile(os.path.expanduser(name)):
                found += _of_file(name, ())
    found += _of_words(_cut(words, " in PETSC_OPTIONS"), " in PETSC_OPTIONS", ())
    found += _of_words(list(arguments), "", ())
    last = {option.name.lower(): option for option in found}
    last.pop(_SKIP_RC, None)
    return last


def _cut(text: str, where: str) -> list[str]:
    """A text cut at blanks, except within quotation marks, which are taken off."""
    lexer = shlex.shlex(text, posix=True)
    lexer.whitespace_split, lexer.commenters, lexer.escape = True, "", ""
    try:
        return list(lexer)
    except ValueError:
        raise InputError(f"a quotation mark that is never closed{where}: {brief(text)}") from None


def _of_words(words: Sequence[str], where: str, opened: tuple[str, ...]) -> Iterator[Given]:
    """The options that words stand for; opened: options files that are being read."""
    position = 0
    while position < len(words):
        word = words[position]
        if not is_option(word):
            raise InputError(f"unexpected argument '{brief(word)}'{where}: a value stands right behind its option")
        has_value = position + 1 < len(words) and not is_option(words[position + 1])
        value = words[position + 1] if has_value else ""
        position += 1 + has_value
        if word in HELP_FLAGS:
            if where:
                raise InputError(f"{word}{where} would be passed over: it is answered on the command line only")
            continue
        if word.startswith("--"):
            raise InputError(f"unknown option {brief(word)}{where}: write {brief(word[1:])}, with one dash")
        yield from _resolved(Given(word[1:], value, where), opened)


def _resolved(option: Given, opened: tuple[str, ...]) -> Iterator[Given]:
    """An option itself, or those in the file that it names."""
    lower = option.name.lower()
    if lower not in _FILE_OPTIONS:
        yield option
    elif not option.text:
        raise InputError(f"-{option.name}{option.where} needs the name of a file")
    else:
        yield from _of_file(option.text, opened, yaml=lower.endswith("yaml"))


def _of_file(name: str, opened: tuple[str, ...], yaml: bool = False) -> Iterator[Given]:
    """The options in a file, in PETSc's own format or in YAML."""
    if "\0" in name:
        raise InputError("the name of an options file holds a null character")
    path = os.path.expanduser(os.path.expandvars(name))
    yaml = yaml or path.endswith(_YAML_SUFFIXES)
    path = path.removesuffix(":yaml")
    if os.path.realpath(path) in opened:
        raise InputError(f"options file {path} names itself, or a file that names it")
    opened = (*opened, os.path.realpath(path))
    try:
        if os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path):
            raise FileError(f"options file {path}: not a regular file")  # a pipe would be waited for
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except (OSError, ValueError) as error:
        raise FileError(f"options file {path}: {getattr(error, 'strerror', error)}") from None
    if yaml or text.startswith(("%YAML ", "---")):
        yield from _of_yaml(path, text, opened)
        return
    for number, line in enumerate(text.splitlines(), 1):
        where = f" (options file {path}, line {number})"
        if not line.lstrip().startswith("!"):
            yield from _of_words(_line(line.split("#", 1)[0], where), where, opened)


def _line(text: str, where: str) -> list[str]:
    """The words of one line of an options file in PETSc's own format: none, or an option and perhaps its value."""
    words = _cut(text, where)
    if words and not is_option(words[0]):
        raise InputError(f"'{words[0]}' is not an option{where}; a line is '-name value'")
    if len(words) > 2 or (len(words) == 2 and is_option(words[1])):
        raise InputError(f"one option and its value a line, not '{' '.join(words)}'{where}")
    return words


def _of_yaml(path: str, text: str, opened: tuple[str, ...]) -> Iterator[Given]:
    """The options in a YAML text: names of nested mappings are joined with _, lists become texts with commas."""
    try:
        import yaml
    except ModuleNotFoundError:
        message = f"options file {path}: YAML needs the Python package PyYAML; or write lines '-name value', in another file"
        raise InputError(message) from None
    try:
        documents = list(yaml.compose_all(text, Loader=yaml.SafeLoader))
    except yaml.MarkedYAMLError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise InputError(f"options file {path}{line}: {error.problem}") from None
    except (yaml.YAMLError, RecursionError) as error:
        raise InputError(f"options file {path}: {' '.join(str(error).split())}") from None
    for document in documents:
        if document is not None:
            for option in _of_node(document, "", path):
                yield from _resolved(option, opened)


def _of_node(node: object, name: str, path: str) -> Iterator[Given]:
    """The options in a node of a YAML tree; name: the names that lead to it."""
    where = f" (options file {path}, line {node.start_mark.line + 1})"
    if node.id == "mapping":
        for key, value in node.value:
            if key.id != "scalar" or not re.fullmatch(r"[A-Za-z]\w*", key.value):
                raise InputError(f"a name of an option is expected{where}")
            yield from _of_node(value, f"{name}_{key.value}" if name else key.value, path)
    elif not name:
        raise InputError(f"'name: value' is expected{where}")
    elif node.id == "scalar":
        plain_null = node.tag.endswith(":null")
        yield Given(name, "" if plain_null else node.value, where)
    elif all(item.id == "scalar" for item in node.value):
        yield Given(name, ",".join(item.value for item in node.value), where)
    else:
        raise InputError(f"a list of numbers or words is expected for {name}{where}")
