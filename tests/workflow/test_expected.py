"""The time to go: right where the jobs take what was expected, and at the measured pace where they do not."""

from pathlib import Path

import pytest

from snakemake_logger_plugin_overturning.expected import RunProgressEstimate, format_minutes_and_seconds

EXPECTED_SECONDS_BY_RULE = {"read": 0.5, "sweep": 4.0, "figures": 12.0, "report": 8.0}


@pytest.mark.parametrize("factor", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("at_once", [1, 2])
def test_the_remaining_time_follows_the_measured_pace(factor: float, at_once: int) -> None:
    """Jobs of one rule, run one or two at a time, take `factor` times the expected time.

    After each job the remaining time is exact.
    """
    run = RunProgressEstimate(dict(EXPECTED_SECONDS_BY_RULE), at_once)
    run.store_run_start_and_job_counts({"sweep": 8}, current_time_s=0.0)
    assert run.completed_share_and_remaining_time(0.0) == (0.0, 32.0 / at_once)
    each = factor * EXPECTED_SECONDS_BY_RULE["sweep"]
    for job in range(8):
        run.store_job_start(job, "sweep", "sweep", [])
    for job in range(8):
        run.store_job_end(job, succeeded=True)
        elapsed = each * (job + 1) / at_once
        share, left = run.completed_share_and_remaining_time(elapsed)
        assert share == pytest.approx((job + 1) / 8)
        assert left == pytest.approx(8 * each / at_once - elapsed)
    assert run.completed_share_and_remaining_time(elapsed)[1] == 0.0


def test_progress_uses_last_percentage_in_log_of_a_job(tmp_path: Path) -> None:
    log = tmp_path / "sweep.log"
    run = RunProgressEstimate({"sweep": 100.0})
    run.store_run_start_and_job_counts({"sweep": 2}, current_time_s=0.0)
    run.store_job_start(1, "sweep", "sweep a", [log])
    assert run.progress_line(10.0) == "0 of 2 steps, 0%, 3:20 to go: sweep a", "no log yet: the expected time"
    log.write_text("12%\n80%\n", encoding="utf-8")
    assert run.progress_line(80.0) == "0 of 2 steps, 40%, 2:00 to go: sweep a"
    run.store_job_end(1, succeeded=False)
    assert run.progress_line(80.0).startswith("0 of 2 steps, 0%"), "a failed job has done nothing"


def test_progress_weights_a_large_job_more_than_a_small_one() -> None:
    run = RunProgressEstimate({"sweep": 10.0})
    run.store_run_start_and_job_counts({"sweep": 2}, current_time_s=0.0)
    for job, size in ((1, 0.5), (2, 1.5)):
        run.store_job_start(job, "sweep", "sweep", [], size)
    run.store_job_end(1, succeeded=True)
    assert run.completed_share_and_remaining_time(5.0) == (pytest.approx(0.25), pytest.approx(15.0))


def test_the_remaining_time_is_shorter_with_concurrent_jobs() -> None:
    run = RunProgressEstimate({"sweep": 100.0}, parallel_job_count=4)
    run.store_run_start_and_job_counts({"sweep": 8}, current_time_s=0.0)
    assert run.completed_share_and_remaining_time(0.0)[1] == 200.0
    assert format_minutes_and_seconds(200.0) == "3:20"
