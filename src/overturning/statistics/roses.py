"""Roses: shares of falls by sector, of directions or axes, from north or the fault normal, means over earthquakes."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import (
    case_weights_by_azimuth_spacing,
    mask_of_azimuths_before_gap_and_grid_step,
    plane_azimuth_period_deg,
)
from overturning.model.space import case_weight_in_direction_statistics
from overturning.model.symmetry import FULL_TURN_DEG
from overturning.statistics.bootstrap import mean_share_interval, means_by_earthquake
from overturning.statistics.by_record import iterate_results_by_record, record_masks_by_group
from overturning.statistics.circular import ROSE_SECTOR_COUNT, fall_shares_by_sector
from overturning.statistics.falls import mask_of_blocks_for_direction_statistics
from overturning.statistics.opposite_azimuths import fall_count_or_probability_by_fall_azimuth


@dataclass(frozen=True)
class FallShareRoseAveragedOverEarthquakes:
    """Rose diagram of falls: mean share, over earthquakes, of the falls in each sector of azimuth.

    The sectors cover a full circle, or half of it for axes. They are 360° / `ROSE_SECTOR_COUNT` wide and ascend; the
    first is centred on 0°.

    Attributes
    ----------
    fall_count : int
        Number of falls.
    mean_fall_share_by_sector : ndarray
        Means over earthquakes of their shares of falls by sector.
    share_interval_low_by_sector, share_interval_high_by_sector : ndarray
        Ends of the intervals of these means; NaN if there are none.
    count_of_earthquakes_with_falls : int
        Number of earthquakes with falls.
    is_measured_from_fault_normal : bool
        True if angles count from the fault normal, False if from north.
    """

    fall_count: int
    mean_fall_share_by_sector: FloatArray
    share_interval_low_by_sector: FloatArray
    share_interval_high_by_sector: FloatArray
    count_of_earthquakes_with_falls: int
    is_measured_from_fault_normal: bool = False

    @property
    def is_axial(self) -> bool:
        """True if opposite fall directions share a sector of the rose, so that the sectors cover half a circle."""
        return self.mean_fall_share_by_sector.size < ROSE_SECTOR_COUNT

    @property
    def earthquake_count_title(self) -> str:
        """Title of the rose diagram: the number of earthquakes with falls, as "3 earthquakes"."""
        return f"{self.count_of_earthquakes_with_falls} earthquake" + "s" * (self.count_of_earthquakes_with_falls != 1)


_FALL_WEIGHT_VARIABLES: Final = ("probability_falls", "fall_north", "fall_east", "members")
"""Variables of a 3-D cube that determine the weight of a fall."""


def _informative_fall_azimuths_and_weights(cube: xr.Dataset) -> tuple[FloatArray, FloatArray]:
    """Return azimuth (degrees) and weight of the falls under one record, two arrays of the same shape.

    Only informative blocks (see `mask_of_blocks_for_direction_statistics`) count. In planar models there is one entry
    per azimuth, whose weight is its number of falls.
    """
    if not default_model_of_same_kind_as_results_cube(cube).is_planar:
        angles = cube["fall_azimuth"].to_numpy()
        fell, weight = np.isfinite(angles), np.ones(angles.shape)
        if "fall_north" in cube:
            parts = (cube[name].to_numpy() for name in _FALL_WEIGHT_VARIABLES)
            weight = case_weight_in_direction_statistics(*parts)
        return angles[fell].astype(np.float64), weight[fell]
    towards = fall_count_or_probability_by_fall_azimuth(cube).where(mask_of_blocks_for_direction_statistics(cube))
    azimuth = towards["azimuth"].to_numpy().astype(np.float64)
    counts = towards.sum([name for name in towards.dims if name != "azimuth"]).to_numpy().astype(np.float64)
    return azimuth, counts


def _width_of_spread_of_2d_falls_in_rose_deg(plane_azimuths_deg: FloatArray) -> float:
    """Return the width (degrees) over which a rose diagram spreads the 2-D falls simulated at one azimuth.

    The width is 0 for a single plane, and if all sectors have equally many planes.
    """
    step = mask_of_azimuths_before_gap_and_grid_step(plane_azimuths_deg, FULL_TURN_DEG)[1]
    in_a_sector = FULL_TURN_DEG / ROSE_SECTOR_COUNT / step
    return 0.0 if plane_azimuths_deg.size <= 2 or abs(in_a_sector - round(in_a_sector)) < 1e-9 else step


def fall_rose(
    cube: xr.Dataset,
    *,
    measure_from_fault_normal: bool = False,
    axial: bool = False,
    confidence_level: float = 0.95,
    bootstrap_sample_count: int = 2000,
) -> FallShareRoseAveragedOverEarthquakes:
    """Compute the rose diagram of falls: the share of falls in each sector of azimuth, averaged over earthquakes.

    Nominal outcomes are used, and the cube is read one record at a time.

    A fall in the 3-D model counts with its `case_weight_in_direction_statistics`, which is small if the fall changes
    direction under nearly the same motion. Shares of a record (each plane counts once) are averaged over the records of
    an earthquake, and then over earthquakes; each sector has its own interval, from `mean_share_interval`. With
    ``measure_from_fault_normal``, azimuths count from the fault normal, and records without one are left out. With
    ``axial``, the shares of opposite sectors are added. If the width of a sector is no multiple of the azimuth step of
    a 2-D study, each fall is spread evenly over one step.
    """
    zero = cube["fault_normal"].to_numpy() if measure_from_fault_normal else np.zeros(cube.sizes["record"])
    events = np.atleast_1d(cube["event"].to_numpy().astype(str))
    shares, total = np.full((zero.size, ROSE_SECTOR_COUNT), np.nan), 0
    planes = default_model_of_same_kind_as_results_cube(cube).is_planar
    for row, one in enumerate(
        iterate_results_by_record(cube, ["overturned"] if planes else ["fall_azimuth", *_FALL_WEIGHT_VARIABLES])
    ):
        azimuth, counts = _informative_fall_azimuths_and_weights(one)
        if counts.any() and np.isfinite(zero[row]):
            weight = (
                counts * case_weights_by_azimuth_spacing(azimuth, plane_azimuth_period_deg(cube)) if planes else counts
            )
            wide = _width_of_spread_of_2d_falls_in_rose_deg(azimuth) if planes else 0.0
            shares[row] = fall_shares_by_sector(azimuth - zero[row], weight, wide)
            total += round(counts.sum()) if planes else counts.size
    if axial:
        shares = shares[:, : ROSE_SECTOR_COUNT // 2] + shares[:, ROSE_SECTOR_COUNT // 2 :]
    fell = np.isfinite(shares[:, 0])
    means = means_by_earthquake(shares[fell], events[fell])
    if means.size == 0:
        nowhere = np.full(shares.shape[1], np.nan)
        return FallShareRoseAveragedOverEarthquakes(
            0, np.zeros(nowhere.size), nowhere, nowhere, 0, measure_from_fault_normal
        )
    # All sectors use the same bootstrap samples, since the seed is the same.
    ends = [
        mean_share_interval(column, confidence_level=confidence_level, bootstrap_sample_count=bootstrap_sample_count)
        for column in means.T
    ]
    low, high = np.array(ends).T
    return FallShareRoseAveragedOverEarthquakes(
        total, means.mean(axis=0), low, high, len(means), measure_from_fault_normal
    )


def fall_rose_from_fault_normal_if_known(cube: xr.Dataset) -> FallShareRoseAveragedOverEarthquakes:
    """Compute the rose diagram of all falls of a study, with angles from the fault normal if any is known.

    Angles count from the fault normal if at least one record has one, otherwise from north.

    The rose is one of axes if a fault normal is known, since its sign is arbitrary, and in 2-D, where a block falls
    along its plane. Only a 3-D study without any fault normal has a rose of directions.
    """
    known = bool(np.isfinite(cube["fault_normal"].to_numpy()).any())
    return fall_rose(
        cube, measure_from_fault_normal=known, axial=known or default_model_of_same_kind_as_results_cube(cube).is_planar
    )


def fall_rose_by_record_group(cube: xr.Dataset) -> dict[str, FallShareRoseAveragedOverEarthquakes]:
    """Compute the rose diagram of falls for each group of records, by name of the group.

    See `fall_rose_from_fault_normal_if_known` and `record_masks_by_group`.
    """
    groups = record_masks_by_group(cube)
    return {
        name: fall_rose_from_fault_normal_if_known(cube.isel(record=np.flatnonzero(members)))
        for name, members in groups.items()
    }
