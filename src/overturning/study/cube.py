"""Opening a cube, and what a reader may rely on."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from overturning.errors import ResultError
from overturning.files import whole
from overturning.study.config import Study
from overturning.study.load import check_study
from overturning.study.scenes import scene_of

if TYPE_CHECKING:
    import xarray as xr


def open_cube(
    path: Path, chunks: dict[str, int] | str | None = None, element: str | None = "reference"
) -> "xr.Dataset":
    """Open a cube in xarray.

    Parameters
    ----------
    path : Path
        The cube.
    chunks : dict or "auto", optional
        Sizes of dask chunks, ``{"record": 1}`` for the chunks of the file; not given: no dask.
    element : str, optional
        Of a scene with several free elements: the name of one, "reference" for the scene's reference element, None for
        all. The dimension is there in the last case only, with the names as its coordinate.

    Returns
    -------
    xarray.Dataset
        Flags as float with NaN where missing; times as numbers of seconds.

    Raises
    ------
    ResultError
        If there is no cube, or the file is none.
    """
    import xarray as xr

    if not path.is_file():
        raise ResultError(f"{path}: no such cube; run the study first")
    if whole(path) is False:
        raise ResultError(f"{path}: damaged, its checksum does not fit; run the study again, which makes it anew")
    try:
        cube = xr.open_dataset(path, engine="netcdf4", chunks=chunks, decode_timedelta=False)
    except OSError as error:
        raise ResultError(f"{path}: cannot be opened ({error}); run the study again") from None
    if "overturned" not in cube or "content_sha256" not in cube.attrs:
        raise ResultError(f"{path}: not a cube of this package, or an unfinished one; run the study again")
    if "element" not in cube.dims:
        return cube
    cube = cube.assign_coords(element=cube["element_name"].to_numpy().astype(str)).drop_vars("element_name")
    if element is None:
        return cube
    if element == "reference":
        element = scene_of(study_of(cube), cube.attrs["variant"]).shown_name
    if element not in cube["element"].to_numpy():
        names = ", ".join(cube["element"].to_numpy().tolist())
        raise ResultError(f"{path}: no element {element!r}; known: {names}")
    return cube.sel(element=element)


def study_of(cube: "xr.Dataset") -> Study:
    """The filled-in study that made a cube."""
    return check_study(json.loads(cube.attrs["study"]), "study in the cube")


def sources_of_records(cube: "xr.Dataset") -> list[dict[str, Any]]:
    """Source, SHA-256 and licence of each record, in the order of the cube."""
    return list(json.loads(cube.attrs["record_sources"]))


def processing_of(cube: "xr.Dataset") -> dict[str, dict[str, Any]]:
    """How each record of a cube came about, by id; see `overturning.records.summary.account`."""
    return dict(json.loads(cube.attrs["record_processing"]))
