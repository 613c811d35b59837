"""The overturning boundary: where along B/H the probability of falling crosses one half, azimuth by azimuth.

Overturning is not monotonic in B/H: a block may stand between two that fall. So all crossings are given, and the
*boundary* is the last one, above which nothing falls.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.planes import fall_probability, period_of, plane_index, plane_weight
from overturning.statistics.circular import resultant

HALF = 0.5


def _crossings_of_line(line: FloatArray, slenderness: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """All crossings of one line, ascending, and whether falling ends (rather than begins) at each."""
    known = np.isfinite(line)
    p, x = line[known] - HALF, slenderness[known]
    at = np.flatnonzero((p[:-1] >= 0) != (p[1:] >= 0))
    return x[at] + (x[at + 1] - x[at]) * p[at] / (p[at] - p[at + 1]), p[at] >= 0


def crossing_values(probability: ArrayLike, b_over_h: ArrayLike, crossings: int) -> FloatArray:
    """All B/H at which the probability crosses one half, by linear interpolation between neighbouring known cells.

    Parameters
    ----------
    probability : array_like, shape (..., n)
        Probability of falling; NaN where not known (neighbours of a gap are joined across it).
    b_over_h : array_like, shape (n,)
        Ascending.
    crossings : int
        Length of the last dimension of the answer, which ascends and is filled up with NaN; of more the last are kept.
    """

    def of_line(line: FloatArray, slenderness: FloatArray) -> FloatArray:
        crossed = _crossings_of_line(line, slenderness)[0][-crossings:]  # the last: they bound what falls
        return np.append(crossed, np.full(crossings - crossed.size, np.nan))

    return _by_line(of_line, "(n),(n)->(k)", probability, b_over_h)


def crossing_bounds(
    probability: ArrayLike, first: ArrayLike, second: ArrayLike, b_over_h: ArrayLike, crossings: int
) -> FloatArray:
    """Interval of each crossing between the scrambles of an ensemble.

    Parameters
    ----------
    probability, b_over_h, crossings
        As in `crossing_values`, whose crossings these intervals belong to.
    first, second : array_like, shape (..., n)
        Probability of falling of each scramble alone.

    Returns
    -------
    ndarray, shape (..., crossings, 2)
        Lowest and highest of the crossing and the nearest one of each scramble at which falling likewise ends, or
        begins; NaN where a scramble has none.
    """

    def of_line(*lines: FloatArray) -> FloatArray:
        (crossed, ends), *others = (_crossings_of_line(line, lines[-1]) for line in lines[:-1])
        out = np.full((crossings, 2), np.nan)
        for index, (at, end) in enumerate(zip(crossed[-crossings:], ends[-crossings:], strict=True)):
            alike = [values[kinds == end] for values, kinds in others]
            if all(values.size for values in alike):
                near = [at, *(values[np.abs(values - at).argmin()] for values in alike)]
                out[index] = min(near), max(near)
        return out

    return _by_line(of_line, "(n),(n),(n),(n)->(k,b)", probability, first, second, b_over_h)


def _by_line(function: Callable[..., FloatArray], signature: str, *values: ArrayLike) -> FloatArray:
    arrays = [np.asarray(one, dtype=np.float64) for one in values]
    return np.asarray(np.vectorize(function, otypes=[np.float64], signature=signature)(*arrays))


def last_known(probability: ArrayLike) -> FloatArray:
    """The last value along the last axis that is not NaN, NaN where all are; shape (…, n) to (…)."""
    values = np.asarray(probability, dtype=np.float64)
    at = values.shape[-1] - 1 - np.isfinite(values)[..., ::-1].argmax(axis=-1)
    return np.asarray(np.take_along_axis(values, at[..., None], axis=-1)[..., 0])


def _along_b_over_h(function: Callable[..., FloatArray], sizes: dict[str, int], *values: xr.DataArray) -> xr.DataArray:
    lazy = [one.chunk({"b_over_h": -1}) if one.chunks is not None else one for one in values]
    crossed: xr.DataArray = xr.apply_ufunc(
        function,
        *lazy,
        input_core_dims=[["b_over_h"]] * len(lazy),
        output_core_dims=[list(sizes)],
        dask="parallelized",
        dask_gufunc_kwargs={"output_sizes": sizes},
        output_dtypes=[np.float64],
    )
    return crossed


def _crossings(probability: xr.DataArray, count: int) -> xr.DataArray:
    if "b_over_h" not in probability.dims:
        raise ArgumentError("probability: no dimension b_over_h; a boundary is sought along it")
    function = partial(crossing_values, crossings=count)
    return _along_b_over_h(function, {"crossing": count}, probability, probability["b_over_h"].astype("float64"))


def boundary(cube: xr.Dataset, *, crossings: int = 6, ensemble: bool = True) -> xr.Dataset:
    """Crossings of probability one half along B/H, and their interval between the ensemble's scrambles.

    Parameters
    ----------
    cube : Dataset
        The cube; for the interval with the ensemble's ``scramble_difference_towards`` and ``_away``.
    crossings : int
        Most crossings kept per azimuth.
    ensemble : bool
        As in `fall_probability`.

    Returns
    -------
    Dataset
        ``crossing_b_over_h`` (…, crossing), ascending, missing where none; ``crossing_low`` and ``crossing_high``, its
        interval between the scrambles (`crossing_bounds`; equal to it without ensemble); ``boundary`` the last crossing
        at which falling ends; ``boundary_low`` and ``boundary_high``, the same from each scramble alone (equal to it
        without ensemble); ``falls_beyond`` where the block still falls at the largest B/H, so that the boundary lies
        above the grid, and ``stands_throughout`` where it never falls.
    """
    p = fall_probability(cube, ensemble=ensemble)
    falls = p["towards"] + p["away"]
    sides = [falls, falls]
    if ensemble and "scramble_difference_towards" in cube:
        gap = (cube["scramble_difference_towards"] + cube["scramble_difference_away"]).fillna(0.0)
        sides = [falls + gap / 2, falls - gap / 2]
    crossed = _crossings(falls, crossings)
    beyond = _along_b_over_h(last_known, {}, falls) >= HALF
    bounds = _along_b_over_h(
        partial(crossing_bounds, crossings=crossings),
        {"crossing": crossings, "bound": 2},
        *(falls, *sides),
        falls["b_over_h"].astype("float64"),
    )
    edges = [_crossings(side, crossings).max("crossing").where(~beyond) for side in sides]
    named = {
        "crossing_b_over_h": (crossed, "slenderness at which the probability of falling is one half"),
        "crossing_low": (bounds.isel(bound=0), "lowest crossing of two scrambles"),
        "crossing_high": (bounds.isel(bound=1), "highest crossing of two scrambles"),
        "boundary": (crossed.max("crossing").where(~beyond), "overturning boundary"),
        "boundary_low": (
            xr.apply_ufunc(np.fmin, *edges, dask="allowed"),
            "overturning boundary, lower of two scrambles",
        ),
        "boundary_high": (
            xr.apply_ufunc(np.fmax, *edges, dask="allowed"),
            "overturning boundary, upper of two scrambles",
        ),
    }
    made = {name: values.assign_attrs(long_name=text, units="1") for name, (values, text) in named.items()}
    return xr.Dataset({**made, "falls_beyond": beyond, "stands_throughout": (falls.fillna(0.0) < HALF).all("b_over_h")})


def easiest_azimuth(bounds: xr.Dataset, b_over_h: ArrayLike) -> xr.Dataset:
    """The plane in which the block overturns most easily, and how much more easily than in the hardest.

    Parameters
    ----------
    bounds : Dataset
        From `boundary`.
    b_over_h : array_like
        The cube's values; where the block never falls the smallest, and where it falls at all the largest, stands for
        the boundary, which is then only known to lie below or above.

    Returns
    -------
    Dataset
        ``easiest_axis`` (degrees, 0 to 180; the mean axis of the planes that tie; missing where all planes tie or
        nothing falls), ``highest_boundary``, ``lowest_boundary`` (B/H), ``ratio`` of the two, and ``bounded``: false
        where one of them is only a bound, so that the ratio is a lower bound.
    """
    grid = np.asarray(b_over_h, dtype=np.float64)
    period = period_of(bounds)
    index = plane_index(bounds["azimuth"].values, period)
    planes = bounds[["boundary", "falls_beyond", "stands_throughout"]].isel(azimuth=index).compute()
    weight = plane_weight(planes["azimuth"].values, period)
    edge = planes["boundary"].where(~planes["falls_beyond"], grid.max()).where(~planes["stands_throughout"], grid.min())
    highest, lowest = edge.max("azimuth"), edge.min("azimuth")

    def axis(line: FloatArray, standing: NDArray[np.bool_]) -> float:
        if standing.all() or not np.isfinite(line).any():
            return np.nan
        ties = np.abs(line - np.nanmax(line)) < 1e-9
        return resultant(planes["azimuth"].values[ties], weight[ties], axial=True)[0]

    easiest = xr.apply_ufunc(
        axis, edge, planes["stands_throughout"], input_core_dims=[["azimuth"], ["azimuth"]], vectorize=True
    )
    never = planes["stands_throughout"].all("azimuth")
    return xr.Dataset(
        {
            "easiest_axis": easiest.assign_attrs(long_name="axis of easiest overturning", units="degree"),
            "highest_boundary": highest.where(~never),
            "lowest_boundary": lowest.where(~never),
            "ratio": (highest / lowest).where(~never),
            "bounded": ~(planes["falls_beyond"].any("azimuth") | planes["stands_throughout"].any("azimuth")),
        }
    )
