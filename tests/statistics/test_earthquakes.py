"""Fall axes over earthquakes."""

import math

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.circular import SECTORS
from overturning.statistics.earthquakes import axes_by_earthquake, compare_alignment, summarise_axes
from overturning.statistics.roses import rose_of


@pytest.fixture
def axes(make_cube, sector):
    """Axes of records whose falls lie so far from their fault normals, each of an earthquake of its own or as named."""

    def of(offsets, *, normals=None, events=None):
        normals = [20.0 + 37 * i for i in range(len(offsets))] if normals is None else normals
        rules = [sector(normal + offset, 10) for normal, offset in zip(normals, offsets, strict=True)]
        names = [f"E{i}" for i in range(len(offsets))] if events is None else events
        return axes_by_earthquake(make_cube(rules, azimuth=range(360), events=names, fault_normal=normals))

    return of


@pytest.mark.parametrize(
    ("offsets", "more", "expected"),
    [
        ([0, 10, -20, 80, 90], {}, [0, 10, -20, 80, 90]),
        # The sign of the fault normal is arbitrary.
        ([12, -30], {"normals": [50.0, 100.0]}, [12, -30]),
        ([12 + 180, -30 + 180], {"normals": [230.0, 280.0]}, [12, -30]),
        # Records of one earthquake are averaged first.
        ([10, 30, -40], {"events": ["A", "A", "B"]}, [20, -40]),
    ],
)
def test_axis_relative_to_the_fault_normal(axes, offsets, more, expected) -> None:
    found = axes(offsets, **more)
    assert found["axis"].values == pytest.approx(expected, abs=1e-6)
    assert found["records"].values.tolist() == [len(offsets) - len(expected) + 1, *[1] * (len(expected) - 1)]
    assert summarise_axes(found).alignment.n == len(expected)


def test_what_does_not_fall_or_has_no_fault_normal_is_not_in_n(make_cube, sector) -> None:
    cube = make_cube([sector(60, 10)] * 4, azimuth=range(360), events="ABCD", fault_normal=[60, 60, 60, math.nan])
    cube["overturned"][{"record": 1}] = 0
    summary = summarise_axes(axes_by_earthquake(cube))
    assert (summary.earthquakes, summary.alignment.n) == (4, 2)
    assert math.isnan(summary.half_width_deg)
    nothing = summarise_axes(axes_by_earthquake(cube.assign(overturned=0 * cube["overturned"])))
    assert nothing.alignment.n == 0
    assert np.isnan([nothing.axis_deg, nothing.alignment.value]).all()


def test_only_blocks_that_just_fall_tell_and_an_earthquake_weighs_as_its_falls_agree(make_cube) -> None:
    """B/H 0.1 falls in every plane and B/H 0.3 near one axis, or, of the last earthquake, near two across each other.

    The expected numbers are of the azimuths in which B/H 0.3 falls, by numpy.
    """
    offsets, normals = [[0], [20, 20], [60], [3, 91]], [10.0, 70.0, 130.0, 40.0]
    planes = np.arange(0, 180, 2)

    def rule(normal: float, offset: list[int]):
        def falls(azimuth, height, slender, friction):
            near = [np.abs((azimuth - normal - one + 90) % 180 - 90) <= 14 for one in offset]
            side = np.where(azimuth < 180, 1, -1)
            return np.where((slender < 0.2) | ((slender == 0.3) & np.any(near, axis=0)), side, 0)

        return falls

    rules = [rule(*one) for one in zip(normals, offsets, strict=True)]
    more = {"azimuth": range(0, 360, 2), "b_over_h": (0.1, 0.3, 0.5), "fault_normal": normals}
    cube = make_cube(rules, events="ABCD", **more)
    doubled = []
    for normal, offset in zip(normals, offsets, strict=True):
        apart = planes - normal
        fell = [one for one in apart if any(abs((one - each + 90) % 180 - 90) <= 14 for each in offset)]
        doubled.append(np.exp(2j * np.radians(fell)).mean())
    found = axes_by_earthquake(cube)
    assert found["cosine"].values == pytest.approx(np.real(doubled))
    assert found["resultant"].values == pytest.approx(np.abs(doubled))
    assert np.abs(doubled[-1]) < 0.05
    assert np.isfinite(found["axis"].values).tolist() == [True, True, True, False]
    summary = summarise_axes(found)
    assert (summary.alignment.n, summary.with_axis, summary.closer_to_normal) == (4, 3, 2)
    assert summary.alignment.value == pytest.approx(np.mean(np.real(doubled)))
    by_shape = axes_by_earthquake(cube, "b_over_h")
    assert by_shape["falls"].sum("event").values.tolist() == [4, 4, 0]  # the slender fall everywhere, and tell nothing
    assert by_shape["axis"].count("event").values.tolist() == [0, 3, 0]
    # A record under which no block only just falls says what all of its falls say: nothing, as they go every way.
    (alone,) = axes_by_earthquake(cube.isel(record=[0], b_over_h=[0]))["resultant"].values
    assert alone == pytest.approx(0.0, abs=1e-9)


def test_a_rose_of_planes_weighs_earthquakes_and_shows_blocks_that_just_fall(make_cube, sector) -> None:
    """Seven earthquakes whose blocks fall in eleven planes about 0°, one of two records with one plane each, 90°."""
    rules = [sector(0, 5)] * 7 + [sector(90, 0)] * 2
    cube = make_cube(rules, azimuth=range(360), events="ABCDEFGHH")
    rose = rose_of(cube)
    assert (rose.falls, rose.earthquakes) == (7 * 11 * 20 + 2 * 20, 8)
    shares = np.zeros(24)
    shares[[0, 6]] = 7 / 8, 1 / 8  # sectors of 15°, the first about north
    assert rose.shares == pytest.approx(shares)
    assert rose.low[6] == 0
    assert rose.high[6] == pytest.approx(3 / 8, abs=0.001)  # 97.5 % of B(8, 1/8) is 3
    # Blocks that fall in all planes, to every side, do not blur it.
    slender = cube.isel(b_over_h=[0]).assign(overturned=1 + 0 * cube["overturned"].isel(b_over_h=[0]))
    slender["overturned"][{"azimuth": slice(180, None)}] = -1
    together = xr.concat([cube, slender.assign_coords(b_over_h=[0.05])], "b_over_h", data_vars="minimal")
    assert rose_of(together).shares == pytest.approx(shares)


@pytest.mark.parametrize("step", [5, 10, 15, 20, 30, 45])
@pytest.mark.parametrize("from_normal", [False, True])
def test_a_rose_of_falls_every_way_is_round_whatever_the_step_of_the_azimuths(make_cube, step, from_normal) -> None:
    """Of azimuths 10° apart every other sector held two, of those 30° apart every other none."""

    def every_way(azimuth: np.ndarray, _: np.ndarray, __: np.ndarray, friction: np.ndarray) -> np.ndarray:
        return np.where(friction < 0.5, 1, -1) * np.where(azimuth < 180, 1, -1)

    cube = make_cube(every_way, azimuth=range(0, 360, step), fault_normal=60.0)
    assert rose_of(cube, from_normal=from_normal).shares == pytest.approx(np.full(SECTORS, 1 / SECTORS))


def test_aligned_and_scattered(axes) -> None:
    offsets = [-12, -7, -3, 2, 6, 9, 14, 4]
    aligned = summarise_axes(axes(offsets))
    assert abs(aligned.axis_deg) < 3
    assert aligned.half_width_deg < 10
    assert aligned.alignment.low > 0.8
    assert aligned.closer_to_normal == aligned.with_axis == 8
    # Planes within 10° of its axis, of each degree, fall under each.
    doubled = np.exp(2j * np.radians(offsets)).mean() * np.cos(2 * np.radians(np.arange(-10, 11))).mean()
    assert aligned.axis_deg == pytest.approx(np.degrees(np.angle(doubled)) / 2)
    assert aligned.alignment.value == pytest.approx(doubled.real)
    scattered = summarise_axes(axes([0, 23, 45, 68, 90, -68, -45, -23]))
    assert math.isnan(scattered.axis_deg)
    assert scattered.alignment.low < 0 < scattered.alignment.high
    assert str(summarise_axes(axes([0, 23, 45, 68, 90, -68, -45, -23]))) == str(scattered)  # the same each time


def test_bootstrap_interval_covers() -> None:
    """Of samples from a known distribution about nine tenths of the 90 % intervals hold its mean axis."""
    generator, held = np.random.default_rng(5), 0
    for _ in range(200):
        angle = np.degrees(generator.vonmises(math.radians(40), 4.0, size=12)) / 2
        parts = {"cosine": np.cos(np.radians(2 * angle)), "sine": np.sin(np.radians(2 * angle)), "axis": angle}
        axes = xr.Dataset(
            {name: ("event", values) for name, values in parts.items()}, {"event": [str(i) for i in range(12)]}
        )
        summary = summarise_axes(axes, level=0.9, draws=400)
        held += abs((summary.axis_deg - 20 + 90) % 180 - 90) <= summary.half_width_deg
    assert 0.80 <= held / 200 <= 0.97


def test_pulse_against_control(axes) -> None:
    pulse = axes([0, 5, -5, 8, -8, 3, 6, -2])
    names = ["E0", "E1", "C2", "C3", "C4", "C5", "C6", "C7"]
    difference = compare_alignment(pulse, axes([90, 70, 85, -80, 60, 88, 75, -85], events=names))
    assert difference.value > 1.5
    assert difference.low > 1
    assert difference.n == 8
    same = compare_alignment(pulse, pulse)
    assert (same.value, same.low, same.high) == (0, 0, 0)  # the same earthquakes are drawn for both
    few = axes([0, 5, 10, 15, 20, 25, 30])
    assert np.isnan([compare_alignment(few, few).low, summarise_axes(few).alignment.low]).all()
