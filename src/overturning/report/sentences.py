"""The report's sentences, made from numbers."""

import math

from overturning.statistics.earthquakes import AlignmentDifference, AxisSummary


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


def axis_sentence(name: str, summary: AxisSummary) -> str:
    """One sentence about the fall axes of a group of records."""
    if summary.n == 0:
        return (
            f"Records {name}: no earthquake with falls and a known fault normal." if name else "No known fault normal."
        )
    mean = f"the mean fall axis lies {signed(abs(summary.mean_axis_deg))}° from the fault normal"
    if math.isnan(summary.mean_axis_deg):
        mean = "the fall axes cancel"
    elif not math.isnan(summary.mean_axis_half_width_deg):
        mean += f" (± {summary.mean_axis_half_width_deg:.0f}°)"
    alignment = f"alignment {signed(summary.alignment, 2)}"
    low, high = summary.alignment_interval
    if not math.isnan(low):
        alignment += f" ({100 * summary.level:.0f} % interval {interval(low, high)})"
    plural = "earthquakes" if summary.n > 1 else "earthquake"
    return (
        f"Records {name}, {summary.n} {plural} with falls: {mean}, {alignment}, {summary.closer_to_normal} of "
        f"{summary.n} closer to the normal than to the fault; {verdict(summary)}."
    )


def pulse_sentence(difference: AlignmentDifference) -> str:
    """Whether pulse records differ from the control."""
    if math.isnan(difference.difference):
        return "Pulse records and control cannot be compared: one of them has no falls."
    low, high = difference.interval
    value = f"Alignment with a pulse minus without: {signed(difference.difference, 2)}"
    if math.isnan(low):
        return f"{value}; too few earthquakes for an interval."
    said = "a difference is shown" if low > 0 or high < 0 else "no difference is shown"
    return f"{value} (95 % interval {interval(low, high)}): {said}."


def answer(
    summaries: dict[str, AxisSummary], difference: AlignmentDifference | None, fallen: float, planes: int
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

    Returns
    -------
    list of str
    """
    if math.isnan(fallen):
        return ["No outcome was found, so nothing can be said; see the causes below."]
    if fallen <= 0:
        return ["No block overturned in any direction, so these records say nothing about the direction of falls."]
    if planes == 1:
        return [f"{fallen:.0%} of the cases overturn; with a single plane of motion nothing is said about direction."]
    if fallen >= 1:
        return ["Every block overturned in every plane: there is no axis along which blocks fall more easily."]
    if all(summary.n == 0 for summary in summaries.values()):
        return [
            f"{fallen:.0%} of the cases overturn; no fault normal is known, so nothing is said relative to a fault."
        ]
    sentences = [axis_sentence(name, summary) for name, summary in summaries.items()]
    return sentences if difference is None else [*sentences, pulse_sentence(difference)]
