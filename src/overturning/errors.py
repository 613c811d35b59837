"""The exceptions a user can meet. Each message names what is wrong, the value, the bound and the remedy."""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import wraps
from inspect import Parameter, signature
from typing import Any, Final, TypeVar, cast

Decorated = TypeVar("Decorated", bound=Callable[..., Any])

MOST_LINES: Final = 20
"""Lines of a message; of more their number."""

REASON_SEPARATOR: Final = "\n       "
"""Between reasons that are told at once: each on a line of its own, below the word ``error:``."""

LONGEST_LINE: Final = 600
"""Characters of a line of a message, whatever the file or name is that it tells about."""

_CONTROL: Final = re.compile(r"[^\x20-\x7e\xa0-\u2027\u202f-\u2065\u2070-\ud7ff\ue000-\U0010ffff\n\t]")


class OverturningError(Exception):
    """Base of every error that a user can cause; the command line prints it in one or two lines, without a traceback.

    What a message quotes of a stranger's file is cut where it is long, and signs that would steer a terminal are spelt
    out.
    """

    def __str__(self) -> str:
        # FileNotFoundError would format its arguments as errno and file name.
        lines = _CONTROL.sub(lambda sign: repr(sign[0])[1:-1], str(self.args[0]) if self.args else "").split("\n")
        more = [f"       … and {len(lines) - MOST_LINES} more lines"] if len(lines) > MOST_LINES else []
        half = LONGEST_LINE // 2
        short = [
            line if len(line) <= LONGEST_LINE else f"{line[:half]} … {line[-half:]}" for line in lines[:MOST_LINES]
        ]
        return "\n".join(short + more)


class ArgumentError(OverturningError, ValueError):
    """An argument is outside its bounds. The message names argument, value and bound."""


class ConfigError(OverturningError, ValueError):
    """A configuration file or record table is wrong. The message names file, key, value and remedy."""


class RecordError(OverturningError, ValueError):
    """A record file cannot be read or contradicts itself. The message names file, line and remedy."""


def did_you_mean(name: str, known: Iterable[str], remedy: str = "") -> str:
    """The end of a message about a name that is none of those known: the nearest, else the remedy, or what is known."""
    names = list(known)
    near = difflib.get_close_matches(name, names, n=1)
    return f"did you mean {near[0]}?" if near else remedy or f"known are {', '.join(names[:40])}"


def suggest_keywords(*further: type | str) -> Callable[[Decorated], Decorated]:
    """Let a function, or the constructor of a class, answer a keyword that it does not have with the nearest.

    `further` names keywords that are passed on, one by one or as a dataclass whose fields are keywords.
    """

    def decorate(face: Decorated) -> Decorated:
        if isinstance(face, type):
            face.__init__ = decorate(face.__init__)  # type: ignore[misc]
            return face
        own = signature(face).parameters.values()
        several = (Parameter.VAR_KEYWORD, Parameter.VAR_POSITIONAL)
        known = [one.name for one in own if one.kind not in several and one.name not in ("self", "cls")]
        for more in further:
            known += [more] if isinstance(more, str) else [field.name for field in fields(more)]

        @wraps(face)
        def checked(*given: Any, **named: Any) -> Any:
            for name in named.keys() - known:
                whose = face.__qualname__.removesuffix(".__init__")
                raise ArgumentError(f"{name}: no keyword of {whose}; {did_you_mean(name, known)}")
            return face(*given, **named)

        return cast(Decorated, checked)

    return decorate


class RefusalReasons:
    """Why a record is refused: what each of several checks has against it, told at once."""

    def __init__(self) -> None:
        self._found: list[str] = []

    @contextmanager
    def collect(self) -> Iterator[None]:
        """Go on after a check that refuses, which may name several reasons itself."""
        try:
            yield
        except RecordError as problem:
            self._found += str(problem).split(REASON_SEPARATOR)

    def raise_all(self) -> None:
        """Raise a RecordError with a line for each reason; nothing where there is none."""
        if self._found:
            raise RecordError(REASON_SEPARATOR.join(dict.fromkeys(self._found)))


class MissingDataError(OverturningError, FileNotFoundError):
    """Data that the user has to provide is not there. The message says which, from where, and where to put it."""


class ResultError(OverturningError):
    """A result file is missing, incomplete or of another version."""
