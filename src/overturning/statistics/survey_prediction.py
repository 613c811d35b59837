"""What the cube of a site says about the stones of a survey."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overturning.errors import ArgumentError
from overturning.statistics.planes import fall_probability, plane_index, plane_weight
from overturning.statistics.survey import Stone

if TYPE_CHECKING:
    import xarray as xr

FloatArray = NDArray[np.float64]

SIDES = ("stood", "forwards", "to its right", "backwards", "to its left")
"""Outcomes of a stone whose face is known: towards the face's azimuth, then clockwise by 90° each."""

BACKGROUND = 0.05
"""Share of stones taken to fall any way (pushed by a neighbour, on a bad footing): without it a single stone in a direction
of probability zero would rule the model out for ever."""


class SitePrediction:
    """Fall probabilities of one site, by azimuth and slenderness.

    Parameters
    ----------
    cube : Dataset
        A cube of one record; heights and frictions (and slendernesses where a stone has none) count the same each.
    background : float
        See `BACKGROUND`.

    Raises
    ------
    ArgumentError
        If the cube holds more than one record, or the background is not between 0 and 1.
    """

    def __init__(self, cube: "xr.Dataset", *, background: float = BACKGROUND) -> None:
        if cube.sizes.get("record", 1) != 1:
            raise ArgumentError(
                f"cube: {cube.sizes['record']} records; a survey belongs to one site, so name its record (--record)"
            )
        if not 0 <= background < 1:
            raise ArgumentError(f"background: {background}; a share from 0 to below 1")
        site = cube.isel(record=0) if "record" in cube.dims else cube
        index = plane_index(site["azimuth"].values)
        weight = plane_weight(site["azimuth"].values[index])
        p = fall_probability(site).isel(azimuth=index).mean(("height", "friction")).transpose("azimuth", "b_over_h")
        self.background = background
        self.b_over_h: FloatArray = p["b_over_h"].values.astype(np.float64)
        plane = site["azimuth"].values[index].astype(np.float64)
        towards, away = np.nan_to_num(p["towards"].values), np.nan_to_num(p["away"].values)
        # Both ends of each plane, in the order of the azimuth: probability of falling towards that azimuth.
        azimuth = np.concatenate([plane % 360, (plane + 180) % 360])
        order = np.argsort(azimuth)
        self.azimuth: FloatArray = azimuth[order]
        self.towards: FloatArray = np.concatenate([towards, away])[order].astype(np.float64)
        self.share: FloatArray = np.concatenate([weight, weight])[order] / 2
        # Each azimuth's sector reaches half way to its neighbours; `start` is where the first one begins.
        self.start = float((self.azimuth[0] + self.azimuth[-1] - 360) / 2)

    def _at(self, azimuth_deg: float, b_over_h: float) -> float:
        by_azimuth = np.array([np.interp(b_over_h, self.b_over_h, line) for line in self.towards])
        return float(np.interp(azimuth_deg % 360, self.azimuth, by_azimuth, period=360))

    def density(self, b_over_h: float = math.nan) -> FloatArray:
        """Probability of each azimuth's sector, given that a stone of unknown orientation fell; sums to 1.

        Stones are taken to be turned every way alike; without ``b_over_h`` all slendernesses of the cube count the same.
        """
        if math.isnan(b_over_h):
            values = self.towards.mean(axis=1)
        else:
            values = np.array([np.interp(b_over_h, self.b_over_h, line) for line in self.towards])
        mass = values * self.share
        total = mass.sum()
        model = mass / total if total > 0 else self.share
        return np.asarray((1 - self.background) * model + self.background * self.share)

    def sides(self, stone: Stone) -> FloatArray:
        """Probabilities of `SIDES` for a stone whose face azimuth and B/H are known; they sum to 1.

        A rectangular stone falls over one of its edges: the two planes through its faces' normals are computed each with
        its own B/H. Where both say that it falls, each is taken to come first in proportion to its probability.
        """
        side = stone.b_over_h if math.isnan(stone.b_over_h_side) else stone.b_over_h_side
        shapes = (stone.b_over_h, side, stone.b_over_h, side)
        p = np.array([self._at(stone.face_azimuth_deg + 90.0 * i, shape) for i, shape in enumerate(shapes)])
        front, across = p[0] + p[2], p[1] + p[3]
        falls = 1 - (1 - min(front, 1.0)) * (1 - min(across, 1.0))
        split = p / p.sum() if p.sum() > 0 else np.full(4, 0.25)
        model = np.concatenate([[1 - falls], falls * split])
        return np.asarray((1 - self.background) * model + self.background * np.concatenate([[0.5], np.full(4, 0.125)]))

    def octants(self, density: FloatArray) -> FloatArray:
        """Probability of each compass octant, from a density over the azimuths' sectors (shared out at the borders)."""
        fine = np.zeros(8)
        width = self.share * 360
        left = self.start + np.concatenate([[0.0], np.cumsum(width)[:-1]])
        for begin, wide, mass in zip(left, width, density, strict=True):
            at = (begin + wide * (np.arange(64) + 0.5) / 64 + 22.5) % 360
            np.add.at(fine, (at // 45).astype(int), mass / 64)
        return np.asarray(fine / fine.sum())


def knows_face(stone: Stone) -> bool:
    """Whether a stone's own faces can be used: face azimuth and B/H are given."""
    return math.isfinite(stone.face_azimuth_deg) and math.isfinite(stone.b_over_h)


def observed_side(stone: Stone) -> int:
    """Index into `SIDES` of what a stone did."""
    if not stone.fell:
        return 0
    return 1 + int(((stone.azimuth_deg - stone.face_azimuth_deg + 45.0) % 360) // 90)
