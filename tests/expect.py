"""Helpers: expected errors, exit status of commands, and required tools."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from typing import NoReturn

import pytest

from overturning.cli import main


@contextmanager
def expect_error(kind: type[Exception], *words: str, brief: bool = False) -> Iterator[None]:
    """Require an error of a class whose message contains all words, in a single line if `brief`."""
    with pytest.raises(kind) as problem:
        yield
    message = str(problem.value)
    assert [word for word in words if word not in message] == [], message
    assert not brief or "\n" not in message


def run_overturning_and_return_printed_text(*words: object, status: int = 0) -> str:
    """Run the command `overturning`, check its exit status, and return its standard output and error as one text."""
    with redirect_stdout(StringIO()) as text, redirect_stderr(text), pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    assert (end.value.code or 0) == status, text.getvalue()
    return text.getvalue()


def skip_test_unless_skipping_is_forbidden(reason: str) -> NoReturn:
    """Skip a test whose environment lacks a requirement; fail it if ``OVERTURNING_NO_SKIP`` is set."""
    (pytest.fail if "OVERTURNING_NO_SKIP" in os.environ else pytest.skip)(reason)
    raise AssertionError


def other_instruction_sets_to_compile_for(targets: Sequence[str]) -> Sequence[str]:
    """Return the first of `targets`, the instruction sets other than that of this machine, as compiling is slow.

    All are returned if ``OVERTURNING_EVERY_TARGET`` is set, as by ``make verify``.
    """
    return targets if "OVERTURNING_EVERY_TARGET" in os.environ else targets[:1]
