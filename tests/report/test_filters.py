"""Numbers as the report prints them."""

import math
from types import SimpleNamespace

import pytest

from overturning.report import filters


@pytest.mark.parametrize(
    ("share", "digits", "shown"),
    [(0.353, 0, "35 %"), (0.004, 0, "0.4 %"), (0.9997, 0, "99.97 %"), (0.0, 1, "0.0 %"), (1.0, 0, "100 %"),
     (1e-12, 0, "0 %"), (None, 0, "–"), (math.nan, 0, "–")],
)  # fmt: skip
def test_shares_between_none_and_all_are_not_printed_as_0_or_100(share: float | None, digits: int, shown: str) -> None:
    assert filters.format_percent(share, digits) == shown.replace(" ", filters.NO_BREAK_SPACE)


def test_interval_of_a_share_is_printed_with_the_digits_of_the_share() -> None:
    one = SimpleNamespace(value=0.99973, low=0.9985, high=0.99999)
    assert (
        filters.format_share_with_interval(one, word_between_ends=" to ")
        == f"99.97{filters.NO_BREAK_SPACE}% (99.85 to 100.00)"
    )


@pytest.mark.parametrize(
    ("value", "digits", "shown"), [(-0.004, 2, "0.00"), (-0.12, 2, "−0.12"), (2.0, 0, "2"), (None, 2, "–")]
)
def test_numbers_are_printed_with_a_true_minus_and_without_minus_zero(
    value: float | None, digits: int, shown: str
) -> None:
    assert filters.format_number(value, digits) == shown


@pytest.mark.parametrize(("value", "full", "shown"), [
        (359.6, 360, "0°"), (179.7, 180, "0°"), (-16.2, 0, "−16°"),
        # Half an octant, as the bootstrap of directions and that of axes give it.
        (22.5, 0, "23°"), (22.5 - 1e-12, 0, "23°"), (22.5 + 1e-12, 0, "23°"), (-22.5, 0, "−23°"), (22.4, 0, "22°"),
        (0.5, 0, "1°"), (359.5, 360, "0°"), (-0.4, 360, "0°"),
    ],
)  # fmt: skip
def test_rounded_degrees_stay_within_the_circle(value: float, full: int, shown: str) -> None:
    assert filters.format_whole_degrees(value, full) == shown


@pytest.mark.parametrize(
    ("median", "low", "high", "shown"),
    [
        (130.19, 117.2, 147.49, ("130", "117 to 147")),
        (1.08, 0.83, 1.12, ("1.08", "0.83 to 1.12")),
        (math.inf, 0.9, math.inf, ("> 1.4", "0.90 to > 1.4")),
        (math.inf, math.inf, math.inf, ("> 1.4", "> 1.4 to > 1.4")),
        (0.0, 0.0, 0.2, ("< 0.1", "< 0.1 to 0.20")),
        (0.6174, None, None, ("0.62", "–")),
    ],
)
def test_a_median_is_printed_with_the_digits_of_its_interval(
    median: float, low: float | None, high: float | None, shown: tuple[str, str]
) -> None:
    one = SimpleNamespace(median=median, low=low, high=high, data_minimum=0.1, data_maximum=1.4)
    found = (
        filters.format_fragility_median_or_interval(one, word_between_ends=" to "),
        filters.format_fragility_median_interval(one, word_between_ends=" to "),
    )
    assert found == tuple(text.replace("> ", f">{filters.NO_BREAK_SPACE}").replace("< ", f"<{filters.NO_BREAK_SPACE}")
                          for text in shown)  # fmt: skip
