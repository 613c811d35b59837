"""How far a run is and how long it has to go, from what its jobs were expected to take and what they have taken."""

import math
import re
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

UNKNOWN: Final = 2.0
"""Seconds that a job is expected to take of which nothing is known."""

_TRUSTED: Final = 0.2
"""How much of the plan counts as run in the time that was expected, lest the first jobs decide alone."""

_SMOOTHED: Final = 0.1
"""Time over which the end that is said follows the one that is expected, over that of the plan."""

_ALMOST: Final = 0.95
"""Share of a job that is done at most as long as it runs."""

_TAIL: Final = 400  # bytes at the end of a log, in which the last share stands


@dataclass
class Job:
    """A job that runs.

    Attributes
    ----------
    name : str
        Rule and wildcards, for the line.
    seconds : float
        Time that it is expected to take, s.
    weight : float
        Time that it is expected to add to the run, s.
    began : float
        When it began, s.
    logs : list of Path
        Its log files; a step that knows how far it is writes per cents there.
    """

    name: str
    seconds: float
    weight: float
    began: float
    logs: list[Path]

    def share(self, now: float, pace: float) -> float:
        """Share of it that is done: what its log says last, or else by the time that has gone at the pace so far."""
        for log in self.logs:
            with suppress(OSError), log.open("rb") as file:
                file.seek(max(log.stat().st_size - _TAIL, 0))
                if said := re.findall(rb"(\d+)%", file.read()):
                    return min(int(said[-1]) / 100, _ALMOST)
        return min((now - self.began) / max(self.seconds * pace, 1e-9), _ALMOST)


@dataclass
class Expected:
    """What a run is expected to take, and what it has taken.

    Jobs of one rule run beside each other, `at_once` of them at most; rules follow one another. So a job adds its
    expected time, divided by the number that run at once, to that of the run. The pace is the time taken over that
    expected for what is done; a part of the plan counts as done at the pace expected, so that it does not jump with the
    first jobs.

    Attributes
    ----------
    seconds : dict of float
        Expected time of a job of each rule, s; `UNKNOWN` where it is not known.
    at_once : int
        Jobs that run at the same time.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    at_once: int = 1
    steps: int = 0
    total: float = 0.0
    finished: int = 0
    done: float = 0.0
    began: float = 0.0
    _counts: dict[str, int] = field(default_factory=dict)
    _running: dict[int, Job] = field(default_factory=dict)
    _ends: float | None = None  # when the run ends, as last said
    _looked: float = 0.0

    @property
    def begun(self) -> bool:
        """Whether any jobs are planned."""
        return self.steps > 0

    def plan(self, counts: dict[str, int], now: float | None = None) -> None:
        """Take note of how many jobs of each rule there are."""
        self._counts, self.steps = counts, sum(counts.values())
        self.total = sum(count * self._weight(rule) for rule, count in counts.items())
        self.began = time.time() if now is None else now

    def begin(self, job: int, rule: str, name: str, logs: list[Path], now: float | None = None) -> None:
        """Take note of a job that begins."""
        began = time.time() if now is None else now
        self._running[job] = Job(name, self.seconds.get(rule, UNKNOWN), self._weight(rule), began, logs)

    def end(self, job: int, well: bool) -> None:
        """Take note of a job that has ended, well or not."""
        ended = self._running.pop(job, None)
        if ended is not None and well:
            self.finished += 1
            self.done += ended.weight

    def to_go(self, now: float) -> tuple[float, float]:
        """Share of the run that is done, and the time to go, s."""
        taken, done = now - self.began, self.done
        trusted = _TRUSTED * self.total
        pace = (taken + trusted) / (done + trusted) if done else 1.0
        done += sum(job.weight * job.share(now, pace) for job in list(self._running.values()))
        pace = (taken + trusted) / (done + trusted)
        ends = now + max(self.total - done, 0.0) * pace
        # Drawn towards what is known now, not set to it.
        drawn = 1.0 if self._ends is None else -math.expm1((self._looked - now) / max(_SMOOTHED * self.total, 1e-9))
        self._ends = ends if self._ends is None else self._ends + drawn * (ends - self._ends)
        self._looked = now
        return (done / self.total if self.total else 0.0), max(self._ends - now, 0.0)

    def line(self, now: float | None = None) -> str:
        """One line: steps, share of the work, time to go, and what runs."""
        share, seconds = self.to_go(time.time() if now is None else now)
        names = ", ".join(job.name for job in list(self._running.values()))
        return f"{self.finished} of {self.steps} steps, {share:.0%}, {clock(seconds)} to go: {names}".removesuffix(": ")

    def _weight(self, rule: str) -> float:
        return self.seconds.get(rule, UNKNOWN) / min(self._counts.get(rule, 1), self.at_once)


def clock(seconds: float) -> str:
    """Minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
