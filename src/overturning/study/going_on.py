"""Going on after an earlier run: alone in the folder, with results that are whole and no older than they are."""

import fcntl
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from overturning.errors import ResultError
from overturning.files import whole
from overturning.study.members import read_members
from overturning.study.own_error_file import read_verification
from overturning.study.timing import block_steps_of

DAMAGED: Final = "damaged, is made again: "
"""What a line begins with that names a file taken away by `mend`."""

_HELD: Final = "OVERTURNING_HOLDS"
_TABLES: Final[dict[str, Callable[[Path], Any]]] = {
    "members.csv": read_members,
    "verification.json": read_verification,
    "sweep/**/*.csv": block_steps_of,
}
_AHEAD: Final = 2.0  # s by which the clocks of a file system and of the processor may differ


def hold(lock: Path) -> int | None:
    """Hold a folder by a lock file as long as this process lives, and wait for steps that outlived an earlier run.

    The lock is the kernel's: it goes with the last process that has the file open, however that ends, so that there is
    never anything to unlock. A process that was started by one that holds the folder is part of the same run.

    Returns
    -------
    int or None
        The descriptor of the file, for a child to inherit; None where an earlier process of this run holds the folder,
        or the file system has no locks.

    Raises
    ------
    ResultError
        If another run holds the folder; one sentence with its process.
    """
    folder = str(lock.resolve().parent)
    if os.environ.get(_HELD) == folder:
        lock.write_text(str(os.getpid()), encoding="utf-8")  # whom to stop, should the other be killed
        return None
    lock.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = os.read(descriptor, 20).decode(errors="replace") or "?"
        os.close(descriptor)
        raise ResultError(
            f"another run works in this folder (process {holder}); wait for it, or stop it and run again"
        ) from None
    except OSError:  # a file system without locks
        os.close(descriptor)
        return None
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, str(os.getpid()).encode(), 0)
    os.environ[_HELD] = folder
    _wait_for_steps(Path.cwd())
    return descriptor


def _steps_at_work(folder: Path) -> Iterator[int]:
    """Processes of steps that write results of a folder."""
    import psutil

    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):
            words = process.cmdline()
            program = any(Path(word).name == "overturning" for word in words[:2])
            if program and any(word.startswith("results/") for word in words) and Path(process.cwd()) == folder:
                yield process.pid


def _wait_for_steps(folder: Path) -> None:
    said = None
    while step := next(_steps_at_work(folder), None):
        if step != said:
            print(f"A step of a killed run is still at work (process {step}); waiting for it.", file=sys.stderr)
            said = step
        time.sleep(0.2)


def mend(results: Path) -> list[Path]:
    """Take away what is damaged or half-written among the results of a study, so that it is made again.

    Times that lie ahead, because the clock was set back, are put just before now, in their order: what is made from such
    a file is then newer than it.

    Returns
    -------
    list of Path
        The damaged files.
    """
    for left in results.rglob(".*.part"):
        left.unlink(missing_ok=True)
    damaged = [path for path in sorted(results.rglob("*.nc")) if path.name[0] != "." and not whole(path)]
    for pattern, read in _TABLES.items():
        for path in sorted(results.glob(pattern)):
            try:
                read(path)
            except ResultError:
                damaged.append(path)
    for path in damaged:
        path.unlink(missing_ok=True)
    _back_from_ahead(results)
    return damaged


def _back_from_ahead(results: Path) -> None:
    now = time.time()
    times = {path: path.lstat().st_mtime for path in results.rglob("*") if path.is_file()}
    ahead = sorted((path for path in times if times[path] > now + _AHEAD), key=lambda path: times[path])
    for rank, path in enumerate(ahead):
        moment = now - 1e-3 * (len(ahead) - rank)
        os.utime(path, (moment, moment))
