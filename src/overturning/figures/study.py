"""Figures that combine all records of a study."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from overturning.figures.alignment import (
    fall_alignment_by_b_over_h_figure,
    fault_normal_alignment_figure_from_fall_axes,
)
from overturning.figures.intensity_plane import outcomes_by_pga_and_pgv_over_pga_figure
from overturning.figures.rose import fall_roses_by_earthquake_figure, fall_roses_by_group_figure
from overturning.figures.site_map import figures_with_several_earthquake_maps, mappable_earthquakes
from overturning.figures.style import use_package_matplotlib_settings
from overturning.figures.write import FigureWriterInAllFormats, empty_folder_then_write_list_of_new_files
from overturning.labels import note_if_sizes_are_not_those_of_shown_stone
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.statistics.earthquakes import fall_axes_from_fault_normal_by_group, summarise_fall_axes
from overturning.statistics.logistic import LogisticFit, fit_logistic_overturning_model
from overturning.statistics.reference_directions import alignments_with_reference_axes_by_record_group
from overturning.study.cube import open_cube_for_reading_by_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_study_figures(
    cube_path: Path, intensity_path: Path, output_folder: Path, write_figure_files: FigureWriterInAllFormats
) -> None:
    """Draw all figures that combine the records of a study, from its results cube and intensity measures (NetCDF).

    Writes into `output_folder`: ``rose``, ``axes``, ``plane`` (2-D) or ``follow`` and ``earthquakes`` (3-D), and the
    maps of the stations into ``maps/`` (see `empty_folder_then_write_list_of_new_files`; empty if no record has
    coordinates). The function `write_figure_files` writes a figure in all formats of the study.
    """
    # Each dask chunk is one record, so that only one record is in memory at a time.
    with (
        open_cube_for_reading_by_record(cube_path) as cube,
        xr.open_dataset(intensity_path, engine="netcdf4") as intensity,
        use_package_matplotlib_settings(),
    ):
        fits = default_model_of_same_kind_as_results_cube(
            cube
        ).is_planar and not note_if_sizes_are_not_those_of_shown_stone(cube)
        fit = fit_logistic_overturning_model(cube, intensity) if fits else None
        for name, draw in all_records_non_map_figure_functions_by_name(
            cube, intensity, fit, fall_axes_from_fault_normal_by_group(cube)
        ).items():
            write_figure_files(draw(), output_folder / name)
        _draw_earthquake_maps(cube, output_folder / "maps", write_figure_files)


def all_records_non_map_figure_functions_by_name(
    cube: xr.Dataset,
    intensity_measures: xr.Dataset,
    logistic_fit: LogisticFit | None,
    fall_axes_by_group: dict[str, xr.Dataset],
) -> "dict[str, Callable[[], Figure]]":
    """Return, by name, functions that draw the figures combining all records of a study, except for the maps.

    The names are ``axes`` and ``rose``, and ``plane`` (2-D) or ``follow`` and ``earthquakes`` (3-D). `logistic_fit`,
    the fitted overturning probability, is drawn into ``plane``; None leaves it out. `fall_axes_by_group` comes from
    `fall_axes_from_fault_normal_by_group`.
    """
    summaries = {name: summarise_fall_axes(axes) for name, axes in fall_axes_by_group.items()}
    functions: dict[str, Callable[[], Figure]] = {
        "axes": partial(fault_normal_alignment_figure_from_fall_axes, fall_axes_by_group, summaries),
        "rose": partial(fall_roses_by_group_figure, cube, summaries),
    }
    if default_model_of_same_kind_as_results_cube(cube).is_planar:
        friction, another = float(cube["friction"].max()), note_if_sizes_are_not_those_of_shown_stone(cube)
        plane = partial(
            outcomes_by_pga_and_pgv_over_pga_figure, cube, intensity_measures, logistic_fit, friction, another
        )
        return functions | {"plane": plane}

    def draw_alignment_with_reference_axes_by_b_over_h() -> "Figure":
        slender = cube["b_over_h"].to_numpy().astype(np.float64)
        return fall_alignment_by_b_over_h_figure(
            alignments_with_reference_axes_by_record_group(cube, intensity_measures), slender
        )

    return functions | {
        "earthquakes": partial(fall_roses_by_earthquake_figure, cube),
        "follow": draw_alignment_with_reference_axes_by_b_over_h,
    }


def _draw_earthquake_maps(cube: xr.Dataset, output_folder: Path, write_figure_files: FigureWriterInAllFormats) -> None:
    """Draw maps of a study's earthquakes, with stations and mean fall axes, and write them into a folder."""
    with empty_folder_then_write_list_of_new_files(output_folder):
        for number, figure in enumerate(figures_with_several_earthquake_maps(mappable_earthquakes(cube)), 1):
            write_figure_files(figure, output_folder / f"{number}")
