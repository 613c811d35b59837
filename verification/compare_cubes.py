"""``python -m verification.compare_cubes OLD NEW``: count the changes between cubes of one study.

Each cube is compared with the one before it, and the last with the first, for the records that both have. Use it for a
change of the sources that must not change results, or whose changes must be counted: make a cube of the same study with
each state of the sources, in separate checkouts.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.model.variables import INT8_MISSING
from overturning.motion.direction import angle_between_azimuths
from overturning.study.answers import MIN_COUNTED_FALL_AZIMUTH_DIFFERENCE_DEG, count_outcome_differences
from overturning.study.cube import open_cube
from verification.measures import MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA, percentage
from verification.tables import markdown_table

MIN_PEAK_SLIP_OF_SLIDING_STONE_M = 1e-3
"""Peak slip from which a stone counts as sliding, m."""


def fall_azimuths_differ(first_azimuths_deg: NDArray[Any], second_azimuths_deg: NDArray[Any]) -> NDArray[np.bool_]:
    """True where two azimuths, degrees, differ by `MIN_COUNTED_FALL_AZIMUTH_DIFFERENCE_DEG` or more; False for NaN."""
    first, second = (np.asarray(azimuths, np.float64) for azimuths in (first_azimuths_deg, second_azimuths_deg))
    return np.asarray(angle_between_azimuths(first, second) >= MIN_COUNTED_FALL_AZIMUTH_DIFFERENCE_DEG)


def neighbours_have_same_outcome(
    overturned_flags: xr.DataArray, fall_azimuths_deg: NDArray[Any] | None = None
) -> NDArray[np.bool_]:
    """Return True for cells that fall or stand like their neighbours in azimuth (or orientation) and B/H.

    On a full circle of azimuths, the first and the last are neighbours. If `fall_azimuths_deg` (3-D, degrees) are
    given, they must agree as well.
    """
    same = np.ones(overturned_flags.shape, bool)
    for name in {"azimuth", "orientation", "b_over_h"} & set(overturned_flags.dims):
        at, values = overturned_flags.get_axis_num(name), np.asarray(overturned_flags[name])
        along, kept = np.moveaxis(overturned_flags.values, at, 0), np.moveaxis(same, at, 0)
        equal = along[1:] == along[:-1]
        if fall_azimuths_deg is not None:
            ways = np.moveaxis(fall_azimuths_deg, at, 0)
            equal &= ~fall_azimuths_differ(ways[1:], ways[:-1])
        kept[1:] &= equal
        kept[:-1] &= equal
        if name == "azimuth" and values.size > 1 and values[-1] + values[1] - values[0] == values[0] + 360:
            kept[[0, -1]] &= along[0] == along[-1]
    return same


def peak_rotation_divided_by_critical_angle(cube: xr.Dataset) -> FloatArray:
    """Return the peak rotation (3-D: peak tilt) over the critical angle α; NaN for an element without α."""
    if "peak_tilt" not in cube:
        return np.asarray(cube.peak_rotation, dtype=np.float64)
    tilt = np.radians(cube.peak_tilt) / np.arctan(cube.b_over_h)
    return np.asarray(tilt.transpose(*cube.peak_tilt.dims), dtype=np.float64)


def fallen_count_and_share_text(overturned_flags: NDArray[np.int8]) -> str:
    """Return a text with the number of cases that fall, and their share of the cases with a known outcome."""
    known = overturned_flags != INT8_MISSING
    down = int((known & (overturned_flags != 0)).sum())
    return f"{down:,} ({percentage(down, int(known.sum())):.2f} %)"


def signed_median_and_absolute_95_percent_change_text(changes_by_cell: FloatArray) -> str:
    """Return a text with the median of signed changes and the 95 % quantile of their absolute values."""
    return (
        f"{np.median(changes_by_cell):+.2g}, {np.quantile(np.abs(changes_by_cell), 0.95):.2g}"
        if changes_by_cell.size
        else "–"
    )


def peak_slip_or_residual_slip_of_stacks(cube: xr.Dataset) -> FloatArray:
    """Return the peak slip of each cell of a cube, m; the residual slip for stacks, whose cubes have no peak slip."""
    if "peak_slip" in cube:
        return np.asarray(cube.peak_slip, dtype=np.float64)
    return np.asarray(np.hypot(cube.residual_slip_north, cube.residual_slip_east), dtype=np.float64)


def outcome_change_texts_by_quantity(old_cube: xr.Dataset, new_cube: xr.Dataset) -> dict[str, str]:
    """Return texts on the changes from one cube of outcomes of a study to another, by name of the quantity."""
    both = [name for name in old_cube.record_id.values if name in new_cube.record_id.values]
    old_cube, new_cube = (
        cube.isel(record=[list(cube.record_id.values).index(name) for name in both]) for cube in (old_cube, new_cube)
    )
    if not both or dict(old_cube.sizes) != dict(new_cube.sizes):
        raise ResultError(
            f"cubes of {dict(old_cube.sizes)} and {dict(new_cube.sizes)} cells; compare those of one study"
        )
    grid = [str(name) for name in old_cube.overturned.dims if name != "record" and name in old_cube.coords]
    if name := next((name for name in grid if not np.array_equal(old_cube[name].values, new_cube[name].values)), ""):
        raise ResultError(f"cubes of different {name} values; compare those of one study")
    flags = old_cube.overturned.fillna(INT8_MISSING).astype(np.int8)
    before, after = flags.values, new_cube.overturned.fillna(INT8_MISSING).astype(np.int8).values
    azimuths = (old_cube.fall_azimuth.values, new_cube.fall_azimuth.values) if "fall_azimuth" in old_cube else None
    away = None if azimuths is None else fall_azimuths_differ(*azimuths)
    firm = neighbours_have_same_outcome(flags, None if azimuths is None else azimuths[0])
    counts = count_outcome_differences(before, after, away)
    firmly = count_outcome_differences(before[firm], after[firm], None if away is None else away[firm])
    turned, turned_too, stands = (
        peak_rotation_divided_by_critical_angle(old_cube),
        peak_rotation_divided_by_critical_angle(new_cube),
        (before == 0) & (after == 0),
    )
    slid, slid_too = peak_slip_or_residual_slip_of_stacks(old_cube), peak_slip_or_residual_slip_of_stacks(new_cube)
    rocks, slides = (
        stands & (turned > MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA) & np.isfinite(turned_too),
        stands & (slid > MIN_PEAK_SLIP_OF_SLIDING_STONE_M),
    )
    rotation_changes = signed_median_and_absolute_95_percent_change_text((turned_too - turned)[rocks])
    return {
        "cells": f"{before.size:,}",
        "fall, before": fallen_count_and_share_text(before),
        "fall, after": fallen_count_and_share_text(after),
        "without an answer, before and after": f"{(before == INT8_MISSING).sum():,}, {(after == INT8_MISSING).sum():,}",
        "cells with another status": f"{(old_cube.status.values != new_cube.status.values).sum():,}",
        "flags changed": f"{counts.flags:,}",
        "of them where the neighbours agree": f"{firmly.flags:,}",
        "sides changed, of what falls in both": f"{counts.sides:,} of {counts.fallen:,}",
        "of these where the neighbours agree": f"{firmly.sides:,} of {firmly.fallen:,}",
        "peak rotation of what rocks and stands: change in α, median and 95 %": rotation_changes,
        "peak slip of what stands: change in %, median and 95 %": signed_median_and_absolute_95_percent_change_text(
            100 * (slid_too[slides] / slid[slides] - 1)
        ),
    }


def table_of_outcome_changes_between_successive_cubes(cube_paths: Sequence[Path]) -> str:
    """Return a Markdown table with a column for each pair of successive cubes, and one for first and last."""
    opened = [open_cube(path, element=None, amplitude=None) for path in cube_paths]
    steps = [(i, i + 1) for i in range(len(cube_paths) - 1)] + [(0, len(cube_paths) - 1)] * (len(cube_paths) > 2)
    columns = [outcome_change_texts_by_quantity(opened[first], opened[last]) for first, last in steps]
    names = [
        path.stem if len({one.stem for one in cube_paths}) == len(cube_paths) else str(path) for path in cube_paths
    ]
    head = [f"{names[first]} → {names[last]}" for first, last in steps]
    return markdown_table(("", *head), [(name, *(column[name] for column in columns)) for name in columns[0]])


def main(
    old: Annotated[Path, typer.Argument(help="a cube")],
    newer: Annotated[list[Path], typer.Argument(help="later cubes of the same study, in order")],
) -> None:
    """Print a table of how outcomes changed from one results cube of a study to the next, and from first to last."""
    try:
        print(table_of_outcome_changes_between_successive_cubes([old, *newer]))
    except ResultError as error:
        raise SystemExit(str(error)) from None


if __name__ == "__main__":
    typer.run(main)
