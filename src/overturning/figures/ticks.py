"""Ticks only where they are seen: Matplotlib also creates those just beyond both ends of an axis."""

from typing import Any

import numpy as np
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, Locator, NullLocator


class LocatorOfTicksWithinLimits(Locator):
    """Tick locator that returns only those ticks of another locator that lie within the limits of the axis.

    A tick outside is not drawn, but takes as long to create and to remove as one that is drawn.

    Parameters
    ----------
    base : Locator
        The other locator.
    """

    def __init__(self, wrapped_locator: Locator) -> None:
        self.base = wrapped_locator

    def set_axis(self, axis: Any) -> None:
        """Set the axis whose limits decide which ticks are created."""
        super().set_axis(axis)
        self.base.set_axis(axis)

    def __call__(self) -> Any:
        """Return the positions of the ticks inside the axis limits, as an array."""
        axis: Any = self.axis
        low, high = sorted(axis.get_view_interval())
        rounding = 1e-9 * (high - low)
        places = np.asarray(self.base(), dtype=np.float64)
        return places[(places >= low - rounding) & (places <= high + rounding)]

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the ticks of the wrapped tick locator for an axis from `vmin` to `vmax`."""
        return self.base.tick_values(vmin, vmax)

    def set_params(self, **kwargs: Any) -> None:
        """Change settings of the wrapped tick locator, such as the number of ticks."""
        self.base.set_params(**kwargs)

    def nonsingular(self, v0: float, v1: float) -> Any:
        """Return the axis limits `v0` and `v1` as the wrapped tick locator adjusts them, such as if they are equal."""
        return self.base.nonsingular(v0, v1)

    def view_limits(self, vmin: float, vmax: float) -> Any:
        """Return the axis limits that the wrapped tick locator chooses for the range of the data."""
        return self.base.view_limits(vmin, vmax)


def limit_ticks_to_axis_range(figure: Figure) -> None:
    """Make the axes of a figure create only ticks within their limits, to save time; the picture stays the same."""
    for axes in figure.axes:
        for axis in () if axes.name == "polar" else (axes.xaxis, axes.yaxis):
            _replace_locators(axis)


def _replace_locators(axis: Axis) -> None:
    """Wrap the tick locators of an axis in `LocatorOfTicksWithinLimits`, except a `FixedLocator` or `NullLocator`."""
    kept = LocatorOfTicksWithinLimits, FixedLocator, NullLocator
    if not isinstance(major := axis.get_major_locator(), kept):
        axis.set_major_locator(LocatorOfTicksWithinLimits(major))
    if not isinstance(minor := axis.get_minor_locator(), kept):
        axis.set_minor_locator(LocatorOfTicksWithinLimits(minor))
