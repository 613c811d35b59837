"""Choice of the records whose maps a report shows, by the alignment of their falls."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.statistics.by_record import record_masks_by_group
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION

MAX_REPORT_MAPS = 4
"""Largest number of maps."""

(
    ALL_RECORDS_SHOWN_REASON,
    FALLS_MOST_ALIGNED_WITH_FAULT_NORMAL_REASON,
    MEDIAN_FAULT_NORMAL_ALIGNMENT_REASON,
    FALLS_LEAST_ALIGNED_WITH_FAULT_NORMAL_REASON,
) = (
    "every record",
    "most aligned",
    "median",
    "least aligned",
)
"""Reasons for a choice: all records of a small study, or the place in the order of the alignment."""

BEST_MUTUAL_AGREEMENT_OF_FALLS_REASON = "clearest axis"
"""Reason for the record whose falls agree best with each other, whatever the fault normal."""

FIRST_RECORDS_WITH_FALLS_REASON = "first with falls"
"""Reason for the first records with falls, where the falls of no record have an axis."""


class RecordChosenForReportMap(NamedTuple):
    """Record whose map a report shows: index of the record, and the reason why it was chosen."""

    record_index: int
    reason_for_choice: str


def choose_records_for_report_maps(
    cube: xr.Dataset,
    fault_normal_alignment_by_record: FloatArray,
    fall_axis_resultant_by_record: FloatArray,
    overturned_share_by_record: FloatArray,
) -> list[RecordChosenForReportMap]:
    """Choose at most `MAX_REPORT_MAPS` records of a study whose maps a report shows.

    Parameters
    ----------
    cube : Dataset
        Cube of a study; the records of its first group are chosen from.
    fault_normal_alignment_by_record : array of float, shape (records,)
        Mean cos 2Δ of each record, Δ the angle from the fault normal to a fall; NaN if it is not known.
    fall_axis_resultant_by_record : array of float, shape (records,)
        Mean resultant length of the fall axes of each record, 0 to 1; NaN without falls, or if the choice of plane
        azimuths alone gives falls a mean axis.
    overturned_share_by_record : array of float, shape (records,)
        Share of the cases of each record that overturn.

    Returns
    -------
    list of RecordChosenForReportMap
        All records if the study has at most `MAX_REPORT_MAPS`. Otherwise records of different earthquakes: those whose
        falls have the largest, median and smallest alignment with the fault normal, and the one with the clearest axis
        (largest resultant). Without fault normals: those with the clearest axes. If the resultant of every record is
        below `MIN_RESULTANT_WITH_MEAN_DIRECTION`: the first records with falls.
    """
    if fault_normal_alignment_by_record.size <= MAX_REPORT_MAPS:
        return [
            RecordChosenForReportMap(place, ALL_RECORDS_SHOWN_REASON)
            for place in range(fault_normal_alignment_by_record.size)
        ]
    members = next(iter(record_masks_by_group(cube).values()))
    events = cube["event"].to_numpy().astype(str)
    by_alignment = _record_indices_by_descending_value(fault_normal_alignment_by_record, members)
    clear = _record_indices_by_descending_value(
        fall_axis_resultant_by_record, members & (fall_axis_resultant_by_record >= MIN_RESULTANT_WITH_MEAN_DIRECTION)
    )
    wanted: list[tuple[str, list[int]]] = []
    if clear and by_alignment:
        middle = len(by_alignment) // 2
        nearest = sorted(range(len(by_alignment)), key=lambda rank: (abs(rank - middle), rank))
        wanted += [
            (FALLS_MOST_ALIGNED_WITH_FAULT_NORMAL_REASON, by_alignment),
            (FALLS_LEAST_ALIGNED_WITH_FAULT_NORMAL_REASON, by_alignment[::-1]),
            (MEDIAN_FAULT_NORMAL_ALIGNMENT_REASON, [by_alignment[rank] for rank in nearest]),
        ]
    last = (
        (BEST_MUTUAL_AGREEMENT_OF_FALLS_REASON, clear)
        if clear
        else (FIRST_RECORDS_WITH_FALLS_REASON, np.flatnonzero(members & (overturned_share_by_record > 0)).tolist())
    )
    wanted += [last] * (MAX_REPORT_MAPS - len(wanted))
    chosen: list[RecordChosenForReportMap] = []
    for reason, order in wanted:
        used = {events[one.record_index] for one in chosen}
        place = next((place for place in order if events[place] not in used), None)
        if place is not None:
            chosen.append(RecordChosenForReportMap(place, reason))
    reasons = (
        FALLS_MOST_ALIGNED_WITH_FAULT_NORMAL_REASON,
        MEDIAN_FAULT_NORMAL_ALIGNMENT_REASON,
        FALLS_LEAST_ALIGNED_WITH_FAULT_NORMAL_REASON,
        BEST_MUTUAL_AGREEMENT_OF_FALLS_REASON,
        FIRST_RECORDS_WITH_FALLS_REASON,
    )
    return sorted(chosen, key=lambda one: reasons.index(one.reason_for_choice))


def _record_indices_by_descending_value(
    value_by_record: FloatArray, group_record_mask: "np.typing.NDArray[np.bool_]"
) -> list[int]:
    """Return the indices of the records in `group_record_mask` with a finite value, in order of descending value."""
    known = np.flatnonzero(group_record_mask & np.isfinite(value_by_record))
    return [int(place) for place in known[np.argsort(-value_by_record[known], kind="stable")]]
