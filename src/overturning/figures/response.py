"""Response of a block, or of a scene's reference element, along several azimuths: rotation, slip and uplift under the motion (the paper's figure 6)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.dem.variables import INT8_MISSING
from overturning.figures.film_of_trajectory import compass_name, window
from overturning.figures.style import DASHED, FALLS, SERIES, caption, labels
from overturning.units import CM, GAL

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ROWS = (
    ("base acceleration, Gal", SERIES[0]),
    ("rotation, °", SERIES[1]),
    ("slip of the base, cm", SERIES[2]),
    ("uplift, cm", SERIES[3]),
)


def response_series(path: "xr.Dataset") -> list[Any]:
    """The four quantities of the reference element in the units of `ROWS`; uplift is that of its highest vertex of those below."""
    one = path.sel(element=path.attrs["reference"])
    p, q = one["vertices"].to_numpy()[np.isfinite(one["vertices"].to_numpy()[:, 0])].T
    lower = q <= q.min() + 1e-9 * np.ptp(q)
    angle, z = (one[name].to_numpy()[:, None] for name in ("rotation", "z"))
    level = z - p[lower] * np.sin(angle) + q[lower] * np.cos(angle)
    return [
        path["ground_acceleration"].to_numpy() / GAL,
        np.degrees(angle[:, 0]),
        one["base_slip"].to_numpy() / CM,
        (level.max(axis=1) - level[0].max()) / CM,
    ]


def response_figure(paths: Sequence["xr.Dataset"], title: str, headings: Sequence[str] = ()) -> "Figure":
    """Figure with a column per trajectory, all with the same scales; its heading is the azimuth where not given."""
    import matplotlib.pyplot as plt

    figure, grid = plt.subplots(
        len(ROWS), len(paths), figsize=(max(3.4 * len(paths), 4.4), 6.4), sharex=True, sharey="row", squeeze=False,
        layout="constrained",
    )  # fmt: skip
    start, end = window(paths)
    start, end = max(0.0, start - 1.5), end + 1.5
    for column, path in enumerate(paths):
        time = path["time"].to_numpy()
        one = path.sel(element=path.attrs["reference"])
        alpha = float(np.degrees(one["critical_angle"]))
        fell = int(one["overturned"]) not in (0, INT8_MISSING)
        for row, ((label, colour), values) in enumerate(zip(ROWS, response_series(path), strict=True)):
            axes = grid[row, column]
            axes.plot(time, values, color=colour, linewidth=0.9)
            axes.axhline(0, color="#c8c8c8", linewidth=0.5, zorder=0)
            labels(axes, "time, s" if axes is grid[-1, column] else "", label if column == 0 else "")
            axes.locator_params(axis="y", nbins=5)
            if row == 1:
                for sign in (1, -1):
                    axes.axhline(sign * alpha, color=FALLS, linewidth=0.7, linestyle=DASHED)
                axes.annotate(
                    "α", (0.01, alpha), xycoords=("axes fraction", "data"), va="bottom", fontsize=7, color=FALLS
                )
        heading = headings[column] if headings else compass_name(path.attrs["azimuth_deg"])
        grid[0, column].set_title(f"{heading}: {'falls' if fell else 'stands'}", fontsize=9)
    grid[0, 0].set_xlim(start, max(end, start + 0.1))
    figure.align_ylabels(grid[:, 0])
    caption(figure, title)
    return figure
