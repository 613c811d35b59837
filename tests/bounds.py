"""Bounds within which any input must be read or refused."""

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PROCESS_MEMORY_FILE = Path("/proc/self/statm")
CAN_LIMIT_TIME_AND_MEMORY = hasattr(signal, "setitimer") and PROCESS_MEMORY_FILE.exists()


def raise_time_limit_error(_signal: int, _frame: object) -> None:
    """Raise an error when the timer signals that the processor time is used up."""
    raise AssertionError("ten seconds for one file")


@contextmanager
def limited_time_and_memory(seconds: float = 10.0) -> Iterator[None]:
    """Limit a `with` block to `seconds` of processor time and 1 GB of further memory, where the system can."""
    if not CAN_LIMIT_TIME_AND_MEMORY:
        yield
        return
    now = int(PROCESS_MEMORY_FILE.read_text().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGPROF, raise_time_limit_error)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    resource.setrlimit(resource.RLIMIT_AS, (now + 1_000_000_000, hard))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
