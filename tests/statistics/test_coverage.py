"""Coverage of intervals and error rate of tests on synthetic cubes with the clusters of the default study."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from scipy.special import iv

from overturning.statistics.bootstrap import MeanOverEarthquakes
from overturning.statistics.earthquakes import (
    MeanFallAxisAndAlignmentOverEarthquakes,
    difference_in_mean_alignment_with_fault_normal,
    fall_axes_from_fault_normal_by_group,
    summarise_fall_axes,
)
from tests.statistics.conftest import FallRule, cube_from_fall_rules

GROUP_NAMES_BY_PULSE = {1: "with a velocity pulse", 0: "without (control)"}
RECORD_COUNTS_PER_EARTHQUAKE_BY_PULSE = {1: [2, 1, 1, 1, 1, 1, 1, 2, 1, 2, 1], 0: [2, 2, 1, 2, 1, 2, 1, 2, 1]}
"""Records of each earthquake of the default study with a pulse (11 earthquakes) and without (9)."""
EARTHQUAKE_INDICES_BY_PULSE = {1: list(range(11)), 0: [0, 3, 5, 7, 8, 9, 11, 12, 13]}
"""Index of each earthquake of a group; six earthquakes have records in both groups."""
BLOCK_B_OVER_H = (0.2, 0.3, 0.4)
FALL_SECTOR_HALF_WIDTHS_DEG = (10, 20, 30, 40)
"""Half-width of the azimuths in which a block falls about its axis, degrees."""
DOUBLED_AXIS_SCATTER_RAD = 0.7
"""Standard deviation of the doubled axes of the blocks of a record, rad: with it a record has a resultant of 0.7."""
DATA_SET_COUNT = 1600
DATA_SETS_PER_CUBE = 50
"""Data sets in one cube."""


class FallAxisSummariesOfRandomDataSet(NamedTuple):
    """Fall-axis summaries of one random data set by group of records, and the difference between the groups.

    The difference, of the mean alignments with the fault normal, is None for most data sets.
    """

    summary_by_record_group: dict[str, MeanFallAxisAndAlignmentOverEarthquakes]
    alignment_difference_of_groups: MeanOverEarthquakes | None


def fall_rule_about_axis_of_each_b_over_h(axes_deg: np.ndarray, half_width: int) -> FallRule:
    """Return a rule: blocks of each B/H fall in planes within ``half_width``° of the axis given for this B/H."""

    def falls_near_axis_of_own_b_over_h(
        azimuth: np.ndarray, _: np.ndarray, slender: np.ndarray, __: np.ndarray
    ) -> np.ndarray:
        axis = axes_deg[np.searchsorted(BLOCK_B_OVER_H, slender - 1e-9)]
        return (np.abs((azimuth - axis + 90) % 180 - 90) <= half_width).astype(float)

    return falls_near_axis_of_own_b_over_h


def expected_fault_normal_alignment(kappa: float) -> float:
    """Return the expected cos 2Δ (Δ: fall axis to fault normal) of random data sets with concentration κ.

    The factors stand for von Mises directions, normal scatter of the axes, and fall sectors of several widths.
    """
    wide = 2 * np.radians(FALL_SECTOR_HALF_WIDTHS_DEG)
    return float(
        iv(2, kappa) / iv(0, kappa) * np.exp(-(DOUBLED_AXIS_SCATTER_RAD**2) / 2) * np.mean(np.sin(wide) / wide)
    )


def cube_of_falls_scattered_about_fault_normals(generator: np.random.Generator, kappa: float) -> xr.Dataset:
    """Return a cube of several data sets whose fall directions are von Mises distributed (κ) about fault normals."""
    rules, events, normals, pulses = [], [], [], []
    for replicate in range(DATA_SETS_PER_CUBE):
        direction = generator.uniform(-np.pi, np.pi, 14) if kappa == 0 else generator.vonmises(0.0, kappa, 14)
        for pulse, clusters in RECORD_COUNTS_PER_EARTHQUAKE_BY_PULSE.items():
            for number in np.repeat(EARTHQUAKE_INDICES_BY_PULSE[pulse], clusters).tolist():
                normal = generator.uniform(0, 360)
                scatter = DOUBLED_AXIS_SCATTER_RAD / 2 * generator.normal(size=len(BLOCK_B_OVER_H))
                axes = normal + np.degrees(direction[number] + scatter)
                rules.append(
                    fall_rule_about_axis_of_each_b_over_h(axes, int(generator.choice(FALL_SECTOR_HALF_WIDTHS_DEG)))
                )
                normals.append(normal)
                events.append(f"{replicate}-{number}")
                pulses.append(pulse)
    grid = {"azimuth": range(0, 180, 5), "height": [0.6], "b_over_h": BLOCK_B_OVER_H, "friction": [1.0]}
    return cube_from_fall_rules(rules, events=events, fault_normal=normals, pulse=pulses, **grid)


@cache
def summarise_random_data_sets(kappa: float) -> list[FallAxisSummariesOfRandomDataSet]:
    """Summarise random data sets with von Mises concentration κ as the report does; κ = 0 is isotropic."""
    generator, found = np.random.default_rng(42), list[FallAxisSummariesOfRandomDataSet]()
    for _ in range(DATA_SET_COUNT // DATA_SETS_PER_CUBE):
        groups = fall_axes_from_fault_normal_by_group(cube_of_falls_scattered_about_fault_normals(generator, kappa))
        for replicate in range(DATA_SETS_PER_CUBE):
            own = {
                name: axes.isel(event=np.flatnonzero(np.char.startswith(axes["event"].values, f"{replicate}-")))
                for name, axes in groups.items()
            }
            pair = (own[name] for name in GROUP_NAMES_BY_PULSE.values())
            difference = difference_in_mean_alignment_with_fault_normal(*pair) if replicate % 25 == 0 else None
            found.append(
                FallAxisSummariesOfRandomDataSet(
                    {name: summarise_fall_axes(one) for name, one in own.items()}, difference
                )
            )
    return found


@pytest.mark.long
@pytest.mark.parametrize("pulse", [1, 0])
@pytest.mark.parametrize("kappa", [0.0, 1.0, 3.0])
def test_intervals_of_the_alignment_cover_the_true_value(kappa: float, pulse: int) -> None:
    """Intervals of the alignment cover the true value in 92 to 97.5 % of random data sets.

    The plain percentile interval, which is not used, covered it in 88 to 92 % and showed a false preference in 9 %.
    """
    found = [
        one.summary_by_record_group[GROUP_NAMES_BY_PULSE[pulse]].mean_cos_of_doubled_angle_to_fault_normal
        for one in summarise_random_data_sets(kappa)
    ]
    truth = expected_fault_normal_alignment(kappa)
    assert {one.earthquake_count for one in found} == {len(RECORD_COUNTS_PER_EARTHQUAKE_BY_PULSE[pulse])}
    assert np.mean([one.mean for one in found]) == pytest.approx(truth, abs=0.02)
    assert 0.92 <= np.mean([one.interval_low <= truth <= one.interval_high for one in found]) <= 0.975
    if kappa == 0:
        assert np.mean([one.interval_low > 0 or one.interval_high < 0 for one in found]) <= 0.07


@pytest.mark.long
@pytest.mark.parametrize("kappa", [0.0, 1.0, 3.0])
def test_intervals_of_alignment_differences_of_equal_groups_cover_zero(kappa: float) -> None:
    found = [
        one.alignment_difference_of_groups
        for one in summarise_random_data_sets(kappa)
        if one.alignment_difference_of_groups is not None
    ]
    assert np.mean([one.interval_low <= 0 <= one.interval_high for one in found]) >= 0.92


@pytest.mark.long
@pytest.mark.parametrize("group", GROUP_NAMES_BY_PULSE.values())
def test_mean_axis_is_reported_for_aligned_and_rarely_for_isotropic_falls(group: str) -> None:
    """Without a significance test 93 % of isotropic data sets would report an axis.

    Directions with κ = 3 have a mean cos 2Δ of 0.31 (Δ: fall axis to fault normal).
    """
    given = {
        kappa: np.mean(
            [
                np.isfinite(one.summary_by_record_group[group].mean_axis_from_fault_normal_deg)
                for one in summarise_random_data_sets(kappa)
            ]
        )
        for kappa in (0, 3)
    }
    assert given[0] <= 0.07
    assert given[3] >= 0.25
    # If an axis is given, its interval covers the true one.
    axes = [
        one.summary_by_record_group[group]
        for one in summarise_random_data_sets(3)
        if np.isfinite(one.summary_by_record_group[group].mean_axis_from_fault_normal_deg)
    ]
    assert (
        np.mean([abs(one.mean_axis_from_fault_normal_deg) <= one.mean_axis_interval_half_width_deg for one in axes])
        >= 0.9
    )
