"""All figures of a study."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from overturning.figures.alignment import axes_figure, follow_figure
from overturning.figures.ground import intensity_figure
from overturning.figures.history import history_figure
from overturning.figures.intensity_plane import intensity_plane_figure
from overturning.figures.maps import map_figure
from overturning.figures.rose import earthquake_roses_figure, rose_figure
from overturning.figures.site_map import site_map_figure, sites_by_earthquake
from overturning.figures.style import save, style
from overturning.files import write_text
from overturning.model.falls import model_of
from overturning.model.scene import gravestone
from overturning.records.store import read_motion, read_unprocessed
from overturning.statistics.earthquakes import axes_by_group, followed, summarise_axes
from overturning.statistics.logistic import overturning_fit
from overturning.study.cube import open_cube, study_of
from overturning.study.resume import DRAWN
from overturning.study.scenes import scene_of
from overturning.study.sections import Figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNTED = ("illustrative", "maps")
"""Folders of which only the drawing knows how many files there will be."""


def draw_study(
    cube_path: Path,
    intensity_path: Path,
    motions: Path,
    folder: Path,
    threads: int = 1,
    settings: Figures | None = None,
) -> None:
    """Draw the figures of a study from its cube, intensity measures and folder of processed motions (NetCDF).

    The folder receives ``polar/ID`` and ``intensity/ID`` for each record (`map_figure`), ``rose``, ``axes`` and
    ``plane``, or, where cases have no azimuth of their own, ``follow`` and ``earthquakes`` in its place, each in all
    formats; ``history/ID.svg`` (time histories, not part of the report's page but beside it); ``illustrative/`` and
    ``maps/`` (empty where no record has coordinates); and ``drawn.txt``, the names of the files in these two.
    Matplotlib draws one figure at a time: `threads` is the number of processes, and the files are the same for any.
    Settings are by default those of the cube's study.
    """
    with open_cube(cube_path) as cube:
        count, write = cube.sizes["record"], partial(write_figure, settings or study_of(cube).figures)
    tasks = [
        partial(draw_whole, cube_path, intensity_path, motions, folder, write),
        *(partial(draw_record, cube_path, intensity_path, motions, folder, write, index) for index in range(count)),
    ]
    if threads == 1:
        for task in tasks:
            task()
    else:
        with ProcessPoolExecutor(threads) as pool:
            for drawn in [pool.submit(task) for task in tasks]:
                drawn.result()
    names = sorted(path.relative_to(folder).as_posix() for name in COUNTED for path in (folder / name).iterdir())
    write_text(folder / DRAWN, "".join(f"{name}\n" for name in names))


Write = Callable[["Figure", Path], None]


def write_figure(settings: Figures, figure: "Figure", stem: Path) -> None:
    """Write a figure in the size, resolution and formats of a study, to a path without its ending."""
    figure.set_size_inches(*(settings.size * figure.get_size_inches()))
    save(figure, *(stem.parent / f"{stem.name}.{kind}" for kind in settings.formats), dpi=settings.dpi)


def draw_record(cube_path: Path, intensity_path: Path, motions: Path, folder: Path, write: Write, index: int) -> None:
    """Draw the figures of one record, by its number; the others as of `draw_study`, but for what writes a figure."""
    # A dask chunk is a record: no more than one is in memory.
    with open_cube(cube_path, chunks={"record": 1}) as cube, xr.open_dataset(intensity_path) as intensity, style():
        one = cube.isel(record=index).load()
        name, station, event = (str(one[key].item()) for key in ("record_id", "station", "event"))
        title = f"{station}, {event}" if event else station
        write(map_figure(one, f"{title}{_stone(cube)}"), folder / "polar" / name)
        around = intensity_figure(intensity.isel(record=index), float(one["fault_normal"]), title)
        write(around, folder / "intensity" / name)
        motion = motions / f"{name}.nc"
        used = read_motion(motion)
        save(history_figure(read_unprocessed(motion) or used, used), folder / "history" / f"{name}.svg")


def _stone(cube: xr.Dataset) -> str:
    """Whose falls a cube shows: scene and element, nothing for the default gravestone."""
    scene = scene_of(study_of(cube), cube.attrs["variant"])
    if scene.name == gravestone().name:
        return ""
    return f"\n{scene.title or scene.name}: {scene.shown_name}"


def draw_whole(cube_path: Path, intensity_path: Path, motions: Path, folder: Path, write: Write) -> None:
    """Draw the figures of all records together."""
    from overturning.figures.illustrative import draw_illustrative_cases

    with open_cube(cube_path, chunks={"record": 1}) as cube, xr.open_dataset(intensity_path) as intensity, style():
        groups = axes_by_group(cube)
        summaries = {name: summarise_axes(axes) for name, axes in groups.items()}
        write(axes_figure(groups, summaries), folder / "axes")
        _draw_maps(cube, folder / "maps")
        write(rose_figure(cube), folder / "rose")
        if not model_of(cube).one_component:
            write(earthquake_roses_figure(cube), folder / "earthquakes")
            slender = cube["b_over_h"].to_numpy().astype(np.float64)
            write(follow_figure(followed(cube, intensity), slender), folder / "follow")
        else:
            fit = overturning_fit(cube, intensity)
            write(intensity_plane_figure(cube, intensity, fit, float(cube["friction"].max())), folder / "plane")
        draw_illustrative_cases(cube, motions, folder / "illustrative")


def _draw_maps(cube: xr.Dataset, folder: Path) -> None:
    # Files of an earlier study would be taken for maps of this one.
    for old in folder.glob("*.svg"):
        old.unlink()
    folder.mkdir(parents=True, exist_ok=True)
    for number, (event, site) in enumerate(sites_by_earthquake(cube).items(), 1):
        save(site_map_figure(site, event), folder / f"{number}.svg")
