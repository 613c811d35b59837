"""Fall axes over earthquakes."""

import math

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.alignment_by_rule import fault_normal_alignments_by_record_group
from overturning.statistics.circular import ROSE_SECTOR_COUNT
from overturning.statistics.earthquakes import (
    difference_in_mean_alignment_with_fault_normal,
    fall_axes_from_fault_normal_by_earthquake,
    mean_fall_directions_and_axes_by_record,
    summarise_fall_axes,
)
from overturning.statistics.falls import (
    ALL_BLOCKS_RULE,
    BLOCK_SELECTION_RULES_IN_REPORT,
    BLOCKS_FALLING_IN_AT_MOST_HALF_PLANES_RULE,
)
from overturning.statistics.roses import fall_rose


@pytest.fixture
def fall_axes_function_of_fault_normal_offsets(make_cube_from_fall_rules, make_sector_fall_rule):
    """Return a function that computes fall axes by earthquake from the offsets of the falls of each record, degrees.

    An offset is the angle from the fault normal of the record to the axis along which its blocks fall.
    """

    def fall_axes_from_fault_normal_of_offset_sectors(offsets, *, normals=None, events=None):
        normals = [20.0 + 37 * i for i in range(len(offsets))] if normals is None else normals
        rules = [make_sector_fall_rule(normal + offset, 10) for normal, offset in zip(normals, offsets, strict=True)]
        names = [f"E{i}" for i in range(len(offsets))] if events is None else events
        return fall_axes_from_fault_normal_by_earthquake(
            make_cube_from_fall_rules(rules, azimuth=range(360), events=names, fault_normal=normals)
        )

    return fall_axes_from_fault_normal_of_offset_sectors


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
def test_fall_axis_is_measured_from_the_fault_normal(
    fall_axes_function_of_fault_normal_offsets, offsets, more, expected
) -> None:
    found = fall_axes_function_of_fault_normal_offsets(offsets, **more)
    assert found["axis"].values == pytest.approx(expected, abs=1e-6)
    assert found["records"].values.tolist() == [len(offsets) - len(expected) + 1, *[1] * (len(expected) - 1)]
    assert summarise_fall_axes(found).mean_cos_of_doubled_angle_to_fault_normal.earthquake_count == len(expected)


def test_sample_size_excludes_records_without_falls_or_fault_normal(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    cube = make_cube_from_fall_rules(
        [make_sector_fall_rule(60, 10)] * 4, azimuth=range(360), events="ABCD", fault_normal=[60, 60, 60, math.nan]
    )
    cube["overturned"][{"record": 1}] = 0
    summary = summarise_fall_axes(fall_axes_from_fault_normal_by_earthquake(cube))
    assert (summary.earthquake_count, summary.mean_cos_of_doubled_angle_to_fault_normal.earthquake_count) == (4, 2)
    assert math.isnan(summary.mean_axis_interval_half_width_deg)
    nothing = summarise_fall_axes(
        fall_axes_from_fault_normal_by_earthquake(cube.assign(overturned=0 * cube["overturned"]))
    )
    assert nothing.mean_cos_of_doubled_angle_to_fault_normal.earthquake_count == 0
    assert np.isnan(
        [nothing.mean_axis_from_fault_normal_deg, nothing.mean_cos_of_doubled_angle_to_fault_normal.mean]
    ).all()


def test_fall_axes_use_only_blocks_that_fall_in_some_planes_and_are_weighted_by_resultant(
    make_cube_from_fall_rules,
) -> None:
    """B/H 0.1 falls in every plane; B/H 0.3 near one axis or, in the last earthquake, near two perpendicular axes.

    The expected values are computed by numpy from the azimuths in which B/H 0.3 falls.
    """
    offsets, normals = [[0], [20, 20], [60], [3, 91]], [10.0, 70.0, 130.0, 40.0]
    planes = np.arange(0, 180, 2)

    def fall_rule_about_normal(normal: float, offset: list[int]):
        def signed_falls_near_axes(azimuth, height, slender, friction):
            near = [np.abs((azimuth - normal - one + 90) % 180 - 90) <= 14 for one in offset]
            side = np.where(azimuth < 180, 1, -1)
            return np.where((slender < 0.2) | ((slender == 0.3) & np.any(near, axis=0)), side, 0)

        return signed_falls_near_axes

    rules = [fall_rule_about_normal(*one) for one in zip(normals, offsets, strict=True)]
    more = {"azimuth": range(0, 360, 2), "b_over_h": (0.1, 0.3, 0.5), "fault_normal": normals}
    cube = make_cube_from_fall_rules(rules, events="ABCD", **more)
    doubled = []
    for normal, offset in zip(normals, offsets, strict=True):
        apart = planes - normal
        fell = [one for one in apart if any(abs((one - each + 90) % 180 - 90) <= 14 for each in offset)]
        doubled.append(np.exp(2j * np.radians(fell)).mean())
    found = fall_axes_from_fault_normal_by_earthquake(cube)
    assert found["cosine"].values == pytest.approx(np.real(doubled))
    assert found["resultant"].values == pytest.approx(np.abs(doubled))
    assert np.abs(doubled[-1]) < 0.05
    assert np.isfinite(found["axis"].values).tolist() == [True, True, True, False]
    summary = summarise_fall_axes(found)
    assert (
        summary.mean_cos_of_doubled_angle_to_fault_normal.earthquake_count,
        summary.earthquakes_with_axis,
        summary.earthquakes_with_axis_within_45_deg_of_normal,
    ) == (4, 3, 2)
    assert summary.mean_cos_of_doubled_angle_to_fault_normal.mean == pytest.approx(np.mean(np.real(doubled)))
    by_shape = fall_axes_from_fault_normal_by_earthquake(cube, "b_over_h")
    assert by_shape["falls"].sum("event").values.tolist() == [
        4,
        4,
        0,
    ]  # slender blocks fall everywhere and do not indicate a direction
    assert by_shape["axis"].count("event").values.tolist() == [0, 3, 0]
    # A record without marginal blocks counts with all its falls, which are isotropic.
    (alone,) = fall_axes_from_fault_normal_by_earthquake(cube.isel(record=[0], b_over_h=[0]))["resultant"].values
    assert alone == pytest.approx(0.0, abs=1e-9)


def test_alignment_cannot_exceed_the_resultant_of_its_records(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    """The alignment is at most the mean resultant of the records, reached if all fall along the fault normal.

    If blocks fall in planes within w of an axis, at steps of s, the resultant of the doubled axes is
    sin(2w + s)/((2w/s + 1) sin s).
    """

    def expected_resultant_of_fall_axes_1_deg_apart(half_width: int) -> float:
        return np.sin(np.radians(2 * half_width + 1)) / ((2 * half_width + 1) * np.sin(np.radians(1)))

    widths, normals = (10, 40, 20, 30), np.array([20.0, 20.0, 75.0, 110.0])
    cube = [
        make_cube_from_fall_rules(
            [make_sector_fall_rule(a + b, width) for a, b, width in zip(normals, offsets, widths, strict=True)],
            azimuth=range(360), events="AABC", fault_normal=normals,
        )
        for offsets in ([0, 0, 0, 0], [0, 90, 30, 60])
    ]  # fmt: skip
    largest = np.mean(
        [
            (expected_resultant_of_fall_axes_1_deg_apart(10) + expected_resultant_of_fall_axes_1_deg_apart(40)) / 2,
            expected_resultant_of_fall_axes_1_deg_apart(20),
            expected_resultant_of_fall_axes_1_deg_apart(30),
        ]
    )
    along, aside = (summarise_fall_axes(fall_axes_from_fault_normal_by_earthquake(one)) for one in cube)
    assert along.mean_resultant_length_of_doubled_fall_axes == pytest.approx(largest)
    assert along.mean_cos_of_doubled_angle_to_fault_normal.mean == pytest.approx(largest), (
        "it is reached where all fall along the normal"
    )
    # Two records of one earthquake that fall across each other allow no less: the axes need not have been.
    assert aside.mean_resultant_length_of_doubled_fall_axes == pytest.approx(largest)
    cosines = [
        (expected_resultant_of_fall_axes_1_deg_apart(10) - expected_resultant_of_fall_axes_1_deg_apart(40)) / 2,
        0.5 * expected_resultant_of_fall_axes_1_deg_apart(20),
        -0.5 * expected_resultant_of_fall_axes_1_deg_apart(30),
    ]
    assert aside.mean_cos_of_doubled_angle_to_fault_normal.mean == pytest.approx(np.mean(cosines))


def test_alignment_is_computed_for_each_rule_that_selects_blocks(make_cube_from_fall_rules) -> None:
    """B/H 0.1 falls in all planes, 0.2 in 5/6, 0.3 in 2/5 and 0.4 in 1/10 of them, each about an axis of its own.

    Numpy computes the expected values.

    Under the second record, of an earthquake of its own, only B/H 0.1 and 0.2 fall.
    """
    share = {0.1: 1.0, 0.2: 5 / 6, 0.3: 2 / 5, 0.4: 1 / 10}
    axis, normals = {0.1: 0.0, 0.2: 20.0, 0.3: 50.0, 0.4: 80.0}, np.array([10.0, 130.0])
    planes = np.arange(0, 180, 1.0)

    def is_in_fall_range_of_b_over_h(azimuth: np.ndarray, normal: float, slender: float) -> np.ndarray:
        apart = np.abs((azimuth - normal - axis[slender] + 89.5) % 180 - 90)
        return apart < 90 * share[slender]

    def fall_rule_with_own_axis_for_each_b_over_h(normal: float, most: float):
        def falls_near_axis_signed_by_half_circle(azimuth, height, slender, friction):
            fell = np.zeros(azimuth.shape, bool)
            for one in share:
                fell |= (slender == one) & is_in_fall_range_of_b_over_h(azimuth, normal, one) & (one <= most)
            return np.where(fell, np.where(azimuth < 180, 1, -1), 0)

        return falls_near_axis_signed_by_half_circle

    cube = make_cube_from_fall_rules(
        [fall_rule_with_own_axis_for_each_b_over_h(10.0, 0.4), fall_rule_with_own_axis_for_each_b_over_h(130.0, 0.2)],
        azimuth=range(360), b_over_h=tuple(share), events="AB", fault_normal=normals
    )  # fmt: skip

    def mean_doubled_axis_vector_from_fault_normal(record: int, shapes: list[float]) -> complex:
        doubled = [
            2j * np.radians(planes[is_in_fall_range_of_b_over_h(planes, normals[record], one)] - normals[record])
            for one in shapes
        ]
        return np.exp(np.concatenate(doubled)).mean()

    every, some, half = [0.1, 0.2, 0.3, 0.4], [0.2, 0.3, 0.4], [0.3, 0.4]
    chosen = [(half, every[:2]), (half, None), ([0.4], None), (some, [0.2]), (every, every[:2])]
    ((group, found),) = fault_normal_alignments_by_record_group(cube).items()
    assert (group, [one.rule for one in found]) == ("all records", list(BLOCK_SELECTION_RULES_IN_REPORT))
    for one, shapes in zip(found, chosen, strict=True):
        means = [mean_doubled_axis_vector_from_fault_normal(record, own) for record, own in enumerate(shapes) if own]
        assert (one.records_with_falls_and_fault_normal, one.mean_cos_of_doubled_angle.earthquake_count) == (
            len(means),
            len(means),
        )
        assert one.mean_cos_of_doubled_angle.mean == pytest.approx(np.mean(np.real(means)), abs=1e-6)
        assert one.mean_resultant_length_of_doubled_fall_axes == pytest.approx(np.mean(np.abs(means)), abs=1e-6)
        assert math.isnan(one.mean_cos_of_doubled_angle.interval_low), "two earthquakes are too few for an interval"
    # The rule of the report is that of the alignment elsewhere, with its interval.
    many = xr.concat([cube.isel(record=[0])] * 9, "record").assign_coords(event=("record", list("ABCDEFGHI")))
    many["fault_normal"] = ("record", 10.0 + 7.0 * np.arange(9))
    own = fault_normal_alignments_by_record_group(many, [BLOCKS_FALLING_IN_AT_MOST_HALF_PLANES_RULE])["all records"][0]
    summary = summarise_fall_axes(fall_axes_from_fault_normal_by_earthquake(many))
    assert own.mean_cos_of_doubled_angle == summary.mean_cos_of_doubled_angle_to_fault_normal
    assert own.mean_resultant_length_of_doubled_fall_axes == pytest.approx(
        summary.mean_resultant_length_of_doubled_fall_axes
    )
    assert (
        own.mean_cos_of_doubled_angle.interval_low
        < own.mean_cos_of_doubled_angle.mean
        < own.mean_cos_of_doubled_angle.interval_high
    )
    assert (
        fault_normal_alignments_by_record_group(many, [ALL_BLOCKS_RULE])["all records"][
            0
        ].mean_resultant_length_of_doubled_fall_axes
        < own.mean_resultant_length_of_doubled_fall_axes
    )


def test_fall_rose_weights_earthquakes_equally_and_omits_blocks_that_fall_in_all_planes(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """Under seven earthquakes blocks fall in eleven planes about 0°, under two records of an eighth in one at 90°."""
    rules = [make_sector_fall_rule(0, 5)] * 7 + [make_sector_fall_rule(90, 0)] * 2
    cube = make_cube_from_fall_rules(rules, azimuth=range(360), events="ABCDEFGHH")
    rose = fall_rose(cube)
    assert (rose.fall_count, rose.count_of_earthquakes_with_falls) == (7 * 11 * 20 + 2 * 20, 8)
    shares = np.zeros(24)
    shares[[0, 6]] = 7 / 8, 1 / 8  # sectors of 15°, the first about north
    assert rose.mean_fall_share_by_sector == pytest.approx(shares)
    assert rose.share_interval_low_by_sector[6] == 0
    # The 1 − Φ(−√(8/7) t₀.₉₇₅,₇) = 99.4 % quantile of B(8, 1/8) is 4: at most 3 have 98.9 %.
    assert rose.share_interval_high_by_sector[6] == pytest.approx(4 / 8, abs=0.001)
    # Blocks that fall in all planes, to every side, do not blur it.
    slender = cube.isel(b_over_h=[0]).assign(overturned=1 + 0 * cube["overturned"].isel(b_over_h=[0]))
    slender["overturned"][{"azimuth": slice(180, None)}] = -1
    together = xr.concat([cube, slender.assign_coords(b_over_h=[0.05])], "b_over_h", data_vars="minimal")
    assert fall_rose(together).mean_fall_share_by_sector == pytest.approx(shares)


def test_rose_sector_with_the_same_share_in_all_earthquakes_has_exact_bounds(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """A rose sector with the share 1 or 0 in all earthquakes has an interval with exact, unequal bounds.

    All falls lie along the fault normal (regression: the intervals had zero width).
    """
    cube = make_cube_from_fall_rules([make_sector_fall_rule(60, 5)] * 9, events="ABCDEFGHI", fault_normal=60.0)
    rose = fall_rose(cube, measure_from_fault_normal=True, axial=True)
    bound = 0.05 ** (1 / 9)  # nine of nine earthquakes have it with a probability of 5 %
    assert rose.mean_fall_share_by_sector.tolist() == [1.0] + [0.0] * 11
    assert (rose.share_interval_low_by_sector[0], rose.share_interval_high_by_sector[0]) == (pytest.approx(bound), 1.0)
    assert rose.share_interval_low_by_sector[1:].tolist() == [0.0] * 11
    assert rose.share_interval_high_by_sector[1:] == pytest.approx(np.full(11, 1 - bound))
    few = fall_rose(cube.isel(record=range(7)), measure_from_fault_normal=True, axial=True)
    assert np.isnan([few.share_interval_low_by_sector, few.share_interval_high_by_sector]).all()


@pytest.mark.parametrize("step", [5, 10, 15, 20, 30, 45])
@pytest.mark.parametrize("from_normal", [False, True])
def test_rose_of_falls_in_all_directions_is_round_for_any_azimuth_step(
    make_cube_from_fall_rules, step, from_normal
) -> None:
    """Regression: with a step of 10° every second rose sector held two azimuths, with 30° every second none."""

    def falls_in_all_directions(azimuth: np.ndarray, _: np.ndarray, __: np.ndarray, friction: np.ndarray) -> np.ndarray:
        return np.where(friction < 0.5, 1, -1) * np.where(azimuth < 180, 1, -1)

    cube = make_cube_from_fall_rules(falls_in_all_directions, azimuth=range(0, 360, step), fault_normal=60.0)
    assert fall_rose(cube, measure_from_fault_normal=from_normal).mean_fall_share_by_sector == pytest.approx(
        np.full(ROSE_SECTOR_COUNT, 1 / ROSE_SECTOR_COUNT)
    )


def test_aligned_fall_axes_have_a_mean_axis_and_scattered_ones_none(
    fall_axes_function_of_fault_normal_offsets,
) -> None:
    offsets = [-12, -7, -3, 2, 6, 9, 14, 4]
    aligned = summarise_fall_axes(fall_axes_function_of_fault_normal_offsets(offsets))
    assert abs(aligned.mean_axis_from_fault_normal_deg) < 3
    assert aligned.mean_axis_interval_half_width_deg < 10
    assert aligned.mean_cos_of_doubled_angle_to_fault_normal.interval_low > 0.8
    assert aligned.earthquakes_with_axis_within_45_deg_of_normal == aligned.earthquakes_with_axis == 8
    # Planes within 10° of its axis, of each degree, fall under each.
    doubled = np.exp(2j * np.radians(offsets)).mean() * np.cos(2 * np.radians(np.arange(-10, 11))).mean()
    assert aligned.mean_axis_from_fault_normal_deg == pytest.approx(np.degrees(np.angle(doubled)) / 2)
    assert aligned.mean_cos_of_doubled_angle_to_fault_normal.mean == pytest.approx(doubled.real)
    scattered = summarise_fall_axes(fall_axes_function_of_fault_normal_offsets([0, 23, 45, 68, 90, -68, -45, -23]))
    assert math.isnan(scattered.mean_axis_from_fault_normal_deg)
    assert (
        scattered.mean_cos_of_doubled_angle_to_fault_normal.interval_low
        < 0
        < scattered.mean_cos_of_doubled_angle_to_fault_normal.interval_high
    )
    assert str(
        summarise_fall_axes(fall_axes_function_of_fault_normal_offsets([0, 23, 45, 68, 90, -68, -45, -23]))
    ) == str(scattered)  # the same each time


def test_bootstrap_interval_covers_the_mean_axis_at_its_level() -> None:
    """For samples from a known distribution about 90 % of the 90 % intervals cover the mean axis."""
    generator, held = np.random.default_rng(5), 0
    for _ in range(200):
        angle = np.degrees(generator.vonmises(math.radians(40), 4.0, size=12)) / 2
        parts = {"cosine": np.cos(np.radians(2 * angle)), "sine": np.sin(np.radians(2 * angle)), "axis": angle}
        parts["largest"] = np.ones(12)
        axes = xr.Dataset(
            {name: ("event", values) for name, values in parts.items()}, {"event": [str(i) for i in range(12)]}
        )
        summary = summarise_fall_axes(axes, confidence_level=0.9, bootstrap_sample_count=400)
        held += (
            abs((summary.mean_axis_from_fault_normal_deg - 20 + 90) % 180 - 90)
            <= summary.mean_axis_interval_half_width_deg
        )
    assert 0.80 <= held / 200 <= 0.97


def test_difference_of_alignment_of_pulse_and_control_groups_has_an_interval(
    fall_axes_function_of_fault_normal_offsets,
) -> None:
    pulse = fall_axes_function_of_fault_normal_offsets([0, 5, -5, 8, -8, 3, 6, -2])
    names = ["E0", "E1", "C2", "C3", "C4", "C5", "C6", "C7"]
    difference = difference_in_mean_alignment_with_fault_normal(
        pulse, fall_axes_function_of_fault_normal_offsets([90, 70, 85, -80, 60, 88, 75, -85], events=names)
    )
    assert difference.mean > 1.5
    assert difference.interval_low > 1
    assert difference.earthquake_count == 8
    same = difference_in_mean_alignment_with_fault_normal(pulse, pulse)
    # The same earthquakes are drawn for both; the difference is 0 in 0.05^(1/8) of all earthquakes, else within ±2.
    assert (same.mean, same.interval_low, same.interval_high) == pytest.approx(
        (0, *(2 * one * (1 - 0.05 ** (1 / 8)) for one in (-1, 1)))
    )
    few = fall_axes_function_of_fault_normal_offsets([0, 5, 10, 15, 20, 25, 30])
    assert np.isnan(
        [
            difference_in_mean_alignment_with_fault_normal(few, few).interval_low,
            summarise_fall_axes(few).mean_cos_of_doubled_angle_to_fault_normal.interval_low,
        ]
    ).all()


@pytest.mark.parametrize(
    ("unknown_planes", "half_width", "imposed"),
    [
        (range(0, 90, 5), 90, True),  # falls in all other planes: their mean axis, 132.5°, is that of these planes
        (range(0, 45, 5), 30, True),  # as many unknown as fallen
        (range(0, 180, 10), 30, False),  # spread over the half circle: they impose nothing
        ([0, 5], 30, False),  # few against the twelve falls
        ([], 30, False),
    ],
)
def test_axis_is_omitted_if_unknown_outcomes_on_one_side_could_impose_it(
    make_cube_from_fall_rules, make_sector_fall_rule, unknown_planes, half_width: float, imposed: bool
) -> None:
    """The fall axis of a record is missing if unknown outcomes in some planes could impose it.

    Planes are 5° apart; under the first record the outcomes of both blocks are unknown in the given planes, under the
    second record all are known.
    """
    whole = make_cube_from_fall_rules(
        [make_sector_fall_rule(120, half_width), make_sector_fall_rule(120, 30)],
        azimuth=range(0, 360, 5), b_over_h=(0.1, 0.2), events="AB", fault_normal=[120.0, 120.0],
    )  # fmt: skip
    unknown = whole["azimuth"].isin([*unknown_planes, *(one + 180 for one in unknown_planes)]) & (whole["record"] == 0)
    cube = whole.assign(overturned=whole["overturned"].where(~unknown))
    means = mean_fall_directions_and_axes_by_record(cube)
    assert means["is_imposed"].values.tolist() == [imposed, False]
    assert np.isnan(means["mean_axis"].values).tolist() == [imposed, False]
    assert means["mean_axis"].values[1] == pytest.approx(120.0)
    axes = fall_axes_from_fault_normal_by_earthquake(cube)
    assert np.isnan(axes["cosine"].values).tolist() == [imposed, False]
    rules = fault_normal_alignments_by_record_group(cube, [ALL_BLOCKS_RULE])["all records"]
    assert rules[0].records_with_falls_and_fault_normal == 2 - imposed
