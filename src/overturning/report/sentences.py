"""The report's sentences, made from numbers."""

import math

from overturning.figures.style import short
from overturning.statistics.earthquakes import AlignmentDifference, AxisSummary
from overturning.statistics.logistic import LogisticFit


def percent(share: float, digits: int = 0) -> str:
    """A share as the whole report writes it, 35 %, with a space that does not break; a dash where there is none."""
    return "–" if math.isnan(share) else f"{100 * share:.{digits}f}\u00a0%"


def interval(low: float, high: float, digits: int = 2) -> str:
    """Two numbers as an interval."""
    return f"{low:.{digits}f} to {high:.{digits}f}".replace("-", "−")


def signed(value: float, digits: int = 0) -> str:
    """A number with a true minus sign and no minus before zero."""
    text = f"{value:.{digits}f}"
    return text.replace("-", "−") if float(text) != 0 else text.replace("-", "")


def verdict(summary: AxisSummary) -> str:
    """What the interval of the alignment says, in a few words."""
    low, high = summary.alignment_interval
    if math.isnan(low):
        return f"{summary.n} {'earthquake is' if summary.n == 1 else 'earthquakes are'} too few for an interval"
    if low > 0:
        return "falls lie closer to the fault normal than to the fault"
    if high < 0:
        return "falls lie closer to the fault than to its normal"
    return "no preference for the normal or the fault can be told"


def _earthquakes(count: int) -> str:
    return f"{count} earthquake{'' if count == 1 else 's'}"


def _name(group: str) -> str:
    """Name of a group inside a sentence; nothing for the only one."""
    return "" if group == "all records" else " " + group.removesuffix(" (control)")


def _mean_axis(summary: AxisSummary) -> str:
    if summary.n == 0:
        return "not at all"
    if math.isnan(summary.mean_axis_deg):
        return "along no common axis"
    width = summary.mean_axis_half_width_deg
    spread = "" if math.isnan(width) else f"\u00a0±\u00a0{width:.0f}°"
    return f"{signed(abs(summary.mean_axis_deg))}°{spread} from the fault normal"


def headline(summaries: dict[str, AxisSummary], difference: AlignmentDifference | None) -> str:
    """The answer in one sentence: mean fall axis with its interval, and whether it tells normal from parallel.

    Parameters
    ----------
    summaries : dict of AxisSummary
        By name of the group; one of them at least has falls.
    difference : AlignmentDifference or None
        Of the two groups, where there are two.

    Returns
    -------
    str
    """
    means = [f"{_mean_axis(one)}{_name(name)} ({_earthquakes(one.n)})" for name, one in summaries.items()]
    said = {name: verdict(one) for name, one in summaries.items() if one.n > 0}
    verdicts = list(dict.fromkeys(said.values()))
    if len(verdicts) == 1:
        conclusion = verdicts[0]
    else:
        conclusion = "; ".join(f"{_name(name).strip()}, {text}" for name, text in said.items())
    low, high = (math.nan, math.nan) if difference is None else difference.interval
    if not math.isnan(low):
        shown = "a difference" if low > 0 or high < 0 else "no difference"
        conclusion += f", and {shown} between the two is shown"
    return f"Blocks fall on average {' and '.join(means)}: {conclusion}."


def alignment_sentence(summaries: dict[str, AxisSummary], difference: AlignmentDifference | None) -> str:
    """The alignment of each group and of their difference with the intervals, and how many earthquakes lie closer to what."""
    parts = []
    for name, one in summaries.items():
        low, high = one.alignment_interval
        known = "" if math.isnan(low) else f" ({100 * one.level:.0f} % interval {interval(low, high)})"
        if one.n:
            parts.append(f"{signed(one.alignment, 2)}{known}{_name(name)}")
    text = f"Alignment, 1 normal to the fault and −1 along it: {'; '.join(parts)}"
    if difference is not None and not math.isnan(difference.difference):
        low, high = difference.interval
        known = "; too few earthquakes for an interval" if math.isnan(low) else f" ({interval(low, high)})"
        text += f"; difference {signed(difference.difference, 2)}{known}"
    closer = [
        f"{one.closer_to_normal} of {_earthquakes(one.n)}{_name(name)}" for name, one in summaries.items() if one.n
    ]
    only = sum(one.n for one in summaries.values()) == 1
    return f"{text}. {' and '.join(closer)} {'lies' if only else 'lie'} closer to the normal than to the fault."


DOUBLED = {1: "PGA, and PGV with it,", 2: "PGV alone", 4: "the size of a block alone"}
"""What doubles where a predictor of `statistics.logistic.overturning_fit` grows by ln 2, by its place."""


def doubling_sentence(fit: LogisticFit) -> str:
    """What doubling the motion or the block does to the odds of a fall; empty where nothing was fitted.

    Parameters
    ----------
    fit : LogisticFit
        From `statistics.logistic.overturning_fit`.

    Returns
    -------
    str
    """
    parts = []
    for place, what in DOUBLED.items():
        factor, low, high = (2.0 ** float(values[place]) for values in (fit.coefficient, fit.low, fit.high))
        if not math.isnan(factor):
            known = "" if math.isnan(low) else f" ({short(low)} to {short(high)})"
            parts.append(f"by {short(factor)}{known} where {what} doubles")
    return f"The odds of a fall are multiplied {'; '.join(parts)}." if parts else ""


def answer(
    summaries: dict[str, AxisSummary],
    difference: AlignmentDifference | None,
    fallen: float,
    planes: int,
    missing: int = 0,
) -> list[str]:
    """The answer: a few sentences with numbers and their uncertainty.

    Parameters
    ----------
    summaries : dict of AxisSummary
        By name of the group.
    difference : AlignmentDifference or None
        Pulse records against control, where a study has both.
    fallen : float
        Share of all cases that overturn, NaN where none was found.
    planes : int
        Vertical planes of the study: one plane tells nothing about direction.
    missing : int
        Cases without an outcome.

    Returns
    -------
    list of str
    """
    if math.isnan(fallen):
        return ["No outcome was found, so nothing can be said; see the causes below."]
    known = " whose outcome is known" if missing else ""
    if fallen <= 0:
        return [
            f"No block{known} overturned in any direction, so these records say nothing about the direction of falls."
        ]
    if planes == 1:
        return [
            f"{percent(fallen)} of the cases overturn; with a single plane of motion nothing is said about direction."
        ]
    if fallen >= 1:
        return [f"Every block{known} overturned in every plane: there is no axis along which blocks fall more easily."]
    if all(summary.n == 0 for summary in summaries.values()):
        return [
            f"{percent(fallen)} of the cases overturn; no fault normal is known, so nothing is said relative to a fault."
        ]
    return [headline(summaries, difference), alignment_sentence(summaries, difference)]
