"""What only a cube in space holds: how good the plane is beside it, and how far stones turn about the vertical."""

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
"""What `plane_agreement` says, of which of the `plane_counts` over which."""


def plane_counts(cube: xr.Dataset) -> xr.Dataset:
    """What `plane_agreement` is made of, for each record and B/H: counts of cases, and the sum of angles between axes.

    The nominal outcome of a cube in space beside what the planes of the faces say, read one record at a time.
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
    """How well the planes of its faces predict a stone in space: over all of the `plane_counts`, or dimensions kept.

    Returns
    -------
    Dataset
        ``cases`` with an outcome in both. Shares of them, missing where nothing is compared: ``flag``, in which the
        planes say rightly whether it falls; ``flag_beside``, the same of the cases whose neighbour in B/H does
        otherwise; ``only_space`` and ``only_plane``, in which it falls in space alone, or in a plane alone. Of those
        that fall in both ``face``, the share that falls within 45° of the predicted azimuth: over the predicted edge;
        and ``axis``, the mean angle between the axes of both falls, degrees; 45° on average by chance.
    """
    total = counts.sum([name for name in counts.dims if name not in keep])
    shares = {name: total[part] / total[of].where(total[of] > 0) for name, (part, of) in _SHARES.items()}
    return xr.Dataset({"cases": total["cases"], **shares})


class Twist(NamedTuple):
    """How far stones that stand have turned about the vertical: how many moved, and quantiles of the turn, degrees."""

    stones: int
    median: float
    most: float
    largest: float


def turns(cube: xr.Dataset) -> dict[tuple[float, float], NDArray[np.float32]]:
    """Turns of the stones that stand at the end and were not at rest throughout, unsigned degrees, by B/H and friction.

    The cube is read one record at a time; of the turns all are kept, since quantiles need them: four bytes for each.
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
    """Summary of `turns`, whose order it changes; ``most`` is the quantile of that share."""
    if turned.size == 0:
        return Twist(0, *(float("nan"),) * 3)
    return Twist(turned.size, *(_quantile(turned, one) for one in (0.5, share, 1.0)))


def _quantile(values: NDArray[np.float32], share: float) -> float:
    """Quantile in double precision, by interpolation between neighbours, with no copy of the values."""
    place = share * (values.size - 1)
    first = int(place)
    ends = [first, min(first + 1, values.size - 1)]
    values.partition(ends)
    return float(np.quantile(values[ends].astype(np.float64), place - first))
