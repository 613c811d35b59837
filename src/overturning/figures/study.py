"""Figures that combine all records of a study."""

from pathlib import Path

import numpy as np
import xarray as xr

from overturning.figures.alignment import alignment_by_b_over_h_figure, earthquake_alignment_figure
from overturning.figures.intensity_plane import intensity_plane_figure
from overturning.figures.rose import earthquake_roses_figure, rose_figure
from overturning.figures.site_map import earthquakes_on_map, site_maps
from overturning.figures.style import style
from overturning.figures.write import Write, refill_folder
from overturning.labels import element_size_note
from overturning.model.falls import model_of_cube
from overturning.statistics.earthquakes import fall_alignment_with_references, fall_axes_by_group, summarise_fall_axes
from overturning.statistics.logistic import fit_logistic_overturning_model
from overturning.study.cube import open_cube_by_record


def draw_study_figures(cube_path: Path, intensity_path: Path, folder: Path, write: Write) -> None:
    """Draw the figures that combine all records of a study, from its cube and intensity measures (NetCDF).

    Writes into `folder`: ``rose``, ``axes``, ``plane`` (2-D) or ``follow`` and ``earthquakes`` (3-D), and the maps of
    the stations into ``maps/`` (see `refill_folder`; empty if no record has coordinates). `write` writes a figure in
    all formats of the study.
    """
    # Each dask chunk is one record, so that only one record is in memory at a time.
    with open_cube_by_record(cube_path) as cube, xr.open_dataset(intensity_path) as intensity, style():
        groups = fall_axes_by_group(cube)
        summaries = {name: summarise_fall_axes(axes) for name, axes in groups.items()}
        write(earthquake_alignment_figure(groups, summaries), folder / "axes")
        _draw_maps(cube, folder / "maps", write)
        write(rose_figure(cube, summaries), folder / "rose")
        if not model_of_cube(cube).one_component:
            write(earthquake_roses_figure(cube), folder / "earthquakes")
            slender = cube["b_over_h"].to_numpy().astype(np.float64)
            write(
                alignment_by_b_over_h_figure(fall_alignment_with_references(cube, intensity), slender),
                folder / "follow",
            )
        else:
            another = element_size_note(cube)
            fit = None if another else fit_logistic_overturning_model(cube, intensity)
            plane = intensity_plane_figure(cube, intensity, fit, float(cube["friction"].max()), another)
            write(plane, folder / "plane")


def _draw_maps(cube: xr.Dataset, folder: Path, write: Write) -> None:
    """Draw the maps of the stations of a cube into a folder."""
    with refill_folder(folder):
        for number, figure in enumerate(site_maps(earthquakes_on_map(cube)), 1):
            write(figure, folder / f"{number}")
