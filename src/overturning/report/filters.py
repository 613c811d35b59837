"""Filters of the report's templates: numbers and estimates as text, without words of a language."""

import math
from collections.abc import Callable
from typing import Any, Final
from urllib.parse import quote

from overturning.findings.values import Estimate

SHARE_AND_ANGLE_ROUNDING_TOLERANCE: Final = 1e-9
"""Distance from 0 or 1 up to which a share counts as 0 or 1, and an angle from half a degree: the rounding of a sum."""

NO_VALUE: Final = "–"
"""Text for a number that is not known."""

NO_BREAK_SPACE: Final = "\u00a0"
"""Space at which no line ends."""


def format_number(value: float | None, decimals: int = 2) -> str:
    """Format a number with a fixed number of decimals and a typographic minus sign; zero has no sign."""
    if _is_none_or_nan(value):
        return NO_VALUE
    text = f"{value:.{decimals}f}"
    return (text.replace("-", "−") if float(text) != 0 else text.replace("-", "")).replace("inf", "∞")


def format_with_all_integer_digits(value: float | None, significant_digits: int = 2) -> str:
    """Format a number with `significant_digits` digits, but all those before the decimal point: 0.29, 6.3, 120."""
    if _is_none_or_nan(value) or value == 0 or math.isinf(value or 0.0):
        return format_number(value, 0)
    return format_number(value, max(0, significant_digits - 1 - math.floor(math.log10(abs(value or 1.0)))))


def format_percent(share: float | None, min_percent_decimals: int = 0) -> str:
    """Format a share in per cent, with enough decimals that only 0 and 1 become 0 % and 100 %: 0.4 %, 99.97 %."""
    if _is_none_or_nan(share) or share is None:
        return NO_VALUE
    return f"{format_number(100 * share, _decimals_needed_for_percent(share, min_percent_decimals))}{NO_BREAK_SPACE}%"


def _decimals_needed_for_percent(share: float, min_percent_decimals: int) -> int:
    """Return the decimals, at least `min_percent_decimals`, with which a share is not rounded to 0 or 100 %."""
    between = SHARE_AND_ANGLE_ROUNDING_TOLERANCE < share < 1.0 - SHARE_AND_ANGLE_ROUNDING_TOLERANCE
    while between and float(f"{100 * share:.{min_percent_decimals}f}") in (0.0, 100.0):
        min_percent_decimals += 1
    return min_percent_decimals


def format_count(value: float | None) -> str:
    """Format a whole number with commas between thousands."""
    return NO_VALUE if _is_none_or_nan(value) else f"{value:,.0f}"


def format_without_trailing_zeros(value: float | None) -> str:
    """Format a number without trailing zeros, such as a setting of the study."""
    return NO_VALUE if _is_none_or_nan(value) else f"{value:g}".replace("-", "−")


def format_at_least_three_significant_digits(value: float | None) -> str:
    """Format a number with three significant digits, with a power of ten if it is very small or large: 0.00143."""
    return NO_VALUE if _is_none_or_nan(value) else f"{value:.3g}"


def format_whole_degrees(angle_deg: float | None, angle_wrapping_period_deg: int = 0) -> str:
    """Format an angle as whole degrees, modulo `angle_wrapping_period_deg` (180 or 360) unless it is 0.

    Half a degree is rounded away from 0, with a tolerance: 22.5° (half an octant) is 23° in spite of rounding errors.
    """
    if _is_none_or_nan(angle_deg) or angle_deg is None:
        return NO_VALUE
    whole = int(math.copysign(math.floor(abs(angle_deg) + 0.5 + SHARE_AND_ANGLE_ROUNDING_TOLERANCE), angle_deg))
    return f"{format_number(whole % angle_wrapping_period_deg if angle_wrapping_period_deg else whole, 0)}°"


def has_interval(estimate: Estimate) -> bool:
    """True if the confidence interval of an estimate is known."""
    return not _is_none_or_nan(estimate.low)


def format_interval(
    estimate: Any, decimals: int = 2, factor_on_interval_ends: float = 1.0, *, word_between_ends: str
) -> str:
    """Format an estimate's interval, such as 0.1 to 0.4; `word_between_ends` is " to " in the report's language."""
    if _is_none_or_nan(estimate.low):
        return NO_VALUE
    low, high = (format_number(factor_on_interval_ends * end, decimals) for end in (estimate.low, estimate.high))
    return f"{low}{word_between_ends}{high}"


def format_estimate_with_interval(estimate: Estimate, decimals: int = 2, *, word_between_ends: str) -> str:
    """Format an estimate, with its interval (if known) in parentheses: 0.13 (−0.18 to 0.41)."""
    interval = (
        f" ({format_interval(estimate, decimals, word_between_ends=word_between_ends)})"
        if has_interval(estimate)
        else ""
    )
    return f"{format_number(estimate.value, decimals)}{interval}"


def format_share_with_interval(share_estimate: Any, min_percent_decimals: int = 0, *, word_between_ends: str) -> str:
    """Format a share in per cent, with its interval (if known) in parentheses: 35 % (28 to 43)."""
    if not has_interval(share_estimate):
        return format_percent(share_estimate.value, min_percent_decimals)
    min_percent_decimals = _decimals_needed_for_percent(share_estimate.value, min_percent_decimals)
    interval = format_interval(share_estimate, min_percent_decimals, 100.0, word_between_ends=word_between_ends)
    return f"{format_percent(share_estimate.value, min_percent_decimals)} ({interval})"


def format_fragility_median_or_interval(
    fragility_curve: Any, shows_median: bool = True, *, word_between_ends: str
) -> str:
    """Format a fragility median (or its interval); values outside the data's range become "> 1.4" or "< 0.2"."""
    decimals = _decimals_of_fragility_median_and_interval(fragility_curve)

    def format_value_or_bound_if_outside_data(median_or_interval_end: float | None) -> str:
        """Format a value; ∞ becomes "> 1.4" (largest value of the data), and 0 "< 0.2" (smallest value)."""
        if _is_none_or_nan(median_or_interval_end) or median_or_interval_end is None:
            return NO_VALUE
        if math.isinf(median_or_interval_end):
            return f">{NO_BREAK_SPACE}{fragility_curve.data_maximum:.3g}"
        return (
            f"<{NO_BREAK_SPACE}{fragility_curve.data_minimum:.3g}"
            if median_or_interval_end == 0
            else format_number(median_or_interval_end, decimals)
        )

    return (
        format_value_or_bound_if_outside_data(fragility_curve.median)
        if shows_median
        else NO_VALUE
        if _is_none_or_nan(fragility_curve.low)
        else word_between_ends.join(
            format_value_or_bound_if_outside_data(end) for end in (fragility_curve.low, fragility_curve.high)
        )
    )


def _decimals_of_fragility_median_and_interval(fragility_curve: Any) -> int:
    """Return the number of decimals with which a fragility median and its interval are shown.

    They show two significant digits of half the interval's width; without a finite interval, two of the smallest
    positive value.
    """
    ends = [
        bound
        for bound in (fragility_curve.low, fragility_curve.high, fragility_curve.median)
        if not _is_none_or_nan(bound)
    ]
    known = min((bound for bound in ends if math.isfinite(bound) and bound > 0), default=fragility_curve.data_maximum)
    bounded = (
        not _is_none_or_nan(fragility_curve.low)
        and math.isfinite(fragility_curve.high - fragility_curve.low)
        and fragility_curve.low > 0
    )
    width = max((fragility_curve.high - fragility_curve.low) / 2, known / 10) if bounded else known
    return max(0, 1 - math.floor(math.log10(width)))


def format_fragility_median_interval(fragility_curve: Any, *, word_between_ends: str) -> str:
    """Format the interval of a fragility median; ends outside the data's range become "> 1.4" or "< 0.2"."""
    return format_fragility_median_or_interval(fragility_curve, shows_median=False, word_between_ends=word_between_ends)


def format_percentage_points(share_difference: Estimate, *, word_between_ends: str) -> str:
    """Format a difference of two shares, with its interval (if known), in percentage points."""
    interval = (
        f" ({format_interval(share_difference, 1, 100.0, word_between_ends=word_between_ends)})"
        if has_interval(share_difference)
        else ""
    )
    return f"{format_number(None if share_difference.value is None else 100 * share_difference.value, 1)}{interval}"


def format_predictor_data_range(coefficient_with_predictor_range: Any, *, word_between_ends: str) -> str:
    """Format the smallest and largest value of a predictor in the data of the study: 0.1 to 0.4."""
    if _is_none_or_nan(coefficient_with_predictor_range.data_minimum):
        return NO_VALUE
    least, most = (
        format_number(coefficient_with_predictor_range.data_minimum),
        format_number(coefficient_with_predictor_range.data_maximum),
    )
    return f"{least}{word_between_ends}{most}"


def format_count_with_noun(counted_number: int, singular_noun: str) -> str:
    """Format a number with an English noun in the singular or plural: 1 record, 2 records."""
    return f"{format_count(counted_number)} {singular_noun}{'' if counted_number == 1 else 's'}"


def format_p_value(p_value: float | None) -> str:
    """Format a p-value with two significant digits, or as "< 0.001"."""
    if _is_none_or_nan(p_value) or p_value is None:
        return NO_VALUE
    return f"<{NO_BREAK_SPACE}0.001" if p_value < 0.001 else f"{p_value:.2g}"


def percent_encode(file_name_or_anchor: str) -> str:
    """Percent-encode a file name or anchor for use in a link."""
    return quote(file_name_or_anchor)


def _is_none_or_nan(value: float | None) -> bool:
    """True if a number is not known: None or NaN."""
    return value is None or math.isnan(value)


LANGUAGE_INDEPENDENT_TEMPLATE_FILTERS: Final[dict[str, Callable[..., str]]] = {
    "number": format_number,
    "significant": format_with_all_integer_digits,
    "percent": format_percent,
    "count": format_count,
    "plain": format_without_trailing_zeros,
    "three_digits": format_at_least_three_significant_digits,
    "degrees": format_whole_degrees,
    "p_value": format_p_value,
    "address": percent_encode,
    "counted": format_count_with_noun,
}
"""Filters without words."""

FILTERS_WITH_WORD_BETWEEN_INTERVAL_ENDS: Final[dict[str, Callable[..., str]]] = {
    "ends": format_interval,
    "estimate": format_estimate_with_interval,
    "share": format_share_with_interval,
    "censored": format_fragility_median_or_interval,
    "censored_interval": format_fragility_median_interval,
    "points": format_percentage_points,
    "data_range": format_predictor_data_range,
}
"""Filters that take the word between the ends of an interval."""
