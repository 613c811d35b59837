"""The figures of all records of a study together."""

from pathlib import Path

import numpy as np
import xarray as xr

from overturning.figures.alignment import axes_figure, follow_figure
from overturning.figures.intensity_plane import intensity_plane_figure
from overturning.figures.rose import earthquake_roses_figure, rose_figure
from overturning.figures.site_map import site_map_figure, sites_by_earthquake
from overturning.figures.style import style
from overturning.figures.write import Write, emptied, save
from overturning.model.falls import model_of
from overturning.statistics.earthquakes import alignment_with_references, axes_by_group, summarise_axes
from overturning.statistics.logistic import overturning_fit
from overturning.study.cube import open_records, sizes_of_another


def draw_whole(cube_path: Path, intensity_path: Path, folder: Path, write: Write) -> None:
    """Draw the figures of all records of a study together, from its cube and intensity measures (NetCDF).

    The folder receives ``rose``, ``axes`` and ``plane``, or, where cases have no azimuth of their own, ``follow`` and
    ``earthquakes`` in its place, by what writes a figure in all its formats; and ``maps/`` as of `emptied`, empty where
    no record has coordinates.
    """
    # A dask chunk is a record: no more than one is in memory.
    with open_records(cube_path) as cube, xr.open_dataset(intensity_path) as intensity, style():
        groups = axes_by_group(cube)
        summaries = {name: summarise_axes(axes) for name, axes in groups.items()}
        write(axes_figure(groups, summaries), folder / "axes")
        _draw_maps(cube, folder / "maps")
        write(rose_figure(cube), folder / "rose")
        if not model_of(cube).one_component:
            write(earthquake_roses_figure(cube), folder / "earthquakes")
            slender = cube["b_over_h"].to_numpy().astype(np.float64)
            write(follow_figure(alignment_with_references(cube, intensity), slender), folder / "follow")
        else:
            another = sizes_of_another(cube)
            fit = None if another else overturning_fit(cube, intensity)
            plane = intensity_plane_figure(cube, intensity, fit, float(cube["friction"].max()), another)
            write(plane, folder / "plane")


def _draw_maps(cube: xr.Dataset, folder: Path) -> None:
    with emptied(folder):
        for number, (event, site) in enumerate(sites_by_earthquake(cube).items(), 1):
            save(site_map_figure(site, event), folder / f"{number}.svg")
