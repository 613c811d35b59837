"""Which way blocks fall: share of planes that overturn, mean fall direction, mean fall axis."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from overturning.statistics.circular import NO_DIRECTION
from overturning.statistics.planes import FALLS, by_plane

CASE_DIMS = ("height", "b_over_h", "friction")


MEAN_OF_MEMBERS = ("probability_falls", "fall_north", "fall_east", "fall_axis_cosine", "fall_axis_sine")
"""What an ensemble in space says of a cell: share of falls, and means of the components of their direction and axis."""

OF_FALLS = (*FALLS, "fall_azimuth", *MEAN_OF_MEMBERS)
"""Variables of a cube, in planes or in space, that shares and vectors of falls come from."""


def in_space(cube: xr.Dataset) -> bool:
    """Whether a cube is of bodies in space: these face an orientation, and fall towards any azimuth."""
    return "orientation" in cube.dims


def case_dims(cube: xr.Dataset) -> tuple[str, ...]:
    """Dimensions of the block: all but the record and the direction."""
    return ("height", "b_over_h", "aspect", "friction") if in_space(cube) else CASE_DIMS


def _mean(vectors: xr.Dataset, kind: str, full: float, plural: str) -> xr.Dataset:
    """Mean angle, up to ``full`` degrees, and mean resultant length of sums that `fall_vectors` made."""
    cosine, sine, total = vectors[f"{kind}_cosine"], vectors[f"{kind}_sine"], vectors["falls"]
    length = (xr.apply_ufunc(np.hypot, cosine, sine, dask="allowed") / total.where(total > 0)).clip(0, 1)
    turned = xr.apply_ufunc(np.arctan2, sine, cosine, dask="allowed")
    angle = (turned * (full / (2 * np.pi)) % full).where(length > NO_DIRECTION)
    angle.attrs = {"long_name": f"mean fall {kind}", "units": "degree"}
    length.attrs = {"long_name": f"mean resultant length of {plural}", "units": "1"}
    return angle.to_dataset(name=f"mean_{kind}").assign({f"{kind}_resultant": length})


def fall_shares(cube: xr.Dataset, *, over: Sequence[str] = (), ensemble: bool = True) -> xr.Dataset:
    """Share of planes, or in space of orientations, that overturn.

    Parameters
    ----------
    cube : Dataset
        The cube.
    over : sequence of str
        Dimensions to take together with ``azimuth`` (every case of them counts the same).
    ensemble : bool
        As in `fall_probability`.

    Returns
    -------
    Dataset
        ``share_overturned`` (of the planes whose outcome is known; missing where none is) and ``share_missing``.
    """
    planes = by_orientation(cube, ensemble=ensemble) if in_space(cube) else by_plane(cube, ensemble=ensemble)
    dims = ("orientation" if in_space(cube) else "azimuth", *over)
    known = planes["weight"].where(planes["falls"].notnull(), 0.0)
    weight = known.sum(dims)
    cases = int(np.prod([cube.sizes[d] for d in over])) if over else 1
    share = (planes["falls"] * planes["weight"]).sum(dims) / weight.where(weight > 0)
    share.attrs = {"long_name": "share of vertical planes in which the block falls", "units": "1"}
    missing = (1 - weight / cases).clip(0)
    missing.attrs = {"long_name": "share of planes without an outcome", "units": "1"}
    return xr.Dataset({"share_overturned": share, "share_missing": missing})


def by_orientation(cube: xr.Dataset, *, ensemble: bool = True) -> xr.Dataset:
    """Falls in space, cell by cell, with the weight of each orientation: all alike on a grid that symmetry closes.

    Returns
    -------
    Dataset
        ``falls`` (probability, or the nominal flag as 0 or 1), ``direction_cosine``, ``direction_sine``, ``axis_cosine`` and
        ``axis_sine``: expected values, 0 where the block stands, missing where the outcome is; and ``weight``.
    """
    known = cube["overturned"].notnull()
    falls = (cube["overturned"] == 1).where(known)
    azimuth = cube["fall_azimuth"].astype("float64") * (np.pi / 180.0)

    def mean_of(values: xr.DataArray) -> xr.DataArray:
        return values.where(falls == 1, 0.0).where(known)

    twice = 2.0 * azimuth
    nominal = {
        "falls": falls.astype("float64"),
        **{
            f"{kind}_{name}": mean_of(xr.apply_ufunc(part, angle, dask="allowed"))
            for kind, angle in (("direction", azimuth), ("axis", twice))
            for name, part in (("cosine", np.cos), ("sine", np.sin))
        },
    }
    if ensemble and "probability_falls" in cube:
        nominal = {
            name: cube[of].astype("float64").fillna(values)
            for (name, values), of in zip(nominal.items(), MEAN_OF_MEMBERS, strict=True)
        }
    count = cube.sizes["orientation"]
    return xr.Dataset({**nominal, "weight": ("orientation", np.full(count, 1.0 / count))})


def fall_vectors(cube: xr.Dataset, *, over: Sequence[str] = (), ensemble: bool = True) -> xr.Dataset:
    """Sums from which mean directions and axes are made; they may be added up further before the angle is taken.

    Parameters
    ----------
    cube, over, ensemble
        As in `fall_shares`.

    Returns
    -------
    Dataset
        ``falls`` (weighted probability of falling), ``direction_cosine``, ``direction_sine`` (of the fall direction) and
        ``axis_cosine``, ``axis_sine`` (of twice the azimuth of plane or fall).
    """
    if in_space(cube):
        found = by_orientation(cube, ensemble=ensemble)
        return (found.drop_vars("weight") * found["weight"]).sum(("orientation", *over))
    planes = by_plane(cube, ensemble=ensemble)
    dims = ("azimuth", *over)
    angle = np.radians(planes["azimuth"].astype("float64"))
    falls, net = planes["falls"] * planes["weight"], (planes["towards"] - planes["away"]) * planes["weight"]
    vectors = {
        "falls": falls,
        "direction_cosine": net * np.cos(angle),
        "direction_sine": net * np.sin(angle),
        "axis_cosine": falls * np.cos(2 * angle),
        "axis_sine": falls * np.sin(2 * angle),
    }
    return xr.Dataset(vectors).sum(dims)


def fall_direction(cube: xr.Dataset, *, over: Sequence[str] = (), ensemble: bool = True) -> xr.Dataset:
    """Mean direction towards which blocks fall (Mardia & Jupp 2000, eqs 2.2.2 to 2.2.4), each plane once.

    Parameters
    ----------
    cube, over, ensemble
        As in `fall_shares`.

    Returns
    -------
    Dataset
        ``mean_direction`` (degrees, 0 to 360; missing where nothing fell or the falls cancel) and
        ``direction_resultant`` (0 to 1; missing where nothing fell).
    """
    return _mean(fall_vectors(cube, over=over, ensemble=ensemble), "direction", 360.0, "fall directions")


def fall_axis(cube: xr.Dataset, *, over: Sequence[str] = (), ensemble: bool = True) -> xr.Dataset:
    """Mean axis along which blocks fall, whichever way: angles doubled (Mardia & Jupp 2000, section 9.1).

    Parameters
    ----------
    cube, over, ensemble
        As in `fall_shares`.

    Returns
    -------
    Dataset
        ``mean_axis`` (degrees, 0 to 180; missing where nothing fell or all planes overturn alike) and ``axis_resultant``
        (0 to 1, of doubled angles; missing where nothing fell).
    """
    return _mean(fall_vectors(cube, over=over, ensemble=ensemble), "axis", 180.0, "doubled fall axes")
