"""The answer in words, from summaries whose meaning is known."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from overturning.report.sections.answer import alignment_sentence, answer_sentences, headline
from overturning.report.sections.cause import doubling_sentence
from overturning.report.sections.scene import comparison_sentence
from overturning.report.text import counted, degrees, interval, number, percent
from overturning.statistics.circular import TestResult
from overturning.statistics.earthquakes import AlignmentDifference, AxisSummary
from overturning.statistics.elements import StoneComparison
from overturning.statistics.logistic import LogisticFit

TEST = TestResult("any", 5, 1.0, 0.5)


def summary(axis: float, half_width: float, low: float, high: float, n: int = 5, closer: int = 4) -> AxisSummary:
    return AxisSummary(n + 1, n, axis, half_width, 0.5, (low + high) / 2, (low, high), closer, 0.95, TEST, TEST)


NORMAL, EITHER = summary(-7.4, 12.0, 0.3, 0.8), summary(20.0, 60.0, -0.2, 0.6, n=3, closer=1)
NOTHING = summary(math.nan, math.nan, math.nan, math.nan, n=0)


def results(difference: AlignmentDifference | None = None, /, **groups: AxisSummary) -> Any:
    """Groups of records: `pulse` and `control`, or `all` of them."""
    names = {"pulse": "with a velocity pulse", "control": "without (control)", "all": "all records"}
    return SimpleNamespace(axes={names[key]: one for key, one in groups.items()}, axes_difference=difference)


def test_one_group() -> None:
    mean, _, conclusion = headline(results(all=NORMAL)).partition(": ")
    assert mean.endswith("7°\u00a0±\u00a012° from the fault normal (5 of 6 earthquakes with falls)")
    assert conclusion == "falls lie closer to the fault normal than to the fault."
    assert "all records" not in headline(results(all=NORMAL))


def test_two_groups_that_differ() -> None:
    groups = results(AlignmentDifference(0.35, (-0.1, 0.7), 5, 3), pulse=NORMAL, control=EITHER)
    means, conclusion = headline(groups).split(": ")
    assert "12° from the fault normal with a velocity pulse (5 of 6 earthquakes with falls) and 20°" in means
    assert means.endswith("from the fault normal without (3 of 4 earthquakes with falls)")
    with_pulse, without = conclusion.split("; ")
    assert with_pulse.startswith("with a velocity pulse, falls lie closer to the fault normal")
    assert without.startswith("without, no preference")
    assert without.endswith("and no difference between the two is shown.")
    text = alignment_sentence(groups)
    assert "0.55 (95 % interval 0.30 to 0.80) with a velocity pulse; 0.20 (95 % interval −0.20 to 0.60) without" in text
    assert "difference 0.35 (−0.10 to 0.70)." in text
    assert "4 of 5 earthquakes with a velocity pulse and 1 of 3 earthquakes without lie closer to the normal" in text


def test_a_difference_that_is_shown_and_one_of_too_few() -> None:
    shown = results(AlignmentDifference(0.35, (0.1, 0.7), 5, 3), pulse=NORMAL, control=EITHER)
    assert "and a difference between the two is shown" in headline(shown)
    few = results(AlignmentDifference(0.35, (math.nan, math.nan), 5, 1), pulse=NORMAL, control=EITHER)
    assert "between the two" not in headline(few)
    assert "difference 0.35; too few earthquakes for an interval" in alignment_sentence(few)


def test_a_group_without_falls_is_named() -> None:
    text = headline(results(pulse=NORMAL, control=NOTHING))
    assert "not at all without (none of 1 earthquake with falls): falls lie closer to the fault normal" in text


def test_falls_along_the_fault() -> None:
    assert "closer to the fault than to its normal" in headline(results(all=summary(80.0, 5.0, -0.9, -0.5)))


@pytest.mark.parametrize(
    ("fallen", "planes", "start"),
    [
        (math.nan, 36, "No outcome was found"),
        (0.0, 36, "No block overturned"),
        (0.5, 1, "50\u00a0% of the cases overturn; with a single plane"),
        (1.0, 36, "Every block overturned in every plane"),
        (0.5, 36, "Blocks fall on average"),
    ],
)
def test_edges(fallen: float, planes: int, start: str) -> None:
    edge = {"statuses": {}, "fallen": fallen, "one_axis": planes == 1, "faults_known": True}
    assert answer_sentences(SimpleNamespace(**vars(results(all=NORMAL)), **edge))[0].startswith(start)


def test_missing_outcomes_are_not_passed_over() -> None:
    edge = {"statuses": {"failed": (3, 3)}, "fallen": 0.0, "one_axis": False, "faults_known": True}
    (text,) = answer_sentences(SimpleNamespace(**vars(results(all=NOTHING)), **edge))
    assert text.startswith("No block whose outcome is known overturned")


def fit_of(coefficient: list[float], low: list[float], high: list[float], earthquakes: int = 9) -> LogisticFit:
    values = [np.array(numbers) for numbers in (coefficient, np.zeros(5), low, high)]
    names = ("intercept", "PGA", "ratio", "shape", "size")
    return LogisticFit(names, *values, 100, earthquakes, np.zeros(4), np.ones(4), 0.95)


def test_doubling() -> None:
    nothing = math.nan
    numbers = [0, 3, 1, -2, -1], [-1, 2, -3, -3, -2], [1, 4, 4, -1, 0]
    told, untold = doubling_sentence(fit_of(*numbers)).split(". ")
    pga, size = told.split("; ")
    assert "by 8 (4 to 16) where PGA, and PGV with it, doubles" in pga
    assert "by 0.5 (0.25 to 1) where the size of a block alone doubles" in size
    assert untold == "9 earthquakes cannot tell by how much the odds of a fall grow where PGV alone doubles."
    no_ends = [[nothing] * 5] * 2
    assert doubling_sentence(fit_of(numbers[0], *no_ends, earthquakes=7)).startswith("7 earthquakes cannot tell")
    assert doubling_sentence(fit_of(*([[nothing] * 5] * 3))) == ""


def test_stones_compared() -> None:
    text = comparison_sentence(StoneComparison("shaft", "monolith", 12, 4, 2, 1, 5, 3, 2))
    assert "Of 12 cases the shaft falls in 6 and the monolith in 5; in 2 only the shaft" in text
    assert "they go to the same side in 75\u00a0%, and the shaft falls first in 50\u00a0%" in text
    alone = comparison_sentence(StoneComparison("shaft", "monolith", 12, 0, 2, 0, 10, 0, 0))
    assert "the shaft falls first in every case in which anything falls" in alone


def test_numbers() -> None:
    nothing = math.nan
    assert (percent(0.351), percent(0.351, 1), percent(nothing)) == ("35\u00a0%", "35.1\u00a0%", "–")
    assert (number(-0.001), number(-1.25, 1), number(nothing)) == ("0.00", "−1.2", "–")
    assert (degrees(359.6, 360), degrees(-30.2), degrees(nothing)) == ("0°", "−30°", "–")
    assert (interval(-0.5, 1.0), interval(nothing, nothing)) == ("−0.50 to 1.00", "–")
    assert (counted(1, "record"), counted(0, "record")) == ("1 record", "0 records")
