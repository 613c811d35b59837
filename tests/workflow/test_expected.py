"""The time to go: near what is left, and no jumps."""

from itertools import pairwise
from pathlib import Path

import pytest

from snakemake_logger_plugin_overturning.expected import Expected, clock

SECONDS = {"read": 0.5, "sweep": 4.0, "figures": 12.0, "report": 8.0}


def simulated(factor: dict[str, float], at_once: int = 2, records: int = 6) -> list[tuple[float, float]]:
    """Time left in truth, and said, each half second of a run whose jobs take so many times what was expected."""
    run = Expected(dict(SECONDS), at_once)
    run.plan({"read": records, "sweep": records, "figures": 1, "report": 1}, now=0.0)
    jobs: list[tuple[float, int, str]] = []  # begin, number, rule
    now, number = 0.0, 0
    ends: dict[int, float] = {}
    for rule, count in (("read", records), ("sweep", records), ("figures", 1), ("report", 1)):
        for first in range(0, count, at_once):
            for _ in range(min(at_once, count - first)):
                jobs.append((now, number, rule))
                ends[number] = now + factor.get(rule, 1.0) * SECONDS[rule]
                number += 1
            now = ends[number - 1]
    said, waiting, running = [], list(jobs), []
    for tick in range(int(2 * now)):
        moment = tick / 2
        for begin, key, rule in [job for job in waiting if job[0] <= moment]:
            run.begin(key, rule, rule, [], begin)
            running.append(key)
        waiting = [job for job in waiting if job[0] > moment]
        for key in [key for key in running if ends[key] <= moment]:
            run.end(key, well=True)
            running.remove(key)
        said.append((now - moment, run.to_go(moment)[1]))
    return said


@pytest.mark.parametrize(
    "factor", [{}, {"sweep": 2.0}, {"sweep": 0.4, "read": 3.0}, dict.fromkeys(SECONDS, 3.0), {"read": 8.0}]
)
def test_the_time_to_go_does_not_jump_and_comes_true(factor: dict[str, float]) -> None:
    said = simulated(factor)
    whole = said[0][0]
    steps = [after[1] - before[1] for before, after in pairwise(said)]
    # It went 84:30, 6:43, 21:37, 1:12: up by three times what was left.
    assert max(steps) <= 0.04 * whole
    assert min(steps) >= -0.08 * whole
    assert said[-1][1] <= 0.13 * whole
    if not factor:
        assert all(abs(left - to_go) <= 0.13 * whole for left, to_go in said)


def test_what_a_step_says_of_itself_counts_more_than_the_clock(tmp_path: Path) -> None:
    log = tmp_path / "sweep.log"
    run = Expected({"sweep": 100.0})
    run.plan({"sweep": 2}, now=0.0)
    run.begin(1, "sweep", "sweep a", [log], now=0.0)
    assert run.to_go(10.0)[0] == pytest.approx(0.05), "by the clock, where there is no log yet"
    log.write_text("12%\n80%\n", encoding="utf-8")
    assert run.to_go(10.0)[0] == pytest.approx(0.4)
    assert run.line(10.0).startswith("0 of 2 steps, 40%, ")
    assert run.line(10.0).endswith(" to go: sweep a")
    run.end(1, well=False)
    assert run.to_go(10.0)[0] == 0.0, "a job that failed has done nothing"


def test_jobs_that_run_beside_each_other_take_less_time() -> None:
    one, four = Expected({"sweep": 100.0}), Expected({"sweep": 100.0}, at_once=4)
    for run in (one, four):
        run.plan({"sweep": 8}, now=0.0)
    assert one.to_go(0.0)[1] == 800.0
    assert four.to_go(0.0)[1] == 200.0
    assert clock(200.0) == "3:20"
