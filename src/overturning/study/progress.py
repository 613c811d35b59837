"""How far a sweep is and how long it has to go: one line on a terminal for all its jobs, quiet lines in a log."""

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from overturning.errors import OverturningError
from overturning.files import said_of

_SCREEN_INTERVAL = 0.5
_LOG_INTERVAL = 10.0


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
                print(f"error: {(isinstance(error, OSError) and said_of(error)) or error}", file=log)
            raise


class Progress:
    """Progress of one part of a sweep, seen together with those that run beside it.

    Each job keeps its share in a small file beside the parts, in their `folder`; the one that writes last draws the line, so
    that several jobs do not draw over one another. The time to go is read off the share done since the first job of this
    run began. `part` names that of this job, one of `parts`; `say` writes a line to the log.
    """

    def __init__(self, folder: Path, part: str, parts: int, say: Callable[[str], None]) -> None:
        self._folder = folder / ".progress"
        self._file = self._folder / part
        self._part, self._parts, self._say = part, parts, say
        self._begin = self._screen = self._log = time.time()

    def __enter__(self) -> Self:
        self._folder.mkdir(parents=True, exist_ok=True)
        self._say(f"{self._part}: begins")
        self._keep(0.0)
        return self

    def __call__(self, done: int, total: int) -> None:
        """Take note of the work done so far, in block steps."""
        now = time.time()
        share = done / total if total else 1.0
        if now - self._screen >= _SCREEN_INTERVAL:
            self._screen = now
            self._keep(share)
            self._draw(now)
        if now - self._log >= _LOG_INTERVAL:
            self._log = now
            self._say(
                f"{self._part}: {share:.0%}, {_clock((now - self._begin) * (1 - share) / max(share, 1e-9))} to go"
            )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._keep(1.0)
            self._draw(time.time())
            self._say(f"{self._part}: done in {_clock(time.time() - self._begin)}")
        else:
            self._file.unlink(missing_ok=True)

    def _keep(self, share: float) -> None:
        self._file.write_text(
            json.dumps({"share": share, "begin": self._begin, "parts": self._parts}), encoding="utf-8"
        )

    def _draw(self, now: float) -> None:
        if not sys.stderr.isatty():
            return
        print(f"\r\x1b[K{overall(_states(self._folder), self._parts, now)}", end="", file=sys.stderr, flush=True)


def _states(folder: Path) -> list[dict[str, float]]:
    states = []
    for file in folder.iterdir():
        with suppress(OSError, ValueError):  # another job is just writing it
            states.append(json.loads(file.read_text(encoding="utf-8")))
    return states


def sweep_line(results: Path, since: float) -> str:
    """How far the sweep is that last moved since a time, of all studies in a folder; empty where none has or all are done."""
    moved = {
        max((file.stat().st_mtime for file in folder.iterdir()), default=0.0): folder
        for folder in results.glob("*/sweep/*/.progress")
    }
    if not moved or max(moved) < since:
        return ""
    states = _states(moved[max(moved)])
    parts = max((int(state.get("parts", 1)) for state in states), default=1)
    return overall(states, parts, time.time()) if any(state["share"] < 1 for state in states) else ""


def overall(states: list[dict[str, float]], parts: int, now: float) -> str:
    """One line for a whole sweep, from the ``share`` done and time ``begin`` (s) of each of the parts that has begun."""
    done = sum(state["share"] for state in states) / parts
    # Parts of an earlier run, long done, would make the time to go too short: only what began since the oldest
    # unfinished part began is speed of this run; where none is unfinished, nothing is to go.
    running = [state["begin"] for state in states if state["share"] < 1]
    line = f"sweep: {sum(state['share'] >= 1 for state in states)} of {parts} parts, {done:.0%}"
    if not running or done >= 1:
        return line
    first = min(running)
    recent = [state for state in states if state["begin"] >= first]
    speed = sum(state["share"] for state in recent) / parts / max(now - first, 1e-3)
    return f"{line}, {_clock((1 - done) / speed)} to go" if speed > 0 else line


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
