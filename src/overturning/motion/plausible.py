"""Plausibility of recorded accelerations: amplitude, unit, sampling interval, dead or clipped axes."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.motion.integration import integrate
from overturning.units import ACCELERATION_UNITS_IN_M_S2, CM, STANDARD_GRAVITY

MAX_PLAUSIBLE_PGA_M_S2: Final = 5.0 * STANDARD_GRAVITY
"""Largest plausible peak acceleration, m/s²; the largest recorded is 4.1 g (vector sum, Iwate-Miyagi 2008, IWTH25)."""

MAX_PLAUSIBLE_PGV_M_S: Final = 1000.0 * CM
"""Largest plausible peak velocity, m/s; the largest recorded is about 3 m/s (Chi-Chi 1999, TCU068)."""

MIN_PLAUSIBLE_PGA_M_S2: Final = 1e-4 * STANDARD_GRAVITY
"""Smallest plausible peak acceleration of a motion that is not rest, m/s²: about 0.1 Gal, too weak to be felt."""

USUAL_SAMPLING_INTERVAL_RANGE_S: Final = (0.0005, 0.05)
"""Shortest and longest usual sampling interval of accelerographs, s."""

MIN_RECORD_DURATION_WITHOUT_WARNING_S: Final = 2.0
"""Shortest duration of a record that raises no doubt about its sampling interval, s."""

MIN_PGV_PGA_RATIO_WITHOUT_WARNING_S: Final = 0.005
"""Smallest PGV/PGA that raises no doubt about the sampling interval, s: the ratio of a sine of 32 Hz."""

MAX_PEAK_RATIO_OF_DEAD_TO_LIVE_AXIS: Final = 0.01
"""Ratio of the peaks of two axes of one sensor below which the weaker axis is assumed dead."""

MAX_DIFFERENCE_TO_PEAK_RATIO_OF_EQUAL_AXES: Final = 1e-3
"""Largest difference of two horizontal axes, as a share of their peak, at which they count as one axis read twice."""

MIN_EQUAL_SAMPLES_IN_PAUSE: Final = 100
"""Smallest number of consecutive equal samples that indicates a pause of an axis: 0.5 to 1 s for most sensors."""

MIN_PEAK_SHARE_OF_MOVING_AXIS: Final = 0.2
"""Smallest share of its peak that an axis must reach for another axis that stands still then to count as dead."""

MIN_CONSECUTIVE_CLIPPED_SAMPLES: Final = 3
"""Smallest number of consecutive equal samples at the extreme of an axis that indicates clipping."""

_LIKELY_PGA_RANGE_M_S2: Final = (0.005 * STANDARD_GRAVITY, 2.0 * STANDARD_GRAVITY)


def implausible_amplitude_reason(
    components: Sequence[FloatArray], sampling_interval: float, *, unit: str = "", check_velocity: bool = True
) -> str:
    """Return the reason why a motion's amplitude is implausible, with units that would make it plausible; else "".

    Parameters
    ----------
    components : sequence of array, shape (n,)
        Accelerations, m/s².
    sampling_interval : float
        Time between samples, s.
    unit : str
        Declared unit of the numbers, a key of `units.ACCELERATION_UNITS_IN_M_S2`; empty if the file states its unit.
    check_velocity : bool
        Check the velocity too; False if an offset has not been removed yet.

    Notes
    -----
    A motion that is exactly zero is rest in every unit, and plausible.
    """
    peak = max(float(np.abs(samples).max()) for samples in components)
    velocity = 0.0
    if check_velocity:
        velocity = max(float(np.abs(integrate(samples, sampling_interval)).max()) for samples in components)
    if peak > MAX_PLAUSIBLE_PGA_M_S2:
        what, bound = f"peak acceleration {peak / STANDARD_GRAVITY:.3g} g", "at most 5 g"
    elif 0.0 < peak < MIN_PLAUSIBLE_PGA_M_S2:
        what, bound = f"peak acceleration {peak / STANDARD_GRAVITY:.3g} g", "at least 0.0001 g"
    elif velocity > MAX_PLAUSIBLE_PGV_M_S:
        what, bound = f"peak velocity {velocity / CM:.4g} cm/s", "at most 1000 cm/s"
    else:
        return ""
    low, high = USUAL_SAMPLING_INTERVAL_RANGE_S
    unusual = (
        ""
        if low <= sampling_interval <= high or velocity <= MAX_PLAUSIBLE_PGV_M_S
        else f"{_sampling_interval_and_usual_range_text(sampling_interval)}: "
    )
    return f"{unusual}{what} ({bound} is accepted as ground motion); {_likely_units_note(peak, unit)}"


def _sampling_interval_and_usual_range_text(sampling_interval: float) -> str:
    """Return a text with an unusual sampling interval, s, and the range of usual ones."""
    low, high = USUAL_SAMPLING_INTERVAL_RANGE_S
    return f"sampling interval {sampling_interval:g} s ({low:g} to {high:g} s are usual)"


def reasons_to_doubt_sampling_interval(components: Sequence[FloatArray], sampling_interval: float) -> tuple[str, ...]:
    """Return reasons to doubt a sampling interval (s): its size, or the duration or PGV/PGA computed with it.

    A constant offset is removed before the integration to velocity.
    """
    low, high = USUAL_SAMPLING_INTERVAL_RANGE_S
    doubts = [] if 0.999 * low <= sampling_interval <= 1.001 * high else [f"{low:g} to {high:g} s are usual"]
    count = components[0].size
    if count * sampling_interval < MIN_RECORD_DURATION_WITHOUT_WARNING_S:
        doubts.append(
            f"{count} samples then last {count * sampling_interval:.3g} s, less than "
            f"{MIN_RECORD_DURATION_WITHOUT_WARNING_S:g} s"
        )
    ratios = []
    for samples in components:
        moving = samples - samples.mean()
        if (pga := float(np.abs(moving).max())) > 0:
            ratios.append(float(np.abs(integrate(moving, sampling_interval)).max()) / pga)
    if ratios and max(ratios) < MIN_PGV_PGA_RATIO_WITHOUT_WARNING_S:
        doubts.append(
            f"PGV/PGA is then {1000 * max(ratios):.2g} ms, less than {1000 * MIN_PGV_PGA_RATIO_WITHOUT_WARNING_S:g} ms"
        )
    return tuple(doubts)


def dead_horizontal_axis_reason(components: Sequence[FloatArray], axis_names: Sequence[str]) -> str:
    """Return why a horizontal component of a motion has no signal (its sensor axis is dead); "" if none is dead.

    Peaks are counted from the mean: a dead channel may have an offset.

    Parameters
    ----------
    components : sequence of array, shape (n,)
        Accelerations along two horizontal axes and, where there is one, a vertical axis, m/s².
    axis_names : sequence of str
        Names of the axes.
    """
    moving = [samples - samples.mean() for samples in components]
    peaks = [float(np.abs(samples).max()) for samples in moving]
    weak, strong = sorted((0, 1), key=lambda axis: peaks[axis])
    least = "less than 1/100 of that of"
    if peaks[weak] < MAX_PEAK_RATIO_OF_DEAD_TO_LIVE_AXIS * peaks[strong]:
        return (
            f"{axis_names[weak]} is dead: its peak is {peaks[weak] / CM:.3g} Gal, {least} "
            f"{axis_names[strong].removeprefix('axis ')}, {peaks[strong] / CM:.4g} Gal"
        )
    if len(peaks) > 2 and peaks[strong] < MAX_PEAK_RATIO_OF_DEAD_TO_LIVE_AXIS * peaks[2]:
        return (
            f"{axis_names[weak]} and {axis_names[strong]} are dead: at most {peaks[strong] / CM:.3g} Gal, {least} "
            f"vertical {axis_names[2]}, {peaks[2] / CM:.4g} Gal"
        )
    return ""


def reasons_to_doubt_recorded_axes(components: Sequence[FloatArray], axis_names: Sequence[str]) -> list[str]:
    """Return warnings about components of a record that have no signal, equal another component or are clipped.

    Parameters
    ----------
    components : sequence of array, shape (n,)
        Accelerations along two horizontal axes and, where there is one, a vertical axis, m/s².
    axis_names : sequence of str
        Names of the axes.
    """
    dead = dead_horizontal_axis_reason(components, axis_names)
    doubts = [dead] if dead else []
    if are_axes_equal_up_to_offset_and_sign(components[0], components[1]):
        doubts.append(f"{axis_names[0]} and {axis_names[1]} have the same samples")
    for name, samples in zip(axis_names, components, strict=False):
        count, rail = clipped_sample_count_and_level(samples)
        if count:
            doubts.append(f"{name} is clipped: {count} samples stand at its rail, {rail / CM:.4g} Gal")
    return doubts


def are_axes_equal_up_to_offset_and_sign(first_samples: FloatArray, second_samples: FloatArray) -> bool:
    """True if two components differ only in offset and sign, as when one file is read or written twice."""
    if first_samples.size != second_samples.size:
        return False
    first_samples, second_samples = first_samples - first_samples.mean(), second_samples - second_samples.mean()
    unlike = min(float(np.abs(first_samples - sign * second_samples).max()) for sign in (1.0, -1.0))
    return bool(first_samples.any()) and unlike <= MAX_DIFFERENCE_TO_PEAK_RATIO_OF_EQUAL_AXES * float(
        np.abs(first_samples).max()
    )


def longest_pause_indices_while_other_axis_moves(
    samples: FloatArray, samples_of_other_axes: Sequence[FloatArray]
) -> tuple[int, int] | None:
    """Return first and last index of a component's longest run of equal samples while another moves; else None.

    None if there is no run of `MIN_EQUAL_SAMPLES_IN_PAUSE` equal samples, if no other axis then reaches
    `MIN_PEAK_SHARE_OF_MOVING_AXIS` of its peak, or if the axis is too coarse to show such a share of its own peak.
    """
    ends = np.concatenate([[-1], np.flatnonzero(np.diff(samples)), [samples.size - 1]])
    longest = int(np.diff(ends).argmax())
    first, last = int(ends[longest]) + 1, int(ends[longest + 1])
    if last + 1 - first < MIN_EQUAL_SAMPLES_IN_PAUSE:
        return None
    peak = float(np.abs(samples - np.median(samples)).max())
    if not peak:
        return None
    for other in (one for one in samples_of_other_axes if one.size == samples.size):
        moving = np.abs(other - np.median(other))
        share = float(moving[first : last + 1].max()) / max(float(moving.max()), 1e-300)
        if share > MIN_PEAK_SHARE_OF_MOVING_AXIS and share * peak > 10.0 * _estimate_sample_resolution(samples, peak):
            return first, last
    return None


def _estimate_sample_resolution(samples: FloatArray, peak: float) -> float:
    """Return the resolution of a component, m/s²: about the smallest difference between two of its values."""
    gaps = np.diff(np.unique(samples))
    gaps = gaps[gaps > 1e-9 * peak]
    return float(np.quantile(gaps, 0.1)) if gaps.size else peak


def clipped_sample_count_and_level(samples: FloatArray) -> tuple[int, float]:
    """Return the number of clipped samples of a component and the largest clipped level (m/s²); (0, 0) if none.

    Counted are runs of at least `MIN_CONSECUTIVE_CLIPPED_SAMPLES` equal samples at the largest or the smallest value.
    The rounded top of a smooth peak is not counted: L samples beyond a plateau of L equal ones a parabola has dropped
    by at most ((3L − 1) / (L − 1))² ≤ 16 times the resolution, a clipped motion by more.
    """
    level = float(np.median(samples))
    away = samples - level
    farthest = float(np.abs(away).max())
    if not farthest:
        return 0, 0.0
    count, rail = 0, 0.0
    for sign in (1.0, -1.0):
        extreme = float((sign * away).max())
        if extreme < 0.5 * farthest:
            continue
        at = np.flatnonzero(sign * away >= extreme - 1e-9 * farthest)
        if at.size < MIN_CONSECUTIVE_CLIPPED_SAMPLES:
            continue
        min_drop = 20.0 * _estimate_sample_resolution(samples, farthest)
        for run in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1):
            if run.size >= MIN_CONSECUTIVE_CLIPPED_SAMPLES and _is_clipped_sample_range(
                sign * away, int(run[0]), int(run[-1]), min_drop
            ):
                count += run.size
                rail = max(rail, abs(float(samples[run[0]])))
    return count, rail


def _is_clipped_sample_range(samples: FloatArray, first_index: int, last_index: int, min_drop: float) -> bool:
    """True if a run of equal samples at a peak is clipped: its neighbours are lower by more than `min_drop`."""
    length = last_index + 1 - first_index
    sides = samples[max(first_index - length, 0) : first_index], samples[last_index + 1 : last_index + 1 + length]
    return all(side.size > 0 and float(samples[first_index] - side.min()) > min_drop for side in sides)


def _likely_units_note(peak: float, declared_unit: str) -> str:
    """Return a note on the units in which the numbers of a motion would give a usual peak acceleration."""
    if not declared_unit:
        return "the unit stated in the file is wrong, or the samples contain an offset or a spike"
    scale = ACCELERATION_UNITS_IN_M_S2[declared_unit]
    names = {"gal": "Gal", "g": "g", "m/s2": "m/s²", "mg": "mg", "mm/s2": "mm/s²"}
    likely = [
        f"{shown} ({peak / scale * ACCELERATION_UNITS_IN_M_S2[name] / STANDARD_GRAVITY:.2g} g)"
        for name, shown in names.items()
        if ACCELERATION_UNITS_IN_M_S2[name] != scale
        and _LIKELY_PGA_RANGE_M_S2[0] <= peak / scale * ACCELERATION_UNITS_IN_M_S2[name] <= _LIKELY_PGA_RANGE_M_S2[1]
    ]
    name = names.get(declared_unit, declared_unit)
    return f"numbers declared in {name} look like {' or '.join(likely)}" if likely else f"{name} is not their unit"
