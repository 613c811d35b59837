"""Progress of a run: completed steps, share of the expected work, and remaining time at the pace so far."""

import re
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

EXPECTED_SECONDS_OF_JOB_WITHOUT_ESTIMATE: Final = 2.0
"""Expected time of a job whose rule has no estimate, s."""

_MIN_COMPLETED_SHARE_TO_USE_MEASURED_PACE: Final = 0.05
"""Share of the work up to which the remaining time comes from the expected pace, not from the measured one."""

_MAX_COMPLETED_SHARE_OF_RUNNING_JOB: Final = 0.95
"""Largest share of a running job that counts as completed."""

_LOG_TAIL_BYTES_SEARCHED_FOR_PERCENTAGE: Final = 400
"""Bytes at the end of a log that are searched for a percentage."""


@dataclass
class RunningJob:
    """Job of the workflow that is running: its name, expected time and log files.

    Attributes
    ----------
    rule_and_wildcards : str
        Rule and wildcards of the job, as one text.
    expected_seconds : float
        Expected time, s.
    logs : list of Path
        Log files; a step that knows its progress writes percentages there.
    """

    rule_and_wildcards: str
    expected_seconds: float
    logs: list[Path]

    def completed_share(self) -> float:
        """Return the completed share of the job, from the last percentage in its log; 0 if there is none."""
        for log in self.logs:
            with suppress(OSError), log.open("rb") as file:
                file.seek(max(log.stat().st_size - _LOG_TAIL_BYTES_SEARCHED_FOR_PERCENTAGE, 0))
                if shares := re.findall(rb"(\d+)%", file.read()):
                    return min(int(shares[-1]) / 100, _MAX_COMPLETED_SHARE_OF_RUNNING_JOB)
        return 0.0


@dataclass
class RunProgressEstimate:
    """Progress of a workflow run: the expected and the completed work, in expected seconds of its jobs.

    Attributes
    ----------
    expected_job_seconds_by_rule : dict of float
        Expected time of a job of each rule, s; a missing rule has `EXPECTED_SECONDS_OF_JOB_WITHOUT_ESTIMATE`.
    parallel_job_count : int
        Number of jobs that run at the same time.
    """

    expected_job_seconds_by_rule: dict[str, float] = field(default_factory=dict)
    parallel_job_count: int = 1
    total_job_count: int = 0
    finished_job_count: int = 0
    _start_time_s: float = 0.0
    _expected_seconds_of_all_jobs: float = 0.0  # expected seconds of all jobs
    _expected_seconds_of_finished_jobs: float = 0.0  # expected seconds of the jobs that ended
    _running_jobs: dict[int, RunningJob] = field(default_factory=dict)

    def store_run_start_and_job_counts(
        self, job_count_by_rule: dict[str, int], current_time_s: float | None = None
    ) -> None:
        """Begin a run: store its start time and the number of jobs of each rule."""
        self.total_job_count = sum(job_count_by_rule.values())
        self._expected_seconds_of_all_jobs = sum(
            count * self.expected_job_seconds_by_rule.get(rule, EXPECTED_SECONDS_OF_JOB_WITHOUT_ESTIMATE)
            for rule, count in job_count_by_rule.items()
        )
        self._start_time_s = time.time() if current_time_s is None else current_time_s

    def store_job_start(
        self, job_id: int, rule_name: str, job_name: str, log_files: list[Path], relative_input_size: float = 1.0
    ) -> None:
        """Store a job that begins; `relative_input_size`: size of its input over the mean, a factor on its time."""
        self._running_jobs[job_id] = RunningJob(
            job_name,
            relative_input_size
            * self.expected_job_seconds_by_rule.get(rule_name, EXPECTED_SECONDS_OF_JOB_WITHOUT_ESTIMATE),
            log_files,
        )

    def store_job_end(self, job_id: int, succeeded: bool) -> None:
        """Store the end of a job; its work counts as completed if the job was successful."""
        ended = self._running_jobs.pop(job_id, None)
        if ended is not None and succeeded:
            self.finished_job_count += 1
            self._expected_seconds_of_finished_jobs += ended.expected_seconds

    def completed_share_and_remaining_time(self, current_time_s: float) -> tuple[float, float]:
        """Return the completed share of the work, and the remaining time, s."""
        running = sum(job.completed_share() * job.expected_seconds for job in list(self._running_jobs.values()))
        done = min(
            (self._expected_seconds_of_finished_jobs + running) / max(self._expected_seconds_of_all_jobs, 1e-9), 1.0
        )
        pace = (
            self._expected_seconds_of_all_jobs / self.parallel_job_count
            if done < _MIN_COMPLETED_SHARE_TO_USE_MEASURED_PACE
            else (current_time_s - self._start_time_s) / done
        )
        return done, max(pace * (1.0 - done), 0.0)

    def progress_line(self, current_time_s: float | None = None) -> str:
        """Return the progress as one line: steps, share of the work, remaining time, and the running jobs."""
        share, seconds = self.completed_share_and_remaining_time(
            time.time() if current_time_s is None else current_time_s
        )
        names = ", ".join(job.rule_and_wildcards for job in list(self._running_jobs.values()))
        steps = f"{self.finished_job_count} of {self.total_job_count} steps"
        return f"{steps}, {share:.0%}, {format_minutes_and_seconds(seconds)} to go: {names}".removesuffix(": ")


def format_minutes_and_seconds(seconds: float) -> str:
    """Return a time given in seconds as text of minutes and seconds, such as 3:20."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
