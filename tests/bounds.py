"""Bounds within which any input must be read or refused."""

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

STATM = Path("/proc/self/statm")
IS_BOUNDED = hasattr(signal, "setitimer") and STATM.exists()


def ring(_signal: int, _frame: object) -> None:
    raise AssertionError("ten seconds for one file")


@contextmanager
def bounded(seconds: float = 10.0) -> Iterator[None]:
    """Not more than 10 s of processor time or 1 GB: by a timer and a limit on the address space where they exist."""
    if not IS_BOUNDED:
        yield
        return
    now = int(STATM.read_text().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    resource.setrlimit(resource.RLIMIT_AS, (now + 1_000_000_000, hard))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
