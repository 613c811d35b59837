"""The map of stations: places, axes and names are where they belong; coordinates without a source are left off."""

import json
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from obspy.geodetics import gps2dist_azimuth

from overturning.errors import ArgumentError
from overturning.figures.site_map import (
    MAX_EARTHQUAKE_MAPS_PER_FIGURE,
    EarthquakeMapContent,
    StationOnMap,
    draw_station_and_fall_axis_maps_of_earthquakes,
    figures_with_several_earthquake_maps,
    local_east_north_km,
    mappable_earthquakes,
)
from overturning.figures.style import use_package_matplotlib_settings
from overturning.study.cube import open_cube
from tests.study.small_study import simulate_study_cube, sine_cycle_record, small_study

EPICENTRE = (35.0, 133.0)


def draw_earthquake_map(*sites: EarthquakeMapContent) -> Figure:
    """Draw the map of some earthquakes with their stations."""
    with use_package_matplotlib_settings():
        figure = draw_station_and_fall_axis_maps_of_earthquakes(sites)
        figure.draw_without_rendering()
        plt.close(figure)
    return figure


def points_of_map_lines_with_label(figure: Figure, label: str) -> list[np.ndarray]:
    """Return the points of the lines with a label, shape (points, 2), km east and north of the epicentre."""
    return [np.transpose(line.get_data()) for line in figure.axes[0].lines if line.get_label() == label]


def ends_of_arrows_in_first_map(figure: Figure) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return both ends of each arrow in the first panel."""
    found = [text for text in figure.axes[0].texts if isinstance(text, Annotation) and text.arrow_patch is not None]
    return [(np.array(one.xy), np.array(one.xyann)) for one in found]


@pytest.mark.parametrize("place", [(36, 136), (61.2, -149.9), (-41.3, 174.8), (40, 33), (0, -179.9), (63.5, -147.4)])
@pytest.mark.parametrize("origin", [(35, 135), (63.5, -147.4), (-42.7, 173), (37.2, 37), (0, 179.9)])
def test_epicentral_distance_and_azimuth_match_obspy(place: tuple[float, float], origin: tuple[float, float]) -> None:
    """Local east and north coordinates agree with obspy's geodesic on a sphere of 6371 km."""
    length, azimuth, _ = gps2dist_azimuth(*origin, *place, a=6_371_000, f=0)
    east, north = local_east_north_km(*place, *origin)
    assert np.hypot(east, north) == pytest.approx(length / 1000, rel=1e-6, abs=1e-6)
    if length > 0:
        assert (np.degrees(np.arctan2(east, north)) - azimuth + 180) % 360 - 180 == pytest.approx(0, abs=1e-3)


def test_stations_are_drawn_at_their_coordinates_on_one_scale() -> None:
    """A degree of latitude is 111.2 km; in pixels both directions have the same scale, and north is up."""
    figure = draw_earthquake_map(
        EarthquakeMapContent("A", [StationOnMap("n", 35.1, 133.0), StationOnMap("e", 35.0, 133.2)], EPICENTRE)
    )
    north, east = points_of_map_lines_with_label(figure, "station")
    assert north[0] == pytest.approx([0, 11.12], abs=0.01)
    assert east[0] == pytest.approx([0.2 * 111.19 * math.cos(math.radians(35)), 0], abs=0.02)
    assert points_of_map_lines_with_label(figure, "epicentre")[0][0].tolist() == [0, 0]
    centre, up, right = figure.axes[0].transData.transform([(0, 0), north[0], east[0]])
    assert up - centre == pytest.approx([0, (up - centre)[1]], abs=1e-6)
    assert (up - centre)[1] > 0
    scale = (up - centre)[1] / north[0][1], (right - centre)[0] / east[0][0]
    assert scale[0] == pytest.approx(scale[1], rel=1e-6)
    # The whole map is in the frame.
    for place in (north[0], east[0], (0, 0)):
        assert np.all(np.abs(figure.axes[0].transAxes.inverted().transform(
            figure.axes[0].transData.transform(place)) - 0.5) < 0.45)  # fmt: skip


@pytest.mark.parametrize("axis", [0.0, 30.0, 90.0, 150.0, 179.0])
def test_fall_axis_of_a_station_is_drawn_as_arrows_to_both_sides(axis: float) -> None:
    """A fall axis of 30° is drawn as arrows towards N30°E and S30°W of the station, the fault strike as a line."""
    figure = draw_earthquake_map(
        EarthquakeMapContent(
            "A", [StationOnMap("s", 35.1, 133.0, fault_strike_deg=axis + 20.0, mean_fall_axis_deg=axis)], EPICENTRE
        )
    )
    ((head, tail),) = ends_of_arrows_in_first_map(figure)
    assert (head + tail) / 2 == pytest.approx(points_of_map_lines_with_label(figure, "station")[0][0])
    along = figure.axes[0].transData.transform(head) - figure.axes[0].transData.transform(tail)
    assert math.degrees(math.atan2(*along)) % 180 == pytest.approx(axis % 180, abs=1e-6)
    (strike,) = points_of_map_lines_with_label(figure, "strike")
    assert math.degrees(math.atan2(*(strike[1] - strike[0]))) % 180 == pytest.approx((axis + 20) % 180, abs=1e-6)
    assert "mean axis of the falls" in [text.get_text() for text in figure.legends[0].get_texts()]


def test_unknown_strike_and_fall_axis_are_neither_drawn_nor_in_the_legend() -> None:
    figure = draw_earthquake_map(
        EarthquakeMapContent("A", [StationOnMap("a", 35.1, 133.0), StationOnMap("b", 35.0, 133.2)])
    )
    assert not ends_of_arrows_in_first_map(figure)
    assert not any(points_of_map_lines_with_label(figure, kind) for kind in ("strike", "trace", "epicentre"))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["station"]


def test_nearest_part_of_the_fault_trace_is_in_the_frame() -> None:
    """A trace passes 20 km north of a station 2 km from the epicentre; only its ends may lie outside the map."""
    trace = (((35.2, 132.0), (35.2, 134.0)),)
    figure = draw_earthquake_map(EarthquakeMapContent("A", [StationOnMap("a", 35.02, 133.0)], EPICENTRE, trace))
    assert figure.axes[0].get_ylim()[1] > 22.3 > 20
    assert figure.axes[0].get_xlim()[1] < 90
    assert points_of_map_lines_with_label(figure, "trace")[0] == pytest.approx(
        np.transpose(local_east_north_km([35.2, 35.2], [132.0, 134.0], *EPICENTRE)), abs=1e-9
    )


def test_each_station_name_on_a_map_is_nearest_to_its_own_station() -> None:
    """Names are nearest to their own stations even where stations are as close as those of Northridge 1994."""
    places = {"north": (34.326, -118.444), "middle": (34.281, -118.478), "south": (34.249, -118.479)}
    figure = draw_earthquake_map(
        EarthquakeMapContent(
            "A", [StationOnMap(name, *place, 122.0, 0.0) for name, place in places.items()], (34.21, -118.55)
        )
    )
    at = [figure.axes[0].transData.transform(one[0]) for one in points_of_map_lines_with_label(figure, "station")]
    points = dict(zip(places, at, strict=True))
    boxes = {text.get_text(): text.get_window_extent() for text in figure.axes[0].texts if text.get_text() in places}
    assert boxes.keys() == places.keys()
    for name, box in boxes.items():
        away = {
            other: math.hypot(max(box.x0 - x, x - box.x1, 0), max(box.y0 - y, y - box.y1, 0))
            for other, (x, y) in points.items()
        }
        assert min(away, key=lambda other: away[other]) == name
    for first in boxes.values():
        assert sum(first.overlaps(other) for other in boxes.values()) == 1, "with itself"


@pytest.mark.parametrize(
    ("site", "words"),
    [
        (EarthquakeMapContent("A", []), "A: no station"),
        (EarthquakeMapContent("A", [StationOnMap("s", 95.0, 133.0)]), "A, s: latitude 95"),
        (EarthquakeMapContent("A", [StationOnMap("s", 35.0, math.nan)]), "A, s: .* longitude nan"),
        (EarthquakeMapContent("A", [StationOnMap("s", 35.0, 133.0)], (35.0, 200.0)), "A, epicentre: .* longitude 200"),
    ],
)
def test_coordinates_off_the_globe_are_refused(site: EarthquakeMapContent, words: str) -> None:
    with use_package_matplotlib_settings(), pytest.raises(ArgumentError, match=words):
        draw_station_and_fall_axis_maps_of_earthquakes([site])
    plt.close("all")


def test_maps_of_many_earthquakes_are_split_over_several_figures() -> None:
    sites = [
        EarthquakeMapContent(str(number), [StationOnMap("s", 35.1, 133.0)], EPICENTRE)
        for number in range(MAX_EARTHQUAKE_MAPS_PER_FIGURE + 1)
    ]
    with use_package_matplotlib_settings():
        panels = [
            [axes.get_title() for axes in one.axes if axes.get_visible()]
            for one in figures_with_several_earthquake_maps(sites)
        ]
    plt.close("all")
    assert panels == [
        [str(number) for number in range(MAX_EARTHQUAKE_MAPS_PER_FIGURE)],
        [str(MAX_EARTHQUAKE_MAPS_PER_FIGURE)],
    ]
    assert list(figures_with_several_earthquake_maps([])) == []


@pytest.fixture(scope="module")
def cube_of_four_stations(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """Return a cube of three stations of earthquake A, with falls along 30°, and one station of earthquake B."""
    # Two records of the same samples would be one.
    records = [
        sine_cycle_record(name, east_over_north=math.tan(math.radians(30.0)), cycles=1 + number)
        for number, name in enumerate(("one", "two", "three", "alone"))
    ]
    use = {"use": [record.record_id for record in records]}
    settings = small_study(records=use, azimuth={"step": 10}, b_over_h=[0.1, 0.2, 0.3], friction=[1.0])
    found = open_cube(simulate_study_cube(settings, records, tmp_path_factory.mktemp("sites"))).load()
    nan = math.nan
    columns = {
        "event": ["A", "A", "A", "B"],
        "station_latitude": [35.1, 35.2, nan, 10.0], "station_longitude": [133.0, 133.1, nan, 20.0],
        "epicentre_latitude": [nan, 35.0, 35.0, nan], "epicentre_longitude": [nan, 133.0, 133.0, nan],
        "fault_normal": [120.0, nan, 120.0, 120.0],
    }  # fmt: skip
    return found.assign_coords({name: ("record", values) for name, values in columns.items()})


def cube_with_added_record_source_entries(cube: xr.Dataset, **said: dict[str, str]) -> xr.Dataset:
    """Return the cube with entries, given by record id, added to its stored table of the sources of records."""
    rows = [row | said.get(row["id"], {}) for row in json.loads(cube.attrs["record_sources"])]
    return cube.assign_attrs(record_sources=json.dumps(rows))


def test_map_data_of_a_cube_have_station_coordinates_strikes_and_fall_axes(cube_of_four_stations: xr.Dataset) -> None:
    """An earthquake with one station and no epicentre has no map, and a station without coordinates is on no map."""
    trace = {"fault_trace": "35 133, 36 133", "fault_trace_source": "map"}
    (site,) = mappable_earthquakes(cube_with_added_record_source_entries(cube_of_four_stations, two=trace))
    assert (site.name, site.epicentre_latitude_longitude, site.fault_trace) == (
        "A",
        (35.0, 133.0),
        (((35.0, 133.0), (36.0, 133.0)),),
    )
    assert [one[:3] for one in site.stations] == [("one", 35.1, 133.0), ("two", 35.2, 133.1)]
    assert [one.fault_strike_deg for one in site.stations] == pytest.approx([30.0, math.nan], nan_ok=True)
    assert [one.mean_fall_axis_deg for one in site.stations] == pytest.approx([30.0, 30.0], abs=0.5)


def test_station_without_a_source_of_its_coordinates_is_not_on_the_map(cube_of_four_stations: xr.Dataset) -> None:
    """Coordinates from the record table are drawn only if the table states their source."""
    (site,) = mappable_earthquakes(
        cube_with_added_record_source_entries(
            cube_of_four_stations, one={"coordinates_source": ""}, two={"coordinates_source": "survey"}
        )
    )
    assert [one.name for one in site.stations] == ["two"]
    none = {name: {"coordinates_source": ""} for name in ("one", "two", "three")}
    assert mappable_earthquakes(cube_with_added_record_source_entries(cube_of_four_stations, **none)) == []


def test_station_where_no_block_falls_has_no_fall_axis_on_the_map(cube_of_four_stations: xr.Dataset) -> None:
    """Where all blocks stand there is no fall axis, so the station has no arrow."""
    names = ("overturned", "probability_towards", "probability_away")
    (site,) = mappable_earthquakes(
        cube_of_four_stations.assign({name: xr.zeros_like(cube_of_four_stations[name]) for name in names})
    )
    assert all(math.isnan(one.mean_fall_axis_deg) for one in site.stations)
