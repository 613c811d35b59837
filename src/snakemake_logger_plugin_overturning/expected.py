"""Progress of a run: completed steps, share of the expected work, and remaining time at the pace so far."""

import re
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

UNKNOWN: Final = 2.0
"""Expected time of a job whose rule has no estimate, s."""

_TRUSTED: Final = 0.05
"""Share of the work up to which the remaining time comes from the expected pace, not from the measured one."""

_ALMOST: Final = 0.95
"""Largest share of a running job that counts as completed."""

_TAIL: Final = 400
"""Bytes at the end of a log that are searched for a percentage."""


@dataclass
class RunningJob:
    """Job of the workflow that is running: its name, expected time and log files.

    Attributes
    ----------
    name : str
        Rule and wildcards.
    work : float
        Expected time, s.
    logs : list of Path
        Log files; a step that knows its progress writes percentages there.
    """

    name: str
    work: float
    logs: list[Path]

    def completed_share(self) -> float:
        """Return the completed share of the job, from the last percentage in its log; 0 if there is none."""
        for log in self.logs:
            with suppress(OSError), log.open("rb") as file:
                file.seek(max(log.stat().st_size - _TAIL, 0))
                if shares := re.findall(rb"(\d+)%", file.read()):
                    return min(int(shares[-1]) / 100, _ALMOST)
        return 0.0


@dataclass
class RunProgressEstimate:
    """Progress of a workflow run: the expected and the completed work, in expected seconds of its jobs.

    Attributes
    ----------
    seconds : dict of float
        Expected time of a job of each rule, s; `UNKNOWN` for others.
    at_once : int
        Number of jobs that run at the same time.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    at_once: int = 1
    steps: int = 0
    finished: int = 0
    _began: float = 0.0
    _planned: float = 0.0  # expected seconds of all jobs
    _done: float = 0.0  # expected seconds of the jobs that ended
    _running: dict[int, RunningJob] = field(default_factory=dict)

    def store_run_start_and_job_counts(self, counts: dict[str, int], now: float | None = None) -> None:
        """Begin a run: store its start time and the number of jobs of each rule."""
        self.steps = sum(counts.values())
        self._planned = sum(count * self.seconds.get(rule, UNKNOWN) for rule, count in counts.items())
        self._began = time.time() if now is None else now

    def store_job_start(self, job: int, rule: str, name: str, logs: list[Path], size: float = 1.0) -> None:
        """Store a job that begins; `size` is that of its input relative to the mean of the jobs of its rule."""
        self._running[job] = RunningJob(name, size * self.seconds.get(rule, UNKNOWN), logs)

    def store_job_end(self, job: int, well: bool) -> None:
        """Store the end of a job; its work counts as completed if the job was successful."""
        ended = self._running.pop(job, None)
        if ended is not None and well:
            self.finished += 1
            self._done += ended.work

    def completed_share_and_remaining_time(self, now: float) -> tuple[float, float]:
        """Return the completed share of the work, and the remaining time, s."""
        running = sum(job.completed_share() * job.work for job in list(self._running.values()))
        done = min((self._done + running) / max(self._planned, 1e-9), 1.0)
        pace = self._planned / self.at_once if done < _TRUSTED else (now - self._began) / done
        return done, max(pace * (1.0 - done), 0.0)

    def progress_line(self, now: float | None = None) -> str:
        """Return the progress as one line: steps, share of the work, remaining time, and the running jobs."""
        share, seconds = self.completed_share_and_remaining_time(time.time() if now is None else now)
        names = ", ".join(job.name for job in list(self._running.values()))
        time_left = format_minutes_and_seconds(seconds)
        return f"{self.finished} of {self.steps} steps, {share:.0%}, {time_left} to go: {names}".removesuffix(": ")


def format_minutes_and_seconds(seconds: float) -> str:
    """Return a time given in seconds as text of minutes and seconds, such as 3:20."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
