"""Helpers: expected errors, exit status of commands, and required tools."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from typing import NoReturn

import pytest

from overturning.cli import main


@contextmanager
def refused(kind: type[Exception], *words: str, brief: bool = False) -> Iterator[None]:
    """Expect an error whose message holds all the words; where it is to be brief, on one line."""
    with pytest.raises(kind) as problem:
        yield
    message = str(problem.value)
    assert [word for word in words if word not in message] == [], message
    assert not brief or "\n" not in message


def said(*words: object, status: int = 0) -> str:
    """Run `overturning`, check its exit status, and return the output of both streams."""
    with redirect_stdout(StringIO()) as text, redirect_stderr(text), pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    assert (end.value.code or 0) == status, text.getvalue()
    return text.getvalue()


def lacking(reason: str) -> NoReturn:
    """Skip a test that lacks something of its surroundings; fail it where nothing may skip."""
    (pytest.fail if "OVERTURNING_NO_SKIP" in os.environ else pytest.skip)(reason)
    raise AssertionError


def every_or_first(targets: Sequence[str]) -> Sequence[str]:
    """The instruction sets to compile for beside the machine's own: one, since each takes a cold compile of its own.

    All of them where ``OVERTURNING_EVERY_TARGET`` is set, as by ``make verify``.
    """
    return targets if "OVERTURNING_EVERY_TARGET" in os.environ else targets[:1]
