"""The figures of the report, each alone.

Each function returns a Matplotlib figure, which a notebook shows and ``figure.savefig`` writes. A cube is one of
`overturning.open_cube` or `overturning.run_study`, or a part of it; `record` is the id of one of its records, not
needed where it has one. Intensity measures and motions are read from the files that a study has beside its cube. An
`ArgumentError` says why a figure would show nothing.
"""

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

from overturning.errors import ArgumentError, MissingDataError, keywords
from overturning.motion.motion import Recorded

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from overturning.arrays import ArrayLike

__all__ = [
    *("axes", "blocks", "boundary", "earthquakes", "follow", "history", "hodograph", "intensity", "plane", "polar"),
    *("response", "rose", "spectra"),
]

Draws = TypeVar("Draws", bound=Callable[..., Any])
Moves = TypeVar("Moves", bound=Any)  # a motion or record

KINDS: Final[dict[str, Callable[..., Any]]] = {}
"""Figures of a cube by name, for `overturning figure`."""

MOTION_KINDS: Final = ("intensity", "hodograph", "history")
"""Those of the motions alone, in which no block is shown."""


def __dir__() -> list[str]:
    return sorted(__all__)


def _styled(draw: Draws) -> Draws:
    """A function that draws with the project's settings."""

    @keywords()
    @wraps(draw)
    def styled(*given: Any, **more: Any) -> Any:
        from overturning.figures.style import style

        with style():
            return draw(*given, **more)

    return cast(Draws, styled)


def _of_a_cube(draw: Draws) -> Draws:
    KINDS[draw.__name__] = _styled(draw)
    return cast(Draws, KINDS[draw.__name__])


@_of_a_cube
def polar(cube: "xr.Dataset", record: str | None = None, title: str | None = None) -> "Figure":
    """Where the block that a study shows first falls under a record: azimuth and B/H; in space by orientation.

    Of a part of the heights or frictions of a cube, and of what `overturning.simulate` returns, it shows all.
    """
    from overturning.study.cube import shown_block

    return _map("polar", cube.sel(shown_block(cube)), record, title)


@_of_a_cube
def blocks(cube: "xr.Dataset", record: str | None = None, title: str | None = None) -> "Figure":
    """Where blocks of all heights and frictions fall under a record, a map each."""
    return _map("blocks", cube, record, title)


def _map(kind: str, cube: "xr.Dataset", record: str | None, title: str | None) -> "Figure":
    from overturning.figures.content import check_outcomes
    from overturning.figures.maps import map_figure

    one = _one(cube, record)
    check_outcomes(one, kind)
    return map_figure(one, _place(one) + _stone(one) if title is None else title)


def _stone(one: "xr.Dataset") -> str:
    """Whose falls are shown, in a line of its own; nothing for what is of no study."""
    from overturning.figures.record import stone_label

    return stone_label(one) if "study" in one.attrs else ""


@_of_a_cube
def boundary(cube: "xr.Dataset", record: str | None = None) -> "Figure":
    """Largest B/H that falls under a record, by azimuth of the motion; of a cube in planes."""
    from overturning.figures.boundary import boundary_figure
    from overturning.figures.content import check_falls
    from overturning.statistics import boundary as statistics

    one = _one(cube, record)
    _only(one, "azimuth", "boundary")
    check_falls(one, "boundary")
    top = float(one["b_over_h"].max())
    bounds = statistics.boundary(one).assign_attrs(one.attrs)
    return boundary_figure(bounds, top, float(one["fault_normal"]), _place(one) + _stone(one))


@_of_a_cube
def rose(cube: "xr.Dataset") -> "Figure":
    """Directions of all falls, from north and from the fault normal, with and without a velocity pulse."""
    from overturning.figures.content import check_falls
    from overturning.figures.rose import rose_figure

    def draw(whole: "xr.Dataset") -> "Figure":
        check_falls(whole, "rose")
        return rose_figure(whole)

    return _of_all(cube, draw)


@_of_a_cube
def earthquakes(cube: "xr.Dataset") -> "Figure":
    """A rose of the directions of falls for each earthquake, from north."""
    from overturning.figures.content import check_falls
    from overturning.figures.rose import earthquake_roses_figure

    def draw(whole: "xr.Dataset") -> "Figure":
        check_falls(whole, "earthquakes")
        return earthquake_roses_figure(whole)

    return _of_all(cube, draw)


@_of_a_cube
def axes(cube: "xr.Dataset") -> "Figure":
    """Fall axes relative to the fault normal, by earthquake, and their means with intervals."""
    from overturning.figures.alignment import axes_figure
    from overturning.figures.content import check_axes
    from overturning.statistics.earthquakes import axes_by_group, summarise_axes

    def draw(whole: "xr.Dataset") -> "Figure":
        groups = axes_by_group(whole)
        summaries = {name: summarise_axes(found) for name, found in groups.items()}
        check_axes(whole, groups, summaries)
        return axes_figure(groups, summaries)

    return _of_all(cube, draw)


@_of_a_cube
def follow(cube: "xr.Dataset") -> "Figure":
    """What falls follow, by B/H: fault normal, radial direction, peaks and pulse of the motion."""
    from overturning.figures.alignment import follow_figure
    from overturning.figures.content import check_alignments
    from overturning.statistics.earthquakes import alignment_with_references

    _only(cube, "orientation", "follow")

    def draw(whole: "xr.Dataset") -> "Figure":
        found = alignment_with_references(whole, _measures(whole))
        check_alignments(whole, found)
        return follow_figure(found, whole["b_over_h"].to_numpy())

    return _of_all(cube, draw)


@_of_a_cube
def plane(cube: "xr.Dataset") -> "Figure":
    """Falls over PGA and PGV/PGA at the largest friction, with the fit and the field's criteria; of planes."""
    from overturning.figures.content import check_plane
    from overturning.figures.intensity_plane import intensity_plane_figure
    from overturning.statistics.logistic import overturning_fit
    from overturning.study.cube import sizes_of_another

    def draw(whole: "xr.Dataset") -> "Figure":
        if other := sizes_of_another(whole):
            raise ArgumentError(f"plane: limits and fit go by the stone's own height and B/H; {other}")
        measures = _measures(whole)
        check_plane(whole, measures)
        fit = overturning_fit(whole, measures)
        return intensity_plane_figure(whole, measures, fit, float(whole["friction"].max()))

    _only(cube, "azimuth", "plane")
    return _of_all(cube, draw)


@_of_a_cube
def intensity(cube: "xr.Dataset", record: str | None = None) -> "Figure":
    """PGA and PGV of a record by azimuth."""
    from overturning.figures.content import check_motion
    from overturning.figures.ground import intensity_figure

    one = _one(cube, record)
    measures = _measures(one).isel(record=0)
    check_motion(float(measures["pga"].max()), "intensity")
    return intensity_figure(measures, float(one["fault_normal"]), _place(one))


@_of_a_cube
def hodograph(cube: "xr.Dataset", record: str | None = None) -> "Figure":
    """Acceleration, velocity and displacement of a record seen from above."""
    from overturning.figures.ground import hodograph_figure
    from overturning.motion.motion import Motion
    from overturning.records.store import read_motion

    one = _one(cube, record)
    motion = _moving(Motion.of(read_motion(_motion(one))), "hodograph")
    return hodograph_figure(motion, float(one["fault_normal"]), _place(one))


@_of_a_cube
def history(motion: "Recorded | xr.Dataset", record: str | None = None) -> "Figure":
    """Time histories and spectra of a motion or record as it is, or of a cube's before and after its processing."""
    import xarray as xr

    from overturning.figures.history import history_figure
    from overturning.motion.motion import as_motion
    from overturning.records.record import Record, as_record
    from overturning.records.store import read_motion, read_unprocessed

    if isinstance(motion, xr.Dataset):
        path = _motion(_one(motion, record))
        used = read_motion(path)
        return history_figure(read_unprocessed(path) or used, _moving(used, "history"))
    if record is not None:
        raise ArgumentError(f"record: {record!r}; a motion or record is one by itself: leave it out")
    one = _moving(as_record(motion if isinstance(motion, Record) else as_motion(motion)), "history")
    return history_figure(one, one)


@_styled
def spectra(motion: "Recorded", azimuth_deg: "ArrayLike" = (0.0, 90.0), title: str = "") -> "Figure":
    """Fourier and response spectra of a motion or record along azimuths, degrees clockwise from north."""
    from overturning.figures.ground import spectra_figure
    from overturning.motion.direction import checked_azimuths
    from overturning.motion.motion import as_motion

    return spectra_figure(_moving(as_motion(motion), "spectra"), checked_azimuths(azimuth_deg).tolist(), title)


@_styled
def response(paths: "xr.Dataset | Sequence[xr.Dataset]", title: str = "") -> "Figure":
    """Rotation, slip and uplift against time of trajectories in planes (`overturning.trajectory`), a column each."""
    import xarray as xr

    from overturning.figures.response import response_figure

    several = [paths] if isinstance(paths, xr.Dataset) else paths
    if any("kind" not in path for path in several):
        raise ArgumentError("response: a path in space; overturning one --body --response draws its axis")
    return response_figure(several, title)


def _of_all(cube: "xr.Dataset", draw: Callable[["xr.Dataset"], "Figure"]) -> "Figure":
    """A figure of all records, of one element and factor; its title says of which, and of what variant and scene."""
    from overturning.figures.style import caption
    from overturning.study.cube import in_order

    if "record" not in cube.dims:
        raise ArgumentError("cube: one record without its dimension; keep it, cube.sel(record=['rinaldi'])")
    whole = in_order(cube.assign_coords(record=range(cube.sizes["record"])))
    figure = draw(whole)
    caption(figure, f"{_place(whole, ())}{_stone(whole)}\n{figure.get_suptitle()}".strip())
    return figure


def _one(cube: "xr.Dataset", record: str | None) -> "xr.Dataset":
    from overturning.study.cube import in_order, record_number

    number = record_number(cube, record)
    one = cube.isel(record=number) if "record" in cube.dims else cube
    unknown = {"station": "", "event": "", "fault_normal": float("nan")}  # of what is no part of a study
    one = one.assign_coords({name: value for name, value in unknown.items() if name not in one})
    return in_order(one).drop_vars("record", errors="ignore").load()


def _moving(motion: Moves, kind: str) -> Moves:
    """Return a motion or record; an ArgumentError if the ground does not move in it, so that a figure is empty."""
    from overturning.figures.content import check_motion

    check_motion(max(float(abs(one).max()) for one in (motion.north, motion.east)), kind)
    return motion


def _place(cube: "xr.Dataset", names: Sequence[str] = ("station", "event")) -> str:
    """Of what a cube is: by some names of its record, and variant and factor where not of the study itself."""
    from overturning.study.cube import variant_said

    times = [f"motion × {_factor(cube):g}"] if _factor(cube) != 1.0 else []
    return ", ".join([*filter(None, (str(cube[name].item()) for name in names)), *variant_said(cube), *times])


def _factor(cube: "xr.Dataset") -> float:
    """The factor on the motions of which a cube, or a part of one, is."""
    return float(cube["amplitude"]) if "amplitude" in cube.coords and "amplitude" not in cube.dims else 1.0


def _only(cube: "xr.Dataset", direction: str, kind: str) -> None:
    if direction not in cube.coords:
        raise ArgumentError(f"{kind}: a cube without {direction} has no such figure; take another kind")


def _beside(cube: "xr.Dataset", name: str) -> Path:
    file = Path(cube.encoding.get("source", ""))
    if not (path := file.parent / name).is_file():
        where = f"{file} has none beside it" if file.is_file() else "a cube in memory has none"
        raise MissingDataError(f"{name}: {where}; open the cube of a study that was run to its end, in its own folder")
    return path


def _motion(one: "xr.Dataset") -> Path:
    return _beside(one, f"{_motions(one)}/{one['record_id'].item()}.nc")


def _motions(cube: "xr.Dataset") -> Path:
    """The folder of a cube's motions, from where it lies; `motion` of what is no part of a study."""
    from overturning.study.cube import motions_beside, study_of

    if _factor(cube) != 1.0:
        raise MissingDataError(
            f"amplitude: motions and measures are of the records as they are, none times {_factor(cube):g}; open the "
            "cube with amplitude=1"
        )
    return motions_beside(Path(), study_of(cube), cube.attrs["variant"]) if "study" in cube.attrs else Path("motion")


def _measures(cube: "xr.Dataset") -> "xr.Dataset":
    """Intensity measures of the records of a cube, in their order."""
    import xarray as xr

    path = _beside(cube, "intensity.nc")
    if _motions(cube) != Path("motion"):
        raise MissingDataError(f"{path}: of the motions as recorded; there is none of those of {cube.attrs['variant']}")
    with xr.open_dataset(path) as measures:
        every = measures["record_id"].to_numpy().tolist()
        return measures.isel(record=[every.index(name) for name in cube["record_id"].to_numpy().ravel()]).load()


def _plot(self: Recorded) -> "Figure":
    """Draw acceleration, velocity, displacement and Fourier amplitudes; see `history`."""
    figure: Figure = history(self)
    return figure


# Figures lie above motions: the method is added here, so that the lower layer knows nothing of this one.
_plot.__name__, _plot.__qualname__ = "plot", "Recorded.plot"
Recorded.plot = _plot  # type: ignore[method-assign]
