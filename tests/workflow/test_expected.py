"""The time to go: near what is left, and no jumps."""

from itertools import pairwise
from pathlib import Path

import pytest

from snakemake_logger_plugin_overturning.expected import Expected, clock

SECONDS = {"read": 0.5, "sweep": 4.0, "figures": 12.0, "report": 8.0}
ALIKE = (1.0,) * 6
ONE_LONG = (0.5,) * 5 + (3.5,)
"""Records of which the last is far longer than the others, as one of the Kaikoura earthquake is."""


def simulated(factor: dict[str, float], sizes: tuple[float, ...], at_once: int = 2) -> list[tuple[float, float]]:
    """Time left in truth, and said, each half second of a run whose jobs take so many times what was expected."""
    run = Expected(dict(SECONDS), at_once)
    run.plan({"read": len(sizes), "sweep": len(sizes), "figures": 1, "report": 1}, now=0.0)
    free, events = [0.0] * at_once, []
    for rule, of_jobs in (("read", [1.0] * len(sizes)), ("sweep", sizes), ("figures", [1.0]), ("report", [1.0])):
        free = [max(free)] * at_once
        for size in of_jobs:
            lane, key = free.index(min(free)), len(events)
            begin, free[lane] = free[lane], free[lane] + factor.get(rule, 1.0) * SECONDS[rule] * size
            events += [(begin, 1, key, rule, size), (free[lane], 0, key, rule, size)]
    said, whole = [], max(free)
    for tick in range(int(2 * whole)):
        for moment, begins, key, rule, size in sorted(event for event in events if tick - 1 < 2 * event[0] <= tick):
            if begins:
                run.begin(key, rule, rule, [], size, now=moment)
            else:
                run.end(key, well=True, now=moment)
        said.append((whole - tick / 2, run.to_go(tick / 2)[1]))
    return said


@pytest.mark.parametrize("sizes", [ALIKE, ONE_LONG], ids=["alike", "one long record"])
@pytest.mark.parametrize(
    "factor", [{}, {"sweep": 2.0}, {"sweep": 0.4, "read": 3.0}, dict.fromkeys(SECONDS, 3.0), {"read": 8.0}]
)
def test_the_time_to_go_does_not_jump_and_comes_true(factor: dict[str, float], sizes: tuple[float, ...]) -> None:
    said = simulated(factor, sizes)
    whole = said[0][0]
    steps = [after[1] - before[1] for before, after in pairwise(said)]
    # It went 84:30, 6:43, 21:37, 1:12: up by three times what was left; and 0:41, 1:05 at the begin of a long record.
    assert max(steps) <= (0.04 * whole if factor else 0.0)
    assert min(steps) >= -0.06 * whole
    assert said[-1][1] <= 0.13 * whole
    if not factor:
        assert all(abs(left - to_go) <= (0.13 if sizes == ALIKE else 0.2) * whole for left, to_go in said)


def test_what_a_step_says_of_itself_counts_more_than_the_clock(tmp_path: Path) -> None:
    log = tmp_path / "sweep.log"
    run, other = Expected({"sweep": 100.0}), Expected({"sweep": 100.0})
    for each in (run, other):
        each.plan({"sweep": 2}, now=0.0)
        each.begin(1, "sweep", "sweep a", [log], now=0.0)
    assert other.to_go(10.0)[1] == pytest.approx(190.0), "by the clock, where there is no log yet"
    log.write_text("12%\n80%\n", encoding="utf-8")
    assert run.to_go(80.0) == (pytest.approx(0.4), pytest.approx(120.0)), "as fast as was expected"
    assert run.line(80.0) == "0 of 2 steps, 40%, 2:00 to go: sweep a"
    run.end(1, well=False, now=80.0)
    assert run.line(80.0).startswith("0 of 2 steps"), "a job that failed has done nothing"


def test_jobs_that_run_beside_each_other_take_less_time() -> None:
    one, four = Expected({"sweep": 100.0}), Expected({"sweep": 100.0}, at_once=4)
    for run in (one, four):
        run.plan({"sweep": 8}, now=0.0)
    assert one.to_go(0.0)[1] == 800.0
    assert four.to_go(0.0)[1] == 200.0
    assert clock(200.0) == "3:20"
