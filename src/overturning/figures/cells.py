"""Cells of maps: their edges, the full circle of azimuths, the rings and panels that a map shows."""

from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.figures.style import azimuths_inside_gaps
from overturning.model.planes import azimuth_period_of_cube_deg
from overturning.model.symmetry import PLANE_PERIOD
from overturning.statistics.falls import add_opposite_azimuths

MAX_COLUMNS: Final = 3
"""Largest number of panels in a row of a figure."""


def close_circle(cube: xr.Dataset) -> xr.Dataset:
    """Return a cube extended to the full circle of azimuths; a single azimuth stays as it is.

    The outcomes of opposite azimuths follow from each other. Gaps between azimuths that were not simulated are filled
    with missing values; see `simulated_azimuths`.
    """
    whole = add_opposite_azimuths(cube) if cube["azimuth"].size > 1 else cube
    unknown = azimuths_inside_gaps(whole["azimuth"].to_numpy())
    return whole.reindex(azimuth=np.union1d(whole["azimuth"], unknown)) if unknown.size else whole


def simulated_azimuths(cube: xr.Dataset) -> FloatArray:
    """Return the azimuths, degrees, at which `close_circle` has outcomes of cases; at all others it fills gaps."""
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    if azimuth.size == 1 or azimuth_period_of_cube_deg(cube) != PLANE_PERIOD:
        return azimuth
    return np.union1d(azimuth, np.round((azimuth + 180.0) % 360.0, 10))


def trim_empty_rings(cube: xr.Dataset, *falls: xr.DataArray) -> xr.Dataset:
    """Return a dataset without the outer B/H rings in which no fall is possible, except the first of these.

    A fall is possible if a value of `falls` (flags or probabilities; a block may fall although its neighbours stand) is
    above 0, or missing in a direction that was simulated. The dataset is unchanged if no fall is possible anywhere.
    """
    return cube.isel(b_over_h=slice(None, count_rings_with_falls(*falls)))


def count_rings_with_falls(*falls: xr.DataArray) -> int:
    """Return the number of inner B/H rings up to the first outer ring without falls."""

    def is_ring_possible(fall_values: xr.DataArray) -> xr.DataArray:
        computed = fall_values.notnull().any(
            [name for name in fall_values.dims if name not in {"azimuth", "orientation"}]
        )
        return ((fall_values.isnull() & computed) | (fall_values > 0)).any(
            [name for name in fall_values.dims if name != "b_over_h"]
        )

    rings = falls[0].sizes["b_over_h"]
    last = np.flatnonzero(sum(map(is_ring_possible, falls)))
    return min(int(last[-1]) + 2, rings) if last.size else rings


def panel_rows_and_columns(height_count: int, friction_count: int) -> tuple[int, int]:
    """Return the numbers of rows and columns of panels: a row per height if it fits, at most three columns."""
    count = height_count * friction_count
    columns = friction_count if height_count > 1 and 1 < friction_count <= MAX_COLUMNS else min(count, MAX_COLUMNS)
    columns = 2 if count == 4 else columns
    return -(-count // columns), columns


def cell_edges(centres: FloatArray) -> FloatArray:
    """Return the edges of cells: half-way between centres, symmetric at the ends; ± 5 % for a single cell."""
    if centres.size == 1:
        return np.array([0.95, 1.05]) * centres[0]
    between = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]])


def slenderness_edges(b_over_h: FloatArray) -> FloatArray:
    """Return the edges of B/H cells, at least 0: a polar axis would not draw a ring with a negative edge."""
    return np.maximum(cell_edges(b_over_h), 0.0)


def azimuth_edges(azimuth_deg: FloatArray) -> FloatArray:
    """Return the m + 1 edges of m azimuth cells, radians, ascending over the full circle."""
    if azimuth_deg.size == 1:
        return np.radians(azimuth_deg[0] + np.array([-2.5, 2.5]))
    next_one = np.append(azimuth_deg[1:], azimuth_deg[0] + 360.0)
    after = (azimuth_deg + next_one) / 2
    return np.radians(np.append(after[-1] - 360.0, after))


def close_curve(azimuth_deg: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return angles, radians, and values of a closed curve of a measure that is the same at opposite azimuths.

    The curve has NaN across gaps between azimuths that were not simulated.
    """
    both = np.concatenate([azimuth_deg, azimuth_deg + 180.0]) % 360.0
    around = np.concatenate([both, azimuths_inside_gaps(both)])
    unknown = np.full(around.size - both.size, np.nan)
    order = np.argsort(around, kind="stable")
    theta, closed = np.radians(around[order]), np.concatenate([values, values, unknown])[order]
    return np.append(theta, theta[0] + 2 * np.pi), np.append(closed, closed[0])
