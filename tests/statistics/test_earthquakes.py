"""Fall axes over earthquakes."""

import math

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.earthquakes import axes_by_earthquake, compare_alignment, summarise_axes


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
    assert summarise_axes(found).n == len(expected)


def test_what_does_not_fall_or_has_no_fault_normal_is_not_in_n(make_cube, sector) -> None:
    cube = make_cube([sector(60, 10)] * 4, azimuth=range(360), events="ABCD", fault_normal=[60, 60, 60, math.nan])
    cube["overturned"][{"record": 1}] = 0
    summary = summarise_axes(axes_by_earthquake(cube))
    assert (summary.earthquakes, summary.n) == (4, 2)
    assert math.isnan(summary.mean_axis_half_width_deg)
    nothing = summarise_axes(axes_by_earthquake(cube.assign(overturned=0 * cube["overturned"])))
    assert nothing.n == 0
    assert np.isnan([nothing.mean_axis_deg, nothing.rayleigh.p_value]).all()


def test_aligned_and_scattered(axes) -> None:
    aligned = summarise_axes(axes([-12, -7, -3, 2, 6, 9, 14, 4]))
    assert abs(aligned.mean_axis_deg) < 3
    assert aligned.mean_axis_half_width_deg < 10
    assert aligned.alignment_interval[0] > 0.8
    assert aligned.v.p_value < 1e-3
    assert aligned.closer_to_normal == 8
    doubled = np.exp(2j * np.radians([-12, -7, -3, 2, 6, 9, 14, 4])).mean()
    assert (aligned.resultant, aligned.mean_axis_deg) == pytest.approx(
        (abs(doubled), np.degrees(np.angle(doubled)) / 2)
    )
    assert aligned.alignment == pytest.approx(doubled.real)
    scattered = summarise_axes(axes([0, 23, 45, 68, 90, -68, -45, -23]))
    assert scattered.rayleigh.p_value > 0.9
    assert scattered.mean_axis_half_width_deg > 45
    assert scattered.alignment_interval[0] < 0 < scattered.alignment_interval[1]
    assert summarise_axes(axes([0, 23, 45, 68, 90, -68, -45, -23])) == scattered  # the same numbers each time


def test_bootstrap_interval_covers() -> None:
    """Of samples from a known distribution about nine tenths of the 90 % intervals hold its mean axis."""
    generator, held = np.random.default_rng(5), 0
    for _ in range(200):
        angle = np.degrees(generator.vonmises(math.radians(40), 4.0, size=12)) / 2
        axes = xr.Dataset({"axis": ("event", angle)}, coords={"event": [str(i) for i in range(12)]})
        summary = summarise_axes(axes, level=0.9, draws=400)
        held += abs((summary.mean_axis_deg - 20 + 90) % 180 - 90) <= summary.mean_axis_half_width_deg
    assert 0.80 <= held / 200 <= 0.97


def test_pulse_against_control(axes) -> None:
    pulse = axes([0, 5, -5, 8, -8, 3, 6, -2])
    names = ["E0", "E1", "C2", "C3", "C4", "C5", "C6", "C7"]
    difference = compare_alignment(pulse, axes([90, 70, 85, -80, 60, 88, 75, -85], events=names))
    assert difference.difference > 1.5
    assert difference.interval[0] > 1
    assert (difference.n_first, difference.n_second) == (8, 8)
    same = compare_alignment(pulse, pulse)
    assert (same.difference, same.interval) == (0, (0, 0))  # the same earthquakes are drawn for both
    few = axes([0, 5, 10, 15, 20, 25, 30])
    assert np.isnan([*compare_alignment(few, few).interval, *summarise_axes(few).alignment_interval]).all()
