"""Over earthquakes: the fall axis relative to the fault normal, one vector per earthquake.

Records of one earthquake share its source, so they are averaged first and count as one. Which of the two directions of
a fault normal is called positive is arbitrary; only axes are compared.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.model.falls import model_of
from overturning.statistics.bootstrap import (
    FEWEST_EARTHQUAKES,
    Interval,
    bootstrap,
    event_means,
    event_names,
    mean_of_sample,
    resampled,
)
from overturning.statistics.by_record import by_record
from overturning.statistics.circular import NO_DIRECTION, TestResult, rayleigh_test, resultant, v_test, wrap_axis
from overturning.statistics.direction import fall_vectors
from overturning.statistics.groups import record_groups


def relative_axes(cube: xr.Dataset, *, over: Sequence[str] | None = None, ensemble: bool = True) -> xr.Dataset:
    """Mean fall axis of each record, relative to its fault normal.

    Parameters
    ----------
    cube : Dataset
        The cube, with coordinate ``fault_normal(record)`` in degrees.
    over : sequence of str
        Dimensions taken together with the direction; all of the block where not given.
    ensemble : bool
        As of `Model.falls`.

    Returns
    -------
    Dataset
        ``cosine``, ``sine``: mean vector of 2 (fall axis − fault normal), length 0 to 1; missing where nothing fell or
        the fault normal is not known.
    """
    v = fall_vectors(cube, over=model_of(cube).case_dims if over is None else over, ensemble=ensemble)
    total = v["falls"].where(v["falls"] > 0)
    turn = 2 * np.radians(cube["fault_normal"].astype("float64"))
    cosine = (v["axis_cosine"] * np.cos(turn) + v["axis_sine"] * np.sin(turn)) / total
    sine = (v["axis_sine"] * np.cos(turn) - v["axis_cosine"] * np.sin(turn)) / total
    return xr.Dataset({"cosine": cosine, "sine": sine})


def axes_by_earthquake(cube: xr.Dataset, *, over: Sequence[str] | None = None, ensemble: bool = True) -> xr.Dataset:
    """Fall axis relative to the fault normal, per earthquake; the cube is read one record at a time.

    Parameters
    ----------
    cube, over, ensemble
        As in `relative_axes`; the coordinate ``event(record)`` says what counts as one earthquake.

    Returns
    -------
    Dataset
        Over dimension ``event`` (in the order of first appearance): ``axis`` (degrees in (−90, 90], 0 is the fault
        normal; missing where nothing fell), ``resultant``, ``cosine``, ``sine`` of the mean of the records' vectors,
        ``records`` and ``records_with_falls``.
    """
    vectors = by_record(partial(relative_axes, over=over, ensemble=ensemble), cube, model_of(cube).reads)
    events = np.atleast_1d(cube["event"].values).astype(str)
    names = event_names(events)
    vectors = vectors.transpose("record", ...).drop_vars(
        [name for name in vectors.coords if vectors[name].dims == ("record",)]
    )
    mean = vectors.isel(record=[0] * len(names)).rename(record="event")
    mean = mean.assign(
        {name: (values.dims, event_means(vectors[name].values, events)) for name, values in mean.items()}
    )
    known = vectors["cosine"].notnull().values
    counts = (mean["cosine"].dims, np.stack([known[events == name].sum(axis=0) for name in names]))
    length = xr.apply_ufunc(np.hypot, mean["cosine"], mean["sine"])
    axis = xr.apply_ufunc(wrap_axis, np.degrees(np.arctan2(mean["sine"], mean["cosine"])) / 2)
    axis = axis.where(length > NO_DIRECTION)
    axis.attrs = {"long_name": "mean fall axis relative to the fault normal", "units": "degree"}
    length.attrs = {"long_name": "mean resultant length of doubled fall axes", "units": "1"}
    records = ("event", np.array([(events == name).sum() for name in names]))
    result = mean.assign(axis=axis, resultant=length, records=records, records_with_falls=counts)
    return result.assign_coords(event=("event", np.array(names, dtype=str)))


def axes_by_group(cube: xr.Dataset, by: str = "pulse", edges: Sequence[float] = ()) -> dict[str, xr.Dataset]:
    """`axes_by_earthquake` of each group of records that has any, by its name; parameters as of `record_groups`."""
    return {
        name: axes_by_earthquake(cube.isel(record=np.flatnonzero(members)))
        for name, members in record_groups(cube, by, edges).items()
        if members.any()
    }


@dataclass(frozen=True)
class AxisSummary:
    """How fall axes of several earthquakes lie about their fault normals.

    Attributes
    ----------
    earthquakes, n : int
        Earthquakes looked at; those with falls and a known fault normal: the sample size of everything below.
    mean_axis_deg : float
        Mean axis relative to the fault normal, (−90, 90]; NaN without falls.
    mean_axis_half_width_deg : float
        Half-width of its bootstrap interval (Fisher 1993, section 8.3: symmetric about the mean axis); NaN below
        `FEWEST_EARTHQUAKES`, 90 where the data do not tell an axis.
    resultant : float
        Mean resultant length of the unit vectors of doubled angles.
    alignment, alignment_interval : float, Interval
        Mean cos 2Δ over earthquakes: 1 normal to the fault, −1 parallel, 0 neither; its bootstrap percentile interval.
    closer_to_normal : int
        Earthquakes whose axis is within 45° of the fault normal.
    level : float
        Of the intervals.
    rayleigh, v : TestResult
        Uniformity against any axis, and against the fault normal.
    """

    earthquakes: int
    n: int
    mean_axis_deg: float
    mean_axis_half_width_deg: float
    resultant: float
    alignment: float
    alignment_interval: Interval
    closer_to_normal: int
    level: float
    rayleigh: TestResult
    v: TestResult


def summarise_axes(axes: xr.Dataset, *, level: float = 0.95, draws: int = 10_000, seed: int = 1) -> AxisSummary:
    """Mean axis over earthquakes with tests and bootstrap over earthquakes.

    Parameters
    ----------
    axes : Dataset
        From `axes_by_earthquake`, without further dimensions.
    level : float
        Of the intervals.
    draws, seed : int
        Bootstrap resamples and their seed.

    Returns
    -------
    AxisSummary
        Intervals: percentile for the alignment (Efron & Tibshirani 1993, chapter 13); for the mean axis the quantile of
        the resamples' distance from it (Fisher 1993, Statistical Analysis of Circular Data, section 8.3.2).
    """
    angle = axes["axis"].values[np.isfinite(axes["axis"].values)]
    n = int(angle.size)
    mean, length = resultant(angle, axial=True)
    cosines = np.cos(np.radians(2 * angle))

    def distance(drawn: FloatArray) -> FloatArray:
        cosine, sine = np.cos(drawn).mean(axis=1), np.sin(drawn).mean(axis=1)
        away = np.abs(wrap_axis(np.degrees(np.arctan2(sine, cosine)) / 2 - mean))
        return np.where(np.hypot(cosine, sine) < NO_DIRECTION, 90.0, away)

    distances = resampled(distance, np.radians(2 * angle), draws, seed)
    return AxisSummary(
        earthquakes=int(axes.sizes["event"]),
        n=n,
        mean_axis_deg=float(wrap_axis(mean)) if n else math.nan,
        mean_axis_half_width_deg=float(np.quantile(distances, level)) if distances.size else math.nan,
        resultant=length,
        alignment=float(cosines.mean()) if n else math.nan,
        alignment_interval=bootstrap(mean_of_sample, cosines, level=level, draws=draws, seed=seed),
        closer_to_normal=int((np.abs(angle) < 45).sum()),
        level=level,
        rayleigh=rayleigh_test(angle, axial=True),
        v=v_test(angle, 0.0, axial=True),
    )


@dataclass(frozen=True)
class AlignmentDifference:
    """Alignment (mean cos 2Δ) of one set of earthquakes minus that of another; NaN where one has no falls.

    The bootstrap percentile interval resamples the earthquakes together; ``n_first`` and ``n_second`` are those with
    falls.
    """

    difference: float
    interval: Interval
    n_first: int
    n_second: int


def compare_alignment(
    first: xr.Dataset, second: xr.Dataset, *, level: float = 0.95, draws: int = 10_000, seed: int = 1
) -> AlignmentDifference:
    """Compare the alignment with the fault normal of two sets of records, such as pulse records and the control.

    An earthquake may have records in both; it is drawn once for both, so that its own orientation does not count as
    a difference.

    Parameters
    ----------
    first, second : Dataset
        From `axes_by_earthquake`.
    level, draws, seed
        As in `summarise_axes`.

    Returns
    -------
    AlignmentDifference
        The interval is missing where either has fewer than `FEWEST_EARTHQUAKES`.
    """
    names = event_names([*first["event"].values, *second["event"].values])
    angles = np.stack([axes["axis"].reindex(event=names).values for axes in (first, second)])
    values = np.cos(np.radians(2 * angles))
    n = [int(k) for k in np.isfinite(values).sum(axis=1)]
    if min(n) == 0:
        return AlignmentDifference(math.nan, Interval(), *n)
    difference = float(np.nanmean(values[0]) - np.nanmean(values[1]))
    if min(n) < FEWEST_EARTHQUAKES:
        return AlignmentDifference(difference, Interval(), *n)

    def of_sample(drawn: FloatArray) -> FloatArray:
        counts = np.isfinite(drawn).sum(axis=1)
        means = np.nansum(drawn, axis=1) / np.where(counts > 0, counts, np.nan)
        return np.asarray(means[:, 0] - means[:, 1])

    ends = bootstrap(of_sample, values.T, level=level, draws=draws, seed=seed)
    return AlignmentDifference(difference, ends, *n)
