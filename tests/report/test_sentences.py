"""The answer in words, from summaries whose meaning is known."""

import math

import numpy as np
import pytest

from overturning.report.sentences import alignment_sentence, answer, doubling_sentence, headline, percent
from overturning.statistics.circular import TestResult
from overturning.statistics.earthquakes import AlignmentDifference, AxisSummary
from overturning.statistics.logistic import LogisticFit

TEST = TestResult("any", 5, 1.0, 0.5)


def summary(axis: float, half_width: float, low: float, high: float, n: int = 5, closer: int = 4) -> AxisSummary:
    return AxisSummary(n + 1, n, axis, half_width, 0.5, (low + high) / 2, (low, high), closer, 0.95, TEST, TEST)


NORMAL, EITHER = summary(-7.4, 12.0, 0.3, 0.8), summary(20.0, 60.0, -0.2, 0.6, n=3, closer=1)
NOTHING = summary(math.nan, math.nan, math.nan, math.nan, n=0)


def test_one_group() -> None:
    assert headline({"all records": NORMAL}, None) == (
        "Blocks fall on average 7°\u00a0±\u00a012° from the fault normal (5 earthquakes): "
        "falls lie closer to the fault normal than to the fault."
    )


def test_two_groups_that_differ() -> None:
    difference = AlignmentDifference(0.35, (-0.1, 0.7), 5, 3)
    groups = {"with a velocity pulse": NORMAL, "without (control)": EITHER}
    assert headline(groups, difference) == (
        "Blocks fall on average 7°\u00a0±\u00a012° from the fault normal with a velocity pulse (5 earthquakes) and "
        "20°\u00a0±\u00a060° from the fault normal without (3 earthquakes): with a velocity pulse, falls lie closer to the "
        "fault normal than to the fault; without, no preference for the normal or the fault can be told, and no difference "
        "between the two is shown."
    )
    assert alignment_sentence(groups, difference) == (
        "Alignment, 1 normal to the fault and −1 along it: 0.55 (95 % interval 0.30 to 0.80) with a velocity pulse; "
        "0.20 (95 % interval −0.20 to 0.60) without; difference 0.35 (−0.10 to 0.70). 4 of 5 earthquakes with a velocity "
        "pulse and 1 of 3 earthquakes without lie closer to the normal than to the fault."
    )


def test_a_group_without_falls_is_named() -> None:
    text = headline({"with a velocity pulse": NORMAL, "without (control)": NOTHING}, None)
    assert "not at all without (0 earthquakes): falls lie closer to the fault normal" in text


@pytest.mark.parametrize(
    ("fallen", "planes", "said"),
    [
        (math.nan, 36, "No outcome was found"),
        (0.0, 36, "No block overturned"),
        (0.5, 1, "50\u00a0% of the cases overturn; with a single plane"),
        (1.0, 36, "Every block overturned in every plane"),
    ],
)
def test_edges(fallen: float, planes: int, said: str) -> None:
    assert answer({"all records": NORMAL}, None, fallen, planes)[0].startswith(said)


def fit_of(coefficient: list[float], low: list[float], high: list[float]) -> LogisticFit:
    values = [np.array(numbers) for numbers in (coefficient, np.zeros(5), low, high)]
    return LogisticFit(
        ("intercept", "PGA", "ratio", "shape", "size"), *values, np.eye(5), 100, 5, np.zeros(4), np.ones(4), 0.95
    )


def test_doubling() -> None:
    nothing = math.nan
    fit = fit_of([0, 3, 1, -2, -1], [-1, 2, nothing, -3, -2], [1, 4, nothing, -1, 0])
    assert doubling_sentence(fit) == (
        "The odds of a fall are multiplied by 8 (4 to 16) where PGA, and PGV with it, doubles; by 2 where PGV alone doubles; "
        "by 0.5 (0.25 to 1) where the size of a block alone doubles."
    )
    assert doubling_sentence(fit_of(*([[nothing] * 5] * 3))) == ""


def test_percent() -> None:
    assert (percent(0.351), percent(0.351, 1), percent(math.nan)) == ("35\u00a0%", "35.1\u00a0%", "–")
