"""The answer to the study's question: how falls lie to the fault normal, with their uncertainty."""

import math
from functools import partial

import numpy as np

from overturning.report.blocks import Answer, Block, Figure, Note, Paragraph, Section
from overturning.report.results import Results
from overturning.report.sections.convergence import dependence
from overturning.report.sections.records import record_directions
from overturning.report.text import counted, degrees, interval, number, percent
from overturning.statistics.bootstrap import mean_over_earthquakes
from overturning.statistics.by_record import by_record, record_groups
from overturning.statistics.earthquakes import AxisSummary
from overturning.statistics.falls import fall_means
from overturning.study.cube import earthquakes_said
from overturning.study.scenes import scene_of

MOST_RECORDS_IN_WORDS = 5
"""Records whose directions still stand in sentences; of more the table tells."""


def answer(results: Results) -> Section:
    """The answer, what it is counted over, and the axes it comes from."""
    axes: tuple[Block, ...] = ()
    within: tuple[str, ...] = ()
    if results.tells_axes:
        within = (agreement_within(results),)
        figure = Figure(
            results.figures / "axes.svg",
            "fall axis of each earthquake relative to its fault normal",
            "Fall axis of each earthquake relative to its fault normal, over all blocks of the study; the point grows "
            "with "
            "how strongly the axes agree. Below, the mean over earthquakes with its bootstrap interval. Which side of "
            "the "
            "fault normal counts as positive is arbitrary, so only axes are compared.",
            width=0.82,
        )
        axes = (figure,)
    sentences = Answer((*scene_sentences(results), *answer_sentences(results), *within, *_directions_in_words(results)))
    exact = dependence(results)
    blocks = (sentences, *((exact,) if exact else ()), Paragraph(_counted(results)), *axes, Note(_cases(results)))
    return Section("Answer", blocks, anchor="answer")


def scene_sentences(results: Results) -> tuple[str, ...]:
    """In how many cases anything of a scene of several elements falls, which, and of which one the rest speaks."""
    if not results.elements:
        return ()
    *each, anything = results.elements
    if not anything.falls:
        return ("Nothing of the scene falls in any case whose outcome is known.",)
    shares = ", ".join(f"the {one.name} in {percent(one.share)}" for one in each)
    shown = scene_of(results.study).shown_name
    return (
        f"In {percent(anything.share)} of the cases something falls: {shares}. “Blocks” are the {shown} in what "
        "follows.",
    )


def answer_sentences(results: Results) -> tuple[str, ...]:
    """A few sentences with numbers and their uncertainty, or why there are none."""
    known = " whose outcome is known" if any(absent for _, absent in results.statuses.values()) else ""
    share = f"{percent(results.fallen)} of the cases overturn"
    if math.isnan(results.fallen):
        return ("No outcome was found, so nothing can be said; see the causes below.",)
    if results.fallen <= 0:
        nothing = "so these records say nothing about the direction of falls"
        return (f"No block{known} overturned in any direction, {nothing}.",)
    if results.one_axis:
        return (f"{share}; with a single plane of motion nothing is said about direction.",)
    if results.fallen >= 1:
        return (f"Every block{known} overturned in every plane: there is no axis along which blocks fall more easily.",)
    if not results.faults_known:
        return (f"{share}; no fault normal is known, so nothing is said relative to a fault.",)
    return headline(results), alignment_sentence(results)


def headline(results: Results) -> str:
    """Mean fall axis with its interval, and whether it tells normal from parallel."""
    means = [f"{_mean_axis(one)}{_name(name)} ({_earthquakes(one)})" for name, one in results.axes.items()]
    verdicts = {name: _verdict(one) for name, one in results.axes.items() if one.n > 0}
    if len(set(verdicts.values())) == 1:
        conclusion = next(iter(verdicts.values()))
    else:
        conclusion = "; ".join(f"{_name(name).strip()}, {text}" for name, text in verdicts.items())
    difference = results.axes_difference
    if difference is not None and not math.isnan(difference.interval[0]):
        low, high = difference.interval
        shown = "a difference" if low > 0 or high < 0 else "no difference"
        conclusion += f", and {shown} between the two is shown"
    return f"Blocks fall on average {' and '.join(means)}: {conclusion}."


def alignment_sentence(results: Results) -> str:
    """The alignment of each group and of their difference, and how many earthquakes lie closer to what."""
    parts, closer = [], []
    groups = {_name(name): one for name, one in results.axes.items() if one.n}
    for name, one in groups.items():
        known = f" ({100 * one.level:.0f} % interval {interval(*one.alignment_interval)})"
        parts.append(f"{number(one.alignment)}{'' if math.isnan(one.alignment_interval[0]) else known}{name}")
        closer.append(f"{one.closer_to_normal} of {counted(one.n, 'earthquake')}{name}")
    text = f"Alignment, 1 normal to the fault and −1 along it: {'; '.join(parts)}"
    difference = results.axes_difference
    if difference is not None and not math.isnan(difference.difference):
        few = math.isnan(difference.interval[0])
        known = "; too few earthquakes for an interval" if few else f" ({interval(*difference.interval)})"
        text += f"; difference {number(difference.difference)}{known}"
    lie = "lies" if sum(one.n for one in groups.values()) == 1 else "lie"
    return f"{text}. {' and '.join(closer)} {lie} closer to the normal than to the fault."


def agreement_within(results: Results) -> str:
    """How far the fall axes of one record agree, over earthquakes, by group of records."""
    cube, model = results.cube, results.model
    lengths = by_record(partial(fall_means, over=model.case_dims), cube, model.reads)["axis_resultant"].to_numpy()
    events = cube["event"].to_numpy().astype(str)
    parts = []
    for name, members in record_groups(cube).items():
        found = mean_over_earthquakes(np.where(members, lengths, np.nan), events)
        known = "" if math.isnan(found.low) else f" ({interval(found.low, found.high)})"
        parts.append(f"{number(found.value)}{known}{_name(name)}")
    return (
        f"Within a record the fall axes agree with a mean resultant of {' and '.join(parts)}; 1 means all alike, 0 any."
    )


def _verdict(summary: AxisSummary) -> str:
    """What the interval of the alignment says."""
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
    spread = "" if math.isnan(summary.mean_axis_half_width_deg) else f"\u00a0{half_width(summary)}"
    return f"{degrees(abs(summary.mean_axis_deg))}{spread} from the fault normal"


def _earthquakes(summary: AxisSummary) -> str:
    """How many earthquakes a mean axis is of, and of how many in all where some have no falls."""
    if summary.n == summary.earthquakes:
        return counted(summary.n, "earthquake")
    return f"{summary.n or 'none'} of {counted(summary.earthquakes, 'earthquake')} with falls"


def half_width(summary: AxisSummary) -> str:
    """Half of the interval of a mean axis, ± 12°."""
    width = summary.mean_axis_half_width_deg
    return "–" if math.isnan(width) else f"±\u00a0{degrees(width)}"


def _directions_in_words(results: Results) -> list[str]:
    """Mean fall direction and axis of each of a few records where there is no fault to compare them with."""
    many = len(results.names) > MOST_RECORDS_IN_WORDS
    if many or results.faults_known or not results.fallen > 0 or results.one_axis:
        return []
    return [
        f"{name.station}: mean fall direction {direction} (resultant {one}), mean fall axis {axis} (resultant "
        f"{other}), over "
        "all blocks, each plane once; a resultant near 0 means falls to nearly every side."
        for name, (direction, one, axis, other, *_) in zip(results.names, record_directions(results.cube), strict=True)
        if direction != "–" or axis != "–"
    ]


def _counted(results: Results) -> str:
    """How many records and earthquakes, and what their number means."""
    records, with_vertical = len(results.names), results.with_vertical
    names = "".join(f" {said}." for said in earthquakes_said(results.cube))
    text = (
        f"{counted(records, 'record')} of {counted(results.earthquake_count, 'earthquake')}.{names} Records of one "
        "earthquake are not "
        f"independent, so earthquakes are counted, not records; {results.model.direction}s of one "
        "record are the same motion seen from many sides, so they are no samples at all."
    )
    if with_vertical == 0:
        return f"{text} None of these records has vertical motion; what it would change is not in these numbers."
    return (
        text if with_vertical == records else f"{text} {with_vertical} records have vertical motion, the others none."
    )


def _cases(results: Results) -> str:
    """Of how many cases the report speaks, and how many have no outcome."""
    cases, computed = (
        int(results.cube["overturned"].size),
        int((results.cube[results.model.copied] == 0).sum().compute()),
    )
    falls = results.elements[-1].share if results.elements else results.fallen
    what = "In {} of them something falls." if results.elements else "{} of them overturn."
    share = "" if math.isnan(falls) else f" {what.format(percent(falls))}"
    copied = f"{computed:,} were computed, the others are {results.words.copies}"
    others = "all were computed" if computed == cases else copied
    absent = ", ".join(f"{count:,} {name}" for name, (_, count) in results.statuses.items() if count)
    missing = f"Without an outcome: {absent}." if absent else "No outcome is missing."
    of = " × ".join(("record", *results.model.dims)).replace("b_over_h", "B/H")
    others_too = len(results.study.amplitude) - 1
    more = (
        f" The cube has them under the records times {counted(others_too, 'other factor')} too." if others_too else ""
    )
    return f"The study has {cases:,} cases ({of}); {others}.{share} {missing}{more}"
