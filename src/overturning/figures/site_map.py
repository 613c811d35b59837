"""Maps of stations, one panel an earthquake: epicentre, fault, and the axis along which stones fall at each station."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.errors import ArgumentError
from overturning.figures.style import (
    DASHED_LINE_STYLE,
    FALL_COLOUR,
    FAULT_COLOUR,
    INK,
    PAGE_WIDTH_INCHES,
    PHONE_FIGURE_WIDTH_INCHES,
    add_panel_grid,
    add_title_and_legend,
    create_figure,
    is_drawing_for_phone,
    largest_round_number_up_to,
    wrap_name_into_lines,
)
from overturning.records.fault_trace import FaultTracePiecesInLatLonDeg, parse_fault_trace
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.statistics.earthquakes import mean_fall_directions_and_axes_by_record
from overturning.study.cube import record_sources
from overturning.units import EARTH_RADIUS_KM

MAX_PANELS_PER_ROW: Final = 4
"""Largest number of panels in a row."""

MAX_PANELS_PER_ROW_ON_PHONE: Final = 2
"""Largest number of panels in a row on a phone: panels as large as on a page."""

MAX_EARTHQUAKE_MAPS_PER_FIGURE: Final = 20
"""Largest number of panels of one figure; there are more figures if a study has more earthquakes."""

MIN_MAP_HALF_WIDTH_KM: Final = 5.0
"""Smallest distance from the middle of a panel to its frame."""

MAP_HALF_WIDTH_OVER_FARTHEST_DISTANCE: Final = 1.7
"""Distance from the middle of a panel to its frame, over that to the farthest place: room for arrows and names."""

ARROW_HALF_LENGTH_OVER_MAP_HALF_WIDTH: Final = 0.22
"""Half of an arrow, as a part of the distance from the middle of a panel to its frame."""

TEXT_SIZE_PT: Final = 8.0
"""Size of names, pt."""


class StationOnMap(NamedTuple):
    """Station on a map: name, coordinates, fault strike, and mean axis of the falls under its record (degrees).

    Azimuths are clockwise from north. NaN stands for an unknown value, or if the falls have no mean axis.
    """

    name: str
    latitude: float
    longitude: float
    fault_strike_deg: float = math.nan
    mean_fall_axis_deg: float = math.nan


class EarthquakeMapContent(NamedTuple):
    """Stations, epicentre (latitude, longitude, degrees) and fault trace of one earthquake for a map.

    An unknown epicentre is None.
    """

    name: str
    stations: Sequence[StationOnMap]
    epicentre_latitude_longitude: tuple[float, float] | None = None
    fault_trace: FaultTracePiecesInLatLonDeg = ()


def local_east_north_km(
    latitude: Any, longitude: Any, origin_latitude: float, origin_longitude: float
) -> tuple[Any, Any]:
    """Return the distances east and north, km, of a point from an origin, given latitudes and longitudes, degrees.

    Distance and direction from the origin are those along the great circle.
    """
    north, north0, turn = (
        np.radians(latitude),
        np.radians(origin_latitude),
        np.radians(np.asarray(longitude) - origin_longitude),
    )
    x = np.cos(north) * np.sin(turn)
    y = np.cos(north0) * np.sin(north) - np.sin(north0) * np.cos(north) * np.cos(turn)
    z = np.sin(north0) * np.sin(north) + np.cos(north0) * np.cos(north) * np.cos(turn)
    # An angle over its sine.
    scale = EARTH_RADIUS_KM / np.sinc(np.arctan2(np.hypot(x, y), z) / np.pi)
    return scale * x, scale * y


def mappable_earthquakes(cube: xr.Dataset) -> list[EarthquakeMapContent]:
    """Return the earthquakes for which a map can be drawn: an epicentre and a station, or two stations, are known.

    The id of a record names its station. A station is left out if its coordinates are unknown, or if the record table
    states them without a source. Its fall axis is that of `mean_fall_directions_and_axes_by_record`, or NaN if the
    resultant is below `MIN_RESULTANT_WITH_MEAN_DIRECTION`. Epicentre and fault trace are those of the first record that
    has them.
    """
    ids, events = (np.atleast_1d(cube[name].to_numpy()).astype(str) for name in ("record_id", "event"))
    stations, epicentres = (
        _station_or_epicentre_coordinates_by_record(cube, "station"),
        _station_or_epicentre_coordinates_by_record(cube, "epicentre"),
    )
    if not any(map(_are_coordinates_known, stations)):
        return []
    said = {row["id"]: row for row in record_sources(cube)}
    about = [said.get(name, {}) for name in ids.tolist()]
    means = mean_fall_directions_and_axes_by_record(cube)
    clear = means["axis_resultant"].to_numpy() >= MIN_RESULTANT_WITH_MEAN_DIRECTION
    axes = np.where(clear, means["mean_axis"].to_numpy(), np.nan).tolist()
    strikes = ((cube["fault_normal"].to_numpy().astype(np.float64) - 90.0) % 360.0).tolist()
    sites = []
    for event in dict.fromkeys(events.tolist()):
        rows = [row for row in np.flatnonzero(events == event) if about[row].get("coordinates_source") != ""]
        shown = [
            StationOnMap(str(ids[row]), *stations[row], strikes[row], axes[row])
            for row in rows
            if _are_coordinates_known(stations[row])
        ]
        epicentre = next((epicentres[row] for row in rows if _are_coordinates_known(epicentres[row])), None)
        if len(shown) < (2 if epicentre is None else 1):
            continue
        traces = (about[row].get("fault_trace", "") for row in rows)
        sites.append(EarthquakeMapContent(event, shown, epicentre, parse_fault_trace(next(filter(None, traces), ""))))
    return sites


def _station_or_epicentre_coordinates_by_record(cube: xr.Dataset, place_kind: str) -> list[tuple[float, float]]:
    """Return latitude and longitude of the station or the epicentre of each record, NaN where unknown."""
    names = (f"{place_kind}_latitude", f"{place_kind}_longitude")
    north, east = (np.atleast_1d(cube[name].to_numpy()).astype(np.float64).tolist() for name in names)
    return list(zip(north, east, strict=True))


def _are_coordinates_known(latitude_and_longitude: tuple[float, float]) -> bool:
    """True if latitude and longitude of a place are known."""
    return all(map(math.isfinite, latitude_and_longitude))


def figures_with_several_earthquake_maps(earthquakes: Sequence[EarthquakeMapContent]) -> Iterator[Figure]:
    """Yield figures with maps of all earthquakes, with at most `MAX_EARTHQUAKE_MAPS_PER_FIGURE` maps per figure."""
    yield from (
        draw_station_and_fall_axis_maps_of_earthquakes(earthquakes[first : first + MAX_EARTHQUAKE_MAPS_PER_FIGURE])
        for first in range(0, len(earthquakes), MAX_EARTHQUAKE_MAPS_PER_FIGURE)
    )


def draw_station_and_fall_axis_maps_of_earthquakes(earthquakes: Sequence[EarthquakeMapContent]) -> Figure:
    """Draw a map of each earthquake: stations, epicentre, fault, and arrows along the mean axes of the falls.

    North is up; each panel has its own scale. An `ArgumentError` is raised if no earthquake is given, if one has no
    stations, or if a latitude or longitude is outside its range.
    """
    if not earthquakes:
        raise ArgumentError("sites: none; give at least one earthquake with a station")
    for site in earthquakes:
        _check_has_stations_and_valid_coordinates(site)
    most, width = (
        (MAX_PANELS_PER_ROW_ON_PHONE, PHONE_FIGURE_WIDTH_INCHES)
        if is_drawing_for_phone()
        else (MAX_PANELS_PER_ROW, PAGE_WIDTH_INCHES)
    )
    columns = min(most, len(earthquakes))
    rows = -(-len(earthquakes) // columns)
    side = width / most if columns == most else width / max(columns, 1.6)
    width_pt = 72.0 * (side - 0.12)
    # A letter of a title is about 4.5 pt wide.
    titles = [wrap_name_into_lines(site.name, int(width_pt / 4.5)) for site in earthquakes]
    above = 0.13 * max(map(len, titles), default=1)
    marks = _legend_entries_of_map_symbols(earthquakes)
    legend_columns = 1 if is_drawing_for_phone() else min(3, columns + 1)
    below = 0.6 + 0.19 * max(0, -(-len(marks) // legend_columns) - 2)  # two lines of the legend need 0.6 in
    figure = create_figure(columns * side, rows * (side + 0.14 + above) + below)
    panels = add_panel_grid(figure, rows, columns, len(earthquakes))
    for axes, site, title in zip(panels.flat, earthquakes, titles, strict=False):
        _draw_earthquake_map(axes, site, width_pt)
        axes.set_title("\n".join(title), fontsize=8.5, parse_math=False, pad=3)
    add_title_and_legend(figure, "", None, legend_columns, legend_handles_before_panel_marks=marks)
    return figure


def _check_has_stations_and_valid_coordinates(earthquake: EarthquakeMapContent) -> None:
    """Raise an error if an earthquake has no stations, or if a latitude or longitude is outside its range."""
    if not earthquake.stations:
        raise ArgumentError(f"{earthquake.name}: no station; leave the earthquake out, or give one")
    places = {one.name: one[1:3] for one in earthquake.stations} | {
        "epicentre": earthquake.epicentre_latitude_longitude or (0.0, 0.0)
    }
    for name, (latitude, longitude) in places.items():
        if not (abs(latitude) <= 90 and abs(longitude) <= 180):  # NaN fails both
            raise ArgumentError(
                f"{earthquake.name}, {name}: latitude {latitude:g}, longitude {longitude:g}; "
                "give −90 to 90 and −180 to 180"
            )


def _legend_entries_of_map_symbols(earthquakes: Sequence[EarthquakeMapContent]) -> list[Any]:
    """Return legend entries for the symbols and lines that occur on at least one map."""
    from matplotlib.lines import Line2D

    stations = [one for site in earthquakes for one in site.stations]
    kinds = {
        "epicentre": (
            any(site.epicentre_latitude_longitude for site in earthquakes),
            _EPICENTRE_MARKER_STYLE | {"linestyle": "none"},
        ),
        "station": (True, _STATION_MARKER_STYLE | {"linestyle": "none"}),
        "mean axis of the falls": (
            any(math.isfinite(one.mean_fall_axis_deg) for one in stations),
            {
                "color": FALL_COLOUR,
                "linewidth": 1.6,
                "marker": "$\\leftrightarrow$",
                "markersize": 13,
                "linestyle": "none",
            },
        ),
        "strike of the fault": (any(math.isfinite(one.fault_strike_deg) for one in stations), _FAULT_STRIKE_LINE_STYLE),
        "trace of the fault": (any(site.fault_trace for site in earthquakes), _FAULT_TRACE_LINE_STYLE),
    }
    return [Line2D([], [], label=name, **look) for name, (there, look) in kinds.items() if there]


_EPICENTRE_MARKER_STYLE: Final[dict[str, Any]] = {
    "marker": "*", "color": "#f0c419", "markersize": 10, "markeredgecolor": INK, "markeredgewidth": 0.6,
}  # fmt: skip
_STATION_MARKER_STYLE: Final[dict[str, Any]] = {
    "marker": "o",
    "color": INK,
    "markersize": 4.5,
    "markeredgecolor": "white",
}
_FAULT_STRIKE_LINE_STYLE: Final[dict[str, Any]] = {
    "color": FAULT_COLOUR,
    "linewidth": 1.2,
    "linestyle": DASHED_LINE_STYLE,
}
_FAULT_TRACE_LINE_STYLE: Final[dict[str, Any]] = {"color": FAULT_COLOUR, "linewidth": 2.2, "alpha": 0.55}


def _draw_earthquake_map(axes: Any, earthquake: EarthquakeMapContent, panel_width_pt: float) -> None:
    """Draw the map of one earthquake; the width of its panel, pt, is needed to place the station names."""
    origin = earthquake.epicentre_latitude_longitude or (
        earthquake.stations[0].latitude,
        earthquake.stations[0].longitude,
    )
    places = np.array([local_east_north_km(one.latitude, one.longitude, *origin) for one in earthquake.stations])
    pieces = [np.array([local_east_north_km(*point, *origin) for point in piece]) for piece in earthquake.fault_trace]
    along = _points_along_fault_trace(pieces)
    away = np.hypot(*(along[:, None] - places).T).min(axis=0)
    # The nearest point of the trace is on the map, too.
    shown = [
        *places,
        *([np.zeros(2)] if earthquake.epicentre_latitude_longitude else []),
        *([along[away.argmin()]] if away.size else []),
    ]
    low, high = np.min(shown, axis=0), np.max(shown, axis=0)
    middle, reach = (
        (low + high) / 2,
        max(float(np.max(high - low)) / 2 * MAP_HALF_WIDTH_OVER_FARTHEST_DISTANCE, MIN_MAP_HALF_WIDTH_KM),
    )
    axes.set(xlim=middle[0] + reach * np.array([-1, 1]), ylim=middle[1] + reach * np.array([-1, 1]), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(True)
    axes.spines[:].set_linewidth(0.6)
    for piece in pieces:
        axes.plot(*piece.T, solid_capstyle="butt", zorder=2, label="trace", **_FAULT_TRACE_LINE_STYLE)
    if earthquake.epicentre_latitude_longitude:
        axes.plot(0, 0, zorder=4, label="epicentre", **_EPICENTRE_MARKER_STYLE)
    star = 4.0 * 2 * reach / panel_width_pt * np.array([(0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)])
    taken = [*along, *(star if earthquake.epicentre_latitude_longitude else ())]
    for one, place in zip(earthquake.stations, places, strict=True):
        for azimuth, half in (
            (one.fault_strike_deg, 1.35 * ARROW_HALF_LENGTH_OVER_MAP_HALF_WIDTH * reach),
            (one.mean_fall_axis_deg, ARROW_HALF_LENGTH_OVER_MAP_HALF_WIDTH * reach),
        ):
            if math.isfinite(azimuth):
                end = half * np.array([math.sin(math.radians(azimuth)), math.cos(math.radians(azimuth))])
                taken += [place + part * end for part in np.linspace(-1, 1, 9)]
                if azimuth is one.mean_fall_axis_deg:
                    look = {
                        "arrowstyle": "<|-|>,head_length=0.28,head_width=0.14",
                        "color": FALL_COLOUR,
                        "linewidth": 1.5,
                    }
                    ends = {"shrinkA": 0, "shrinkB": 0}
                    axes.annotate("", place + end, place - end, arrowprops=look | ends, zorder=5)
                else:
                    axes.plot(
                        *np.transpose([place - end, place + end]), zorder=3, label="strike", **_FAULT_STRIKE_LINE_STYLE
                    )
        axes.plot(*place, zorder=6, label="station", **_STATION_MARKER_STYLE)
    _write_station_names(axes, [one.name for one in earthquake.stations], places, taken, panel_width_pt / (2 * reach))
    _draw_scale_bar_and_north_arrow(axes, reach, middle[0], -8.0 / panel_width_pt)


def _points_along_fault_trace(fault_trace_pieces: Sequence[Any]) -> Any:
    """Return closely spaced points along all pieces of a fault trace, in the unit of the pieces, shape (points, 2)."""
    steps = np.linspace(0, 1, 51)[:, None, None]
    points = [(piece[:-1] + steps * (piece[1:] - piece[:-1])).reshape(-1, 2) for piece in fault_trace_pieces]
    return np.concatenate(points) if points else np.empty((0, 2))


def _write_station_names(
    axes: Any,
    station_names: Sequence[str],
    station_east_north_km: Any,
    points_to_keep_visible_km: list[Any],
    typographic_points_per_km: float,
) -> None:
    """Write each station's name on a map, at the place where the name hides the fewest lines, symbols and names."""
    own = typographic_points_per_km * np.asarray(station_east_north_km)
    marks = typographic_points_per_km * np.asarray([*station_east_north_km, *points_to_keep_visible_km])
    frame = typographic_points_per_km * np.array([axes.get_xlim(), axes.get_ylim()])
    boxes: list[StationNameBox] = []
    for number, name in enumerate(station_names):
        size = np.array([0.58 * TEXT_SIZE_PT * len(name) + 2, TEXT_SIZE_PT + 2])
        around = [
            own[number] + np.array(side) * (away + size / 2)
            for away in (6.0, 12.0, 19.0)
            for side in _NAME_OFFSET_DIRECTIONS
        ]
        best = min((StationNameBox(middle - size / 2, middle + size / 2) for middle in around),
                   key=lambda box: _name_placement_cost(box, number, own, marks, boxes, frame))  # fmt: skip
        boxes.append(best)
        axes.annotate(
            name, (best.lower_left_corner_pt + best.upper_right_corner_pt) / 2 / typographic_points_per_km,
            ha="center", va="center", fontsize=TEXT_SIZE_PT,
            parse_math=False,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.4}, annotation_clip=False,
            zorder=4.5,
        )  # fmt: skip


_NAME_OFFSET_DIRECTIONS: Final = ((0, -1), (0, 1), (1, 0), (-1, 0), (1, -1), (-1, -1), (1, 1), (-1, 1))


class StationNameBox(NamedTuple):
    """Rectangle, pt, that a station's name occupies on a map: lower left and upper right corner."""

    lower_left_corner_pt: Any
    upper_right_corner_pt: Any

    def distances_to_points_pt(self, points: Any) -> Any:
        """Return the distances, pt, of points from the box of a station's name; 0 for points inside the box."""
        return np.hypot(
            *np.clip(np.maximum(self.lower_left_corner_pt - points, points - self.upper_right_corner_pt), 0, None).T
        )


def _name_placement_cost(
    box: StationNameBox,
    station_index: int,
    station_positions_pt: Any,
    points_to_keep_visible_pt: Any,
    boxes_of_placed_names: Sequence[StationNameBox],
    panel_limits_pt: Any,
) -> float:
    """Return a penalty for a station's name in a box, such as if it hides symbols or another station is nearer."""
    out = float(
        np.clip(
            np.concatenate(
                [panel_limits_pt[:, 0] - box.lower_left_corner_pt, box.upper_right_corner_pt - panel_limits_pt[:, 1]]
            ),
            0,
            None,
        ).sum()
    )
    over = sum(
        bool(
            np.all(
                (box.lower_left_corner_pt < other.upper_right_corner_pt)
                & (box.upper_right_corner_pt > other.lower_left_corner_pt)
            )
        )
        for other in boxes_of_placed_names
    )
    away = box.distances_to_points_pt(station_positions_pt)
    others = np.delete(away, station_index)
    misleading = bool(others.size) and others.min() < 1.3 * away[station_index]
    covered = float((box.distances_to_points_pt(points_to_keep_visible_pt) == 0).sum())
    return 3 * out + 3 * covered + 12 * over + 25 * misleading + 0.3 * float(away[station_index])


def _draw_scale_bar_and_north_arrow(axes: Any, half_width_km: float, centre_x_km: float, axes_y: float) -> None:
    """Draw a scale bar and a north arrow at the height `axes_y`, a share of the panel's height, below a map."""
    length = largest_round_number_up_to(half_width_km / 2)
    below, left = axes.get_xaxis_transform(), centre_x_km - half_width_km
    look = {"color": INK, "linewidth": 2.2, "solid_capstyle": "butt", "clip_on": False}
    axes.plot([left, left + length], [axes_y, axes_y], transform=below, label="scale", **look)
    text = {"xycoords": below, "textcoords": "offset points", "va": "center", "fontsize": TEXT_SIZE_PT}
    axes.annotate(f"{length:g} km", (left + length, axes_y), (3, 0), annotation_clip=False, **text)
    axes.annotate("N ↑", (centre_x_km + half_width_km, axes_y), (0, 0), ha="right", annotation_clip=False, **text)
