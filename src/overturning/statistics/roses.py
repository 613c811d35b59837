"""Roses: shares of falls by sector, from north and from the fault normal."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.falls import model_of
from overturning.model.planes import azimuth_weight, period_of
from overturning.statistics.bootstrap import bootstrap, event_means, mean_of_sample
from overturning.statistics.by_record import each_record, record_groups
from overturning.statistics.circular import SECTORS, sector_shares
from overturning.statistics.falls import falls_towards, near_boundary


@dataclass(frozen=True)
class Rose:
    """Shares of falls by sector, shape (SECTORS,).

    Attributes
    ----------
    falls : int
        Their number.
    shares : ndarray
        Of the falls, or means over earthquakes of their shares.
    low, high : ndarray
        Ends of the intervals of such means, NaN where there are none.
    earthquakes : int
        Those with falls; 0 where falls are counted and not earthquakes.
    what : str
        What is counted.
    """

    falls: int
    shares: FloatArray
    low: FloatArray
    high: FloatArray
    earthquakes: int = 0
    what: str = "falls"

    @property
    def title(self) -> str:
        """What it is of."""
        return f"{self.falls} {self.what}" + (f", {self.earthquakes} earthquakes" if self.earthquakes else "")


def rose_of(
    cube: xr.Dataset, *, from_normal: bool = False, level: float = 0.95, draws: int = 2000, seed: int = 1
) -> Rose:
    """Rose of the nominal fall azimuths of a cube that has them, read one record at a time.

    Each record's shares are averaged over the records of an earthquake, and these over earthquakes, as of `bootstrap`;
    ``from_normal`` takes azimuths from the fault normal, of the records for which it is known.
    """
    zero = cube["fault_normal"].to_numpy() if from_normal else np.zeros(cube.sizes["record"])
    events = np.atleast_1d(cube["event"].to_numpy().astype(str))
    shares = np.full((zero.size, SECTORS), np.nan)
    total = 0
    for row, one in enumerate(each_record(cube, ["fall_azimuth"])):
        angles = one["fall_azimuth"].to_numpy()
        known = angles[np.isfinite(angles)].astype(np.float64) - zero[row]
        known = known[np.isfinite(known)]
        if known.size:
            shares[row], total = sector_shares(known), total + known.size
    fell = np.isfinite(shares[:, 0])
    means = event_means(shares[fell], events[fell])
    nowhere = np.full(SECTORS, np.nan)
    if means.size == 0:
        return Rose(0, np.zeros(SECTORS), nowhere, nowhere)
    # The same samples for each sector, since the seed is the same.
    ends = [bootstrap(mean_of_sample, column, level=level, draws=draws, seed=seed) for column in means.T]
    low, high = np.array(ends).T
    return Rose(total, means.mean(axis=0), low, high, len(means))


def study_roses(cube: xr.Dataset) -> dict[str, tuple[Rose, Rose | None]]:
    """Roses by group of records: from north, and from the fault normal, None where no record's is known.

    Where each direction has its own component of the motion they are of the falls that tell most about direction: those
    of blocks near the boundary (`near_boundary`), or all where there is none. Each plane counts once, and azimuths
    added to the grid share the weight of their neighbourhood. Otherwise they are means over earthquakes, as of
    `rose_of`.
    """
    groups, known = record_groups(cube), np.isfinite(cube["fault_normal"].to_numpy())
    of = _counted_roses(cube) if model_of(cube).one_component else partial(_rose_of_records, cube)
    return {
        name: (of(members, False), of(members & known, True) if known.any() else None)
        for name, members in groups.items()
    }


def _rose_of_records(cube: xr.Dataset, members: NDArray[np.bool_], from_normal: bool) -> Rose:
    return rose_of(cube.isel(record=np.flatnonzero(members)), from_normal=from_normal)


def _counted_roses(cube: xr.Dataset) -> Callable[[NDArray[np.bool_], bool], Rose]:
    near = near_boundary(cube)
    some = bool(near.any())
    falls = falls_towards(cube).where(near | (not some)).sum(["height", "b_over_h", "friction"]).compute()
    azimuth = falls["azimuth"].to_numpy().astype(np.float64)
    counts = falls.transpose("record", "azimuth").to_numpy().astype(np.float64)
    weighted = counts * azimuth_weight(azimuth, period_of(cube))
    zero, nowhere = cube["fault_normal"].to_numpy(), np.full(SECTORS, np.nan)

    def of(members: NDArray[np.bool_], from_normal: bool) -> Rose:
        relative = (azimuth - zero[members][:, None]) % 360.0
        shares = (
            sector_shares(relative.ravel(), weighted[members].ravel())
            if from_normal
            else sector_shares(azimuth, weighted[members].sum(axis=0))
        )
        what = "falls near the boundary" if some else "falls"
        return Rose(round(counts[members].sum()), shares, nowhere, nowhere, what=what)

    return of
