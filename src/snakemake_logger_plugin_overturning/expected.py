"""How far a run is and how long it has to go, from the work that its jobs have done and have yet to do."""

import math
import re
import time
from collections import Counter, defaultdict
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

UNKNOWN: Final = 2.0
"""Seconds that a job is expected to take of which nothing is known."""

_TRUSTED: Final = 0.5
"""How much of the plan counts as run in the time that was expected, lest the first jobs decide alone."""

_SMOOTHED: Final = 0.1
"""Time over which the time that is said follows a shorter one that is expected, over that of the plan."""

_LONGER: Final = 1.5
"""How many times longer than said the time to go must be for more to be said: the run is not what it seemed."""

_ALMOST: Final = 0.95
"""Share of a job that is done at most as long as it runs."""

_TAIL: Final = 400  # bytes at the end of a log, in which the last share stands


@dataclass
class Job:
    """A job that runs.

    Attributes
    ----------
    rule, name : str
        Its rule, and rule and wildcards for the line.
    size : float
        Its work over that of the mean job of its rule.
    began : float
        When it began, s.
    logs : list of Path
        Its log files; a step that knows how far it is writes per cents there.
    """

    rule: str
    name: str
    size: float
    began: float
    logs: list[Path]

    def said(self) -> float | None:
        """Share of it that is done, as its log says last."""
        for log in self.logs:
            with suppress(OSError), log.open("rb") as file:
                file.seek(max(log.stat().st_size - _TAIL, 0))
                if shares := re.findall(rb"(\d+)%", file.read()):
                    return min(int(shares[-1]) / 100, _ALMOST)
        return None


@dataclass
class Expected:
    """What a run is expected to take, and what it has taken.

    The work of a rule is counted in mean jobs. What a mean job takes is learned from those that have ended and from
    what running ones say in their logs; until then it is the expected time at the pace of the other rules. Jobs of one
    rule run beside each other, `at_once` of them at most; rules follow one another. The time that is said falls as the
    work does and rises only where it was far too short.

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
    finished: int = 0
    _began: float = 0.0
    _counts: Counter[str] = field(default_factory=Counter)  # jobs of each rule that have not ended
    _waiting: dict[str, float] = field(default_factory=dict)  # work of each rule that has not begun
    _taken: dict[str, float] = field(
        default_factory=lambda: defaultdict(float)
    )  # seconds that ended jobs of each rule took
    _done: dict[str, float] = field(default_factory=lambda: defaultdict(float))  # their work
    _running: dict[int, Job] = field(default_factory=dict)
    _planned: float = 0.0  # seconds of all jobs
    _said: tuple[float, float] | None = None  # when, and which time to go

    def plan(self, counts: dict[str, int], now: float | None = None) -> None:
        """Take note of how many jobs of each rule there are."""
        self._counts, self._waiting, self.steps = Counter(counts), {**counts}, sum(counts.values())
        self._planned = sum(count * self.seconds.get(rule, UNKNOWN) for rule, count in counts.items())
        self._began = time.time() if now is None else now

    def begin(
        self, job: int, rule: str, name: str, logs: list[Path], size: float = 1.0, now: float | None = None
    ) -> None:
        """Take note of a job that begins, with its work over that of the mean job of its rule."""
        left, begun = self._waiting.get(rule, 1.0), sum(one.rule == rule for one in list(self._running.values()))
        size = left if self._counts[rule] - begun <= 1 else min(size, left)  # the last one takes what is left
        self._waiting[rule] = left - size
        self._running[job] = Job(rule, name, size, time.time() if now is None else now, logs)

    def end(self, job: int, well: bool, now: float | None = None) -> None:
        """Take note of a job that has ended, well or not."""
        if (ended := self._running.pop(job, None)) is None:
            return
        self._counts[ended.rule] -= 1
        if well:
            self.finished += 1
            self._taken[ended.rule] += (time.time() if now is None else now) - ended.began
            self._done[ended.rule] += ended.size

    def to_go(self, now: float) -> tuple[float, float]:
        """Share of the time that has gone, and the time to go, s."""
        left, before = self._left(now), self._said
        if before is not None:
            gone = now - before[0]
            falling = before[1] * max(1.0 - gone / max(left, 1e-9), 0.0)
            off = left - falling if not falling < left < _LONGER * falling + UNKNOWN else 0.0
            left = falling - off * math.expm1(-gone / max(_SMOOTHED * (now - self._began + left), 1e-9))
        self._said = now, left
        return (now - self._began) / max(now - self._began + left, 1e-9), left

    def line(self, now: float | None = None) -> str:
        """One line: steps, share of the time, time to go, and what runs."""
        share, seconds = self.to_go(time.time() if now is None else now)
        names = ", ".join(job.name for job in list(self._running.values()))
        return f"{self.finished} of {self.steps} steps, {share:.0%}, {clock(seconds)} to go: {names}".removesuffix(": ")

    def _left(self, now: float) -> float:
        """Time that the work to be done takes, s, as far as is known now."""
        running = [(job, now - job.began, job.said()) for job in list(self._running.values())]
        taken, done = self._taken.copy(), self._done.copy()
        for job, gone, share in running:
            if share is not None:
                taken[job.rule] += gone
                done[job.rule] += share * job.size
        expected = {rule: self.seconds.get(rule, UNKNOWN) for rule in self._counts}
        trusted = _TRUSTED * self._planned
        pace = (sum(taken.values()) + trusted) / max(sum(done[rule] * expected[rule] for rule in done) + trusted, 1e-9)
        left = 0.0
        for rule, count in self._counts.items():
            each = (taken[rule] + pace * expected[rule]) / (done[rule] + 1.0)
            parts = [
                max(job.size * each * (1.0 - share) if share is not None else job.size * each - gone, 0.0)
                for job, gone, share in running
                if job.rule == rule
            ]
            work = self._waiting[rule] * each + sum(parts)
            left += max([work / max(min(count, self.at_once), 1), *parts])
        return left


def clock(seconds: float) -> str:
    """Minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
