"""Falls by the azimuth towards which they go."""

import numpy as np
import xarray as xr


def falls_towards(cube: xr.Dataset) -> xr.DataArray:
    """Whether the block falls towards an azimuth.

    A block that falls towards −1 at φ falls towards φ + 180°; motions along φ and φ + 180° are one plane and one
    outcome. So each fall stands exactly once in the result, at the azimuth it goes to, whether the cube holds one or both
    azimuths of its plane.

    Parameters
    ----------
    cube : xarray.Dataset
        With ``overturned`` and ``azimuth``.

    Returns
    -------
    xarray.DataArray
        1 where the block falls towards the azimuth, 0 where it does not (it stands, or falls the other way), NaN where
        the outcome is missing. Its azimuths are those of the cube and their opposites, ascending; lazy where the
        cube is.
    """
    overturned = cube["overturned"].astype("float32")
    azimuth = cube["azimuth"].to_numpy()
    turned = (azimuth.astype(np.float64) + 180.0) % 360.0
    opposite = turned.astype(azimuth.dtype) if np.issubdtype(azimuth.dtype, np.integer) else np.round(turned, 10)
    everywhere = np.union1d(azimuth, opposite)
    here = overturned.reindex(azimuth=everywhere)
    mirrored = overturned.assign_coords(azimuth=opposite).sortby("azimuth").reindex(azimuth=everywhere)
    known = here.fillna(-mirrored)
    return xr.where(known.isnull(), np.nan, (known > 0).astype("float32")).assign_attrs(
        long_name="block falls towards the azimuth", units="1"
    )


def overturns(cube: xr.Dataset) -> xr.DataArray:
    """Whether the block falls to either side: 1, 0, or NaN where the outcome is missing."""
    overturned = cube["overturned"]
    return xr.where(overturned.isnull(), np.nan, (overturned != 0).astype("float32")).assign_attrs(
        long_name="block overturns to either side", units="1"
    )


def near_boundary(cube: xr.Dataset) -> xr.DataArray:
    """Blocks that only just fall under a record: that overturn in some of its planes, and in at most half of them.

    More slender ones fall in nearly every plane, to whichever side, and hide the direction that these show. True or False
    over the dimensions of ``overturned`` without ``azimuth``; planes whose outcome is missing do not count.
    """
    share = overturns(cube).mean("azimuth").compute()
    return (share > 0) & (share <= 0.5)
