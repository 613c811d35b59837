"""Planes along which something moves: what intensities of motion say nothing of is left out of their statistics."""

from typing import Final

import xarray as xr

from overturning.model.planes import FALLS

LEAST_PGA: Final = 1e-6
"""PGA, m/s², up to which nothing moves but the rounding of motions, to 1e-9 m/s²."""


def where_it_moves(cube: xr.Dataset, intensity: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Both without the planes along which nothing moves, as across a pulse: there PGV/PGA is 0/0."""
    measured = intensity[["pga", "pgv"]].where(intensity["pga"] > LEAST_PGA)
    pga = measured["pga"].sel(azimuth=cube["azimuth"], method="nearest")
    moves = pga.notnull().drop_vars(["record", "azimuth"], errors="ignore")
    if bool(moves.all()):
        return cube, intensity
    return cube.assign({name: cube[name].where(moves) for name in FALLS if name in cube}), measured
