"""Exceptions for errors that a user can cause; each message names the fault, the value, the bound and the remedy."""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import wraps
from inspect import Parameter, signature
from typing import Any, Final, TypeVar, cast

Decorated = TypeVar("Decorated", bound=Callable[..., Any])

MAX_MESSAGE_LINES: Final = 20
"""Largest number of lines of a message; for longer ones the number of further lines is given."""

REASON_SEPARATOR: Final = "\n       "
"""Separator of reasons in one message: each starts on a new line, aligned with the text after ``error:``."""

MAX_MESSAGE_LINE_CHARACTERS: Final = 600
"""Largest number of characters in a line of a message."""

_CONTROL_CHARACTER_PATTERN: Final = re.compile(
    r"[^\x20-\x7e\xa0-\u2027\u202f-\u2065\u2070-\ud7ff\ue000-\U0010ffff\n\t]"
)


class OverturningError(Exception):
    """Base class of errors that a user can cause; the command line prints them without a traceback.

    Long quotations from files are shortened, and control characters, which could steer a terminal, are escaped.
    """

    def __str__(self) -> str:
        # Do not use the base class: FileNotFoundError formats its arguments as errno and file name.
        lines = _CONTROL_CHARACTER_PATTERN.sub(
            lambda sign: repr(sign[0])[1:-1], str(self.args[0]) if self.args else ""
        ).split("\n")
        more = [f"       … and {len(lines) - MAX_MESSAGE_LINES} more lines"] if len(lines) > MAX_MESSAGE_LINES else []
        half = MAX_MESSAGE_LINE_CHARACTERS // 2
        short = [
            line if len(line) <= MAX_MESSAGE_LINE_CHARACTERS else f"{line[:half]} … {line[-half:]}"
            for line in lines[:MAX_MESSAGE_LINES]
        ]
        return "\n".join(short + more)


class ArgumentError(OverturningError, ValueError):
    """Raised if an argument is invalid. The message names argument, value and bound."""


class ConfigError(OverturningError, ValueError):
    """Raised if a configuration file or record table is invalid. The message names file, key, value and remedy."""


class RecordError(OverturningError, ValueError):
    """Raised if a record file cannot be read or contradicts itself. The message names file, line and remedy."""


def closest_name_hint(unknown_name: str, known_names: Iterable[str], hint_if_none_is_close: str = "") -> str:
    """Return a hint for an error message: the known name closest to an unknown one, or all known names."""
    names = list(known_names)
    near = difflib.get_close_matches(unknown_name, names, n=1)
    return f"did you mean {near[0]}?" if near else hint_if_none_is_close or f"known are {', '.join(names[:40])}"


def refuse_unknown_keywords(*further_accepted_keywords: type | str) -> Callable[[Decorated], Decorated]:
    """Return a decorator that makes a function or class refuse unknown keywords, and name the closest known one.

    `further_accepted_keywords` are keywords that the function passes on: names, or dataclasses with fields so named.
    """

    def add_keyword_check(function_or_class: Decorated) -> Decorated:
        """Return the function or class with a check of its keywords at each call."""
        if isinstance(function_or_class, type):
            function_or_class.__init__ = add_keyword_check(function_or_class.__init__)  # type: ignore[misc]
            return function_or_class
        own = signature(function_or_class).parameters.values()
        several = (Parameter.VAR_KEYWORD, Parameter.VAR_POSITIONAL)
        known = [one.name for one in own if one.kind not in several and one.name not in ("self", "cls")]
        for more in further_accepted_keywords:
            known += [more] if isinstance(more, str) else [field.name for field in fields(more)]

        @wraps(function_or_class)
        def check_keywords_and_call(*arguments: Any, **keywords: Any) -> Any:
            for name in keywords.keys() - known:
                whose = function_or_class.__qualname__.removesuffix(".__init__")
                raise ArgumentError(f"{name}: no keyword of {whose}; {closest_name_hint(name, known)}")
            return function_or_class(*arguments, **keywords)

        return cast(Decorated, check_keywords_and_call)

    return add_keyword_check


class RecordRefusalReasonCollector:
    """Collector of the reasons for which several checks refuse a record, so that they are reported together."""

    def __init__(self) -> None:
        self._found: list[str] = []

    @contextmanager
    def suppress_record_error_and_keep_reasons(self) -> Iterator[None]:
        """Context manager that suppresses a RecordError raised in its block and stores the reasons of the error."""
        try:
            yield
        except RecordError as problem:
            self._found += str(problem).split(REASON_SEPARATOR)

    def raise_collected_reasons(self) -> None:
        """Raise a RecordError with a line for each stored reason; do nothing if there is none."""
        if self._found:
            raise RecordError(REASON_SEPARATOR.join(dict.fromkeys(self._found)))


class MissingDataError(OverturningError, FileNotFoundError):
    """Raised if data from the user are missing. The message names the data, their source and where to put them."""


class ResultError(OverturningError):
    """Raised if a result file is missing, incomplete or from another version."""
