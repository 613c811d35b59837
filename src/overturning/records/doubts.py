"""Doubts about the samples of a record: dead or clipped axes, and a sampling interval that no accelerograph has."""

from collections.abc import Callable, Sequence

import numpy as np

from overturning.motion.plausible import DEAD_RATIO, samples_at_rail, sampling_doubts
from overturning.records.component import Component


def sample_notes(components: Sequence[Component], contradicts: Callable[[str, str], None]) -> list[str]:
    """Return notes on the samples of the components of one record, the two horizontal ones first.

    A sampling interval that two things speak against is handed to ``contradicts`` with the remedy.
    """
    notes = [*_sampling_notes(components, contradicts), *_vertical_notes(components)]
    for component in components:
        count, rail = samples_at_rail(component.samples)
        if count:
            notes.append(
                f"{component.file}: axis {component.axis!r} is clipped: {count} samples stand at its rail, "
                f"{100 * rail:.4g} Gal; the ground moved more than that"
            )
    return notes


def _moving_peak(component: Component) -> float:
    """Peak less the mean, m/s²: a dead channel may have an offset."""
    return float(np.abs(component.samples - component.samples.mean()).max())


def check_dead_axis(components: Sequence[Component], contradicts: Callable[[str, str], None]) -> None:
    """Refuse a record of which one horizontal axis is dead: every block would fall along the other one."""
    if len(components) < 2 or any(c.vertical for c in components[:2]):
        return
    weak, strong = sorted(components[:2], key=_moving_peak)
    small, large = _moving_peak(weak), _moving_peak(strong)
    if small < DEAD_RATIO * large:
        contradicts(
            f"{weak.file}: axis {weak.axis!r} is dead: its peak is {100 * small:.3g} Gal, less than 1/100 of that of "
            f"{strong.axis!r}, {100 * large:.4g} Gal",
            "get the file again, or say --trust-data",
        )


def _vertical_notes(components: Sequence[Component]) -> list[str]:
    peaks = [_moving_peak(component) for component in components]
    if len(peaks) < 3 or peaks[2] >= DEAD_RATIO * max(peaks[:2]):
        return []
    dead = components[2]
    return [
        f"{dead.file}: vertical axis {dead.axis!r} is dead: its peak is {100 * peaks[2]:.3g} Gal, that of the "
        f"horizontal axes {100 * max(peaks[:2]):.4g} Gal"
    ]


def _sampling_notes(components: Sequence[Component], contradicts: Callable[[str, str], None]) -> list[str]:
    """Return the doubt about the sampling interval, which is a contradiction where two things speak against it."""
    first = components[0]
    doubts = sampling_doubts([c.samples for c in components[:2]], first.sampling_interval)
    if not doubts:
        return []
    why = f"{first.file}: sampling interval {first.sampling_interval:g} s is doubtful: {'; '.join(doubts)}"
    if len(doubts) == 1:
        return [f"{why}; look whether its unit is right"]
    contradicts(why, "correct it or its unit, or say --trust-data")
    return []
