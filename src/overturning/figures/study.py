"""All figures of a study."""

from pathlib import Path

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

    # A dask chunk is a record: no more than one is in memory.
    with open_cube(cube_path, chunks={"record": 1}) as cube, xr.open_dataset(intensity_path) as intensity, style():
        for index, name in enumerate(cube["record_id"].to_numpy()):
            one = cube.isel(record=index).load()
            station, event = str(one["station"].item()), str(one["event"].item())
            title = f"{station}, {event}" if event else station
            save(fall_map_figure(one, title), folder / "polar" / f"{name}.svg")
            save(
                intensity_figure(intensity.isel(record=index), float(one["fault_normal"]), title),
                folder / "intensity" / f"{name}.svg",
            )
        save(rose_figure(cube), folder / "rose.svg")
