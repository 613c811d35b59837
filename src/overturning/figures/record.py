"""Figures of single records: fall map, intensity by azimuth, and processing history."""

from collections.abc import Iterable
from pathlib import Path

import xarray as xr

from overturning.figures.ground import intensity_figure
from overturning.figures.history import RESPONSE_PERIODS, history_figure
from overturning.figures.maps import map_figure
from overturning.figures.style import style
from overturning.figures.write import Write, save
from overturning.model.scene import gravestone
from overturning.records.store import read_record_from_motion_file, read_unprocessed_record_from_motion_file
from overturning.study.cube import element_name_of_cube, first_shown_height_and_friction, open_cube, study_of_cube
from overturning.study.scenes import variant_scene


def draw_record_figures(
    cube_path: Path,
    intensity_path: Path,
    motions: Path,
    folder: Path,
    write: Write,
    numbers: Iterable[int] | None = None,
) -> None:
    """Draw and write the figures of each record of a cube.

    Parameters
    ----------
    cube_path : Path
        The cube; it may hold only some records of the study.
    intensity_path : Path
        Intensity measures of all records of the study (NetCDF).
    motions : Path
        Folder of the motions.
    folder : Path
        Receives ``polar/ID`` (map of the block shown first), ``blocks/ID`` (maps of all blocks, if there are several),
        ``intensity/ID`` and ``history/ID.svg`` (time histories, a file next to the report).
    write : callable
        Writes a figure in all formats of the study.
    numbers : iterable of int, optional
        Positions of the records to draw; all by default.
    """
    with open_cube(cube_path) as cube, xr.open_dataset(intensity_path) as intensity:
        everyone, study, stone = (
            intensity["record_id"].to_numpy().tolist(),
            study_of_cube(cube),
            scene_element_label(cube),
        )
        for index in range(cube.sizes["record"]) if numbers is None else numbers:
            one = cube.isel(record=index).load()
            name, station = (str(one[key].item()) for key in ("record_id", "station"))
            around = intensity.isel(record=everyone.index(name))
            event = str(around["event"].item())  # event names depend on all records; this cube may hold one only
            title = f"{station}, {event}" if event else station
            motion = motions / f"{name}.nc"
            used = read_record_from_motion_file(motion)
            with style():
                write(
                    map_figure(one.sel(first_shown_height_and_friction(one)), f"{title}{stone}", around["pgv"]),
                    folder / "polar" / name,
                )
                if study.has_several_blocks:
                    write(map_figure(one, f"{title}{stone}", around["pgv"]), folder / "blocks" / name)
                write(intensity_figure(around, float(one["fault_normal"]), title), folder / "intensity" / name)
                spectra = around["psa_rotd"].sel(period=RESPONSE_PERIODS, method="nearest").to_numpy()
                save(
                    history_figure(read_unprocessed_record_from_motion_file(motion) or used, used, spectra),
                    folder / "history" / f"{name}.svg",
                )


def scene_element_label(cube: xr.Dataset) -> str:
    """Return the names of the scene and the element of a cube, as the second line of a title.

    It names the element to which H and B/H refer if this is another one. Empty for the default gravestone.
    """
    scene = variant_scene(study_of_cube(cube), cube.attrs["variant"])
    if scene.name == gravestone().name:
        return ""
    shown = element_name_of_cube(cube)
    sizes = "" if shown == scene.reference_name else f", by H and B/H of the {scene.reference_name}"
    return f"\n{scene.title or scene.name}: {shown}{sizes}"
