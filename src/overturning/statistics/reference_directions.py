"""Alignment of falls with reference directions: peaks, pulse and the direction away from the epicentre."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.bootstrap import (
    MeanOverEarthquakes,
    mean_over_earthquakes,
)
from overturning.statistics.by_record import record_masks_by_group
from overturning.statistics.earthquakes import BOUNDS_OF_COSINE_DIFFERENCE, fall_sums_for_direction_statistics_by_record
from overturning.statistics.falls import (
    mean_cosine_and_sine_to_reference,
)
from overturning.units import EARTH_RADIUS_KM

MIN_EPICENTRAL_DISTANCE_FOR_RADIAL_DIRECTION_KM: Final = 1.0
"""Smallest epicentral distance with a radial direction, km; epicentres are not located more accurately."""


def azimuth_away_from_epicentre(cube: xr.Dataset) -> xr.DataArray:
    """Compute, for each record, the azimuth at the station that points away from the epicentre.

    This radial direction is the back azimuth + 180°, along the great circle on a sphere; that on the ellipsoid differs
    by at most 0.2°.

    Parameters
    ----------
    cube : Dataset
        With ``epicentre_latitude``, ``epicentre_longitude``, ``station_latitude`` and ``station_longitude`` of each
        record, degrees, north and east positive, NaN where unknown. The result is NaN if the cube lacks any of these
        variables.

    Returns
    -------
    DataArray
        Degrees clockwise from north, 0 to 360; NaN where a location is unknown, or the station is nearer to the
        epicentre than `MIN_EPICENTRAL_DISTANCE_FOR_RADIAL_DIRECTION_KM`.
    """
    names = [f"{where}_{name}" for where in ("epicentre", "station") for name in ("latitude", "longitude")]
    if any(name not in cube.variables for name in names):
        return xr.DataArray(math.nan)
    bare = (cube[name].reset_coords(drop=True).astype(np.float64) for name in names)  # nothing to merge at each step
    latitude0, longitude0, latitude, longitude = map(np.radians, bare)
    east = longitude - longitude0
    # East and north components of the unit vector to the epicentre, in the axes of the station.
    towards_east = -np.cos(latitude0) * np.sin(east)
    towards_north = np.cos(latitude) * np.sin(latitude0) - np.sin(latitude) * np.cos(latitude0) * np.cos(east)
    far = np.hypot(towards_east, towards_north) >= math.sin(
        MIN_EPICENTRAL_DISTANCE_FOR_RADIAL_DIRECTION_KM / EARTH_RADIUS_KM
    )
    radial = np.degrees(np.arctan2(-towards_east, -towards_north)) % 360.0
    return radial.where(far)


_AZIMUTH_VARIABLE_BY_REFERENCE_DIRECTION = {
    "peak velocity": "pgv_azimuth",
    "peak acceleration": "pga_azimuth",
    "pulse": "pulse_axis",
}


@dataclass(frozen=True)
class MeanFallAlignmentByBOverH:
    """Mean alignment of the falls of a group of records with several reference directions, by range of B/H.

    All values are means over the earthquakes of the group.

    Attributes
    ----------
    cosines_per_b_over_h_by_reference_and_axial : dict
        Lists, by range of B/H, of the mean of ``cosine`` of `mean_cosine_and_sine_to_reference`. Keys: name of the
        reference, and True if falls and reference are axes (cos 2Δ), False if directions (cos Δ; peaks and radial
        direction only).
    two_best_aligned_reference_names : tuple of str
        The two references with the largest mean cos 2Δ in the first range of B/H. Only the references known for the
        largest number of records are compared, so that all means are over the same records; shorter if there are fewer.
    best_minus_second_axis_cosines_per_b_over_h : list of MeanOverEarthquakes
        Mean of cos 2Δ for the best aligned reference minus that for the second best under the same record, by range of
        B/H.
    """

    cosines_per_b_over_h_by_reference_and_axial: dict[tuple[str, bool], list[MeanOverEarthquakes]]
    two_best_aligned_reference_names: tuple[str, ...]
    best_minus_second_axis_cosines_per_b_over_h: list[MeanOverEarthquakes]


def alignments_with_reference_axes_by_record_group(
    cube: xr.Dataset, reference_azimuths: xr.Dataset, index_slices_along_b_over_h: Sequence[slice] | None = None
) -> dict[str, MeanFallAlignmentByBOverH]:
    """Compute, by group of records, the alignment of falls with reference directions such as the fault normal.

    References are the azimuths of PGA and PGV, the pulse axis, the fault normal and the direction from the epicentre.

    The last one, the radial direction, is left out if no record has one. The transverse axis is no reference of its
    own: its mean cos 2Δ is that of the radial axis with the opposite sign.

    Parameters
    ----------
    cube, reference_azimuths : Dataset
        Cube, and azimuths ``pgv_azimuth``, ``pga_azimuth`` and ``pulse_axis`` of each record, degrees.
    index_slices_along_b_over_h : sequence of slice
        Ranges of positions along B/H; not given: each B/H separately.
    """
    sums = fall_sums_for_direction_statistics_by_record(cube, "b_over_h")
    parts = index_slices_along_b_over_h or [slice(index, index + 1) for index in range(cube.sizes["b_over_h"])]
    totals = [sums.isel(b_over_h=part).sum("b_over_h") for part in parts]
    references = {
        name: reference_azimuths[of].drop_vars("record", errors="ignore")
        for name, of in _AZIMUTH_VARIABLE_BY_REFERENCE_DIRECTION.items()
    }
    events, cosines = cube["event"].to_numpy().astype(str), dict[tuple[str, bool], list[FloatArray]]()
    references["fault normal"], radial = cube["fault_normal"], azimuth_away_from_epicentre(cube)
    if radial.notnull().any():
        references["radial direction"] = radial
    for name, azimuth in references.items():
        for axial in (True, False)[: 1 + name.startswith(("peak", "radial"))]:
            cosines[name, axial] = [
                mean_cosine_and_sine_to_reference(one, azimuth, axial=axial)["cosine"].to_numpy() for one in totals
            ]
    return {
        group: _mean_alignment_with_reference_axes_in_group(cosines, members, events)
        for group, members in record_masks_by_group(cube).items()
    }


def _mean_alignment_with_reference_axes_in_group(
    cosines_by_reference: dict[tuple[str, bool], list[FloatArray]],
    group_record_mask: NDArray[np.bool_],
    earthquake_name_by_record: NDArray[np.str_],
) -> MeanFallAlignmentByBOverH:
    """Average cosines to reference directions over a group's earthquakes, for each reference and range of B/H.

    The lists of `cosines_by_reference` have one array of shape (records,) for each range of B/H; their keys
    are those of `MeanFallAlignmentByBOverH.cosines_per_b_over_h_by_reference_and_axial`.
    """

    def mean_cosine_over_earthquakes(
        cosine_by_record: FloatArray, cosine_bounds: tuple[float, float] = (-1.0, 1.0)
    ) -> MeanOverEarthquakes:
        return mean_over_earthquakes(
            np.where(group_record_mask, cosine_by_record, np.nan), earthquake_name_by_record, value_bounds=cosine_bounds
        )

    means = {key: [mean_cosine_over_earthquakes(one) for one in values] for key, values in cosines_by_reference.items()}
    counts = {
        name: int(np.isfinite(cosines_by_reference[name, True][0][group_record_mask]).sum())
        for name, axial in means
        if axial
    }
    known = [name for name, records in counts.items() if records == max(counts.values()) > 0]
    first, *others = sorted(known, key=lambda name: -means[name, True][0].mean) or [""]
    pairs = zip(cosines_by_reference[first, True], cosines_by_reference[others[0], True], strict=True) if others else ()
    closer = [mean_cosine_over_earthquakes(one - other, BOUNDS_OF_COSINE_DIFFERENCE) for one, other in pairs]
    return MeanFallAlignmentByBOverH(means, tuple([first, *others][:2]) if first else (), closer)
