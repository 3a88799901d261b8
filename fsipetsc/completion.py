"""What the Tab key completes in a shell: cases, commands, options and what they allow, from the table of options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fsipetsc.errors import InputError
from fsipetsc.options import Option

SHELLS = ("bash", "zsh")
#: suffix of the files that a first word wants, by command; a case file where a case is wanted
_FILES = {"info": "h5", "plot": "h5", "report": "h5", "diff": "h5", "flutter": "h5", "new": "py", "convergence": "py"}
_SCRIPT = """\
# Completion of fsipetsc and scripts/run for {shell}:  eval "$(fsipetsc completion {shell})"
{first}_fsipetsc() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} offered= files=
    COMPREPLY=()
    if [ "$COMP_CWORD" = 1 ]; then
        offered='{firsts}' files=py
    else
        case $previous in
{choices}
        {values}) return ;;
        esac
        if [ -z "$offered" ]; then
            case ${{COMP_WORDS[1]}} in
{options}
            *) offered='{common}' ;;
            esac
            case ${{COMP_WORDS[1]}} in
{files}
            esac
        fi
    fi
    case $word in -*) files= ;; esac
    COMPREPLY=($(compgen -W "$offered" -- "$word"))
    if [ -n "$files" ]; then
        COMPREPLY+=($(compgen -f -X "!*.$files" -- "$word") $(compgen -d -- "$word"))
    fi
}}
complete -o default -F _fsipetsc fsipetsc scripts/run
"""


def script(
    shell: str,
    cases: Mapping[str, Sequence[Option]],
    commands: Mapping[str, Sequence[Option]],
    flags: Mapping[str, Mapping[str, str | None]],
) -> str:
    """A program for a shell that reads it in; cases, commands: name -> its options. InputError for another shell.

    flags: name of a command -> options of its own, "-name" -> what stands behind, None for nothing.
    """
    if shell not in SHELLS:
        raise InputError(f"completion: there is none for '{shell}': expected {' or '.join(SHELLS)}")
    common = set.intersection(*({option.name for option in options} for options in cases.values()))
    known = {option.name: option for options in (*cases.values(), *commands.values()) for option in options}
    choices = {f"-{name}": map(str, option.choices) for name, option in known.items() if option.choices}
    choices |= {f"-{name}": ("true", "false") for name, option in known.items() if option.kind == "bool"}
    values = [f"-{name}" for name, option in known.items() if option.needs_value and not option.choices]
    values += {flag for those in flags.values() for flag, behind in those.items() if behind is not None}
    own = {
        name: _words(*(option.name for option in options), *(flag[1:] for flag in flags.get(name, ())))
        for name, options in {**cases, **commands}.items()
    }
    return _SCRIPT.format(
        shell=shell,
        first="autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else "",
        firsts=" ".join((*cases, *commands)),
        choices="\n".join(f"        {name}) offered='{' '.join(words)}' ;;" for name, words in sorted(choices.items())),
        values="|".join(sorted(values)),
        options="\n".join(f"            {name}) offered='{words}' ;;" for name, words in own.items()),
        common=_words(*common),
        files="\n".join(f"            {name}) files={suffix} ;;" for name, suffix in _FILES.items()),
    )


def _words(*names: str) -> str:
    return " ".join(sorted(f"-{name}" for name in {*names, "help"}))
