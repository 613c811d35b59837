"""Fall rates of a cemetery: stones drawn from a population, each doing what the cell most like it does."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import qmc

from overturning.arrays import FloatArray
from overturning.model.falls import model_of
from overturning.model.model import Outcomes
from overturning.statistics.circular import resultant, sector
from overturning.study.ensemble import wilson
from overturning.study.sections import Population, Spread
from overturning.surveys.stones import OCTANTS


@dataclass(frozen=True)
class Stones:
    """Stones of a population, each attribute an ndarray of shape (n,).

    Attributes
    ----------
    height, b_over_h, friction : ndarray
        m, B/H, µ.
    face : ndarray
        Azimuth that the front looks to, degrees.
    lot : ndarray, shape (3, n)
        In 0 to 1, for height, B/H and friction: decides between the two values of a cube's grid that a stone lies
        between.
    """

    height: FloatArray
    b_over_h: FloatArray
    friction: FloatArray
    face: FloatArray
    lot: FloatArray


def draw_stones(population: Population) -> Stones:
    """Draw the stones of a population that are not fixed, as scrambled Sobol points (Owen 1998, ACM TOMACS 8)."""
    generator = np.random.Generator(np.random.PCG64(population.seed))
    unit = qmc.Sobol(7, scramble=True, rng=generator).random(population.stones).T

    def between(spread: Spread, u: FloatArray) -> FloatArray:
        return spread.low + (spread.high - spread.low) * u

    width, height = between(population.width, unit[0]), between(population.height, unit[1])
    about = population.face_spread * (2 * unit[3] - 1)
    face = 360 * unit[3] if population.face is None else population.face + about
    return Stones(height, width / height, between(population.friction, unit[2]), face % 360, unit[4:])


def grid_places(grid: FloatArray, values: FloatArray, lot: FloatArray) -> NDArray[np.intp]:
    """Places of values in an ascending grid: of two neighbours the nearer one the more often, so that means are linear.

    Beyond the grid it is the end.
    """
    where = np.interp(values, grid, np.arange(grid.size))
    below = np.floor(where)
    return (below + (lot < where - below)).astype(np.intp)


def outside_grid(cube: xr.Dataset, stones: Stones) -> float:
    """Share of the stones whose height, B/H or friction lies beyond the cube's grid by more than rounding."""
    beyond = np.zeros(stones.height.size, np.bool_)
    for name in ("height", "b_over_h", "friction"):
        grid, values = cube[name].to_numpy(), getattr(stones, name)
        beyond |= (values < grid.min() - 1e-9) | (values > grid.max() + 1e-9)
    return float(beyond.mean())


def stone_outcomes(site: xr.Dataset, stones: Stones) -> Outcomes:
    """What each stone does under one record, from the cells of the record's cube.

    Parameters
    ----------
    site : Dataset
        Cube of one record, with or without the dimension of amplitudes.
    stones : Stones
        n stones.
    """
    height, shape, friction = _cells(site, stones)
    return model_of(site).outcomes(site, stones.face, {"height": height, "b_over_h": shape, "friction": friction})


def _cells(site: xr.Dataset, stones: Stones) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Places of the stones along height, B/H and friction.

    Below µ = B/H a block slides rather than rocks: of two frictions the one on the stone's own side of it, where there
    is one.
    """
    height, shape, friction = (
        grid_places(site[name].to_numpy(), getattr(stones, name), lot)
        for name, lot in zip(("height", "b_over_h", "friction"), stones.lot, strict=True)
    )
    grid, ratio = site["friction"].to_numpy(), site["b_over_h"].to_numpy()[shape]
    rocks = stones.friction > stones.b_over_h
    below = np.clip(np.searchsorted(grid, stones.friction, side="right") - 1, 0, grid.size - 1)
    above = np.minimum(below + 1, grid.size - 1)
    lower, upper = ((grid[place] > ratio) == rocks for place in (below, above))
    return height, shape, np.where(lower & ~upper, below, np.where(upper & ~lower, above, friction))


def rates(found: Outcomes, population: Population) -> dict[str, FloatArray]:
    """Rates of what `stone_outcomes` found, of the stones that have an answer.

    Returns
    -------
    dict of ndarray
        ``fall_rate``, ``shift_rate``, ``rotation_rate`` (NaN where the model cannot turn), ``unknown``, shape (a,);
        their 95 % intervals by Wilson for a cemetery of as many stones, ``fall_interval`` and so on, shape (a, 2);
        ``fall_octant``, shape (a, 8), the share that fell towards each compass octant, with ``octant_interval``, shape
        (a, 8, 2); and ``fall_axis`` with ``fall_resultant``, the axis of the falls, degrees, and its mean resultant
        length, shape (a,).
    """
    stands = found.known & ~found.fell
    count = found.known.sum(axis=1)
    octant = sector(np.nan_to_num(found.azimuth), len(OCTANTS))
    towards = np.stack([(np.isfinite(found.azimuth) & (octant == i)).sum(axis=1) for i in range(len(OCTANTS))], axis=1)
    turned = (stands & (np.abs(found.twist) >= population.rotated)).sum(axis=1)
    told = np.isfinite(np.where(stands, found.twist, 0.0)).all(axis=1)
    axes = [
        resultant(azimuth[fell], axial=True) if fell.any() else (np.nan, np.nan)
        for azimuth, fell in zip(found.azimuth, found.fell, strict=True)
    ]
    rotation = {
        name: np.where(told.reshape(-1, *(1 for _ in values.shape[1:])), values, np.nan)
        for name, values in _shares("rotation", turned, count).items()
    }
    return {
        **_shares("fall", found.fell.sum(axis=1), count),
        **_shares("shift", (stands & (found.slip >= population.shifted)).sum(axis=1), count),
        **rotation,
        "unknown": 1.0 - found.known.mean(axis=1),
        "fall_octant": towards / np.maximum(count, 1)[:, None],
        "octant_interval": np.stack(wilson(towards, count[:, None]), axis=-1),
        "fall_axis": np.array([axis for axis, _ in axes]),
        "fall_resultant": np.array([length for _, length in axes]),
    }  # fmt: skip


def _shares(name: str, counted: NDArray[np.int64], count: NDArray[np.int64]) -> dict[str, FloatArray]:
    return {
        f"{name}_rate": counted / np.maximum(count, 1),
        f"{name}_interval": np.stack(wilson(counted, count), axis=-1),
    }
