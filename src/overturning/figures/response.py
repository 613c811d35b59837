"""Response of a scene's elements along several azimuths: rotation, slip and uplift (the paper's figure 6)."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.figures.film_of_trajectory import free_elements, window
from overturning.figures.style import DASHED, DASHES, PAGE_WIDTH, SERIES, caption, compass_name, labels
from overturning.model.variables import INT8_MISSING
from overturning.units import CM, GAL

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ROWS = ("base acceleration, Gal", "rotation, °", "slip of the base, cm", "uplift, cm")

LIMIT_SHOWN = 3.0
"""The angle of no return is drawn within so many times the largest rotation of all: a wider one hides them."""


def response_series(one: "xr.Dataset") -> list[Any]:
    """Rotation, slip and uplift of one element in the units of `ROWS`; uplift is of its base's highest vertex."""
    p, q = one["vertices"].to_numpy()[np.isfinite(one["vertices"].to_numpy()[:, 0])].T
    lower = q <= q.min() + 1e-9 * np.ptp(q)
    angle, z = (one[name].to_numpy()[:, None] for name in ("rotation", "z"))
    level = z - p[lower] * np.sin(angle) + q[lower] * np.cos(angle)
    return [
        np.degrees(angle[:, 0]),
        one["base_slip"].to_numpy() / CM,
        (level.max(axis=1) - level[0].max()) / CM,
    ]


def response_figure(paths: Sequence["xr.Dataset"], title: str, headings: Sequence[str] = ()) -> "Figure":
    """Figure with a column per trajectory, all with the same scales; its heading is the azimuth where not given.

    Every free element has a curve of its own, named where there are several, and a dashed line at its angle of no
    return.
    """
    import matplotlib.pyplot as plt

    width = max(min(3.3 * len(paths), PAGE_WIDTH), 4.4, 2.0 * len(paths))
    figure, grid = plt.subplots(
        len(ROWS), len(paths), figsize=(width, 6.6), sharex=True, sharey="row", squeeze=False, layout="constrained"
    )
    start, end = window(paths)
    largest = max(float(np.abs(np.degrees(free_elements(path)["rotation"])).max()) for path in paths)
    several = free_elements(paths[0]).sizes["element"] > 1
    for column, path in enumerate(paths):
        time, upper = path["time"].to_numpy(), grid[0, column]
        upper.plot(time, path["ground_acceleration"].to_numpy() / GAL, color="#555555", linewidth=0.8)
        for number, name in enumerate(free_elements(path)["element"].to_numpy()):
            one, look = path.sel(element=name), {"color": SERIES[number % len(SERIES)], "linewidth": 1.0}
            for axes, values in zip(grid[1:, column], response_series(one), strict=True):
                axes.plot(time, values, label=str(name), linestyle=DASHES[number % len(DASHES)], **look)
            alpha = float(np.degrees(one["critical_angle"]))
            if alpha <= LIMIT_SHOWN * largest:
                for sign in (1, -1):
                    grid[1, column].axhline(sign * alpha, linestyle=DASHED, **(look | {"linewidth": 0.7}))
                grid[1, column].annotate(
                    "α", (0.01, alpha), xycoords=("axes fraction", "data"), va="bottom", fontsize=8, color=look["color"]
                )
        for row, axes in enumerate(grid[:, column]):
            axes.axhline(0, color="#c8c8c8", linewidth=0.5, zorder=0)
            axes.locator_params(axis="y", nbins=5)
            labels(axes, "time, s" if row == len(ROWS) - 1 else "", ROWS[row] if column == 0 else "")
        heading = headings[column] if headings else compass_name(path.attrs["azimuth_deg"])
        upper.set_title(
            fill(f"{heading}: {_does(path)}", int(18 * width / len(paths) / 1.25)), fontsize=9, parse_math=False
        )
    # The curves end with the longest path, and so does the axis.
    last = min(end + 1.5, max(float(path["time"][-1]) for path in paths))
    start = max(0.0, start - 1.5)
    grid[0, 0].set_xlim(start, max(last, start + 0.1))
    figure.align_ylabels(grid[:, 0])
    caption(figure, title, grid[1, 0] if several else None, 3)
    return figure


def _does(path: "xr.Dataset") -> str:
    """Which free elements fall."""
    free = free_elements(path)
    fell = [
        str(name)
        for name, side in zip(free["element"].to_numpy(), free["overturned"].to_numpy(), strict=True)
        if side not in (0, INT8_MISSING)
    ]
    if not fell:
        return "stands"
    return "falls" if free.sizes["element"] == 1 else f"{', '.join(fell)} {'falls' if len(fell) == 1 else 'fall'}"
