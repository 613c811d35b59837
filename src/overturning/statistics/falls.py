"""Falls by the azimuth towards which they go."""

import numpy as np
import xarray as xr

from overturning.model.falls import model_of
from overturning.model.planes import FALLS, fall_probability, period_of
from overturning.model.symmetry import PLANE_PERIOD, nearest_planes
from overturning.model.variables import VARIABLES
from overturning.study.ensemble import ENSEMBLE_VARIABLES


def whole_circle(cube: xr.Dataset) -> xr.Dataset:
    """A cube of planes, or what was made of it, with the opposites of all its azimuths, ascending.

    Motions along φ and φ + 180° are one plane and one outcome. Where the cube holds one of them, the other is that one
    seen from behind; where it holds both, both stay as they are. Of a scene that is not its own mirror image, where
    they are two cases, opposites are added where the cube knows nothing of them, all missing. Lazy where the cube is.
    """
    azimuth = cube["azimuth"].to_numpy()
    opposite = np.round((azimuth.astype(np.float64) + 180.0) % 360.0, 10).astype(azimuth.dtype)
    everywhere = np.union1d(azimuth, opposite)
    if np.array_equal(everywhere, azimuth):
        return cube
    sources = nearest_planes(azimuth, everywhere, period_of(cube))
    if period_of(cube) != PLANE_PERIOD:
        return cube.reindex(azimuth=everywhere[np.isin(everywhere, azimuth) | ~sources.known])
    turned = cube.isel(azimuth=sources.cell).assign_coords(azimuth=("azimuth", everywhere, cube["azimuth"].attrs))
    behind = xr.DataArray(sources.mirrored, dims="azimuth")
    changed = {}
    for variable in (*VARIABLES, *ENSEMBLE_VARIABLES):
        if variable.name in cube and (variable.odd or variable.exchanged):
            values, seen = turned[variable.name], turned[variable.exchanged or variable.name]
            changed[variable.name] = xr.where(behind, -seen if variable.odd else seen, values).transpose(*values.dims)
            changed[variable.name].attrs = values.attrs
    return turned.assign(changed)


def falls_towards(cube: xr.Dataset, *, ensemble: bool = False) -> xr.DataArray:
    """Whether the block falls towards an azimuth.

    A block that falls towards −1 at φ falls towards φ + 180°. So each fall stands exactly once in the result, at the
    azimuth it goes to, whether the cube holds one or both azimuths of its plane.

    Parameters
    ----------
    cube : xarray.Dataset
        With ``overturned`` and ``azimuth``.
    ensemble : bool
        Take probabilities rather than flags, as of `fall_probability`.

    Returns
    -------
    xarray.DataArray
        Number of falls towards the azimuth: 1 where the block falls to it, 0 where it does not (it stands, or falls the
        other way), NaN where the outcome is missing. Of a scene that is not its own mirror image the falls of two cases
        go to an azimuth, its own and that of the opposite one. Azimuths as of `whole_circle`, and of such a scene the
        opposites beside them; lazy where the cube is.
    """
    used = [name for name in (FALLS if ensemble else FALLS[:1]) if name in cube]
    p = fall_probability(whole_circle(cube[used]), ensemble=ensemble)
    falls, azimuth = p["towards"], p["azimuth"]
    if period_of(cube) != PLANE_PERIOD:
        away = p["away"].assign_coords(azimuth=((azimuth + 180) % 360).astype(azimuth.dtype)).sortby("azimuth")
        both = xr.concat(xr.align(falls, away, join="outer"), "side")
        falls = both.sum("side", min_count=1).transpose(*falls.dims)
    return falls.assign_attrs(long_name="falls towards the azimuth", units="1")


def overturns(cube: xr.Dataset) -> xr.DataArray:
    """Whether the block falls to either side: 1, 0, or NaN where the outcome is missing."""
    overturned = cube["overturned"]
    return xr.where(overturned.isnull(), np.nan, (overturned != 0).astype("float32")).assign_attrs(
        long_name="block overturns to either side", units="1"
    )


def near_boundary(cube: xr.Dataset) -> xr.DataArray:
    """Blocks that only just fall under a record: that overturn in some of its planes, and in at most half of them.

    More slender ones fall in nearly every plane, to whichever side, and hide the direction that these show. True or
    False over the dimensions of ``overturned`` without ``azimuth``; each plane counts once, none whose outcome is
    missing.
    """
    share = overturns(cube).isel(azimuth=model_of(cube).representative(cube)).mean("azimuth").compute()
    return (share > 0) & (share <= 0.5)
