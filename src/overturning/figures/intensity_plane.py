"""Figure of outcomes by PGA and PGV/PGA, with published overturning criteria and the fitted probability."""

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.style import (
    DASHED_LINE_STYLE,
    FALL_COLOUR,
    INK,
    SERIES_COLOURS,
    STANDS_COLOUR,
    add_title_and_legend,
    create_panel_grid,
    is_drawing_for_phone,
    label_axes,
    set_logarithmic_ticks,
)
from overturning.labels import friction_label
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.statistics.criteria_limits import OVERTURNING_CRITERIA, west_acceleration_limit
from overturning.statistics.falls import mean_fall_probability_over_directions
from overturning.statistics.logistic import MAX_PGA_FROM_ROUNDING_M_S2, LogisticFit
from overturning.units import GAL, STANDARD_GRAVITY

CRITERION_LINE_STYLES: Final = (
    (SERIES_COLOURS[0], DASHED_LINE_STYLE),
    (INK, (0, (1, 1.2))),
    (SERIES_COLOURS[3], "solid"),
    (SERIES_COLOURS[5], (0, (5, 1.2, 1, 1.2))),
    (SERIES_COLOURS[4], (0, (9, 2))),
)
"""Colour and line style of each of `criteria.OVERTURNING_CRITERIA`."""


def motion_pga_pgv_ratio_and_block_fall_probability(
    cube: xr.Dataset, pga_and_pgv_dataset: xr.Dataset, height: float, b_over_h: float, friction: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return PGA (m/s²), PGV/PGA (s) and one block's fall probability for each azimuth of each record.

    The three arrays have shape (n,). Cases without outcome are left out, and so are motions whose PGA does not exceed
    `MAX_PGA_FROM_ROUNDING_M_S2`.
    """
    block = cube.sel(height=height, b_over_h=b_over_h, friction=friction, method="nearest")
    planes = default_model_of_same_kind_as_results_cube(cube).fall_probability_and_direction_by_case(block).compute()
    along = pga_and_pgv_dataset[["pga", "pgv"]].sel(azimuth=planes["azimuth"], method="nearest")
    falls = planes["falls"].transpose("record", "azimuth").to_numpy().ravel()
    pga, pgv = (along[name].transpose("record", "azimuth").to_numpy().ravel() for name in ("pga", "pgv"))
    known = np.isfinite(falls) & (pga > MAX_PGA_FROM_ROUNDING_M_S2)
    return pga[known], (pgv / np.where(known, pga, 1))[known], falls[known]


def _draw_outcomes_by_pga_and_pgv_over_pga(
    axes: Any,
    pga_pgv_over_pga_and_fall_probability: tuple[FloatArray, FloatArray, FloatArray],
    height: float,
    b_over_h: float,
    logistic_fit: LogisticFit | None = None,
    fit_label: str = "fit: probability ½",
    *,
    draws_published_criteria: bool = True,
) -> None:
    """Draw one block's outcomes by PGA and PGV/PGA, with published criteria and the line of fitted probability ½."""
    pga, ratio, falls = pga_pgv_over_pga_and_fall_probability
    axes.set(xscale="log", yscale="log")
    west = float(west_acceleration_limit(b_over_h))
    low_x, high_x = min(pga.min(initial=west), west) / 1.5, max(pga.max(initial=west), west) * 1.5
    low_y, high_y = ratio.min(initial=0.05) / 1.5, ratio.max(initial=0.2) * 1.5
    stands = falls < 0.5
    common = {"s": 9, "linewidth": 0.5, "rasterized": True}
    for chosen, label, look in (
        (stands, "stands", {"marker": "o", "facecolor": STANDS_COLOUR, "edgecolor": "#555555"}),
        (~stands, "falls", {"marker": "D", "facecolor": FALL_COLOUR, "edgecolor": FALL_COLOUR}),
    ):
        axes.scatter(pga[chosen] / GAL, ratio[chosen], label=label, **common, **look)
    x = np.geomspace(low_x, high_x, 200)
    y = np.geomspace(low_y, high_y, 200)
    for criterion, (color, dashes) in (
        zip(OVERTURNING_CRITERIA, CRITERION_LINE_STYLES, strict=True) if draws_published_criteria else ()
    ):
        limit = criterion.pga_limit_from_height_b_over_h_pgv_over_pga(height, b_over_h, y)
        axes.plot(limit / GAL, y, color=color, linewidth=1.3, linestyle=dashes, label=criterion.name)
    if logistic_fit is not None and abs(logistic_fit.coefficient_estimates[2]) > 1e-9:
        # Probability one half: the linear predictor is zero.
        constant, over_west, over_ratio, over_shape, over_size = logistic_fit.coefficient_estimates
        shape, size = np.nan_to_num(over_shape) * np.log(b_over_h), np.nan_to_num(over_size) * np.log(height)
        with np.errstate(over="ignore"):  # far beyond the figure
            y = np.exp(-(constant + over_west * np.log(x / (STANDARD_GRAVITY * b_over_h)) + shape + size) / over_ratio)
        axes.plot(x / GAL, y, color=SERIES_COLOURS[2], linewidth=1.6, label=fit_label)
    axes.set(xlim=(low_x / GAL, high_x / GAL), ylim=(low_y, high_y))
    for axis in (axes.xaxis, axes.yaxis):
        set_logarithmic_ticks(axis)
    label_axes(axes, "PGA, Gal", "PGV/PGA, s", ticks_with_small_labels="both")
    axes.grid(True, which="major")
    # With a given place, Matplotlib does not measure the ticks to find one.
    axes.set_title(f"B/H = {b_over_h:.3g}, H = {height:g} m", fontsize=9, y=1.0)


def outcomes_by_pga_and_pgv_over_pga_figure(
    cube: xr.Dataset,
    pga_and_pgv_dataset: xr.Dataset,
    logistic_fit: LogisticFit | None,
    friction: float,
    note_that_sizes_are_of_other_stone: str = "",
) -> Figure:
    """Draw outcomes in the plane of PGA and PGV/PGA, for up to three B/H (columns) and two heights (rows).

    A figure for a phone shows the smallest height only. `pga_and_pgv_dataset` has ``pga`` (m/s²) and ``pgv`` (m/s) by
    record and azimuth. `note_that_sizes_are_of_other_stone`, from `note_if_sizes_are_not_those_of_shown_stone`, is
    added to the title; with this note the published criteria are left out, since H and B/H are not those of the stone
    whose outcomes are shown.
    """
    slender = cube["b_over_h"].to_numpy()
    one_friction = cube.sel(friction=[friction], method="nearest")
    share = (
        mean_fall_probability_over_directions(one_friction, summed_dims=("record", "height", "friction"))
        .compute()
        .to_numpy()
    )
    # Show the slendernesses with the most evenly divided outcomes: they are the most informative.
    chosen = np.sort(slender[np.argsort(-np.nan_to_num(share * (1 - share)), kind="stable")[:3]])
    heights = cube["height"].to_numpy()
    shown = heights[:1] if is_drawing_for_phone() else heights[np.unique([0, heights.size - 1])]
    # The fit includes all frictions, the points show one.
    named = "fit: probability ½" if cube.sizes["friction"] == 1 else "fit of all µ together: probability ½"
    figure, panels = create_panel_grid(shown.size, chosen.size, max(2.7 * chosen.size, 4.2), 2.4 * shown.size + 0.8)
    for row, height in enumerate(shown):
        for column, b_over_h in enumerate(chosen):
            points = motion_pga_pgv_ratio_and_block_fall_probability(
                cube, pga_and_pgv_dataset, float(height), float(b_over_h), friction
            )
            block = float(height), float(b_over_h)
            _draw_outcomes_by_pga_and_pgv_over_pga(
                panels[row, column],
                points,
                *block,
                logistic_fit,
                named,
                draws_published_criteria=not note_that_sizes_are_of_other_stone,
            )
    title = f"Every plane of every record, {friction_label(cube, friction)}"
    add_title_and_legend(figure, f"{title}\n{note_that_sizes_are_of_other_stone}".rstrip(), panels[0, 0], 3)
    return figure
