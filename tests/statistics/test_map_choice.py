"""Choice of the records whose maps a report shows."""

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.statistics.map_choice import (
    ALL_RECORDS_SHOWN_REASON,
    BEST_MUTUAL_AGREEMENT_OF_FALLS_REASON,
    FALLS_LEAST_ALIGNED_WITH_FAULT_NORMAL_REASON,
    FALLS_MOST_ALIGNED_WITH_FAULT_NORMAL_REASON,
    FIRST_RECORDS_WITH_FALLS_REASON,
    MEDIAN_FAULT_NORMAL_ALIGNMENT_REASON,
    choose_records_for_report_maps,
)


def cube_of_earthquakes_and_pulse_flags(events: str, pulse: list[float]) -> xr.Dataset:
    """Return a cube that has only the earthquake and the pulse flag of each record."""
    return xr.Dataset({"pulse": ("record", pulse)}, {"event": ("record", list(events))})


def test_maps_of_all_records_of_a_small_study_are_shown() -> None:
    chosen = choose_records_for_report_maps(
        cube_of_earthquakes_and_pulse_flags("AAB", [np.nan] * 3), np.full(3, np.nan), np.full(3, 0.5), np.ones(3)
    )
    assert chosen == [(0, ALL_RECORDS_SHOWN_REASON), (1, ALL_RECORDS_SHOWN_REASON), (2, ALL_RECORDS_SHOWN_REASON)]


def test_maps_show_the_extreme_and_median_alignments_of_the_pulse_group() -> None:
    """Maps are chosen from the seven records that have a pulse.

    The two records without a pulse have the largest and the smallest alignment of all, and are not chosen.
    """
    alignment = np.array([0.1, 0.9, -0.7, 0.3, 0.5, -0.2, np.nan, 1.0, -1.0])
    resultant = np.array([0.2, 0.9, 0.8, 0.4, 0.7, 0.99, 1.0, 1.0, 1.0])
    cube = cube_of_earthquakes_and_pulse_flags("ABCDEFGHI", [1.0] * 7 + [0.0] * 2)
    chosen = {reason: place for place, reason in choose_records_for_report_maps(cube, alignment, resultant, np.ones(9))}
    # Sorted: B 0.9, E 0.5, D 0.3, A 0.1, F −0.2, C −0.7: the middle one is A.
    assert chosen == {
        FALLS_MOST_ALIGNED_WITH_FAULT_NORMAL_REASON: 1,
        FALLS_LEAST_ALIGNED_WITH_FAULT_NORMAL_REASON: 2,
        MEDIAN_FAULT_NORMAL_ALIGNMENT_REASON: 0,
        BEST_MUTUAL_AGREEMENT_OF_FALLS_REASON: 6,
    }


def test_each_map_shows_a_record_of_another_earthquake() -> None:
    alignment, resultant = np.array([0.9, 0.8, 0.1, -0.8, -0.9]), np.array([0.9, 0.8, 0.3, 0.8, 0.95])
    chosen = choose_records_for_report_maps(
        cube_of_earthquakes_and_pulse_flags("AABCC", [1.0] * 5), alignment, resultant, np.ones(5)
    )
    assert [place for place, _ in chosen] == [0, 2, 4]


@pytest.mark.parametrize("known", [True, False])
def test_maps_show_the_clearest_fall_axes_without_fault_normals(known: bool) -> None:
    resultant = np.array([0.2, 0.9, 0.8, 0.4, 0.7]) if known else np.full(5, np.nan)
    share = np.full(5, float(known))
    chosen = choose_records_for_report_maps(
        cube_of_earthquakes_and_pulse_flags("ABCDE", [1.0] * 5), np.full(5, np.nan), resultant, share
    )
    assert [place for place, _ in chosen] == ([1, 2, 4, 3] if known else [])


@pytest.mark.parametrize("resultant", [0.9 * MIN_RESULTANT_WITH_MEAN_DIRECTION, np.nan])
def test_maps_show_the_first_records_with_falls_if_none_has_a_fall_axis(resultant: float) -> None:
    """The first records with falls are shown if the resultants of fall directions give no axis.

    The resultants are too small (falls in all directions) or undefined (the choice of planes imposes the axis). Nothing
    falls under the first record.
    """
    share = np.array([0.0, 0.2, 0.1, 0.3, 0.3, 1.0])
    chosen = choose_records_for_report_maps(
        cube_of_earthquakes_and_pulse_flags("ABCCDE", [1.0] * 6), np.full(6, 0.01), np.full(6, resultant), share
    )
    assert chosen == [
        (1, FIRST_RECORDS_WITH_FALLS_REASON),
        (2, FIRST_RECORDS_WITH_FALLS_REASON),
        (4, FIRST_RECORDS_WITH_FALLS_REASON),
        (5, FIRST_RECORDS_WITH_FALLS_REASON),
    ]
