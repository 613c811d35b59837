"""Filters of the report's templates: numbers and estimates as text, without words of a language."""

import math
from collections.abc import Callable
from typing import Any, Final
from urllib.parse import quote

from overturning.findings.values import Estimate

ROUNDING: Final = 1e-9
"""Distance from 0 or 1 up to which a share counts as 0 or 1, and an angle from half a degree: the rounding of a sum."""

NO_VALUE: Final = "–"
"""Text for a number that is not known."""

NO_BREAK: Final = "\u00a0"
"""Space at which no line ends."""


def number(value: float | None, digits: int = 2) -> str:
    """Return a number with a fixed number of decimals and a true minus sign; zero has no sign."""
    if _unknown(value):
        return NO_VALUE
    text = f"{value:.{digits}f}"
    return (text.replace("-", "−") if float(text) != 0 else text.replace("-", "")).replace("inf", "∞")


def significant(value: float | None, digits: int = 2) -> str:
    """Return a number with so many significant digits, or with all digits before its point: 0.29, 6.3, 120."""
    if _unknown(value) or value == 0 or math.isinf(value or 0.0):
        return number(value, 0)
    return number(value, max(0, digits - 1 - math.floor(math.log10(abs(value or 1.0)))))


def percent(share: float | None, digits: int = 0) -> str:
    """Return a share in per cent; a share that is neither 0 nor 1 has enough digits to show so: 0.4 %, 99.97 %."""
    if _unknown(share) or share is None:
        return NO_VALUE
    return f"{number(100 * share, _digits_of_percent(share, digits))}{NO_BREAK}%"


def _digits_of_percent(share: float, digits: int) -> int:
    """Return the number of decimals, at least `digits`, with which a share is not rounded to 0 or 100 %."""
    between = ROUNDING < share < 1.0 - ROUNDING
    while between and float(f"{100 * share:.{digits}f}") in (0.0, 100.0):
        digits += 1
    return digits


def count(value: float | None) -> str:
    """Return a whole number with commas between thousands."""
    return NO_VALUE if _unknown(value) else f"{value:,.0f}"


def plain(value: float | None) -> str:
    """Return a number without trailing zeros, such as a setting of the study."""
    return NO_VALUE if _unknown(value) else f"{value:g}".replace("-", "−")


def three_digits(value: float | None) -> str:
    """Return a number with three significant digits, with a power of ten if it is very small or large: 0.00143."""
    return NO_VALUE if _unknown(value) else f"{value:.3g}"


def degrees(value: float | None, full: int = 0) -> str:
    """Return whole degrees; with `full` (180 or 360) in the range from 0 to below `full`.

    Half a degree is rounded away from 0, so that 22.5°, half an octant, is 23° whatever its last binary digit is.
    """
    if _unknown(value) or value is None:
        return NO_VALUE
    whole = int(math.copysign(math.floor(abs(value) + 0.5 + ROUNDING), value))
    return f"{number(whole % full if full else whole, 0)}°"


def has_interval(one: Estimate) -> bool:
    """True if an estimate has an interval."""
    return not _unknown(one.low)


def ends(one: Any, digits: int = 2, scale: float = 1.0, *, to: str) -> str:
    """Return the interval of an estimate, its ends joined by the word `to` of the language."""
    if _unknown(one.low):
        return NO_VALUE
    return f"{number(scale * one.low, digits)}{to}{number(scale * one.high, digits)}"


def estimate(one: Estimate, digits: int = 2, *, to: str) -> str:
    """Return an estimate with its interval, if there is one, in parentheses: 0.13 (−0.18 to 0.41)."""
    interval = f" ({ends(one, digits, to=to)})" if has_interval(one) else ""
    return f"{number(one.value, digits)}{interval}"


def share(one: Any, digits: int = 0, *, to: str) -> str:
    """Return a share with its interval, if there is one, in per cent: 35 % (28 to 43)."""
    if not has_interval(one):
        return percent(one.value, digits)
    digits = _digits_of_percent(one.value, digits)
    return f"{percent(one.value, digits)} ({ends(one, digits, 100.0, to=to)})"


def censored(one: Any, value: bool = True, *, to: str) -> str:
    """Return a value (or its interval) with two or three digits, "> 1.4" above and "< 0.2" below the data's range."""
    digits = _digits_of_interval(one)

    def end(bound: float | None) -> str:
        if _unknown(bound) or bound is None:
            return NO_VALUE
        if math.isinf(bound):
            return f">{NO_BREAK}{one.data_maximum:.3g}"
        return f"<{NO_BREAK}{one.data_minimum:.3g}" if bound == 0 else number(bound, digits)

    return end(one.median) if value else NO_VALUE if _unknown(one.low) else f"{end(one.low)}{to}{end(one.high)}"


def _digits_of_interval(one: Any) -> int:
    """Return the number of decimals at which half the interval has two digits, or the value if it has no interval."""
    ends = [bound for bound in (one.low, one.high, one.median) if not _unknown(bound)]
    known = min((bound for bound in ends if math.isfinite(bound) and bound > 0), default=one.data_maximum)
    bounded = not _unknown(one.low) and math.isfinite(one.high - one.low) and one.low > 0
    width = max((one.high - one.low) / 2, known / 10) if bounded else known
    return max(0, 1 - math.floor(math.log10(width)))


def censored_interval(one: Any, *, to: str) -> str:
    """Return the interval of a value as `censored` writes its ends."""
    return censored(one, value=False, to=to)


def points(one: Estimate, *, to: str) -> str:
    """Return the difference of two shares, and its interval, in percentage points."""
    interval = f" ({ends(one, 1, 100.0, to=to)})" if has_interval(one) else ""
    return f"{number(None if one.value is None else 100 * one.value, 1)}{interval}"


def data_range(one: Any, *, to: str) -> str:
    """Return the range of the data of a predictor."""
    if _unknown(one.data_minimum):
        return NO_VALUE
    return f"{number(one.data_minimum)}{to}{number(one.data_maximum)}"


def counted(value: int, noun: str) -> str:
    """Return a number with an English noun: 1 record, 2 records."""
    return f"{count(value)} {noun}{'' if value == 1 else 's'}"


def p_value(value: float | None) -> str:
    """Return a p-value with two digits, "< 0.001" for smaller ones."""
    if _unknown(value) or value is None:
        return NO_VALUE
    return f"<{NO_BREAK}0.001" if value < 0.001 else f"{value:.2g}"


def address(name: str) -> str:
    """Return a file name or anchor as part of an address."""
    return quote(name)


def _unknown(value: float | None) -> bool:
    """True if a number is not known: None or NaN."""
    return value is None or math.isnan(value)


FILTERS: Final[dict[str, Callable[..., str]]] = {
    "number": number,
    "significant": significant,
    "percent": percent,
    "count": count,
    "plain": plain,
    "three_digits": three_digits,
    "degrees": degrees,
    "p_value": p_value,
    "address": address,
    "counted": counted,
}
"""Filters without words."""

FILTERS_WITH_WORDS: Final[dict[str, Callable[..., str]]] = {
    "ends": ends,
    "estimate": estimate,
    "share": share,
    "censored": censored,
    "censored_interval": censored_interval,
    "points": points,
    "data_range": data_range,
}
"""Filters that take the word between the ends of an interval."""
