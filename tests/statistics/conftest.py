"""Synthetic cubes with known answers."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

from overturning.statistics.fragility import FittedFragilityCurve, fit_fragility_curve

FallRule = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Function of azimuth, height, B/H and friction: 1 for a fall towards the azimuth, −1 away from it, 0 for none."""


def cube_from_fall_rules(
    rule: FallRule | Sequence[FallRule],
    *,
    azimuth: Sequence[float] = tuple(range(0, 360, 5)),
    height: Sequence[float] = (0.6, 1.2),
    b_over_h: Sequence[float] = (0.1, 0.2, 0.3, 0.4, 0.5),
    friction: Sequence[float] = (0.33, 1.0),
    events: Sequence[str] = ("A",),
    fault_normal: Sequence[float] | float = 60.0,
    pulse: Sequence[int] | int = 1,
) -> xr.Dataset:
    """Return a 2-D cube whose fall flags follow from one `FallRule` for all records, or from one for each record."""
    axes = np.meshgrid(azimuth, height, b_over_h, friction, indexing="ij")
    rules = [rule] * len(events) if callable(rule) else list(rule)
    flags = np.stack([one(*axes).astype(np.float32) for one in rules])
    n = len(events)
    dims = ("record", "azimuth", "height", "b_over_h", "friction")
    return xr.Dataset(
        {"overturned": (dims, flags)},
        coords={
            "record": np.arange(n),
            "azimuth": np.asarray(azimuth, dtype=float),
            "height": list(height),
            "b_over_h": list(b_over_h),
            "friction": list(friction),
            "record_id": ("record", [f"r{i}" for i in range(n)]),
            "event": ("record", list(events)),
            "station": ("record", [f"S{i}" for i in range(n)]),
            "fault_normal": ("record", np.broadcast_to(np.asarray(fault_normal, float), n).copy()),
            "pulse": ("record", np.broadcast_to(np.asarray(pulse, np.int8), n).copy()),
        },
    )


def sector_fall_rule(axis: float, half_width: float, largest_b_over_h: float = 1.0, side: int = 1) -> FallRule:
    """Return a rule: blocks up to a B/H fall towards ``axis`` (side −1: away) in planes up to ``half_width`` off."""

    def signed_falls_in_sector(
        azimuth: np.ndarray, height: np.ndarray, slender: np.ndarray, friction: np.ndarray
    ) -> np.ndarray:
        offset = (azimuth - axis + 180) % 360 - 180
        sign = np.where(np.abs(offset) <= half_width, 1, np.where(np.abs(offset) >= 180 - half_width, -1, 0))
        return np.where(slender <= largest_b_over_h + 1e-9, side * sign, 0)

    return signed_falls_in_sector


def fit_curve_to_lognormal_fall_rates(
    median: float,
    spread: float,
    name: str = "all stones",
    measure: tuple[str, str] = ("PGA", "g"),
    largest_intensity: float = 2.0,
) -> FittedFragilityCurve:
    """Fit a fragility curve to lognormal fall rates of eight earthquakes, at intensities from 0.1 to a largest one."""
    x = np.tile(np.geomspace(0.1, largest_intensity, 20), 4)
    return fit_fragility_curve(name, measure, x, norm.cdf(np.log(x / median) / spread), np.repeat(list("abcdefgh"), 10))


@pytest.fixture
def make_cube_from_fall_rules() -> Callable[..., xr.Dataset]:
    """Return the function `cube_from_fall_rules`, which makes a synthetic 2-D cube from given fall rules."""
    return cube_from_fall_rules


@pytest.fixture
def make_sector_fall_rule() -> Callable[..., FallRule]:
    """Return the function `sector_fall_rule`, which makes a rule by which blocks fall within a sector of azimuths."""
    return sector_fall_rule
