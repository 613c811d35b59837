"""Functions that draw single figures of the report.

Each function returns a Matplotlib figure, which a notebook displays and ``figure.savefig`` writes. A cube comes from
`overturning.open_cube` or `overturning.run_study`; `record` is the id of one of its records, optional if there is only
one. Intensity measures and motions are read from the files next to the cube. An empty figure is an `ArgumentError`.
"""

from collections.abc import Callable, Sequence
from functools import partial, wraps
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

from overturning.errors import ArgumentError, MissingDataError, refuse_unknown_keywords
from overturning.figures.files_beside_cube import (
    motion_amplitude_factor,
    motion_file_path_of_single_record_cube,
    read_intensity_measures,
)
from overturning.motion.motion import Accelerogram

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from overturning.arrays import ArrayLike

__all__ = [
    *("fall_alignment_by_b_over_h", "fall_alignment_by_earthquake", "fall_map", "fall_maps_by_block", "fall_rose"),
    *("fall_roses_by_earthquake", "hodograph", "outcomes_by_pga_and_pgv_ratio", "overturning_boundary"),
    *("pga_and_pgv_by_azimuth", "rotation_slip_and_uplift", "spectra", "time_histories"),
]

DrawFunction = TypeVar("DrawFunction", bound=Callable[..., Any])
MotionOrRecord = TypeVar("MotionOrRecord", bound=Any)  # a motion or record

CUBE_FIGURE_FUNCTIONS: Final[dict[str, Callable[..., Any]]] = {}
"""Functions that draw a figure of a cube, by kind: the name in `overturning figure` and in the folder of figures."""

MOTION_FIGURE_KINDS: Final = ("intensity", "hodograph", "history")
"""Kinds of figures that show only the motion and no block."""


def __dir__() -> list[str]:
    return sorted(__all__)


def _with_style_and_checks(draw_figure: DrawFunction, first_argument_is_cube: bool = False) -> DrawFunction:
    """Wrap a drawing function: refuse unknown keywords, use the project's style and, if asked, check its cube."""

    @refuse_unknown_keywords()
    @wraps(draw_figure)
    def draw_with_project_style(*arguments: Any, **keywords: Any) -> Any:
        from overturning.figures.content import check_is_results_cube
        from overturning.figures.style import use_package_matplotlib_settings

        if first_argument_is_cube and (arguments or "cube" in keywords):
            check_is_results_cube(arguments[0] if arguments else keywords["cube"], draw_figure.__name__)
        with use_package_matplotlib_settings():
            return draw_figure(*arguments, **keywords)

    return cast(DrawFunction, draw_with_project_style)


def _register_cube_figure(figure_kind: str, draw_figure: DrawFunction) -> DrawFunction:
    """Register a function that draws a kind of figure from a results cube; return it with the project's style."""
    CUBE_FIGURE_FUNCTIONS[figure_kind] = styled = _with_style_and_checks(draw_figure, figure_kind != "history")
    return styled


@partial(_register_cube_figure, "polar")
def fall_map(cube: "xr.Dataset", record: str | Sequence[str] | None = None, title: str | None = None) -> "Figure":
    """Draw the falls of one block under one record, by azimuth and B/H (2-D) or orientation and B/H (3-D).

    Each sector is as wide as the step of azimuths; sectors of a single plane (one azimuth, or two opposite ones) are
    5° wide. The study chooses the block in its setting `figures`, by default the first height and the last friction.
    If the cube holds only a part of the heights or frictions, or comes from `overturning.simulate`, all its blocks are
    shown. Several records, as a list, are drawn on one radial scale (2-D only).
    """
    from overturning.study.cube import default_height_and_friction_of_figures

    return _draw_fall_maps_of_one_or_several_records(
        "polar", cube.sel(default_height_and_friction_of_figures(cube)), record, title
    )


@partial(_register_cube_figure, "blocks")
def fall_maps_by_block(
    cube: "xr.Dataset", record: str | Sequence[str] | None = None, title: str | None = None
) -> "Figure":
    """Draw the falls under one record by azimuth and B/H, one map for each height and friction."""
    return _draw_fall_maps_of_one_or_several_records("blocks", cube, record, title)


def _draw_fall_maps_of_one_or_several_records(
    figure_kind: str, cube: "xr.Dataset", record: str | Sequence[str] | None, title: str | None
) -> "Figure":
    """Draw maps of the falls under one record, or of one block under several records on a common scale."""
    from overturning.figures.content import check_has_outcomes
    from overturning.figures.maps import fall_map_figure
    from overturning.figures.polar_map import fall_map_by_azimuth_figure

    names = list(record) if isinstance(record, Sequence) and not isinstance(record, str) else [record]
    if not names:
        raise ArgumentError("record: none; give an id of the cube, or leave it out")
    several = [_select_outcomes_under_record(cube, name) for name in names]
    for one in several:
        check_has_outcomes(one, figure_kind)
    first = several[0]
    if len(several) == 1:
        shown = _record_title(first) + _scene_and_element_title(first) if title is None else title
        return fall_map_figure(first, shown, _read_pgv_by_azimuth(first))
    _check_cube_has_coordinate_for_figure(cube, "azimuth", f"{figure_kind} of several records")
    own = (_record_title(first, ()) + _scene_and_element_title(first)).strip() if title is None else title
    return fall_map_by_azimuth_figure(several, own, [_read_pgv_by_azimuth(one) for one in several])


def _read_pgv_by_azimuth(cube: "xr.Dataset") -> "xr.DataArray | None":
    """Return PGV by azimuth, m/s, of the record in a results cube; None if it was not computed."""
    try:
        return read_intensity_measures(cube, "pgv")["pgv"].isel(record=0)
    except MissingDataError:
        return None


def _scene_and_element_title(cube: "xr.Dataset") -> str:
    """Return scene and element of a results cube as a line for a title; "" if the cube belongs to no study."""
    from overturning.figures.record import second_title_line_with_scene_and_element

    return second_title_line_with_scene_and_element(cube) if "study" in cube.attrs else ""


@partial(_register_cube_figure, "boundary")
def overturning_boundary(cube: "xr.Dataset", record: str | None = None) -> "Figure":
    """Draw the largest B/H that overturns under one record, by azimuth of the motion (2-D results only)."""
    from overturning.figures.boundary import overturning_boundary_figure
    from overturning.figures.content import check_has_falls
    from overturning.statistics import boundary as statistics

    one = _select_outcomes_under_record(cube, record)
    _check_cube_has_coordinate_for_figure(one, "azimuth", "boundary")
    check_has_falls(one, "boundary")
    top = float(one["b_over_h"].max())
    bounds = statistics.overturning_boundary_b_over_h_by_azimuth(one).assign_attrs(one.attrs)
    return overturning_boundary_figure(
        bounds, top, float(one["fault_normal"]), _record_title(one) + _scene_and_element_title(one)
    )


@partial(_register_cube_figure, "rose")
def fall_rose(cube: "xr.Dataset") -> "Figure":
    """Draw roses of the fall axes under records with and without a velocity pulse, relative to the fault normal."""
    from overturning.figures.content import check_has_falls
    from overturning.figures.rose import fall_roses_by_group_figure
    from overturning.statistics.earthquakes import fall_axes_from_fault_normal_by_group, summarise_fall_axes

    def draw_fall_rose(cube_of_one_element_and_amplitude: "xr.Dataset") -> "Figure":
        check_has_falls(cube_of_one_element_and_amplitude, "rose")
        groups = fall_axes_from_fault_normal_by_group(cube_of_one_element_and_amplitude)
        return fall_roses_by_group_figure(
            cube_of_one_element_and_amplitude, {name: summarise_fall_axes(found) for name, found in groups.items()}
        )

    return _draw_figure_of_all_records_with_title(cube, draw_fall_rose)


@partial(_register_cube_figure, "earthquakes")
def fall_roses_by_earthquake(cube: "xr.Dataset") -> "Figure":
    """Draw a rose of the fall directions, from north, for each earthquake."""
    from overturning.figures.content import check_has_falls
    from overturning.figures.rose import fall_roses_by_earthquake_figure

    def draw_earthquake_roses(cube_of_one_element_and_amplitude: "xr.Dataset") -> "Figure":
        check_has_falls(cube_of_one_element_and_amplitude, "earthquakes")
        return fall_roses_by_earthquake_figure(cube_of_one_element_and_amplitude)

    return _draw_figure_of_all_records_with_title(cube, draw_earthquake_roses)


@partial(_register_cube_figure, "axes")
def fall_alignment_by_earthquake(cube: "xr.Dataset") -> "Figure":
    """Draw mean cos 2Δ of falls (Δ: angle from fault normal) by earthquake, and group means with intervals."""
    from overturning.figures.alignment import fault_normal_alignment_figure_from_fall_axes
    from overturning.figures.content import check_has_falls_and_fault_normal
    from overturning.statistics.earthquakes import fall_axes_from_fault_normal_by_group, summarise_fall_axes

    def draw_fall_alignment_by_earthquake(cube_of_one_element_and_amplitude: "xr.Dataset") -> "Figure":
        groups = fall_axes_from_fault_normal_by_group(cube_of_one_element_and_amplitude)
        summaries = {name: summarise_fall_axes(found) for name, found in groups.items()}
        check_has_falls_and_fault_normal(cube_of_one_element_and_amplitude, groups)
        return fault_normal_alignment_figure_from_fall_axes(groups, summaries)

    return _draw_figure_of_all_records_with_title(cube, draw_fall_alignment_by_earthquake)


@partial(_register_cube_figure, "follow")
def fall_alignment_by_b_over_h(cube: "xr.Dataset") -> "Figure":
    """Draw the alignment of falls with the fault, the epicentre and the motion's peak and pulse axes, by B/H."""
    from overturning.figures.alignment import fall_alignment_by_b_over_h_figure
    from overturning.figures.content import check_has_fall_alignment
    from overturning.statistics.reference_directions import alignments_with_reference_axes_by_record_group

    _check_cube_has_coordinate_for_figure(cube, "orientation", "follow")

    def draw_fall_alignment_by_b_over_h(cube_of_one_element_and_amplitude: "xr.Dataset") -> "Figure":
        found = alignments_with_reference_axes_by_record_group(
            cube_of_one_element_and_amplitude, read_intensity_measures(cube_of_one_element_and_amplitude)
        )
        check_has_fall_alignment(cube_of_one_element_and_amplitude, found)
        return fall_alignment_by_b_over_h_figure(found, cube_of_one_element_and_amplitude["b_over_h"].to_numpy())

    return _draw_figure_of_all_records_with_title(cube, draw_fall_alignment_by_b_over_h)


@partial(_register_cube_figure, "plane")
def outcomes_by_pga_and_pgv_ratio(cube: "xr.Dataset") -> "Figure":
    """Draw outcomes by PGA and PGV/PGA at the largest friction, with logistic fit and overturning criteria (2-D)."""
    from overturning.figures.content import check_has_outcomes_and_nonzero_motion
    from overturning.figures.intensity_plane import outcomes_by_pga_and_pgv_over_pga_figure
    from overturning.labels import note_if_sizes_are_not_those_of_shown_stone
    from overturning.statistics.logistic import fit_logistic_overturning_model

    def draw_outcomes_by_pga_and_pgv_ratio(cube_of_one_element_and_amplitude: "xr.Dataset") -> "Figure":
        if other := note_if_sizes_are_not_those_of_shown_stone(cube_of_one_element_and_amplitude):
            raise ArgumentError(f"plane: criteria and fit need the stone's own height and B/H; {other}")
        measures = read_intensity_measures(cube_of_one_element_and_amplitude)
        check_has_outcomes_and_nonzero_motion(cube_of_one_element_and_amplitude, measures)
        fit = fit_logistic_overturning_model(cube_of_one_element_and_amplitude, measures)
        return outcomes_by_pga_and_pgv_over_pga_figure(
            cube_of_one_element_and_amplitude, measures, fit, float(cube_of_one_element_and_amplitude["friction"].max())
        )

    _check_cube_has_coordinate_for_figure(cube, "azimuth", "plane")
    return _draw_figure_of_all_records_with_title(cube, draw_outcomes_by_pga_and_pgv_ratio)


@partial(_register_cube_figure, "intensity")
def pga_and_pgv_by_azimuth(cube: "xr.Dataset", record: str | None = None) -> "Figure":
    """Draw PGA and PGV of a record by azimuth."""
    from overturning.figures.content import check_ground_moves
    from overturning.figures.ground import pga_and_pgv_by_azimuth_figure

    one = _select_outcomes_under_record(cube, record)
    measures = read_intensity_measures(one).isel(record=0)
    check_ground_moves(float(measures["pga"].max()), "intensity")
    return pga_and_pgv_by_azimuth_figure(measures, float(one["fault_normal"]), _record_title(one))


@partial(_register_cube_figure, "hodograph")
def hodograph(cube: "xr.Dataset", record: str | None = None) -> "Figure":
    """Draw hodographs of acceleration, velocity and displacement of a record."""
    from overturning.figures.ground import hodograph_figure
    from overturning.motion.motion import Motion
    from overturning.records.store import read_record_from_motion_file

    one = _select_outcomes_under_record(cube, record)
    motion = _checked_nonzero_motion(
        Motion.of(read_record_from_motion_file(motion_file_path_of_single_record_cube(one))), "hodograph"
    )
    return hodograph_figure(motion, float(one["fault_normal"]), _record_title(one))


@partial(_register_cube_figure, "history")
def time_histories(motion: "Accelerogram | xr.Dataset", record: str | None = None) -> "Figure":
    """Draw time histories and spectra of a motion or record; for a results cube, before and after processing."""
    import xarray as xr

    from overturning.figures.history import record_before_and_after_processing_figure
    from overturning.motion.motion import as_motion
    from overturning.records.record import Record, as_record
    from overturning.records.store import read_record_before_processing_if_processed, read_record_from_motion_file

    if isinstance(motion, xr.Dataset):
        path = motion_file_path_of_single_record_cube(_select_outcomes_under_record(motion, record))
        used = read_record_from_motion_file(path)
        return record_before_and_after_processing_figure(
            read_record_before_processing_if_processed(path) or used, _checked_nonzero_motion(used, "history")
        )
    if record is not None:
        raise ArgumentError(f"record: {record!r}; it chooses a record of a cube, not of a motion or record: omit it")
    one = _checked_nonzero_motion(as_record(motion if isinstance(motion, Record) else as_motion(motion)), "history")
    return record_before_and_after_processing_figure(one, one)


@_with_style_and_checks
def spectra(motion: "Accelerogram", azimuth_deg: "ArrayLike" = (0.0, 90.0), title: str = "") -> "Figure":
    """Draw Fourier and response spectra of a motion or record along azimuths, degrees clockwise from north."""
    from overturning.figures.ground import fourier_and_response_spectra_figure
    from overturning.motion.direction import checked_azimuths
    from overturning.motion.motion import as_motion

    return fourier_and_response_spectra_figure(
        _checked_nonzero_motion(as_motion(motion), "spectra"), checked_azimuths(azimuth_deg).tolist(), title
    )


@_with_style_and_checks
def rotation_slip_and_uplift(trajectories: "xr.Dataset | Sequence[xr.Dataset]", title: str = "") -> "Figure":
    """Draw rotation, slip and uplift over time, one column for each 2-D simulation from `overturning.trajectory`."""
    from overturning.figures.content import check_are_trajectories_in_2d
    from overturning.figures.response import rotation_slip_and_uplift_figure

    several = list(trajectories) if isinstance(trajectories, Sequence) else [trajectories]
    check_are_trajectories_in_2d(several)
    return rotation_slip_and_uplift_figure(several, title)


def _draw_figure_of_all_records_with_title(
    cube: "xr.Dataset", draw_figure: Callable[["xr.Dataset"], "Figure"]
) -> "Figure":
    """Draw a figure of all records in a results cube; put variant, amplitude factor and scene above its title."""
    from overturning.figures.style import add_title_and_legend
    from overturning.study.cube import select_and_sort_cube_for_figures

    if "record" not in cube.dims:
        raise ArgumentError("cube: no dimension record; keep it (cube.sel(record=['rinaldi'])), or draw fall_map")
    cube_of_one_element_and_amplitude = select_and_sort_cube_for_figures(
        cube.assign_coords(record=range(cube.sizes["record"]))
    )
    figure = draw_figure(cube_of_one_element_and_amplitude)
    heading = _record_title(cube_of_one_element_and_amplitude, ()) + _scene_and_element_title(
        cube_of_one_element_and_amplitude
    )
    add_title_and_legend(figure, f"{heading}\n{figure.get_suptitle()}".strip())
    return figure


def _select_outcomes_under_record(cube: "xr.Dataset", record: str | None) -> "xr.Dataset":
    """Select the part of a results cube under one record, sort its coordinates for figures and load it into memory."""
    from overturning.study.cube import index_of_record, select_and_sort_cube_for_figures

    number = index_of_record(cube, record)
    one = cube.isel(record=number) if "record" in cube.dims else cube
    unknown = {"station": "", "event": "", "fault_normal": float("nan")}  # defaults for a cube of no study
    one = one.assign_coords({name: value for name, value in unknown.items() if name not in one})
    return select_and_sort_cube_for_figures(one).drop_vars("record", errors="ignore").load()


def _checked_nonzero_motion(motion: MotionOrRecord, figure_kind: str) -> MotionOrRecord:
    """Return a motion or record unchanged; raise an ArgumentError if its acceleration is zero throughout."""
    from overturning.figures.content import check_ground_moves

    check_ground_moves(max(float(abs(one).max()) for one in (motion.north, motion.east)), figure_kind)
    return motion


def _record_title(cube: "xr.Dataset", coordinate_names: Sequence[str] = ("station", "event")) -> str:
    """Return a title: metadata of the record (station, event), variant if not nominal, amplitude factor if not 1."""
    from overturning.labels import variant_label_in_list_if_not_nominal

    times = [f"motion × {motion_amplitude_factor(cube):g}"] if motion_amplitude_factor(cube) != 1.0 else []
    own = filter(None, (str(cube[name].item()) for name in coordinate_names))
    return ", ".join([*own, *variant_label_in_list_if_not_nominal(cube), *times])


def _check_cube_has_coordinate_for_figure(cube: "xr.Dataset", coordinate_name: str, figure_kind: str) -> None:
    """Raise an ArgumentError if a cube lacks the coordinate azimuth (2-D) or orientation (3-D) that a figure needs."""
    if coordinate_name not in cube.coords:
        raise ArgumentError(f"{figure_kind}: a cube without {coordinate_name} has no such figure; choose another kind")


def _plot_motion(self: Accelerogram) -> "Figure":
    """Draw acceleration, velocity, displacement and Fourier amplitudes of the motion; see `time_histories`."""
    figure: Figure = time_histories(self)
    return figure


# The method is added here, because the lower layer `motion` must not import figures.
_plot_motion.__name__, _plot_motion.__qualname__ = "plot", "Accelerogram.plot"
Accelerogram.plot = _plot_motion  # type: ignore[method-assign]
