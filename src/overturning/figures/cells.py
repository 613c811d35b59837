"""Cells of maps: their edges, the full circle of azimuths, the rings and panels that a map shows."""

from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.figures.style import gap_azimuths_one_step_from_simulated_ones
from overturning.model.plane_weights import plane_azimuth_period_deg
from overturning.model.symmetry import PLANE_SYMMETRY_PERIOD_DEG
from overturning.statistics.opposite_azimuths import cube_with_opposite_azimuths

MAX_PANEL_COLUMNS: Final = 3
"""Largest number of panels in a row of a figure."""


def extend_azimuths_to_full_circle(cube: xr.Dataset) -> xr.Dataset:
    """Extend the azimuths of a results cube to the full circle by adding the opposite azimuth of each case.

    Missing values are added next to the ends of each range of azimuths without results; see
    `azimuths_simulated_or_known_by_symmetry_deg`.
    """
    whole = cube_with_opposite_azimuths(cube)
    unknown = gap_azimuths_one_step_from_simulated_ones(whole["azimuth"].to_numpy())
    return whole.reindex(azimuth=np.union1d(whole["azimuth"], unknown)) if unknown.size else whole


def azimuths_simulated_or_known_by_symmetry_deg(cube: xr.Dataset) -> FloatArray:
    """Return the simulated azimuths, degrees, including opposite azimuths whose outcome follows by mirror symmetry."""
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    if plane_azimuth_period_deg(cube) != PLANE_SYMMETRY_PERIOD_DEG:
        return azimuth
    return np.union1d(azimuth, np.round((azimuth + 180.0) % 360.0, 10))


def trim_rings_without_falls_except_innermost(cube: xr.Dataset, *falls: xr.DataArray) -> xr.Dataset:
    """Remove the large B/H at which no block can fall from a results cube, except for the smallest of them.

    The smallest is drawn as an empty ring; a ring is the part of a polar map that shows one B/H. A fall is possible if
    a value of `falls` (flags or probabilities of falling) is above 0, or missing in a direction that was simulated. The
    dataset is unchanged if no fall is possible anywhere.
    """
    return cube.isel(b_over_h=slice(None, count_b_over_h_rings_to_draw(*falls)))


def count_b_over_h_rings_to_draw(*falls: xr.DataArray) -> int:
    """Return the number of B/H to draw: all up to the largest with a possible fall, and the next larger one.

    All are drawn if no fall is possible.
    """

    def has_fall_or_unknown_outcome_by_b_over_h(fall_flags_or_probabilities: xr.Variable) -> xr.Variable:
        """Return, for each B/H, True if a block falls (value above 0) or a simulated case has no known outcome."""
        computed = fall_flags_or_probabilities.notnull().any(
            [name for name in fall_flags_or_probabilities.dims if name not in {"azimuth", "orientation"}]
        )
        return ((fall_flags_or_probabilities.isnull() & computed) | (fall_flags_or_probabilities > 0)).any(
            [name for name in fall_flags_or_probabilities.dims if name != "b_over_h"]
        )

    rings = falls[0].sizes["b_over_h"]
    # Variables have no coordinates, which need not be compared at each operation.
    last = np.flatnonzero(sum(has_fall_or_unknown_outcome_by_b_over_h(one.variable) for one in falls))
    return min(int(last[-1]) + 2, rings) if last.size else rings


def panel_row_and_column_counts(panel_group_count: int, panels_per_group: int) -> tuple[int, int]:
    """Return the numbers of rows and columns of a figure's panels, with at most `MAX_PANEL_COLUMNS` columns."""
    count = panel_group_count * panels_per_group
    columns = (
        panels_per_group
        if panel_group_count > 1 and 1 < panels_per_group <= MAX_PANEL_COLUMNS
        else min(count, MAX_PANEL_COLUMNS)
    )
    columns = 2 if count == 4 else columns
    return -(-count // columns), columns


def cell_edges(cell_centres: FloatArray) -> FloatArray:
    """Return the n + 1 edges of n grid cells, half-way between their centres; ± 5 % for a single cell."""
    if cell_centres.size == 1:
        return np.array([0.95, 1.05]) * cell_centres[0]
    between = (cell_centres[1:] + cell_centres[:-1]) / 2
    return np.concatenate([[2 * cell_centres[0] - between[0]], between, [2 * cell_centres[-1] - between[-1]]])


def b_over_h_cell_edges(b_over_h_values: FloatArray) -> FloatArray:
    """Return the n + 1 edges of map cells around n values of B/H; edges below 0 become 0, as polar axes need."""
    return np.maximum(cell_edges(b_over_h_values), 0.0)


def azimuth_cell_edges_rad(full_circle_azimuths_deg: FloatArray) -> FloatArray:
    """Return the m + 1 ascending edges, radians, of map cells around m azimuths (degrees) of a full circle."""
    next_one = np.append(full_circle_azimuths_deg[1:], full_circle_azimuths_deg[0] + 360.0)
    after = (full_circle_azimuths_deg + next_one) / 2
    return np.radians(np.append(after[-1] - 360.0, after))


def symmetric_polar_curve_angles_rad_and_radii(
    simulated_azimuths_deg: FloatArray, radius_by_azimuth: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return angles (radians) and radii of a closed curve; each value applies to its azimuth and the opposite one.

    The curve has NaN across gaps between azimuths that were not simulated.
    """
    both = np.concatenate([simulated_azimuths_deg, simulated_azimuths_deg + 180.0]) % 360.0
    around = np.concatenate([both, gap_azimuths_one_step_from_simulated_ones(both)])
    unknown = np.full(around.size - both.size, np.nan)
    order = np.argsort(around, kind="stable")
    theta, closed = np.radians(around[order]), np.concatenate([radius_by_azimuth, radius_by_azimuth, unknown])[order]
    return np.append(theta, theta[0] + 2 * np.pi), np.append(closed, closed[0])


def isolated_curve_point_indices(closed_curve_radii: FloatArray) -> list[int]:
    """Return the indices of the points between two NaN of a closed curve, which a line without markers would not show.

    The last value of the closed curve is the first one again. A curve of a single point is isolated.
    """
    known = np.isfinite(closed_curve_radii[:-1])
    has_neighbour = (np.roll(known, 1) | np.roll(known, -1)) & (known.size > 1)
    return [int(index) for index in np.flatnonzero(known & ~has_neighbour)]
