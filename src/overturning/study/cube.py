"""Open a cube and read its attributes."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from overturning.arrays import convert_argument_to_float_array, keep_xarray_from_importing_dask
from overturning.errors import ArgumentError, ResultError, refuse_unknown_keywords
from overturning.files import checksum_at_end_matches, convert_argument_to_path
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.grid import CF_ATTRIBUTES_BY_DIMENSION
from overturning.model.symmetry import FULL_TURN_DEG
from overturning.study.load import load_study, study_from_content
from overturning.study.scenes import settings_changed_by_variant, variant_model, variant_scene
from overturning.study.schema import Study

if TYPE_CHECKING:
    import xarray as xr


_REQUIRED_CUBE_ATTRIBUTES: Final = {
    "study",
    "variant",
    "content_sha256",
    "record_sources",
    "record_processing",
    "versions",
}
COMPLETE_STUDY_FILE_NAME: Final = "study.yaml"
"""File of the complete study, next to the cube of a finished run."""

MAX_CUBE_VALUES_IN_MEMORY: Final = 20_000_000
"""Largest number of values (8 bytes or less each) of a cube that is read into memory."""

_REQUIRED_RECORD_COORDINATES: Final = ("record_id", "station", "event", "fault_normal")


def _reason_why_cube_is_incomplete(cube: "xr.Dataset") -> str:
    """Return "no NAME" for the first variable that a results file lacks or has in a wrong shape; "" if complete."""
    flags = cube["overturned"]
    grid = set(flags.dims)
    model = default_model_of_same_kind_as_results_cube(cube)
    needed = {"record", *model.dimension_names}
    if missing := sorted(needed - grid) or sorted(str(name) for name in grid if not cube.sizes[name]):
        return f"no cell along {missing[0]}"
    for name in (*sorted(needed - {"record"}), *_REQUIRED_RECORD_COORDINATES):
        if name not in cube or cube[name].dims != ((name,) if name in needed else ("record",)):
            return f"no {name}"
    if "element" in grid and not {"element", "element_name"} & {*cube.coords}:  # names as in the file, or as opened
        return "no element_name"
    for variable in model.outcome_variables:
        if variable.name not in cube or not needed <= set(cube[variable.name].dims):
            return f"no {variable.name}"
    return ""


@refuse_unknown_keywords()
def open_cube(
    path: str | Path,
    chunks: dict[str, int] | str | None = None,
    element: str | None = "reference",
    amplitude: float | None = 1.0,
) -> "xr.Dataset":
    """Open a results cube, the NetCDF file with the outcomes of all cases of a study, as an xarray dataset.

    Select a record by its id: ``cube.sel(record="rinaldi")``.

    Parameters
    ----------
    path : path
        The cube.
    chunks : dict or "auto", optional
        Sizes of dask chunks of the variables, ``{"record": 1}`` for the chunks of the file; not given: no dask.
    element : str, optional
        For a scene with several free elements: the name of one, "reference" for the scene's reference element, or None
        for all. Only with None is ``element`` a dimension, with the names as its coordinate.
    amplitude : float, optional
        For a study with several factors on its motions: one of them, or None for all. Only with None is ``amplitude`` a
        dimension; a selected factor other than 1 stays as a coordinate.

    Returns
    -------
    xarray.Dataset
        Flags as float with NaN where missing; times as numbers of seconds; records by their ids.

    Raises
    ------
    ResultError
        If there is no cube at this path, or the cube has no such element or factor.
    ArgumentError
        If the path, the factor or `chunks` is invalid.
    """
    import xarray as xr

    path = convert_argument_to_path("path", path, "the path of cube.nc")
    if isinstance(chunks, str) and chunks != "auto":
        raise ArgumentError(f'chunks: {chunks!r}; give a dictionary such as {{"record": 1}}, "auto", or nothing')
    if amplitude is not None:
        amplitude = float(convert_argument_to_float_array("amplitude", amplitude))
    try:
        is_file, is_folder = path.is_file(), path.is_dir()
    except OSError as error:  # a name that is too long, or a folder that must not be read
        raise ResultError(f"{path}: cannot be opened ({error.strerror}); check its name and permissions") from None
    if not is_file:
        why = "a folder; name the cube in it, cube.nc" if is_folder else "no such cube; run the study first"
        raise ResultError(f"{path}: {why}")
    if checksum_at_end_matches(path) is False:
        raise ResultError(f"{path}: damaged, its checksum does not match; run the study again to recreate it")
    keep_xarray_from_importing_dask()
    try:
        with _hdf5_chunk_cache_reduced_if_read_once(each_hdf5_chunk_is_read_once=chunks is not None):
            cube = xr.open_dataset(path, engine="netcdf4", chunks=chunks, decode_timedelta=False)
    except (OSError, ValueError, RuntimeError, AttributeError, KeyError, IndexError, TypeError) as error:
        # Damage inside a file raises any of these exceptions in the libraries that read it.
        raise ResultError(f"{path}: cannot be opened ({error}); run the study again") from None
    if "overturned" not in cube or not cube.attrs.keys() >= _REQUIRED_CUBE_ATTRIBUTES:
        raise ResultError(f"{path}: not a cube of this package, or an unfinished one; run the study again")
    if absent := _reason_why_cube_is_incomplete(cube):
        raise ResultError(f"{path}: not a cube of this package: {absent}; run the study again")
    chosen = select_element_and_amplitude(cube, path, element, amplitude)
    chosen = chosen.assign_coords(record=chosen["record_id"].variable)
    chosen.set_close(cube.close)  # a selection has no reference to the file, which must stay open until it is closed
    if chunks is not None:
        # Load the small coordinates of records; as dask arrays they would be read again at each access.
        for name, values in chosen.coords.items():
            if values.dims == ("record",):
                chosen.variables[name].load()
    return chosen


def open_cube_for_reading_by_record(
    cube_path: Path, element_name: str | None = "reference", motion_amplitude_factor: float | None = 1.0
) -> "xr.Dataset":
    """Open a results cube for processing by record: a small cube in memory, a large one read one record at a time."""
    cube = open_cube(cube_path, None, element_name, motion_amplitude_factor)
    if sum(values.size for values in cube.data_vars.values()) <= MAX_CUBE_VALUES_IN_MEMORY:
        return cube.load()
    cube.close()
    return open_cube(cube_path, {"record": 1}, element_name, motion_amplitude_factor)


@contextmanager
def _hdf5_chunk_cache_reduced_if_read_once(each_hdf5_chunk_is_read_once: bool) -> Iterator[None]:
    """Context manager that reduces the HDF5 chunk cache if each chunk of a file is read only once, to save memory."""
    import netCDF4

    before = netCDF4.get_chunk_cache()
    if each_hdf5_chunk_is_read_once:
        netCDF4.set_chunk_cache(size=1 << 20)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*before)


def select_element_and_amplitude(
    cube: "xr.Dataset",
    cube_path: Path,
    element_name: str | None = "reference",
    motion_amplitude_factor: float | None = 1.0,
) -> "xr.Dataset":
    """Select one element of the scene and one amplitude factor from a results cube; see `overturning.open_cube`."""
    if motion_amplitude_factor is not None:
        several = "amplitude" in cube.dims  # otherwise one amplitude, 1 unless the coordinate has another value
        known = np.atleast_1d(cube["amplitude"]).tolist() if "amplitude" in cube.coords else [1.0]
        if motion_amplitude_factor not in known:
            raise ResultError(
                f"{cube_path}: no amplitude {motion_amplitude_factor:g}; known: "
                f"{', '.join(f'{one:g}' for one in known)}"
            )
        if several:  # an amplitude other than 1 stays as a coordinate
            cube = cube.sel(amplitude=motion_amplitude_factor, drop=motion_amplitude_factor == 1.0)
    if "element" not in cube.dims:
        if element_name not in (None, "reference"):
            _check_element_exists(
                element_name, variant_model(study_of_cube(cube), cube.attrs["variant"]).free_element_names, cube_path
            )
        return cube
    if "element_name" in cube:
        cube = cube.assign_coords(element=cube["element_name"].to_numpy().astype(str)).drop_vars("element_name")
    if element_name is None:
        return cube
    if element_name == "reference":
        if "study" not in cube.attrs:  # the result of `overturning.simulate`
            names = cube["element"].to_numpy().tolist()
            remedy = f"choose one, as cube.sel(element={names[-1]!r})"
            raise ArgumentError(f"cube: outcomes of {len(names)} elements; {remedy}")
        element_name = variant_scene(study_of_cube(cube), cube.attrs["variant"]).name_of_element_shown_by_default
    _check_element_exists(element_name, cube["element"].to_numpy().tolist(), cube_path)
    return cube.sel(element=element_name)


def select_and_sort_cube_for_figures(cube: "xr.Dataset") -> "xr.Dataset":
    """Return one element and amplitude of a results cube, with all dimensions, sorted and without repeated coordinates.

    For the selection see `select_element_and_amplitude`. B/H and directions ascend, with
    azimuths in [0°, 360°); heights, aspects and frictions stay in their order. An `ArgumentError` is raised if a
    dimension is empty.
    """
    cube = select_element_and_amplitude(
        cube, Path("cube"), motion_amplitude_factor=1.0 if "amplitude" in cube.dims else None
    )
    alone = [name for name in CF_ATTRIBUTES_BY_DIMENSION if name in cube.coords and name not in cube.dims]
    cube = cube.expand_dims(alone).transpose("record", *CF_ATTRIBUTES_BY_DIMENSION, ..., missing_dims="ignore")
    if "azimuth" in cube.dims:
        azimuth = cube["azimuth"].variable
        within = np.round(azimuth.to_numpy() % FULL_TURN_DEG, 9) % FULL_TURN_DEG
        cube = cube.assign_coords(azimuth=azimuth.copy(data=within.astype(azimuth.dtype)))
    for name in {"record", *CF_ATTRIBUTES_BY_DIMENSION} & set(cube.dims):
        values = cube[name].to_numpy()
        first = np.unique(values, return_index=True)[1]
        kept = first if name in ("azimuth", "orientation", "b_over_h") else np.sort(first)
        if not kept.size:
            raise ArgumentError(f"cube: nothing along {name}; choose what it has")
        if kept.tolist() != list(range(values.size)):
            cube = cube.isel({name: kept})
    return cube


def _check_element_exists(element_name: str | None, known_element_names: Sequence[str], cube_path: Path) -> None:
    """Raise a ResultError if a results cube has no element with this name."""
    if element_name not in known_element_names:
        raise ResultError(f"{cube_path}: no element {element_name!r}; known: {', '.join(known_element_names)}")


def index_of_record(cube: "xr.Dataset", record_id: str | None) -> int:
    """Return the index of a record from its id; None is allowed if the results cube has only one record.

    A selection of one record has its id without a dimension; a cube without a study has no ids. An `ArgumentError`
    lists the ids if the record is unknown or not given.
    """
    names = np.atleast_1d(cube["record_id"]).astype(str).tolist() if "record_id" in cube else []
    file, some = Path(cube.encoding.get("source", "cube")).name, ", ".join(names[:4] + ["…"][: len(names) > 4])
    if record_id is None and len(names) > 1:
        raise ArgumentError(f"{file}: {len(names)} records; name one as record (--record): {some}")
    if record_id is not None and record_id not in names:
        raise ArgumentError(f"{file}: no record {record_id!r}; it has {', '.join(names) or 'none'}")
    return names.index(record_id) if record_id is not None else 0


def parse_json_attribute(cube: "xr.Dataset", attribute_name: str, expected_type: type) -> Any:
    """Parse a JSON attribute of a results cube; a ResultError if it is missing, damaged or of another type."""
    return _parse_json(cube.attrs.get(attribute_name), attribute_name, expected_type)


def _parse_json(json_text: Any, attribute_name: str, expected_type: type) -> Any:
    """Parse the JSON text of a cube's attribute; a ResultError if it is missing, damaged or of another type."""
    try:
        found = json.loads(json_text)
        if not isinstance(found, expected_type):
            raise ValueError(attribute_name)
    except (TypeError, ValueError, RecursionError):
        raise ResultError(
            f"cube: its attribute {attribute_name!r} is missing or damaged; run the study again"
        ) from None
    return found


def study_of_cube(cube: "xr.Dataset") -> Study:
    """Return the study whose settings a results cube stores; a ResultError or ConfigError if missing or invalid."""
    text = cube.attrs.get("study")
    return _study_from_json(text if isinstance(text, str) else "")


@lru_cache(maxsize=16)
def _study_from_json(study_json_text: str) -> Study:
    """Parse and validate the study in a cube's JSON attribute; cached, since figures need it several times."""
    return study_from_content(_parse_json(study_json_text, "study", dict), "study in the cube")


def find_study_with_title_and_figure_settings(cube: "xr.Dataset", study: Study | None = None) -> Study | None:
    """Return the study whose title, question and figure settings apply to a results cube; None without a study.

    This is the given study; otherwise the study in study.yaml next to the cube, if it is named like the study stored in
    the cube; otherwise the stored study, which has no title and no question.
    """
    if study is not None:
        return study
    if "study" not in cube.attrs:
        return None
    own, source = study_of_cube(cube), cube.encoding.get("source")  # xarray drops the source in some operations
    path = Path(source).with_name(COMPLETE_STUDY_FILE_NAME) if source else None
    return beside if path and path.is_file() and (beside := load_study(path)).name == own.name else own


def default_height_and_friction_of_figures(cube: "xr.Dataset", study: Study | None = None) -> dict[str, list[float]]:
    """Return the height and friction that figures show by default: by dimension name, a list of one value.

    The values are those of `figures` in the study (see `find_study_with_title_and_figure_settings`); if not set, the
    first height and the last friction of the study. A dimension is left out if the cube has only part of the study's
    values along it. The result is empty if the cube belongs to no study.
    """
    own = find_study_with_title_and_figure_settings(cube, study)
    if own is None:
        return {}
    chosen = own.figures.height or own.height[0], own.figures.friction
    block = {"height": chosen[0], "friction": own.friction[-1] if chosen[1] is None else chosen[1]}
    whole = (name for name in block if cube.sizes.get(name) == len(getattr(own, name)) and block[name] in cube[name])
    return {name: [block[name]] for name in whole}


def select_heights_and_frictions(
    cube: "xr.Dataset",
    cube_path: Path,
    chosen_heights_m: Sequence[float] | None,
    chosen_friction_coefficients: Sequence[float] | None,
    *,
    choose_default_if_only_one_dimension_given: bool = False,
) -> "xr.Dataset":
    """Select heights and frictions from a results cube; an `ArgumentError` names a value that it does not have.

    If only heights or only frictions are given, all values of the other dimension are kept, or, with
    `choose_default_if_only_one_dimension_given`, the one of `default_height_and_friction_of_figures`.
    """
    given = {"height": chosen_heights_m, "friction": chosen_friction_coefficients}
    for name, chosen in given.items():
        known = cube[name].to_numpy().tolist()
        if unknown := [value for value in chosen or () if value not in known]:
            known_text = ", ".join(f"{value:g}" for value in known)
            raise ArgumentError(f"--{name} {unknown[0]:g}: not in {cube_path}; it has {known_text}")
        cube = cube.sel({name: chosen}) if chosen else cube
    if choose_default_if_only_one_dimension_given and (chosen_heights_m or chosen_friction_coefficients):
        return cube.sel(
            {name: shown for name, shown in default_height_and_friction_of_figures(cube).items() if not given[name]}
        )
    return cube


def element_name_to_show(cube: "xr.Dataset") -> str:
    """Return the name of the element whose outcomes a results cube shows: the selected or default one."""
    chosen = "element" in cube.coords and "element" not in cube.dims
    return (
        str(cube["element"].item())
        if chosen
        else variant_scene(study_of_cube(cube), cube.attrs["variant"]).name_of_element_shown_by_default
    )


def motion_folder_of_cube(cube_path: Path, study: Study, variant: str) -> Path:
    """Return the folder of the input motions of a results cube; motions on top of soil layers have their own folder."""
    return cube_path.parent / "motion" / (variant if settings_changed_by_variant(study, variant).site else "")


def record_sources(cube: "xr.Dataset") -> list[dict[str, Any]]:
    """Return source, SHA-256 and licence of each record in a results cube, and the source of its coordinates.

    See `overturning.records.catalogue.RecordTableRow.coordinate_source_and_fault_trace_metadata`.
    """
    return list(parse_json_attribute(cube, "record_sources", list))


def record_sources_and_processing_by_id(cube: "xr.Dataset") -> dict[str, dict[str, Any]]:
    """Return source and processing of each record in a results cube, by record id."""
    return dict(parse_json_attribute(cube, "record_processing", dict))
