"""Statistics of 3-D cubes: agreement with the 2-D model, and twist of standing stones."""

from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.statistics.by_record import by_record, each_record
from overturning.statistics.circular import wrap_axis

_SHARES: Final = {
    "flag": ("right", "cases"), "flag_beside": ("right_beside", "beside"), "only_space": ("only_space", "cases"),
    "only_plane": ("only_plane", "cases"), "face": ("over_edge", "both"), "axis": ("axes_apart", "both"),
}  # fmt: skip
"""Numerator and denominator, in `plane_counts`, of each share of `plane_agreement`."""


def plane_counts(cube: xr.Dataset) -> xr.Dataset:
    """Count cases in which the 3-D outcome and the planes of the faces agree, for each record and B/H.

    The cube is read one record at a time. The result also has the sum of angles between the axes of both falls.
    """
    names = ("overturned", "fall_azimuth", "plane_overturned", "plane_fall_azimuth")
    return by_record(_plane_counts, cube, names)


def _plane_counts(cube: xr.Dataset) -> xr.Dataset:
    space, plane = cube["overturned"], cube["plane_overturned"]
    known = space.notnull() & plane.notnull()
    both = (space == 1) & (plane == 1)
    slenderer, stouter = (space.shift(b_over_h=by) for by in (1, -1))
    beside = known & (((space != slenderer) & slenderer.notnull()) | ((space != stouter) & stouter.notnull()))
    apart = (cube["fall_azimuth"].astype("float64") - cube["plane_fall_azimuth"].astype("float64")).where(both)
    found = xr.Dataset({
        "cases": known,
        "right": known & (space == plane),
        "beside": beside,
        "right_beside": beside & (space == plane),
        "only_space": (space == 1) & (plane == 0),
        "only_plane": (space == 0) & (plane == 1),
        "both": both,
        "over_edge": np.abs((apart + 180.0) % 360.0 - 180.0) <= 45.0,
        "axes_apart": np.abs(xr.apply_ufunc(wrap_axis, apart)),
    })  # fmt: skip
    return found.sum([name for name in space.dims if name not in ("record", "b_over_h")])


def plane_agreement(counts: xr.Dataset, *keep: str) -> xr.Dataset:
    """Compute how well the planes of its faces predict a 3-D stone, over all `plane_counts` but the kept dimensions.

    Returns
    -------
    Dataset
        ``cases`` with an outcome in both. Shares of them, missing where nothing is compared: ``flag``, in which the
        planes predict correctly whether it falls; ``flag_beside``, the same for marginal cases, whose neighbour in B/H
        has another outcome; ``only_space`` and ``only_plane``, in which it falls in 3-D only, or in a plane only. Of
        those that fall in both ``face``, the share that falls within 45° of the predicted azimuth, over the predicted
        edge; and ``axis``, the mean angle between the axes of both falls, degrees; 45° on average by chance.
    """
    total = counts.sum([name for name in counts.dims if name not in keep])
    shares = {name: total[part] / total[of].where(total[of] > 0) for name, (part, of) in _SHARES.items()}
    return xr.Dataset({"cases": total["cases"], **shares})


class Twist(NamedTuple):
    """Twist of standing stones: number of stones that moved, and quantiles of the twist, degrees."""

    stones: int
    median: float
    most: float
    largest: float


def turns(cube: xr.Dataset) -> dict[tuple[float, float], NDArray[np.float32]]:
    """Return the absolute twist of stones that moved and stand at the end, degrees, by B/H and friction.

    The cube is read one record at a time; all values are stored (four bytes each), since quantiles need them.
    """
    shapes = [(ratio, friction) for ratio in cube["b_over_h"].to_numpy() for friction in cube["friction"].to_numpy()]
    # As large as they could be; what is never written to takes no memory.
    kept = np.empty((len(shapes), cube["residual_twist"].size // len(shapes)), np.float32)
    count = np.zeros(len(shapes), np.int64)
    for one in each_record(cube, ("overturned", "status", "residual_twist")):
        turned = one["residual_twist"].where((one["status"] == 0) & (one["overturned"] == 0))
        rows = np.abs(turned.transpose("b_over_h", "friction", ...).to_numpy()).reshape(len(shapes), -1)
        for place, row in enumerate(rows):
            known = row[np.isfinite(row)]
            kept[place, count[place] : count[place] + known.size] = known
            count[place] += known.size
    return {shape: kept[place, : count[place]] for place, shape in enumerate(shapes)}


def twist(turned: NDArray[np.float32], share: float = 0.9) -> Twist:
    """Summarise `turns` (reordered in place); ``most`` is the quantile of `share`."""
    if turned.size == 0:
        return Twist(0, *(float("nan"),) * 3)
    return Twist(turned.size, *(_quantile(turned, one) for one in (0.5, share, 1.0)))


def _quantile(values: NDArray[np.float32], share: float) -> float:
    """Compute a quantile in double precision by interpolation, without a copy of the values."""
    place = share * (values.size - 1)
    first = int(place)
    ends = [first, min(first + 1, values.size - 1)]
    values.partition(ends)
    return float(np.quantile(values[ends].astype(np.float64), place - first))
