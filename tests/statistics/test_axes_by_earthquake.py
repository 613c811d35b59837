"""Fall axes over earthquakes."""

import math

import numpy as np
import pytest

from overturning.statistics.earthquakes import axes_by_earthquake, compare_alignment, summarise_axes


def cube_of(make_cube, sector, offsets, *, normals=None, events=None, pulse=1):
    normals = [20.0 + 37 * i for i in range(len(offsets))] if normals is None else normals
    rules = [sector(normal + offset, 10) for normal, offset in zip(normals, offsets, strict=True)]
    names = [f"E{i}" for i in range(len(offsets))] if events is None else events
    return make_cube(rules, azimuth=range(360), events=names, fault_normal=normals, pulse=pulse)


def test_axis_relative_to_the_fault_normal(make_cube, sector) -> None:
    offsets = [0, 10, -20, 80, 90]
    axes = axes_by_earthquake(cube_of(make_cube, sector, offsets))
    assert axes["axis"].values == pytest.approx(offsets, abs=1e-6)
    assert (axes["records"] == 1).all()


def test_the_sign_of_the_fault_normal_is_arbitrary(make_cube, sector) -> None:
    one = cube_of(make_cube, sector, [12, -30], normals=[50.0, 100.0])
    other = one.assign_coords(fault_normal=("record", [230.0, 280.0]))
    assert axes_by_earthquake(other)["axis"].values == pytest.approx(axes_by_earthquake(one)["axis"].values)


def test_records_of_one_earthquake_count_once(make_cube, sector) -> None:
    axes = axes_by_earthquake(cube_of(make_cube, sector, [10, 30, -40], events=["A", "A", "B"]))
    assert axes["event"].values.tolist() == ["A", "B"]
    assert axes["axis"].values == pytest.approx([20, -40])
    assert axes["records"].values.tolist() == [2, 1]
    assert summarise_axes(axes).n == 2


def test_an_earthquake_without_falls_is_not_in_n(make_cube, sector) -> None:
    cube = cube_of(make_cube, sector, [0, 0, 0])
    cube["overturned"][{"record": 1}] = 0
    summary = summarise_axes(axes_by_earthquake(cube))
    assert (summary.earthquakes, summary.n) == (3, 2)
    assert math.isnan(summary.mean_axis_half_width_deg)


def test_no_falls_at_all(make_cube) -> None:
    cube = make_cube(lambda azimuth, *_rest: np.zeros_like(azimuth), events=("A", "B"))
    summary = summarise_axes(axes_by_earthquake(cube))
    assert summary.n == 0
    assert math.isnan(summary.mean_axis_deg)
    assert math.isnan(summary.rayleigh.p_value)


def test_an_unknown_fault_normal_is_left_out(make_cube, sector) -> None:
    cube = cube_of(make_cube, sector, [0, 5, 10])
    cube = cube.assign_coords(fault_normal=cube["fault_normal"].where(cube["record"] != 2))
    assert summarise_axes(axes_by_earthquake(cube)).n == 2


def test_aligned_and_scattered(make_cube, sector) -> None:
    aligned = summarise_axes(axes_by_earthquake(cube_of(make_cube, sector, [-12, -7, -3, 2, 6, 9, 14, 4])))
    assert abs(aligned.mean_axis_deg) < 3
    assert aligned.mean_axis_half_width_deg < 10
    assert aligned.alignment_interval[0] > 0.8
    assert aligned.v.p_value < 1e-3
    assert aligned.closer_to_normal == 8
    scattered = summarise_axes(axes_by_earthquake(cube_of(make_cube, sector, [0, 23, 45, 68, 90, -68, -45, -23])))
    assert scattered.rayleigh.p_value > 0.9
    assert scattered.mean_axis_half_width_deg > 45
    assert scattered.alignment_interval[0] < 0 < scattered.alignment_interval[1]


def test_bootstrap_interval_covers() -> None:
    """Of samples from a known distribution about nine tenths of the 90 % intervals hold its mean axis."""
    import xarray as xr

    generator, held = np.random.default_rng(5), 0
    for _ in range(200):
        angle = np.degrees(generator.vonmises(math.radians(40), 4.0, size=12)) / 2
        axes = xr.Dataset({"axis": ("event", angle)}, coords={"event": [str(i) for i in range(12)]})
        summary = summarise_axes(axes, level=0.9, draws=400)
        held += abs((summary.mean_axis_deg - 20 + 90) % 180 - 90) <= summary.mean_axis_half_width_deg
    assert 0.80 <= held / 200 <= 0.97


def test_pulse_against_control(make_cube, sector) -> None:
    pulse = axes_by_earthquake(cube_of(make_cube, sector, [0, 5, -5, 8, -8, 3, 6, -2]))
    names = ["E0", "E1", "C2", "C3", "C4", "C5", "C6", "C7"]
    control = axes_by_earthquake(cube_of(make_cube, sector, [90, 70, 85, -80, 60, 88, 75, -85], events=names))
    difference = compare_alignment(pulse, control)
    assert difference.difference > 1.5
    assert difference.interval[0] > 1
    assert (difference.n_first, difference.n_second) == (8, 8)
    same = compare_alignment(pulse, pulse)
    assert same.difference == 0
    assert same.interval == (0, 0)  # the same earthquakes are drawn for both


def test_no_interval_from_few(make_cube, sector) -> None:
    few = axes_by_earthquake(cube_of(make_cube, sector, [0, 5, 10, 15, 20, 25, 30]))
    assert np.isnan([*compare_alignment(few, few).interval, *summarise_axes(few).alignment_interval]).all()


def test_the_same_numbers_each_time(make_cube, sector) -> None:
    axes = axes_by_earthquake(cube_of(make_cube, sector, [0, 20, -30, 45, 60, -50, 70, 5]))
    assert summarise_axes(axes) == summarise_axes(axes)
