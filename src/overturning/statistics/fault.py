"""Overturning along the fault normal against along the fault, counted in earthquakes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overturning.statistics.falls import overturns

if TYPE_CHECKING:
    import xarray as xr

SECTOR_HALF_WIDTH_DEG = 22.5


def axial_distance(azimuth_deg: NDArray[np.float64], axis_deg: float) -> NDArray[np.float64]:
    """Angle between azimuths and an axis, degrees in [0, 90]: φ and φ + 180° are one plane."""
    return np.abs((azimuth_deg - axis_deg + 90.0) % 180.0 - 90.0)


def shares_by_direction(cube: "xr.Dataset") -> "xr.Dataset":
    """Share of cases that overturn in the planes near the fault normal and in those near the fault, per record.

    Parameters
    ----------
    cube : xarray.Dataset
        The cube, with ``fault_normal`` in degrees per record.

    Returns
    -------
    xarray.Dataset
        ``normal`` and ``parallel`` over dimension record: share of the found outcomes of all heights, slendernesses and
        frictions in planes within 22.5° that overturn; NaN where the fault normal is not known or no plane lies there.
    """
    import xarray as xr

    by_plane = overturns(cube).mean(["height", "b_over_h", "friction"]).compute()
    azimuth = by_plane["azimuth"].to_numpy().astype(np.float64)
    values = by_plane.transpose("record", "azimuth").to_numpy()
    result = np.full((2, values.shape[0]), np.nan)
    for record, normal in enumerate(cube["fault_normal"].to_numpy()):
        for row, axis in enumerate((normal, normal + 90.0)):
            near = (
                axial_distance(azimuth, axis) <= SECTOR_HALF_WIDTH_DEG
                if np.isfinite(axis)
                else np.zeros(azimuth.size, bool)
            )
            if near.any() and np.isfinite(values[record, near]).any():
                result[row, record] = np.nanmean(values[record, near])
    coordinates = {name: cube[name] for name in ("record", "record_id", "station", "event", "pulse") if name in cube}
    return xr.Dataset({"normal": ("record", result[0]), "parallel": ("record", result[1])}, coords=coordinates)


@dataclass(frozen=True)
class GroupComparison:
    """Fault-normal against fault-parallel in one group of records.

    Attributes
    ----------
    name : str
        The group.
    records, earthquakes : int
        How many it has.
    falling : int
        Earthquakes in which any block overturned near one of the two directions.
    more_normal, more_parallel : int
        Of those, in how many a larger share overturned near the normal, or near the fault.
    normal, parallel : float
        Mean over earthquakes of the share that overturns; records of one earthquake are averaged first.
    """

    name: str
    records: int
    earthquakes: int
    falling: int
    more_normal: int
    more_parallel: int
    normal: float
    parallel: float


def compare_group(shares: "xr.Dataset", name: str) -> GroupComparison:
    """Compare the two directions over the records of a dataset made by `shares_by_direction`.

    Parameters
    ----------
    shares : xarray.Dataset
        The records of the group.
    name : str
        Name of the group.

    Returns
    -------
    GroupComparison
    """
    events = shares["event"].to_numpy().astype(str)
    normal, parallel = shares["normal"].to_numpy(), shares["parallel"].to_numpy()
    known = np.isfinite(normal) & np.isfinite(parallel)
    names = sorted(set(events[known]))
    pairs = np.array([[normal[known & (events == e)].mean(), parallel[known & (events == e)].mean()] for e in names])
    pairs = pairs.reshape(-1, 2)
    falling = pairs.max(axis=1, initial=0.0) > 0
    return GroupComparison(
        name=name,
        records=int(events.size),
        earthquakes=len(set(events)),
        falling=int(falling.sum()),
        more_normal=int((pairs[:, 0] > pairs[:, 1]).sum()),
        more_parallel=int((pairs[:, 0] < pairs[:, 1]).sum()),
        normal=float(pairs[:, 0].mean()) if names else float("nan"),
        parallel=float(pairs[:, 1].mean()) if names else float("nan"),
    )
