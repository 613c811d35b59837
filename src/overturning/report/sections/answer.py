"""The answer to the study's question: how falls lie to the fault normal, with their uncertainty."""

import math

from overturning.report.blocks import Answer, Block, Column, Figure, Note, Paragraph, Section, Table, number_columns
from overturning.report.results import Results
from overturning.report.sections.records import record_directions
from overturning.report.text import counted, degrees, interval, number, percent
from overturning.statistics.earthquakes import AlignmentDifference, AxisSummary

MOST_RECORDS_IN_WORDS = 5
"""Records whose directions still stand in sentences; of more the table tells."""


def answer(results: Results) -> Section:
    """The answer, what it is counted over, and the axes it comes from."""
    axes: tuple[Block, ...] = ()
    if results.tells_axes:
        figure = Figure(
            results.figures / "axes.svg",
            "fall axis of each earthquake relative to its fault normal",
            "Fall axis of each earthquake relative to its fault normal, over all blocks of the study; the point grows with "
            "how strongly the axes agree. Below, the mean over earthquakes with its bootstrap interval. Which side of the "
            "fault normal counts as positive is arbitrary, so only axes are compared.",
            width=0.82,
        )
        note = Note(
            "Alignment is the mean of cos 2Δ over earthquakes, Δ the angle between fall axis and fault normal: 1 normal to "
            "the fault, −1 along it, 0 neither. Intervals: 95 %, bootstrap over earthquakes. Rayleigh: any preferred axis; "
            "V: the fault normal, stated beforehand; both on doubled angles."
        )
        axes = (figure, _summary_table(results.axes), note)
    return Section(
        "Answer",
        (Answer(tuple(_sentences(results))), Paragraph(_counted(results)), *axes, Note(_cases(results))),
        anchor="answer",
    )


def _sentences(results: Results) -> list[str]:
    sentences = answer_sentences(
        results.axes,
        results.axes_difference,
        results.fallen,
        planes=results.planes,
        missing=sum(results.missing.values()),
    )
    some_fall = results.fallen > 0 and results.planes > 1
    if not results.faults_known and some_fall and len(results.names) <= MOST_RECORDS_IN_WORDS:
        for name, row in zip(results.names, record_directions(results.cube), strict=True):
            if row.direction != "–" or row.axis != "–":
                sentences.append(
                    f"{name.station}: mean fall direction {row.direction} (resultant {row.direction_resultant}), mean fall "
                    f"axis {row.axis} (resultant {row.axis_resultant}), over all blocks, each plane once; a resultant near 0 "
                    "means falls to nearly every side."
                )
    return sentences


def _counted(results: Results) -> str:
    """How many records and earthquakes, and what their number means."""
    records, with_vertical = len(results.names), results.with_vertical
    text = (
        f"{counted(records, 'record')} of {counted(results.earthquakes, 'earthquake')}. Records of one earthquake are not "
        "independent, so earthquakes are counted, not records; azimuths of one record are the same motion seen from many "
        "sides, so they are no samples at all."
    )
    if with_vertical == 0:
        return f"{text} None of these records has vertical motion; what it would change is not in these numbers."
    if with_vertical < records:
        return f"{text} {with_vertical} records have vertical motion, the others none."
    return text


def _cases(results: Results) -> str:
    """Of how many cases the report speaks, and how many have no outcome."""
    cases, computed = int(results.cube["overturned"].size), int((results.cube["mirrored"] == 0).sum().compute())
    share = "" if math.isnan(results.fallen) else f" {percent(results.fallen)} of them overturn."
    others = (
        "all were computed" if computed == cases else f"{computed:,} were computed, the others are their mirror images"
    )
    absent = ", ".join(f"{count:,} {name}" for name, count in results.missing.items())
    return f"The study has {cases:,} cases (record × azimuth × height × B/H × friction); {others}.{share} " + (
        f"Without an outcome: {absent}." if absent else "No outcome is missing."
    )


def _summary_table(axes: dict[str, AxisSummary]) -> Table:
    columns = number_columns(
        *("earthquakes", "with falls", "mean axis from normal", "interval", "alignment", "interval"),
        *("closer to normal", "Rayleigh p", "V test p"),
    )
    rows = tuple(
        (
            name,
            str(s.earthquakes),
            str(s.n),
            degrees(s.mean_axis_deg),
            "–" if math.isnan(s.mean_axis_half_width_deg) else f"±\u00a0{s.mean_axis_half_width_deg:.0f}°",
            "–" if s.n == 0 else number(s.alignment),
            interval(*s.alignment_interval),
            f"{s.closer_to_normal} of {s.n}",
            *("–" if s.n < 2 else f"{test.p_value:.2g}" for test in (s.rayleigh, s.v)),
        )
        for name, s in axes.items()
    )
    return Table((Column("records", "text"), *columns), rows)


def verdict(summary: AxisSummary) -> str:
    """What the interval of the alignment says, in a few words."""
    low, high = summary.alignment_interval
    if math.isnan(low):
        return f"{counted(summary.n, 'earthquake')} {'is' if summary.n == 1 else 'are'} too few for an interval"
    if low > 0:
        return "falls lie closer to the fault normal than to the fault"
    if high < 0:
        return "falls lie closer to the fault than to its normal"
    return "no preference for the normal or the fault can be told"


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
    return f"{number(abs(summary.mean_axis_deg), 0)}°{spread} from the fault normal"


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
    means = [f"{_mean_axis(one)}{_name(name)} ({counted(one.n, 'earthquake')})" for name, one in summaries.items()]
    verdicts = {name: verdict(one) for name, one in summaries.items() if one.n > 0}
    if len(set(verdicts.values())) == 1:
        conclusion = next(iter(verdicts.values()))
    else:
        conclusion = "; ".join(f"{_name(name).strip()}, {text}" for name, text in verdicts.items())
    low, high = (math.nan, math.nan) if difference is None else difference.interval
    if not math.isnan(low):
        shown = "a difference" if low > 0 or high < 0 else "no difference"
        conclusion += f", and {shown} between the two is shown"
    return f"Blocks fall on average {' and '.join(means)}: {conclusion}."


def alignment_sentence(summaries: dict[str, AxisSummary], difference: AlignmentDifference | None) -> str:
    """The alignment of each group and of their difference with the intervals, and how many earthquakes lie closer to what."""
    parts, closer = [], []
    for name, one in summaries.items():
        known = "" if math.isnan(one.alignment_interval[0]) else interval(*one.alignment_interval)
        known = known and f" ({100 * one.level:.0f} % interval {known})"
        if one.n:
            parts.append(f"{number(one.alignment)}{known}{_name(name)}")
            closer.append(f"{one.closer_to_normal} of {counted(one.n, 'earthquake')}{_name(name)}")
    text = f"Alignment, 1 normal to the fault and −1 along it: {'; '.join(parts)}"
    if difference is not None and not math.isnan(difference.difference):
        low, high = difference.interval
        known = "; too few earthquakes for an interval" if math.isnan(low) else f" ({interval(low, high)})"
        text += f"; difference {number(difference.difference)}{known}"
    only = sum(one.n for one in summaries.values()) == 1
    return f"{text}. {' and '.join(closer)} {'lies' if only else 'lie'} closer to the normal than to the fault."


def answer_sentences(
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
    known, share = " whose outcome is known" if missing else "", f"{percent(fallen)} of the cases overturn"
    if math.isnan(fallen):
        return ["No outcome was found, so nothing can be said; see the causes below."]
    if fallen <= 0:
        return [
            f"No block{known} overturned in any direction, so these records say nothing about the direction of falls."
        ]
    if planes == 1:
        return [f"{share}; with a single plane of motion nothing is said about direction."]
    if fallen >= 1:
        return [f"Every block{known} overturned in every plane: there is no axis along which blocks fall more easily."]
    if all(summary.n == 0 for summary in summaries.values()):
        return [f"{share}; no fault normal is known, so nothing is said relative to a fault."]
    return [headline(summaries, difference), alignment_sentence(summaries, difference)]
