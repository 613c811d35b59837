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

MIN_SHARE_OF_PEAK_TO_JUDGE_OTHER_AXIS_DEAD: Final = 0.2
"""Smallest share of its peak that an axis must reach for another axis that stands still then to count as dead."""

MIN_CONSECUTIVE_CLIPPED_SAMPLES: Final = 3
"""Smallest number of consecutive equal samples at the extreme of an axis that indicates clipping."""

_LIKELY_PGA_RANGE_M_S2: Final = (0.005 * STANDARD_GRAVITY, 2.0 * STANDARD_GRAVITY)


def implausible_amplitude_reason(
    acceleration_components: Sequence[FloatArray],
    sampling_interval: float,
    *,
    declared_unit_if_file_states_none: str = "",
    check_velocity: bool = True,
) -> str:
    """Return the reason why a motion's amplitude is implausible, with units that would make it plausible; else "".

    Parameters
    ----------
    acceleration_components : sequence of array, shape (n,)
        Accelerations, m/s².
    sampling_interval : float
        Time between samples, s.
    declared_unit_if_file_states_none : str
        Declared unit of the numbers, a key of `units.ACCELERATION_UNITS_IN_M_S2`; empty if the file states its unit.
    check_velocity : bool
        Check the velocity too; False if an offset has not been removed yet.

    Notes
    -----
    A motion that is exactly zero is rest in every unit, and plausible.
    """
    peak = max(float(np.abs(samples).max()) for samples in acceleration_components)
    velocity = 0.0
    if check_velocity:
        velocity = max(
            float(np.abs(integrate(samples, sampling_interval)).max()) for samples in acceleration_components
        )
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
    note = _likely_units_note(peak, declared_unit_if_file_states_none)
    return f"{unusual}{what} ({bound} is accepted as ground motion); {note}"


def _sampling_interval_and_usual_range_text(sampling_interval: float) -> str:
    """Return a text that states a sampling interval, s, and the usual range."""
    low, high = USUAL_SAMPLING_INTERVAL_RANGE_S
    return f"sampling interval {sampling_interval:g} s ({low:g} to {high:g} s are usual)"


def reasons_to_doubt_sampling_interval(
    acceleration_components: Sequence[FloatArray], sampling_interval: float
) -> tuple[str, ...]:
    """Return reasons to doubt a sampling interval, s: it is unusual, or gives a short duration or a small PGV/PGA.

    A constant offset is removed before the integration to velocity.
    """
    low, high = USUAL_SAMPLING_INTERVAL_RANGE_S
    doubts = [] if 0.999 * low <= sampling_interval <= 1.001 * high else [f"{low:g} to {high:g} s are usual"]
    count = acceleration_components[0].size
    if count * sampling_interval < MIN_RECORD_DURATION_WITHOUT_WARNING_S:
        doubts.append(
            f"{count} samples then last {count * sampling_interval:.3g} s, less than "
            f"{MIN_RECORD_DURATION_WITHOUT_WARNING_S:g} s"
        )
    ratios = []
    for samples in acceleration_components:
        moving = samples - samples.mean()
        if (pga := float(np.abs(moving).max())) > 0:
            ratios.append(float(np.abs(integrate(moving, sampling_interval)).max()) / pga)
    if ratios and max(ratios) < MIN_PGV_PGA_RATIO_WITHOUT_WARNING_S:
        doubts.append(
            f"PGV/PGA is then {1000 * max(ratios):.2g} ms, less than {1000 * MIN_PGV_PGA_RATIO_WITHOUT_WARNING_S:g} ms"
        )
    return tuple(doubts)


def dead_horizontal_axis_reason(acceleration_components: Sequence[FloatArray], axis_names: Sequence[str]) -> str:
    """Return why a horizontal component is dead (peak below 1 % of that of another component); "" if none is.

    Peaks are counted from the mean: a dead channel may have an offset.

    Parameters
    ----------
    acceleration_components : sequence of array, shape (n,)
        Accelerations along two horizontal axes and, where there is one, a vertical axis, m/s².
    axis_names : sequence of str
        Names of the axes.
    """
    moving = [samples - samples.mean() for samples in acceleration_components]
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


def warnings_of_dead_equal_or_clipped_axes(
    acceleration_components: Sequence[FloatArray], axis_names: Sequence[str]
) -> list[str]:
    """Return warnings about components of a record that are dead, equal another component or are clipped.

    Parameters
    ----------
    acceleration_components : sequence of array, shape (n,)
        Accelerations along two horizontal axes and, where there is one, a vertical axis, m/s².
    axis_names : sequence of str
        Names of the axes.
    """
    dead = dead_horizontal_axis_reason(acceleration_components, axis_names)
    doubts = [dead] if dead else []
    if are_axes_equal_up_to_offset_and_sign(acceleration_components[0], acceleration_components[1]):
        doubts.append(f"{axis_names[0]} and {axis_names[1]} have the same samples")
    for name, samples in zip(axis_names, acceleration_components, strict=False):
        count, rail = clipped_sample_count_and_level(samples)
        if count:
            doubts.append(f"{name} is clipped: {count} samples stand at its rail, {rail / CM:.4g} Gal")
    return doubts


def are_axes_equal_up_to_offset_and_sign(
    first_axis_acceleration: FloatArray, second_axis_acceleration: FloatArray
) -> bool:
    """True if two components differ only in offset and sign, as when one file is read or written twice."""
    if first_axis_acceleration.size != second_axis_acceleration.size:
        return False
    first = first_axis_acceleration - first_axis_acceleration.mean()
    second = second_axis_acceleration - second_axis_acceleration.mean()
    unlike = min(float(np.abs(first - sign * second).max()) for sign in (1.0, -1.0))
    return bool(first.any()) and unlike <= MAX_DIFFERENCE_TO_PEAK_RATIO_OF_EQUAL_AXES * float(np.abs(first).max())


def longest_pause_indices_while_other_axis_moves(
    acceleration_samples: FloatArray, acceleration_samples_of_other_axes: Sequence[FloatArray]
) -> tuple[int, int] | None:
    """Return first and last index of a component's longest run of equal samples, if another axis moves then; else None.

    The result is None if the run has fewer than `MIN_EQUAL_SAMPLES_IN_PAUSE` samples, or if no other axis exceeds the
    share `MIN_SHARE_OF_PEAK_TO_JUDGE_OTHER_AXIS_DEAD` of its peak during the run. It is also None if the component
    could not show such motion: the share that the other axis reaches, of the component's peak, is at most 10 times its
    resolution.
    """
    ends = np.concatenate([[-1], np.flatnonzero(np.diff(acceleration_samples)), [acceleration_samples.size - 1]])
    longest = int(np.diff(ends).argmax())
    first, last = int(ends[longest]) + 1, int(ends[longest + 1])
    if last + 1 - first < MIN_EQUAL_SAMPLES_IN_PAUSE:
        return None
    peak = float(np.abs(acceleration_samples - np.median(acceleration_samples)).max())
    if not peak:
        return None
    for other in (one for one in acceleration_samples_of_other_axes if one.size == acceleration_samples.size):
        moving = np.abs(other - np.median(other))
        share = float(moving[first : last + 1].max()) / max(float(moving.max()), 1e-300)
        if share > MIN_SHARE_OF_PEAK_TO_JUDGE_OTHER_AXIS_DEAD and share * peak > 10.0 * _estimate_sample_resolution(
            acceleration_samples, peak
        ):
            return first, last
    return None


def _estimate_sample_resolution(acceleration_samples: FloatArray, peak_departure_from_median: float) -> float:
    """Return the resolution of a component, m/s²: the 10 % quantile of the gaps between its sorted distinct values."""
    gaps = np.diff(np.unique(acceleration_samples))
    gaps = gaps[gaps > 1e-9 * peak_departure_from_median]
    return float(np.quantile(gaps, 0.1)) if gaps.size else peak_departure_from_median


def clipped_sample_count_and_level(acceleration_samples: FloatArray) -> tuple[int, float]:
    """Return the number of clipped samples of a component and the largest clipped level (m/s²); (0, 0) if none.

    Runs of at least `MIN_CONSECUTIVE_CLIPPED_SAMPLES` equal samples at the largest or the smallest value are counted,
    unless they are the rounded top of a smooth peak. A parabola whose top has L equal samples drops over the next L
    samples by at most ((3L − 1) / (L − 1))² ≤ 16 times the resolution. Beside a counted run, the drop
    exceeds 20 times the resolution.
    """
    level = float(np.median(acceleration_samples))
    away = acceleration_samples - level
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
        min_drop = 20.0 * _estimate_sample_resolution(acceleration_samples, farthest)
        for run in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1):
            if run.size >= MIN_CONSECUTIVE_CLIPPED_SAMPLES and _is_clipped_sample_range(
                sign * away, int(run[0]), int(run[-1]), min_drop
            ):
                count += run.size
                rail = max(rail, abs(float(acceleration_samples[run[0]])))
    return count, rail


def _is_clipped_sample_range(
    departures_from_median_towards_peak: FloatArray,
    first_index_of_run: int,
    last_index_of_run: int,
    min_drop_beside_run: float,
) -> bool:
    """Return True if a run of equal samples at a peak is clipped: the motion drops steeply on both sides of it.

    On each side, one of as many samples as the run has must be lower by more than `min_drop_beside_run`, m/s².
    """
    length = last_index_of_run + 1 - first_index_of_run
    before = departures_from_median_towards_peak[max(first_index_of_run - length, 0) : first_index_of_run]
    after = departures_from_median_towards_peak[last_index_of_run + 1 : last_index_of_run + 1 + length]
    peak = departures_from_median_towards_peak[first_index_of_run]
    return all(side.size > 0 and float(peak - side.min()) > min_drop_beside_run for side in (before, after))


def _likely_units_note(peak_acceleration: float, declared_unit_if_file_states_none: str) -> str:
    """Return a note for an error message: units in which a motion's numbers give a usual PGA, or another cause."""
    if not declared_unit_if_file_states_none:
        return "the unit stated in the file is wrong, or the samples contain an offset or a spike"
    scale = ACCELERATION_UNITS_IN_M_S2[declared_unit_if_file_states_none]
    names = {"gal": "Gal", "g": "g", "m/s2": "m/s²", "mg": "mg", "mm/s2": "mm/s²"}
    likely = [
        f"{shown} ({peak_acceleration / scale * ACCELERATION_UNITS_IN_M_S2[name] / STANDARD_GRAVITY:.2g} g)"
        for name, shown in names.items()
        if ACCELERATION_UNITS_IN_M_S2[name] != scale
        and _LIKELY_PGA_RANGE_M_S2[0]
        <= peak_acceleration / scale * ACCELERATION_UNITS_IN_M_S2[name]
        <= _LIKELY_PGA_RANGE_M_S2[1]
    ]
    name = names.get(declared_unit_if_file_states_none, declared_unit_if_file_states_none)
    return f"numbers declared in {name} look like {' or '.join(likely)}" if likely else f"{name} is not their unit"
