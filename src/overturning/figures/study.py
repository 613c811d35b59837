"""All figures of a study."""

from pathlib import Path

import numpy as np

from overturning.figures.intensity import intensity_figure
from overturning.figures.polar import fall_map_figure
from overturning.figures.rose import rose_figure
from overturning.figures.style import save, style
from overturning.study.cube import open_cube


def draw_study(cube_path: Path, intensity_path: Path, folder: Path) -> None:
    """Draw the figures of a study.

    Parameters
    ----------
    cube_path, intensity_path : Path
        The cube and the intensity measures, NetCDF.
    folder : Path
        Receives ``polar/ID.svg`` and ``intensity/ID.svg`` for each record, and ``rose.svg``.
    """
    import xarray as xr

    with open_cube(cube_path, chunks={"record": 1}) as cube, xr.open_dataset(intensity_path) as intensity, style():
        for index, name in enumerate(cube["record_id"].to_numpy()):
            one = cube.isel(record=index)
            station, event = str(one["station"].item()), str(one["event"].item())
            title = f"{station}, {event}" if event else station
            save(fall_map_figure(one.load(), title), folder / "polar" / f"{name}.svg")
            normal = float(one["fault_normal"]) if "fault_normal" in one else np.nan
            save(intensity_figure(intensity.isel(record=index), normal, title), folder / "intensity" / f"{name}.svg")
        save(rose_figure(cube), folder / "rose.svg")
