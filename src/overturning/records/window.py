"""Window of time that the axes of a sensor share, and contradictions between the axes."""

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta
from typing import Any

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError, RecordRefusalReasonCollector
from overturning.records.component import RecordComponent, seed_band_and_instrument_code
from overturning.records.earthquakes import great_circle_distance_km
from overturning.records.record import largest_pga_pgv_pgd_of_components

MAX_START_OR_DURATION_DIFFERENCE_S = 0.5
"""Largest difference in start or in length between components of one record, s."""

MIN_PEAK_IN_WINDOW_TO_WHOLE_PEAK_RATIO = 0.8
"""Smallest share of a component's peak in the common window, if lengths differ by more than the bound above."""

MAX_STATION_COORDINATE_MISMATCH_KM = 1.0
"""Largest distance between stated places of one station, km; files round them to degrees or minutes."""


class AssemblyRefusalCollector(RecordRefusalReasonCollector):
    """Collector of reasons why components cannot form one record, and of contradictions that the user accepts."""

    def __init__(self, *, accept_contradictions: bool) -> None:
        super().__init__()
        self.trusts_contradictions = accept_contradictions
        self.contradictions_accepted_with_trust_data: list[str] = []

    @property
    def has_refusal_reasons(self) -> bool:
        """True if at least one reason to refuse the components has been collected."""
        return bool(self._found)

    def refuse_or_store_contradiction(self, contradiction_text: str, remedy: str) -> None:
        """Raise a RecordError for a contradiction; if the user trusts the data, only store the contradiction."""
        if not self.trusts_contradictions:
            raise RecordError(f"{contradiction_text}; {remedy}")
        self.contradictions_accepted_with_trust_data.append(contradiction_text)


def check_and_cut_to_common_window(
    components: Sequence[RecordComponent], refusals_out: AssemblyRefusalCollector
) -> list[RecordComponent]:
    """Check that components belong to one record, and cut them to the time window that all of them cover.

    Differences of start are rounded to whole samples, so that a shift of up to half a sample remains. Raises a
    RecordError if sampling intervals differ, or starts by more than 0.5 s. Components of one file may differ in length,
    because recorders stop channels one after another. Different lengths in several files, different stations,
    earthquakes, sensors or places, and a mixture of raw and processed data are contradictions: they raise a RecordError
    unless the user sets ``trust_data``.
    """
    _check_components_belong_to_one_record(components, refusals_out)
    interval = _common_sampling_interval(components)
    _check_station_places_agree(components, refusals_out)
    offsets = _sample_counts_before_common_start(components, interval, refusals_out)
    spread = _checked_longest_minus_shortest_duration_s(components, interval, refusals_out)
    length = min(c.acceleration.size - offset for c, offset in zip(components, offsets, strict=True))
    if length < 2:
        raise RecordError(f"{components[0].file_name}: components have no common window")
    cut = []
    for component, offset in zip(components, offsets, strict=True):
        start = component.start_time_utc and component.start_time_utc + timedelta(seconds=offset * interval)
        cut.append(
            replace(component, acceleration=component.acceleration[offset : offset + length], start_time_utc=start)
        )
    if spread > MAX_START_OR_DURATION_DIFFERENCE_S:
        _check_peak_in_common_window(components, cut, refusals_out)
    return cut


def _check_components_belong_to_one_record(
    components: Sequence[RecordComponent], refusals_out: AssemblyRefusalCollector
) -> None:
    """Report a contradiction if components differ in station, network, earthquake or sensor, or only some are raw."""
    said = [
        (
            c.station,
            c.extra_metadata.get("network", ""),
            c.event,
            "processed" if c.is_already_corrected else "raw",
            c.sensor_location,
            sensor,
        )
        for c, sensor in zip(components, map(seed_band_and_instrument_code, components), strict=True)
    ]
    for texts in zip(*said, strict=True):
        named = {" ".join(text.split()).casefold(): text for text in texts if text}
        if len(named) > 1:
            why = f"{components[0].file_name}: components of {' and '.join(map(repr, named.values()))}"
            remedy = "give the files of one sensor together, or say --trust-data if it is one record anyway"
            refusals_out.refuse_or_store_contradiction(why, f"they are not of one record: {remedy}")


def _common_sampling_interval(components: Sequence[RecordComponent]) -> float:
    """Return the sampling interval of the components, s; raise a RecordError if it is not the same for all."""
    interval = components[0].sampling_interval
    for other in components[1:]:
        if not math.isclose(other.sampling_interval, interval, rel_tol=1e-6):
            raise RecordError(
                f"{other.file_name}: sampling interval {other.sampling_interval:g} s along {other.axis_name_in_file}, "
                f"{components[0].file_name} has {interval:g} s; components of one record must share it"
            )
    return interval


def _sample_counts_before_common_start(
    components: Sequence[RecordComponent], sampling_interval: float, refusals_out: AssemblyRefusalCollector
) -> list[int]:
    """Return each component's number of samples before the latest start of all; zeros if a start is unknown."""
    starts = [c.start_time_utc for c in components if c.start_time_utc is not None]
    if 0 < len(starts) < len(components):
        undated = " and ".join(
            f"{c.axis_name_in_file} of {c.file_name}" for c in components if c.start_time_utc is None
        )
        remedy = "give it the start that it has, or say --trust-data to take first samples as those of one time"
        refusals_out.refuse_or_store_contradiction(
            f"{undated} does not say when it begins, other components do", remedy
        )
    if len(starts) < len(components):
        return [0] * len(components)
    latest = max(starts)
    spread = (latest - min(starts)).total_seconds()
    if spread > MAX_START_OR_DURATION_DIFFERENCE_S:
        raise RecordError(
            f"{components[0].file_name}: components start {spread:.2f} s apart "
            f"(at most {MAX_START_OR_DURATION_DIFFERENCE_S} s); "
            "they are not of one record"
        )
    return [round((latest - start).total_seconds() / sampling_interval) for start in starts]


def _checked_longest_minus_shortest_duration_s(
    components: Sequence[RecordComponent], sampling_interval: float, refusals_out: AssemblyRefusalCollector
) -> float:
    """Return the longest minus the shortest duration of the components, s.

    Report a contradiction if it is above `MAX_START_OR_DURATION_DIFFERENCE_S` and the components come from several
    files that were not digitised from film.
    """
    sizes = [c.acceleration.size for c in components]
    spread = (max(sizes) - min(sizes)) * sampling_interval
    one_file = len({c.sha256 for c in components}) == 1 or all(c.is_digitised_from_analogue_film for c in components)
    if spread > MAX_START_OR_DURATION_DIFFERENCE_S + 0.5 * sampling_interval and not one_file:
        bound = f"(at most {MAX_START_OR_DURATION_DIFFERENCE_S} s)"
        counts = f"{' and '.join(map(str, sizes))} samples, {spread:.2f} s apart {bound}"
        remedy = "get the file again, or say --trust-data to keep the common part"
        refusals_out.refuse_or_store_contradiction(f"{components[0].file_name}: components have {counts}", remedy)
    return spread


def _check_station_places_agree(components: Sequence[RecordComponent], refusals_out: AssemblyRefusalCollector) -> None:
    """Report a contradiction if stated station coordinates are more than `MAX_STATION_COORDINATE_MISMATCH_KM` apart."""
    places = [
        (c.station_latitude_deg, c.station_longitude_deg)
        for c in components
        if c.station_latitude_deg is not None and c.station_longitude_deg is not None
    ]
    for place in places[1:]:
        if (apart := great_circle_distance_km(places[0], place)) > MAX_STATION_COORDINATE_MISMATCH_KM:
            first, other = (f"{north:g}° N, {east:g}° E" for north, east in (places[0], place))
            why = f"{components[0].file_name}: components at {first} and at {other}, {apart:.3g} km apart"
            remedy = "give the files of one sensor together, or say --trust-data if it is one record anyway"
            refusals_out.refuse_or_store_contradiction(why, f"they are not of one record: {remedy}")


def _check_peak_in_common_window(
    components_before_cut: Sequence[RecordComponent],
    components_in_common_window: Sequence[RecordComponent],
    refusals_out: AssemblyRefusalCollector,
) -> None:
    """Report a contradiction if the peak in the common time window is below 80 % of the peak of the whole component.

    A peak is the largest distance of a sample from the mean of the whole component.
    """
    for component, kept in zip(components_before_cut, components_in_common_window, strict=True):
        level = component.acceleration.mean()
        peak, left = (float(np.abs(samples - level).max()) for samples in (component.acceleration, kept.acceleration))
        if left < MIN_PEAK_IN_WINDOW_TO_WHOLE_PEAK_RATIO * peak:
            short, size = min(components_before_cut, key=lambda one: one.acceleration.size), component.acceleration.size
            why = (
                f"{short.file_name}: {short.axis_name_in_file} breaks off after {short.acceleration.size} of {size} "
                f"samples, "
                f"before the largest motion along {component.axis_name_in_file} ({100 * left:.4g} Gal until then, "
                f"{100 * peak:.4g} later)"
            )
            remedy = "get the file again, leave that component out, or say --trust-data to keep the common part"
            refusals_out.refuse_or_store_contradiction(why, remedy)


def common_window_processing_entries(
    components_before_cut: Sequence[RecordComponent],
    components_in_common_window: Sequence[RecordComponent],
    north_acceleration_in_common_window: FloatArray,
    east_acceleration_in_common_window: FloatArray,
) -> tuple[dict[str, Any], ...]:
    """Return the entry for `Record.processing` that describes the cut to the common window; () if nothing was cut."""
    sizes = {c.axis_name_in_file: c.acceleration.size for c in components_before_cut}
    kept, interval = components_in_common_window[0].acceleration.size, components_in_common_window[0].sampling_interval
    left_out = max(sizes.values()) - kept
    found = largest_pga_pgv_pgd_of_components(
        np.stack([north_acceleration_in_common_window, east_acceleration_in_common_window]), interval
    )
    step = {"step": "common_window", "samples": sizes, "kept": kept, "left_out_s": round(left_out * interval, 6)}
    return (step | {"effect": {name: [peak, peak] for name, peak in found.items()}},) if left_out else ()
