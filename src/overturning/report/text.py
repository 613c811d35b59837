"""Numbers as the report writes them: a true minus sign, a dash where there is none, spaces that do not break."""

import math
from typing import Any, Final

from overturning.statistics.bootstrap import Mean

ROUNDING: Final = 1e-9
"""A share that is closer to 0 or to 1 than this is that, but for the rounding of a sum."""


def capitalised(text: str) -> str:
    """A text that begins a sentence; what follows keeps its capitals."""
    return text[:1].upper() + text[1:]


def number(value: float, digits: int = 2) -> str:
    """A number with so many decimals, with no minus before zero."""
    if math.isnan(value):
        return "–"
    text = f"{value:.{digits}f}"
    return text.replace("-", "−") if float(text) != 0 else text.replace("-", "")


def percent(share: float, digits: int = 0) -> str:
    """A share, 35 %; with as many digits as tell it from nothing and from all: 0.4 %, 99.97 %."""
    if math.isnan(share):
        return "–"
    neither = ROUNDING < share < 1.0 - ROUNDING
    while neither and float(f"{100 * share:.{digits}f}") in (0.0, 100.0):
        digits += 1
    return f"{100 * share:.{digits}f}\u00a0%"


def interval(low: float, high: float, none: str = "–") -> str:
    """Two numbers as an interval, or what is said where there is none."""
    return none if math.isnan(low) else f"{low:z.2f} to {high:z.2f}".replace("-", "−")


def estimate(value: float, low: float, high: float) -> str:
    """A number with its interval where it has one, 0.5 (0.2 to 0.7)."""
    return number(value) + ("" if math.isnan(low) else f" ({interval(low, high)})")


def shown(mean: Mean) -> str:
    """A mean over earthquakes as of `estimate`."""
    return estimate(mean.value, mean.low, mean.high)


def share(value: float, low: float, high: float, digits: int = 0) -> str:
    """A share with its interval where it has one, 35 % (28 to 43), each as `percent` writes it."""
    ends = (percent(end, digits).removesuffix("\u00a0%") for end in (low, high))
    return percent(value, digits) + ("" if math.isnan(low) else f" ({' to '.join(ends)})")


def decimals(mean: Mean) -> int:
    """Of a mean share in %: one where its interval is no wider than some per cent, or there is none."""
    return int(math.isnan(mean.low) or mean.high - mean.low < 0.1)


def verdict(mean: Mean, above: str, below: str, neither: str, few: str = "too few for an interval") -> str:
    """What the interval of a mean says: it lies above 0 or below, takes 0 in, or there is none."""
    if math.isnan(mean.low):
        return few
    return above if mean.low > 0 else below if mean.high < 0 else neither


def censored(value: float, low: float, high: float, least: float, most: float) -> tuple[str, str]:
    """A number and its interval with the digits that the interval allows, and where the data end: above 1.4.

    Infinite is what lies above `most`, 0 what lies below `least`. Half the interval has two digits, or the number where
    there is no interval; no number has more than three.
    """
    known = min((one for one in (low, high, value) if math.isfinite(one) and one > 0), default=most)
    width = max((high - low) / 2, known / 10) if math.isfinite(high - low) and low > 0 else known
    digits = max(0, 1 - math.floor(math.log10(width)))

    def end(one: float) -> str:
        return f"above {most:.3g}" if one == math.inf else f"below {least:.3g}" if one == 0 else number(one, digits)

    ends = dict.fromkeys((end(low), end(high)))
    return end(value), "–" if math.isnan(low) else " to ".join(ends)


def two_digits(value: float) -> str:
    """A positive number with two digits, or with those before its point: 0.29, 6.3, 120."""
    return number(value, max(0, 1 - math.floor(math.log10(value))) if 0 < value < math.inf else 0)


def degrees(value: float, full: int = 0) -> str:
    """Whole degrees; with ``full`` brought into 0 to below it, so that 359.6° is 0° and not 360°."""
    if math.isnan(value):
        return "–"
    return f"{number(round(value) % full if full else round(value), 0)}°"


def counted(count: int, what: str) -> str:
    """So many of something: 1 record, 2 records."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def of_group(name: str) -> str:
    """Name of a group of records inside a sentence, as of `record_groups`; nothing for the only one."""
    return "" if name == "all records" else f" {name.replace('without (control)', 'without a pulse')}"


WRITTEN: Final = {
    "g": lambda value: f"{value:g}",
    "d": lambda value: f"{value:,}",
    "1": lambda value: number(value, 1),
    "2": number,
    "%": percent,
    "°": degrees,
}
"""How a cell of a table is written that is a number, by the letter of its column."""


def cell(value: Any, letter: str) -> str:
    """A cell of a table; what is text already stays."""
    return value if isinstance(value, str) else WRITTEN.get(letter, str)(value)
