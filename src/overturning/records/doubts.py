"""Doubts about the samples of a record: dead or clipped axes, and a sampling interval that no accelerograph has."""

from collections.abc import Callable, Iterable, Sequence
from typing import Final

import numpy as np

from overturning.motion.plausible import (
    MAX_PEAK_RATIO_OF_DEAD_TO_LIVE_AXIS,
    are_axes_equal_up_to_offset_and_sign,
    clipped_sample_count_and_level,
    dead_horizontal_axis_reason,
    longest_pause_indices_while_other_axis_moves,
    reasons_to_doubt_sampling_interval,
)
from overturning.records.component import RecordComponent

CLIPPED_NOTE_PHRASE: Final = "is clipped"
SAME_SAMPLES_NOTE_PHRASE: Final = "have the same samples"
STANDSTILL_NOTE_PHRASE: Final = "stands still"
DEAD_VERTICAL_NOTE_PHRASE: Final = "is dead: its peak"
DOUBTFUL_SAMPLING_INTERVAL_NOTE_PHRASE: Final = "is doubtful"

NOTE_PHRASE_BY_DATA_PROBLEM: Final = {
    "clipped samples": CLIPPED_NOTE_PHRASE,
    "two axes with the same samples": SAME_SAMPLES_NOTE_PHRASE,
    "an axis that stands still during the motion": STANDSTILL_NOTE_PHRASE,
    "a dead vertical axis": DEAD_VERTICAL_NOTE_PHRASE,
    "a doubtful sampling interval": DOUBTFUL_SAMPLING_INTERVAL_NOTE_PHRASE,
}
"""Phrase by which each kind of data problem is recognised in the notes of `sample_quality_notes`, by name."""


def data_problem_kinds_in_notes(notes: Iterable[str]) -> list[str]:
    """Find which kinds of data problems, such as clipped samples, the notes on a record mention."""
    notes = list(notes)
    return [kind for kind, phrase in NOTE_PHRASE_BY_DATA_PROBLEM.items() if any(phrase in note for note in notes)]


def sample_quality_notes(
    components: Sequence[RecordComponent], report_contradiction_and_remedy: Callable[[str, str], None]
) -> list[str]:
    """Return notes on dead, clipped or identical axes of a record and on an implausible sampling interval.

    If the sampling interval fails at least two plausibility checks, ``report_contradiction_and_remedy`` is called
    instead; it refuses the record unless the user trusts its data.
    """
    notes = [
        *_doubtful_sampling_interval_notes(components, report_contradiction_and_remedy),
        *_implausibly_weak_vertical_axis_notes(components),
    ]
    first, second = components[0], components[min(1, len(components) - 1)]
    if (
        first is not second
        and not second.vertical_sense
        and are_axes_equal_up_to_offset_and_sign(first.acceleration, second.acceleration)
    ):
        notes.append(
            f"{first.file_name}: axes {first.axis_name_in_file!r} and {second.axis_name_in_file!r} "
            f"{SAME_SAMPLES_NOTE_PHRASE}, so that "
            "the ground moves along one line: is one a copy of the other?"
        )
    for component in components:
        count, rail = clipped_sample_count_and_level(component.acceleration)
        if count:
            notes.append(
                f"{component.file_name}: axis {component.axis_name_in_file!r} {CLIPPED_NOTE_PHRASE}: {count} samples "
                f"stand at "
                f"its rail, {100 * rail:.4g} Gal; the ground moved more than that"
            )
        others = [other.acceleration for other in components if other is not component]
        if pause := longest_pause_indices_while_other_axis_moves(component.acceleration, others):
            begin, end = (index * component.sampling_interval for index in pause)
            notes.append(
                f"{component.file_name}: axis {component.axis_name_in_file!r} {STANDSTILL_NOTE_PHRASE} from "
                f"{begin:.4g} to "
                f"{end:.4g} s while the ground moves along another: it is dead there"
            )
    return notes


def _peak_after_mean_removal(component: RecordComponent) -> float:
    """Return the peak of a component after removing its mean, m/s², since a dead channel may have an offset."""
    return float(np.abs(component.acceleration - component.acceleration.mean()).max())


def report_dead_horizontal_axis(
    components: Sequence[RecordComponent], report_contradiction_and_remedy: Callable[[str, str], None]
) -> None:
    """Call ``report_contradiction_and_remedy`` if a horizontal axis of a record is dead.

    An axis is dead if its peak, measured from its mean, is below 1/100 of the peak of another axis.
    """
    if len(components) < 2 or any(c.vertical_sense for c in components[:2]):
        return
    names = [f"axis {component.axis_name_in_file!r}" for component in components]
    reason = dead_horizontal_axis_reason([component.acceleration for component in components], names)
    if reason:
        weak = min(components[:2], key=_peak_after_mean_removal)
        report_contradiction_and_remedy(f"{weak.file_name}: {reason}", "get the file again, or say --trust-data")


def _implausibly_weak_vertical_axis_notes(components: Sequence[RecordComponent]) -> list[str]:
    """Return a note if the vertical component's peak is below 1/100 of the largest horizontal peak; else []."""
    peaks = [_peak_after_mean_removal(component) for component in components]
    if len(peaks) < 3 or peaks[2] >= MAX_PEAK_RATIO_OF_DEAD_TO_LIVE_AXIS * max(peaks[:2]):
        return []
    dead = components[2]
    return [
        f"{dead.file_name}: vertical axis {dead.axis_name_in_file!r} {DEAD_VERTICAL_NOTE_PHRASE} is "
        f"{100 * peaks[2]:.3g} Gal, "
        f"that of the horizontal axes {100 * max(peaks[:2]):.4g} Gal"
    ]


def _doubtful_sampling_interval_notes(
    components: Sequence[RecordComponent], report_contradiction_and_remedy: Callable[[str, str], None]
) -> list[str]:
    """Return a note if the sampling interval fails one plausibility check; report a contradiction if it fails more."""
    first = components[0]
    doubts = reasons_to_doubt_sampling_interval([c.acceleration for c in components[:2]], first.sampling_interval)
    if not doubts:
        return []
    interval = f"sampling interval {first.sampling_interval:g} s"
    why = f"{first.file_name}: {interval} {DOUBTFUL_SAMPLING_INTERVAL_NOTE_PHRASE}: {'; '.join(doubts)}"
    if len(doubts) == 1:
        return [f"{why}; look whether its unit is right"]
    report_contradiction_and_remedy(why, "correct it or its unit, or say --trust-data")
    return []
