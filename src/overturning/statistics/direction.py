"""Which way blocks fall: share of cases that overturn, mean fall direction, mean fall axis."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from overturning.model.falls import model_of
from overturning.statistics.circular import NO_DIRECTION


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
    """Share of planes, or of a body's orientations, that overturn.

    Parameters
    ----------
    cube : Dataset
        The cube.
    over : sequence of str
        Dimensions to take together with the direction (every case of them counts the same).
    ensemble : bool
        As of `Model.falls`.

    Returns
    -------
    Dataset
        ``share_overturned`` (of the directions whose outcome is known; missing where none is) and ``share_missing``.
    """
    model = model_of(cube)
    falls, dims = model.falls(cube, ensemble=ensemble), (model.direction, *over)
    known = falls["weight"].where(falls["falls"].notnull(), 0.0)
    weight = known.sum(dims)
    cases = int(np.prod([cube.sizes[d] for d in over])) if over else 1
    share = (falls["falls"] * falls["weight"]).sum(dims) / weight.where(weight > 0)
    share.attrs = {"long_name": f"share of {model.direction}s in which the block falls", "units": "1"}
    missing = (1 - weight / cases).clip(0)
    missing.attrs = {"long_name": f"share of {model.direction}s without an outcome", "units": "1"}
    return xr.Dataset({"share_overturned": share, "share_missing": missing})


def fall_vectors(cube: xr.Dataset, *, over: Sequence[str] = (), ensemble: bool = True) -> xr.Dataset:
    """Sums from which mean directions and axes are made; they may be added up further before the angle is taken.

    Parameters
    ----------
    cube, over, ensemble
        As in `fall_shares`.

    Returns
    -------
    Dataset
        The variables of `Model.falls`, each the sum of its values times their weights.
    """
    model = model_of(cube)
    falls = model.falls(cube, ensemble=ensemble)
    return (falls.drop_vars("weight") * falls["weight"]).sum((model.direction, *over))


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
        ``mean_axis`` (degrees, 0 to 180; missing where nothing fell or all planes overturn alike) and
        ``axis_resultant`` (0 to 1, of doubled angles; missing where nothing fell).
    """
    return _mean(fall_vectors(cube, over=over, ensemble=ensemble), "axis", 180.0, "doubled fall axes")
