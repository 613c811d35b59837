"""Figures of single records: maps of falls, and intensity by azimuth."""

from collections.abc import Iterable
from pathlib import Path

import xarray as xr

from overturning.figures.film_words import station_and_event_text
from overturning.figures.ground import pga_and_pgv_by_azimuth_figure
from overturning.figures.maps import fall_map_figure
from overturning.figures.style import use_package_matplotlib_settings
from overturning.figures.write import FigureWriterInAllFormats
from overturning.model.scene import gravestone
from overturning.study.cube import (
    default_height_and_friction_of_figures,
    element_name_to_show,
    open_cube,
    study_of_cube,
)
from overturning.study.scenes import variant_scene


def draw_record_figures(
    cube_path: Path,
    intensity_path: Path,
    output_folder: Path,
    write_figure_files: FigureWriterInAllFormats,
    drawn_record_indices: Iterable[int] | None = None,
) -> None:
    """Draw and write the figures of each record in a results cube.

    Parameters
    ----------
    cube_path : Path
        The cube; it may hold only some records of the study.
    intensity_path : Path
        Intensity measures of all records of the study (NetCDF).
    output_folder : Path
        Receives, by record id, ``polar/ID`` (map of falls of the default block), ``blocks/ID`` (maps of all blocks, if
        there are several) and ``intensity/ID`` (PGA and PGV by azimuth).
    write_figure_files : callable
        Writes a figure in all formats of the study.
    drawn_record_indices : iterable of int, optional
        Positions of the records to draw; all by default.
    """
    with open_cube(cube_path) as cube, xr.open_dataset(intensity_path, engine="netcdf4") as intensity:
        everyone, study, stone = (
            intensity["record_id"].to_numpy().tolist(),
            study_of_cube(cube),
            second_title_line_with_scene_and_element(cube),
        )
        for index in range(cube.sizes["record"]) if drawn_record_indices is None else drawn_record_indices:
            one = cube.isel(record=index).load()
            name, station = (str(one[key].item()) for key in ("record_id", "station"))
            around = intensity.isel(record=everyone.index(name))
            event = str(around["event"].item())  # event names depend on all records; this cube may hold one only
            title = station_and_event_text(station or name, event)
            with use_package_matplotlib_settings():
                write_figure_files(
                    fall_map_figure(
                        one.sel(default_height_and_friction_of_figures(one)), f"{title}{stone}", around["pgv"]
                    ),
                    output_folder / "polar" / name,
                )
                if study.has_several_heights_frictions_or_aspects:
                    write_figure_files(
                        fall_map_figure(one, f"{title}{stone}", around["pgv"]), output_folder / "blocks" / name
                    )
                write_figure_files(
                    pga_and_pgv_by_azimuth_figure(around, float(one["fault_normal"]), title),
                    output_folder / "intensity" / name,
                )


def second_title_line_with_scene_and_element(cube: xr.Dataset) -> str:
    """Return a line break and the names of scene and shown element, to append to a title; "" for the gravestone scene.

    The line also names the element to which H and B/H refer, if that is not the element shown.
    """
    scene = variant_scene(study_of_cube(cube), cube.attrs["variant"])
    if scene.name == gravestone().name:
        return ""
    shown = element_name_to_show(cube)
    sizes = (
        ""
        if shown == scene.size_reference_element_name
        else f", by H and B/H of the {scene.size_reference_element_name}"
    )
    return f"\n{scene.name}: {shown}{sizes}"
