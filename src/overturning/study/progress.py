"""The log of a step: how far it is, in per cents, and the error that ends it."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from overturning.errors import OverturningError
from overturning.files import describe

_INTERVAL = 1.0  # s, between two lines


@contextmanager
def logged_to(path: Path | None) -> Iterator[Callable[[str], None]]:
    """Lines, by the function yielded, and an error that ends the block go into a log; without one, to standard error."""
    if path is None:
        yield lambda line: print(line, file=sys.stderr)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", buffering=1) as log:
        try:
            yield lambda line: print(line, file=log)
        except (OverturningError, OSError) as error:
            with suppress(OSError):  # the disk is full
                print(f"error: {(isinstance(error, OSError) and describe(error)) or error}", file=log)
            raise


def percents(say: Callable[[str], None]) -> Callable[[int, int], None]:
    """What takes note of the work done and all of it, and says each per cent, but one a second; the run's progress line reads it."""
    last, said = time.monotonic(), 0

    def progress(done: int, total: int) -> None:
        nonlocal last, said
        now, share = time.monotonic(), 100 * done // total if total else 100
        if share > said and now - last >= _INTERVAL:
            last, said = now, share
            say(f"{share}%")

    return progress
