"""The order of convergence in space: how largest tilt and azimuth of the fall of single cases change with the step."""

from typing import Any, Final

import numpy as np

from overturning.dem.body.simulate import simulate_in_space_arrays
from overturning.motion.motion import Motion

STEPS: Final = (1, 2, 4, 8)
"""Times shorter than the default's."""
REFERENCE: Final = 64
ROCKS: Final = 0.5
"""Tilt above which a stone that stands has rocked, degrees."""


def pulse() -> Motion:
    """Two components of a smooth pulse, the second later and shorter."""
    t = np.arange(160) * 0.01
    window = np.where(t < 1.2, np.sin(np.pi * t / 1.2) ** 2, 0.0)
    return Motion(
        5.0 * window * np.sin(5.0 * t), 4.0 * window * np.cos(8.0 * t), sampling_interval=0.01, trust_data=True
    )


def orders(scheme: str) -> dict[str, tuple[float, np.ndarray]]:
    """Order of convergence by quantity: slope of the median error over the step, and these errors by `STEPS`, rad.

    Stones that stand tell the largest tilt, stones that fall the azimuth of it; the reference is `REFERENCE` times
    finer.
    """
    grid: dict[str, Any] = {
        "orientation_deg": np.arange(5.0, 90.0, 10.0), "height": [0.6], "b_over_h": [0.14, 0.2, 0.31, 0.32, 0.33, 0.34],
        "friction": [0.8],
    }  # fmt: skip
    found = {
        step: simulate_in_space_arrays(pulse(), scheme=scheme, refinement=step, **grid) for step in (*STEPS, REFERENCE)
    }
    fell = np.all([one["overturned"] == 1 for one in found.values()], axis=0)
    stood = np.all([(one["overturned"] == 0) & (one["peak_tilt"] > ROCKS) for one in found.values()], axis=0)
    best, slopes = found[REFERENCE], {}
    for name, chosen in (("peak_tilt", stood), ("fall_azimuth", fell)):
        away = [np.radians((found[step][name] - best[name] + 180.0) % 360.0 - 180.0)[chosen] for step in STEPS]
        errors = np.median(np.abs(away), axis=1)
        slopes[name] = (-float(np.polyfit(np.log(STEPS), np.log(errors), 1)[0]), errors)
    return slopes
