"""Grids of compasses with slenderness as radius, one panel per block: what the polar maps have in common."""

from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.figures.style import mark_fault_normal

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray as xr
    from matplotlib.figure import Figure

MOST_IN_A_ROW = 4
"""Panels side by side where only one of height and friction varies; more go into further rows."""


def case_panels(blocks: "xr.Dataset | xr.DataArray", *, more_width: float = 0.0) -> "tuple[Figure, Any]":
    """A panel per friction (columns) and height (rows), or in rows of four where there is one of either only.

    Parameters
    ----------
    blocks : Dataset or DataArray
        With coordinates ``height`` and ``friction``.
    more_width : float
        Room for a colour bar, inches.

    Returns
    -------
    figure : Figure
    panels : ndarray of polar Axes
        Those that stay empty are hidden; take them by `blocks_of`.
    """
    import matplotlib.pyplot as plt
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    rows, columns = blocks["height"].size, blocks["friction"].size
    count = rows * columns
    if min(rows, columns) == 1 and count > 1:
        columns = min(count, MOST_IN_A_ROW if columns == 1 and count > 3 else columns, MOST_IN_A_ROW)
        rows = -(-count // columns)
    figure, panels = plt.subplots(
        rows,
        columns,
        figsize=(max(2.35 * columns, 4.4) + more_width, 2.45 * rows + 1.05),
        subplot_kw={"projection": "polar"},
        squeeze=False,
        # the letters below a panel stay clear of the title of the next
        layout=ConstrainedLayoutEngine(h_pad=0.11),
    )
    for axes in panels.flat[count:]:
        axes.set_visible(False)
    return figure, panels


def blocks_of(blocks: Any, panels: Any) -> "Iterator[tuple[Any, Any]]":
    """Each panel with its block, its title set: heights outside, frictions inside."""
    places = np.ndindex(blocks["height"].size, blocks["friction"].size)
    for axes, (row, column) in zip(panels.flat, places, strict=False):
        one = blocks.isel(height=row, friction=column)
        axes.set_title(f"µ = {float(one['friction']):g}, H = {float(one['height']):g} m", pad=3, fontsize=9)
        yield axes, one


def radius_ticks(axes: Any, top: float, middle: float) -> None:
    """Ticks of B/H from the centre to ``top``; of a narrow range the ``middle`` alone."""
    axes.set_ylim(0.0, top)
    ticks = [tick for tick in (0.2, 0.4, 0.6, 0.8, 1.0) if tick < top] or [round(middle, 2)]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_rlabel_position(112.5)
    axes.tick_params(axis="y", labelsize=7)


def fault_normal_of(cube: "xr.Dataset") -> float:
    """Fault normal of a cube of one record, degrees; NaN where it is not known."""
    return float(cube["fault_normal"]) if "fault_normal" in cube.variables else float("nan")


def mark_normals(cube: "xr.Dataset", panels: Any) -> None:
    """Mark the fault normal of a cube of one record on every panel that is shown."""
    for axes in panels.flat:
        if axes.get_visible():
            mark_fault_normal(axes, fault_normal_of(cube), axes.get_ylim()[1])
