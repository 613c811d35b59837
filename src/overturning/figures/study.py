"""All figures of a study."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import xarray as xr

from overturning.figures.axes_by_earthquake import axes_figure
from overturning.figures.history import history_figure
from overturning.figures.intensity import intensity_figure
from overturning.figures.intensity_plane import intensity_plane_figure
from overturning.figures.polar import fall_map_figure
from overturning.figures.probability import probability_map_figure
from overturning.figures.rose import rose_figure
from overturning.figures.site_map import site_map_figure, sites_by_earthquake
from overturning.figures.style import save, style
from overturning.records.store import read_motion, read_unprocessed
from overturning.statistics.earthquakes import axes_by_group, summarise_axes
from overturning.statistics.logistic import overturning_fit
from overturning.study.cube import open_cube

PALETTE = 64
"""Colours of the pictures of which there is one per record."""


def draw_study(cube_path: Path, intensity_path: Path, motions: Path, folder: Path, threads: int = 1) -> None:
    """Draw the figures of a study.

    Parameters
    ----------
    cube_path, intensity_path : Path
        The cube and the intensity measures, NetCDF.
    motions : Path
        Folder of the processed motions, for the time histories and the telling cases.
    folder : Path
        Receives ``polar/ID.png``, ``intensity/ID.png`` and ``history/ID.svg`` (time histories, not part of the report's
        page but beside it) for each record (the polar map shows probabilities where the
        cube has an ensemble, flags otherwise), ``rose.svg``, ``axes.svg``, ``plane.svg``, ``telling/``, and ``maps/`` (empty where no
        record has coordinates).
    threads : int
        Number of processes that draw: Matplotlib draws one figure at a time. The files are the same for any number.
    """
    with open_cube(cube_path) as cube:
        count = cube.sizes["record"]
    tasks = [
        partial(_draw_whole, cube_path, intensity_path, motions, folder),
        *(partial(_draw_record, cube_path, intensity_path, motions, folder, index) for index in range(count)),
    ]
    if threads == 1:
        for task in tasks:
            task()
        return
    with ProcessPoolExecutor(threads) as pool:
        for drawn in [pool.submit(task) for task in tasks]:
            drawn.result()


def _draw_record(cube_path: Path, intensity_path: Path, motions: Path, folder: Path, index: int) -> None:
    # A dask chunk is a record: no more than one is in memory.
    with open_cube(cube_path, chunks={"record": 1}) as cube, xr.open_dataset(intensity_path) as intensity, style():
        one = cube.isel(record=index).load()
        name, station, event = (str(one[key].item()) for key in ("record_id", "station", "event"))
        title = f"{station}, {event}" if event else station
        polar_figure = probability_map_figure if "probability_towards" in cube else fall_map_figure
        save(polar_figure(one, title), folder / "polar" / f"{name}.png", PALETTE)
        around = intensity_figure(intensity.isel(record=index), float(one["fault_normal"]), title)
        save(around, folder / "intensity" / f"{name}.png", PALETTE)
        motion = motions / f"{name}.nc"
        used = read_motion(motion)
        save(history_figure(read_unprocessed(motion) or used, used), folder / "history" / f"{name}.svg")


def _draw_whole(cube_path: Path, intensity_path: Path, motions: Path, folder: Path) -> None:
    from overturning.figures.telling import draw_telling_cases

    with open_cube(cube_path, chunks={"record": 1}) as cube, xr.open_dataset(intensity_path) as intensity, style():
        save(rose_figure(cube), folder / "rose.svg")
        groups = axes_by_group(cube)
        summaries = {name: summarise_axes(axes) for name, axes in groups.items()}
        save(axes_figure(groups, summaries), folder / "axes.svg")
        _draw_maps(cube, folder / "maps")
        plane = intensity_plane_figure(cube, intensity, overturning_fit(cube, intensity), float(cube["friction"].max()))
        save(plane, folder / "plane.svg")
        draw_telling_cases(cube, motions, folder / "telling")


def _draw_maps(cube: xr.Dataset, folder: Path) -> None:
    # Files of an earlier study would be taken for maps of this one.
    for old in folder.glob("*.svg"):
        old.unlink()
    folder.mkdir(parents=True, exist_ok=True)
    for number, (event, site) in enumerate(sites_by_earthquake(cube).items(), 1):
        save(site_map_figure(site, event), folder / f"{number}.svg")
