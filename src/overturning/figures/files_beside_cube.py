"""Files beside a results cube that figures read: ground motions and intensity measures."""

from pathlib import Path
from typing import TYPE_CHECKING

from overturning.errors import MissingDataError

if TYPE_CHECKING:
    import xarray as xr


def motion_amplitude_factor(cube: "xr.Dataset") -> float:
    """Return the amplitude factor of the motions in a results cube; 1 if it is not stated."""
    return float(cube["amplitude"]) if "amplitude" in cube.coords and "amplitude" not in cube.dims else 1.0


def existing_path_next_to_cube(cube: "xr.Dataset", file_name: str) -> Path:
    """Return the path of a file next to a results cube; raise a MissingDataError if the file does not exist."""
    file = Path(cube.encoding.get("source", ""))
    if not (path := file.parent / file_name).is_file():
        where = f"not next to {file}" if file.is_file() else "a cube in memory has no such file"
        raise MissingDataError(f"{file_name}: {where}; open the cube of a completed study, in the folder of the study")
    return path


def motion_file_path_of_single_record_cube(cube: "xr.Dataset") -> Path:
    """Return the path of the motion file of the one record in a results cube."""
    record = cube["record_id"].item() if "record_id" in cube else "RECORD"  # of a cube that belongs to no study
    return existing_path_next_to_cube(cube, f"{ground_motion_folder_beside_cube(cube)}/{record}.nc")


def ground_motion_folder_beside_cube(cube: "xr.Dataset") -> Path:
    """Return the folder of the motion files, relative to the folder of a results cube."""
    from overturning.study.cube import motion_folder_of_cube, study_of_cube

    if motion_amplitude_factor(cube) != 1.0:
        raise MissingDataError(
            f"amplitude: motions and measures exist only for the factor 1, not {motion_amplitude_factor(cube):g}; "
            "open the cube with amplitude=1"
        )
    return (
        motion_folder_of_cube(Path(), study_of_cube(cube), cube.attrs["variant"])
        if "study" in cube.attrs
        else Path("motion")
    )


def read_intensity_measures(cube: "xr.Dataset", *names: str) -> "xr.Dataset":
    """Return intensity measures (all, or only `names`) of the records in a results cube, in the cube's record order."""
    import xarray as xr

    path = existing_path_next_to_cube(cube, "intensity.nc")
    if ground_motion_folder_beside_cube(cube) != Path("motion"):
        raise MissingDataError(
            f"{path}: measures of the variant {cube.attrs['variant']} do not exist; use the nominal one"
        )
    with xr.open_dataset(path, engine="netcdf4") as measures:
        every, used = measures["record_id"].to_numpy().tolist(), measures[list(names)] if names else measures
        return used.isel(record=[every.index(name) for name in cube["record_id"].to_numpy().ravel()]).load()
