"""The answer to the study's question, with its uncertainty, for each kind of question."""

import math
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.findings.contrast import compared_records
from overturning.labels import azimuth_gap_label, earthquake_assignment_notes
from overturning.model.planes import azimuth_period_deg
from overturning.model.symmetry import PLANE_PERIOD
from overturning.report.blocks import Answer, Figure, Note, Said, section
from overturning.report.results import Results
from overturning.report.sections.alignment import alignment_sentences, axes_shown
from overturning.report.sections.causes import finding_sentence
from overturning.report.sections.contrast import (
    NO_VERTICAL,
    compared_said,
    contrast_sentences,
    contrast_shown,
    setting_said,
)
from overturning.report.sections.exactness import dependence
from overturning.report.sections.records import record_directions
from overturning.report.sections.space import follow_answer, plane_answer, references_shown
from overturning.report.sections.surveys import survey_sentences
from overturning.report.text import capitalised, counted, decimals, number, percent, verdict
from overturning.statistics.bootstrap import mean_over_earthquakes, share_over_earthquakes
from overturning.statistics.by_record import record_groups
from overturning.statistics.falls import count_flag_changes, overturned_shares_by_record, overturned_shares_near_normal
from overturning.study.evaluation import CONTRASTS, Asks
from overturning.study.scenes import NOMINAL, variant_scene

MOST_RECORDS_IN_WORDS = 5
"""Records whose directions still stand in sentences; of more the table tells."""

_SHARES: Final = {
    "share": "the share of the cases{} that overturn",
    "fall_rate": "the fall rate of the population under the records as they are",
}
"""Primary statistics that are shares of something under each record; of which cases, `Results.of_known` says."""


AnswerParts = tuple[tuple[str, ...], Figure | None]
"""Sentences, and the figure that shows what they say."""


@section("Answer", "answer")
def answer(results: Results) -> Said:
    """The answer for the kind of question that the study asks, its figure, and how far it holds."""
    sentences, figure = ANSWERS[results.study.asks](results)
    yield Answer((*sentences, *scene_sentences(results)))
    yield from (figure, dependence(results), " ".join(_counted(results)), Note(_cases(results)))


def _direction(results: Results) -> AnswerParts:
    """How fall axes lie to the fault normal; without a fault the mean directions of a few records."""
    own = results.study.primary.statistic == "alignment"
    first = () if own else (primary_sentence(results),)
    if untold := _untold(results):
        return (*first, *_directions_in_words(results), untold), None
    sentences = alignment_sentences(results, primary=own)
    return ((*first, *sentences), axes_shown(results)) if own else ((*first, *_changes(results), *sentences), None)


def _changes(results: Results) -> list[str]:
    """How often the outcome is another one along each dimension that says of a block how it stands."""
    parts = list[str]()
    for dim, name, unit in ((results.model.direction, results.model.direction, "°"), ("b_over_h", "B/H", "")):
        steps = np.unique(np.diff(results.cube[dim].to_numpy().astype(np.float64)).round(9))
        changed, pairs = count_flag_changes(results.cube, dim)
        if pairs:
            on = f" ({steps[0]:g}{unit} on)" if steps.size == 1 else ""
            of = " of the cases" if not parts else ""
            parts.append(f"in {percent(changed / pairs, 1)}{of} from one {name} to the next{on}")
    if not parts:
        return []
    what = "whether a block falls, and to which side," if results.model.one_component else "whether a block falls"
    return [capitalised(f"{what} changes {' and '.join(parts)}.")]


def _reference(results: Results) -> AnswerParts:
    """What falls follow, how good the plane is, and the primary statistic."""
    if untold := _untold(results, fault=False):
        return (untold,), None
    plane = [plane_answer(results)] if "plane_overturned" in results.cube else []
    chosen = "Which reference lies closest was found in these results, not fixed beforehand."
    of_fault, _ = _direction(results)
    return (*follow_answer(*results.reference_alignment), *plane, f"{chosen} {of_fault[0]}"), references_shown(results)


def _contrast(results: Results) -> AnswerParts:
    """What a variant changes, as the primary statistic has it, and case by case."""
    sentences, figure = contrast_sentences(results), contrast_shown(results)
    return (primary_sentence(results), *sentences), figure


def _survey(results: Results) -> AnswerParts:
    """The primary statistic, published outcomes and surveys beside the study."""
    if results.study.primary.statistic != "alignment":
        first = [primary_sentence(results)]
    else:
        first = [_untold(results) or alignment_sentences(results, primary=True)[0]]
    near = beside_the_normal(results.cube) if results.study.published else ()
    surveys = (
        f"{one.stones}: {sentence}" if len(results.surveys) > 1 else sentence
        for one in results.surveys
        for sentence in survey_sentences(one.comparison)[:2]
    )
    return (*first, *near, *surveys), None


def beside_the_normal(cube: xr.Dataset) -> tuple[str, ...]:
    """In how many cases planes near the fault normal overturn, and those near the fault; nothing without a fault."""
    within, beyond = overturned_shares_near_normal(cube)
    if math.isnan(within):
        return ()
    return (
        f"Over all its azimuths and sizes the block overturns in {percent(within)} of the cases within 45° of the "
        f"fault normal, and in {percent(beyond)} of the cases nearer to the fault"
        f"{', so not in the direction of the normal only' if beyond > 0 else ''}.",
    )


ANSWERS: Final[dict[Asks, Callable[[Results], AnswerParts]]] = {
    "direction": _direction,
    "reference": _reference,
    **dict.fromkeys(CONTRASTS, _contrast),
    "survey": _survey,
}
"""What answers each kind of question. To add a kind, name it in `study.sections.Asks` and enter its function here."""


def scene_sentences(results: Results) -> tuple[str, ...]:
    """In how many cases anything of a scene of several elements falls, which, and of which one the rest speaks."""
    if not results.element_totals:
        return ()
    *each, anything = results.element_totals
    if not anything.falls:
        return ("Nothing of the scene falls in any case whose outcome is known.",)
    shares = ", ".join(f"the {one.name} in {percent(one.share)}" for one in each)
    shown = variant_scene(results.study).default_element
    return (
        f"In {percent(anything.share)} of the cases{results.of_known} something falls: {shares}. “Blocks” are the "
        f"{shown} in what follows.",
    )


def _untold(results: Results, *, fault: bool = True) -> str:
    """Why nothing is said of the axes of falls, or of them relative to a fault; empty where something is."""
    known, own = results.of_known, results.study.primary.statistic == "share"
    share = "" if own else f"{percent(results.share_overturned)} of the cases{known} overturn; "
    if math.isnan(results.share_overturned):
        return "No outcome was found, so nothing can be said; see the causes below."
    if results.share_overturned <= 0:
        nothing = "so these records say nothing about the direction of falls"
        return f"No block{known} overturned in any direction, {nothing}."
    if results.has_single_axis:
        return capitalised(f"{share}with a single plane of motion nothing is said about direction.")
    if results.every_case_overturns:
        return f"Every block{known} overturned in every plane: there is no axis along which blocks fall more easily."
    if fault and not results.fault_normal_known:
        stated = bool(results.cube["fault_normal"].notnull().any())
        why = "no record that counts has both falls and a known fault normal" if stated else "no fault normal is known"
        return capitalised(f"{share}{why}, so nothing is said relative to a fault.")
    return ""


def primary_sentence(results: Results) -> str:
    """The primary statistic of a study where it is not the alignment, with its interval and what that says."""
    primary, against = results.study.primary, results.study.primary.against
    if primary.statistic == "published":
        return f"Primary statistic, fixed beforehand: {finding_sentence(results, NOMINAL)}"

    def of_record(variant: str) -> FloatArray:
        if primary.statistic == "fall_rate":
            return results.populations[variant]["fall_rate"].sel(amplitude=1.0).to_numpy()
        return overturned_shares_by_record(results.reference_cube(variant)).to_numpy()

    values, what, of = of_record(NOMINAL), _SHARES[primary.statistic].format(results.of_known), ""
    events = results.events
    if against:
        places, of = compared_records(results, against), compared_said(results, against)
        if not places.size:
            return f"Primary statistic, fixed beforehand: {what}. {NO_VERTICAL}"
        values, events = (values - of_record(against))[places], events[places]
        this, that = setting_said(results, NOMINAL, against), setting_said(results, against, NOMINAL)
        what += f" {this}, less that {that}"
    found = (mean_over_earthquakes if against else share_over_earthquakes)(values, events)
    digits, unit = decimals(found), "percentage points" if against else "%"
    shown = f"{number(100 * found.value, digits)}\u00a0{unit}"
    if math.isnan(found.low):
        sure = f"{counted(found.n, 'earthquake')}, too few for an interval"
    else:
        ends = " to ".join(number(100 * end, digits) for end in (found.low, found.high))
        sure = f"95 % interval {ends}{'' if against else ' %'}; {counted(found.n, 'earthquake')}"
    text = f"Primary statistic, fixed beforehand: {what}, a mean over earthquakes{of}, is {shown} ({sure})"
    if not against:
        return f"{text}."
    return f"{text}{verdict(found, f': more fall {this}', f': fewer fall {this}', ': no difference is shown', '')}."


def _directions_in_words(results: Results) -> list[str]:
    """Mean fall direction and axis of each of a few records where there is no fault to compare them with."""
    many = len(results.record_names) > MOST_RECORDS_IN_WORDS
    if many or results.fault_normal_known or not results.share_overturned > 0 or results.has_single_axis:
        return []
    return [
        f"{name.heading}: mean fall direction {direction} (resultant {one}), mean fall axis {axis} (resultant "
        f"{other}), over {results.words.blocks}, each plane once; a resultant near 0 means falls to nearly every side."
        for name, (direction, one, axis, other, *_) in zip(
            results.record_names, record_directions(results), strict=True
        )
        if direction != "–" or axis != "–"
    ]


def _counted(results: Results) -> Iterator[str]:
    """How many records and earthquakes, what their number means, and what of them is left out, a sentence each."""
    records, with_vertical = counted(len(results.record_names), "record"), results.records_with_vertical
    yield f"{records} of {counted(results.earthquake_count, 'earthquake')}."
    yield from (f"{said}." for said in earthquake_assignment_notes(results.cube))
    yield (
        "Records of one earthquake are not independent, so earthquakes are counted, not records; "
        f"{results.model.direction}s of one record are the same motion seen from many sides, so they are no samples at "
        "all."
    )
    neither = ~np.any(list(record_groups(results.cube).values()), axis=0)
    if names := [name.id for name, alone in zip(results.record_names, neither, strict=True) if alone]:
        have, them = ("has", "it") if len(names) == 1 else ("have", "them")
        yield (
            f"Whether {', '.join(names)} {have} a velocity pulse is not stated, so that alignments, axes and roses, of "
            f"records with and without one, leave {them} out."
        )
    # Nothing can fall along planes that were left out.
    if results.model.one_component and not results.has_single_axis and (gaps := azimuth_gap_label(results.cube)):
        none = ", so that no block could fall that way" if azimuth_period_deg(results.cube) == PLANE_PERIOD else ""
        yield f"No plane {gaps} was computed{none}: directions, axes and shares are those of the other planes."
    if with_vertical == 0:
        why = "None of these records has vertical motion"
        if left_out := results.records_without_their_vertical:
            why = f"The study leaves out the vertical motion, which {left_out} of {records} had"
        yield f"{why}; what it would change is not in these numbers."
    elif with_vertical < len(results.record_names):
        have = "has" if with_vertical == 1 else "have"
        yield f"{counted(with_vertical, 'record')} {have} vertical motion, the others none."


def _cases(results: Results) -> str:
    """Of how many cases the report speaks, and how many have no outcome."""
    cases = int(results.cube["overturned"].size)
    computed = int((results.cube[results.model.copied] == 0).sum().compute())
    falls = results.element_totals[-1].share if results.element_totals else results.share_overturned
    them = "those with an outcome" if results.of_known else "them"
    what = f"In {{}} of {them} something falls." if results.element_totals else f"{{}} of {them} overturn."
    share = "" if math.isnan(falls) else f" {what.format(percent(falls))}"
    copied = f"{computed:,} were computed, the others are {results.words.copies}"
    others = "all were computed" if computed == cases else copied
    absent = ", ".join(f"{count:,} {name}" for name, (_, count) in results.status_counts.items() if count)
    missing = f"Without an outcome: {absent}." if absent else "No outcome is missing."
    of = " × ".join(("record", *results.model.dims)).replace("b_over_h", "B/H")
    factors = len(results.study.amplitude) - 1
    times = f" The cube also has them under the records multiplied by {counted(factors, 'other factor')}."
    more = times if factors else ""
    return f"The study has {cases:,} cases ({of}); {others}.{share} {missing}{more}"
