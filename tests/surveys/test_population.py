"""Fall rates of populations with known stones."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.stats import binomtest, norm

from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate
from overturning.findings.population import share_of_compared_motions_with_interval
from overturning.model.cases import Cases
from overturning.model.model import StoneOutcomesByAmplitudeFactor
from overturning.motion.motion import Motion
from overturning.settings import LengthRange, StonePopulation
from overturning.statistics.bootstrap import mean_share_over_earthquakes
from overturning.surveys.population import (
    SampledStones,
    choose_neighbouring_grid_indices_at_random,
    fall_rates_of_stones_with_outcome_in_both_cubes,
    fit_population_fragility_curves,
    outcome_rates_at_each_amplitude_factor,
    population_outcome_rates_by_record,
    sample_stones,
    share_of_stones_outside_grid,
    take_stone_outcomes_from_neighbouring_cases,
)
from overturning.units import STANDARD_GRAVITY

SAMPLING_INTERVAL = 0.01


def motion_of_one_sine_cycle_after_rest(peak: float, period: float, azimuth_deg: float = 0.0) -> Motion:
    """Return a motion: one sine cycle of a peak, m/s², and a period, s, along an azimuth, degrees."""
    sine = peak * np.sin(2 * np.pi * np.arange(0, period + SAMPLING_INTERVAL, SAMPLING_INTERVAL) / period)
    sine = np.concatenate([sine, np.zeros(5)])
    phi = np.radians(azimuth_deg)
    return Motion(sine * np.cos(phi), sine * np.sin(phi), sampling_interval=SAMPLING_INTERVAL)


def test_sampled_stones_have_the_sizes_of_the_population() -> None:
    population = StonePopulation(face=90, face_spread=5, stones=512)
    stones = sample_stones(population)
    assert stones.height.mean() == pytest.approx(0.75, abs=0.002)
    width = stones.height * stones.b_over_h
    assert (width.min() >= 0.3, width.max() <= 0.4) == (True, True)
    assert (np.abs(stones.face_azimuth_deg - 90) <= 5).all()
    # Square plan, independent width and height: the mean of B/H is E[B] E[1/H].
    assert stones.b_over_h.mean() == pytest.approx(0.35 * np.log(0.9 / 0.6) / 0.3, rel=0.002)


def simulated_cube(motion: Motion, **axes: list[float]) -> xr.Dataset:
    """Simulate blocks of these heights, B/H and frictions under a motion in planes every 15°."""
    return simulate(motion, azimuth_deg=np.arange(0, 360, 15), **axes)


def test_a_stone_falls_in_the_plane_of_the_pulse() -> None:
    # A pulse towards the east throws a slender stone west, or east after an impact: never north or south.
    stones = stones_of_equal_height_shape_friction_and_face(0.7, 0.15, 0.8, 0.0, count=2)
    stones = replace(stones, face_azimuth_deg=np.array([90.0, 0.0]))
    size = {"height": [0.7], "b_over_h": [0.15], "friction": [0.8]}
    weak, strong = (
        take_stone_outcomes_from_neighbouring_cases(
            simulated_cube(motion_of_one_sine_cycle_after_rest(4.0, 1.0, 90).scaled_by(f), **size), stones
        )
        for f in (0.01, 1.0)
    )
    assert not weak.fell.any()
    assert strong.fell.all()
    assert np.isnan(weak.fall_azimuth_deg).all()
    assert np.abs(np.sin(np.radians(strong.fall_azimuth_deg[0]))) == pytest.approx([1, 1])


def test_fall_rate_from_a_cube_matches_stones_simulated_singly() -> None:
    """A population's fall rate from a cube is within 0.03 of that of its stones simulated one by one.

    The cube is a grid of B/H, heights and µ.
    """
    population = StonePopulation(width=LengthRange(low=0.1, high=0.3), face=0, face_spread=0, stones=1024)
    motion = motion_of_one_sine_cycle_after_rest(4.0, 0.8)
    stones = sample_stones(population)
    cells = simulate(
        motion,
        azimuth_deg=[0, 90, 180, 270],
        height=np.arange(0.6, 0.91, 0.1),
        b_over_h=np.arange(0.1, 0.51, 0.025),
        friction=[0.5, 0.7, 0.9],
    )
    found = outcome_rates_at_each_amplitude_factor(
        take_stone_outcomes_from_neighbouring_cases(cells, stones), population
    )
    # The motion has no component across, so the plane along it decides alone.
    alone = run_cases(motion, Cases(0.0, stones.height, stones.b_over_h, stones.friction))
    assert found["fall_rate"][0] == pytest.approx(np.mean(alone.overturned != 0), abs=0.03)
    low, high = found["fall_interval"][0]
    assert 0 < low < found["fall_rate"][0] < high < 1
    known = binomtest(round(1024 * found["fall_rate"][0]), 1024).proportion_ci(method="wilson")
    assert (low, high) == pytest.approx((known.low, known.high))
    assert found["fall_octant"].sum(axis=1) == pytest.approx(found["fall_rate"])
    assert np.abs(np.sin(np.radians(found["fall_axis"]))) == pytest.approx([0], abs=1e-9)


def test_2d_model_gives_no_shift_rate_where_the_3d_model_finds_sliding() -> None:
    """The 2-D model gives no shift rate for a motion under which a stone slides only in 3-D.

    With µ = 0.3 and B/H = 0.8, half a sine of 0.28 g along each of two axes, 0.4 g together, makes a stone slide by
    Coulomb's law only in 3-D.
    """
    along = 0.28 * STANDARD_GRAVITY * np.sin(np.pi * np.arange(101) / 100)
    motion = Motion(along, along, sampling_interval=SAMPLING_INTERVAL)
    size = {"height": [0.5], "b_over_h": [0.8], "friction": [0.3]}
    stone, few = stones_of_equal_height_shape_friction_and_face(0.5, 0.8, 0.3, 0.0), StonePopulation(shifted=0.01)
    planes = outcome_rates_at_each_amplitude_factor(
        take_stone_outcomes_from_neighbouring_cases(simulate(motion, azimuth_deg=[0, 90, 180, 270], **size), stone), few
    )
    space = outcome_rates_at_each_amplitude_factor(
        take_stone_outcomes_from_neighbouring_cases(simulate(motion, "rectangle", orientation_deg=[0], **size), stone),
        few,
    )
    assert planes["fall_rate"] == space["fall_rate"] == [0]
    assert space["shift_rate"] == [1]
    assert np.isnan([planes["shift_rate"], planes["rotation_rate"]]).all()
    assert np.isnan(planes["shift_interval"]).all()


def test_randomly_chosen_neighbour_cells_average_to_linear_interpolation() -> None:
    lot = (np.arange(1000) + 0.5) / 1000
    place = choose_neighbouring_grid_indices_at_random(np.array([0.2, 0.4, 1.0]), np.full(1000, 0.55), lot)
    assert set(place) == {1, 2}
    assert place.mean() == pytest.approx(1.25)
    assert (
        choose_neighbouring_grid_indices_at_random(np.array([0.2, 0.4]), np.array([0.1, 0.9]), lot[:2]) == [0, 1]
    ).all()


def cube_with_values_as_flags_and_fall_times(values: np.ndarray, **grid: list[float]) -> xr.Dataset:
    """Return a cube of one record whose overturning flags and fall times both have the given values.

    The blocks are 0.6 m high unless `grid` has other heights.
    """
    grid = {"azimuth": [0, 90], "height": [0.6], "b_over_h": [0.4], "friction": [0.7]} | grid
    return xr.Dataset({name: (tuple(grid), values) for name in ("overturned", "overturning_time")}, grid)


def stones_of_equal_height_shape_friction_and_face(*size: float, count: int = 1) -> SampledStones:
    """Return equal stones of a height, B/H, µ and face, with evenly spaced random numbers."""
    lot = np.tile((np.arange(count) + 0.5) / count, (3, 1))
    return SampledStones(*(np.full(count, value) for value in size), lot)


def test_rocking_stone_takes_no_outcome_from_a_case_where_blocks_slide() -> None:
    """With µ = 0.5, between the grid values 0.33 and 0.58, a stone of B/H 0.4 rocks as at 0.58 and falls.

    One of B/H 0.55 slides and stands.
    """
    values = np.zeros((4, 1, 2, 3))
    values[:, :, :, 1] = 1  # only at µ = 0.58 it falls
    site = cube_with_values_as_flags_and_fall_times(
        values, azimuth=[0, 90, 180, 270], b_over_h=[0.4, 0.55], friction=[0.33, 0.58, 1.0]
    )
    assert take_stone_outcomes_from_neighbouring_cases(
        site, stones_of_equal_height_shape_friction_and_face(0.6, 0.4, 0.5, 0.0, count=200)
    ).fell.all()
    assert not take_stone_outcomes_from_neighbouring_cases(
        site, stones_of_equal_height_shape_friction_and_face(0.6, 0.55, 0.5, 0.0, count=200)
    ).fell.any()


@pytest.mark.parametrize("flag", [1, 0, np.nan])
def test_stone_with_an_unknown_outcome_in_one_plane_has_no_outcome(flag: float) -> None:
    """A stone has no known outcome if that of the blocks in one of its planes is unknown.

    The outcome in plane 90° is unknown: whatever happens in plane 0°, a fall over the other edge may have come first.
    """
    found = take_stone_outcomes_from_neighbouring_cases(
        cube_with_values_as_flags_and_fall_times(np.reshape([flag, np.nan], (2, 1, 1, 1))),
        stones_of_equal_height_shape_friction_and_face(0.6, 0.4, 0.7, 0.0),
    )
    assert (found.trajectory_has_known_outcome.item(), found.fell.item()) == (False, False)


def test_stones_without_an_outcome_have_no_fall_rate() -> None:
    known, untold = np.array([[False, False], [True, False]]), np.full((2, 2), np.nan)
    found = outcome_rates_at_each_amplitude_factor(
        StoneOutcomesByAmplitudeFactor(~known & known, known, untold, untold, untold), StonePopulation()
    )
    np.testing.assert_array_equal(found["fall_rate"], [np.nan, 0.0])
    np.testing.assert_array_equal(found["fall_octant"], [[np.nan] * 8, [0.0] * 8])
    assert found["unknown"].tolist() == [1.0, 0.5]


@pytest.mark.parametrize("fixed", [0.0, 0.3])
def test_fall_rates_of_two_cubes_count_only_stones_known_in_both(fixed: float) -> None:
    """Low stones fall, tall ones stand, in both cubes; one cube lacks the outcomes of the low ones."""
    heights = np.tile([1.0, 0.0], (2, 1)).reshape(2, 2, 1, 1)
    low, high = (
        cube_with_values_as_flags_and_fall_times(np.where(heights == lost, np.nan, heights), height=[0.6, 0.9])
        for lost in (1.0, 2.0)
    )
    names = {"record_id": ("record", ["a"]), "event": ("record", ["e"])}
    lacking, whole = (one.expand_dims("record").assign_coords(names) for one in (low, high))
    population = StonePopulation(stones=64, fixed=fixed)
    alone = population_outcome_rates_by_record(whole, population)["fall_rate"].sel(amplitude=1.0).to_numpy()
    assert alone == pytest.approx([0.5 * (1 - fixed)], abs=0.1)
    assert fall_rates_of_stones_with_outcome_in_both_cubes(whole, lacking, population) == ([0.0], [0.0])
    for same in fall_rates_of_stones_with_outcome_in_both_cubes(whole, whole, population):
        np.testing.assert_array_equal(same, alone)
    nothing = lacking.assign(overturned=lacking["overturned"] * np.nan)
    assert np.isnan(fall_rates_of_stones_with_outcome_in_both_cubes(whole, nothing, population)).all()


@pytest.mark.parametrize("fixed", [0.0, 0.3])
def test_shares_of_shifted_and_rotated_stones_match_hand_counts(fixed: float) -> None:
    """Of four square stones one falls, one is shifted, one is rotated, and one is both shifted and rotated.

    Turning all faces by 90° or 270° changes no share. If 30 % of the stones are fixed to their base, the shares are
    70 % of those of free stones.
    """
    free = 1 - fixed
    values = {"overturned": [1, 0, 0, 0], "fall_azimuth": [40, np.nan, np.nan, np.nan], "residual_twist": [np.nan, 2,
    -30, 30],
              "residual_slip_north": [9, 0.03, 0, 0.03], "residual_slip_east": [9, 0.04, 0, 0.04]}  # fmt: skip
    grid = {"orientation": [0, 30, 45, 60], "height": [0.7], "b_over_h": [0.5], "aspect": [1.0], "friction": [0.7]}
    site = xr.Dataset({name: (tuple(grid), np.reshape(v, (4, 1, 1, 1, 1))) for name, v in values.items()}, grid)
    for turn in (0, 90, 270):
        face = np.array([1.0, 29.0, 44.0, 61.0]) + turn
        stones = replace(
            stones_of_equal_height_shape_friction_and_face(0.7, 0.5, 0.7, 0.0, count=4), face_azimuth_deg=face
        )
        found = outcome_rates_at_each_amplitude_factor(
            take_stone_outcomes_from_neighbouring_cases(site, stones), StonePopulation(fixed=fixed)
        )
        assert found["fall_rate"] == pytest.approx([0.25 * free], rel=1e-15)
        assert found["free_fall_rate"] == [0.25]
        assert found["shift_rate"] == found["rotation_rate"] == [0.5 * free]
        assert found["fall_octant"][0].tolist() == [0, *found["fall_rate"], 0, 0, 0, 0, 0, 0]
        for rate, interval in (("fall_rate", "fall_interval"), ("shift_rate", "shift_interval")):
            share = found[rate][0]  # Wilson: the ends p hold (p - share)² = z² p (1 - p) / n
            for end in found[interval][0]:
                assert (end - share) ** 2 == pytest.approx(norm.ppf(0.975) ** 2 * end * (1 - end) / 4)


@pytest.mark.parametrize(("b_over_h", "outside"), [(0.33, 0.0), (0.3333, 0.0), (0.34, 0.0), (0.32, 1.0), (0.35, 1.0)])
def test_a_size_that_equals_a_rounded_grid_value_is_not_outside_the_grid(b_over_h: float, outside: float) -> None:
    grid = xr.Dataset(coords={"height": [0.75], "b_over_h": [b_over_h], "friction": [0.7]})
    assert (
        share_of_stones_outside_grid(
            grid, stones_of_equal_height_shape_friction_and_face(0.75, 0.25 / 0.75, 0.7, 0.0, count=4)
        )
        == outside
    )


def test_fall_rates_are_computed_for_each_amplitude_factor() -> None:
    """Stones that fall under a motion multiplied by 2 fall at the amplitude factor 2 of the cube."""
    motion, population = (
        motion_of_one_sine_cycle_after_rest(3.0, 0.8),
        StonePopulation(width=LengthRange(low=0.1, high=0.3), stones=64),
    )
    axes = {"height": [0.6, 0.9], "b_over_h": [0.1, 0.2, 0.3, 0.5], "friction": [0.5, 0.9]}
    both = xr.concat(
        [simulated_cube(motion, **axes), simulated_cube(motion.scaled_by(2.0), **axes)],
        dim=pd.Index([1.0, 2.0], name="amplitude"),
    )
    both = both.expand_dims("record").assign_coords(record_id=("record", ["a"]), event=("record", ["e"]))
    found = population_outcome_rates_by_record(both, population)
    alone = outcome_rates_at_each_amplitude_factor(
        take_stone_outcomes_from_neighbouring_cases(
            simulated_cube(motion.scaled_by(2.0), **axes), sample_stones(population)
        ),
        population,
    )
    assert (
        found["fall_rate"].sel(amplitude=2.0).item()
        == alone["fall_rate"][0]
        > found["fall_rate"].sel(amplitude=1.0).item()
    )
    some = population_outcome_rates_by_record(both, population.model_copy(update={"fixed": 0.3}))
    np.testing.assert_allclose(some["fall_rate"], 0.7 * found["fall_rate"])
    for name in ("free_fall_rate", "class_rate", "unknown", "fall_axis"):
        np.testing.assert_array_equal(some[name], found[name])
    assert found.attrs["outside"] == 0
    assert found["octant"].values.tolist() == [0, 45, 90, 135, 180, 225, 270, 315]


def test_fragility_fits_separate_spread_of_records_from_that_of_stones() -> None:
    """Fragility fits over Sa(0.5 s) and over PGA separate the spread of stones from that of records.

    Fall rates follow a known curve over Sa(0.5 s): the fit over Sa attributes the spread to the stones, the fit over
    PGA much of it to the records.
    """
    generator = np.random.default_rng(3)
    sa, pga = np.geomspace(0.2, 2, 30), np.geomspace(0.2, 2, 30) * np.exp(generator.normal(0, 0.5, 30))
    rate = norm.cdf(np.log(sa / 0.7) / 0.3)[:, None]
    found = xr.Dataset(
        {
            "free_fall_rate": (("record", "amplitude"), rate),
            "class_rate": (("record", "amplitude", "stones"), rate[..., None]),
            "unknown": (("record", "amplitude"), np.zeros_like(rate)),
            "class_unknown": (("record", "amplitude", "stones"), np.zeros_like(rate[..., None])),
        },
        {
            "event": ("record", [f"E{i}" for i in range(30)]),
            "amplitude": [1.0],
            "stones": ["B/H up to 0.5, H up to 0.6 m"],
            "members": ("stones", [100]),
        },
        {"period": [0.5], "members": 200},
    )
    psa = STANDARD_GRAVITY * sa[:, None, None]
    intensity = xr.Dataset(
        {
            "psa_rotd": (("record", "percentile", "period"), psa),
            **dict.fromkeys(("pga_rotd", "pgv_rotd"), (("record", "percentile"), STANDARD_GRAVITY * pga[:, None])),
        },
        {"percentile": [50.0], "period": [0.5]},
    )
    curves = {(one.measure, one.stone_class): one for one in fit_population_fragility_curves(found, intensity)}
    own = curves["SA(0.5)", "all stones"]
    assert (own.unit, own.median, own.spread) == ("g", pytest.approx(0.7, rel=1e-3), pytest.approx(0.3, rel=1e-3))
    assert own.log_std_between_records_and_between_stones[0] < 0.05
    other = curves["PGA", "all stones"]
    assert other.log_std_between_records_and_between_stones[0] > 0.4
    assert np.hypot(*other.log_std_between_records_and_between_stones) == pytest.approx(other.spread)
    # With the outcomes of five stones per record, shares differ by chance, not from record to record.
    fell = generator.binomial(5, rate) / 5
    few = found.assign(free_fall_rate=found["free_fall_rate"].copy(data=fell), unknown=found["unknown"] + 195 / 200)
    few = few.assign(class_rate=few["class_rate"].copy(data=fell[..., None]), class_unknown=few["class_unknown"] + 0.95)
    for one in fit_population_fragility_curves(few, intensity):
        assert one.measure != "SA(0.5)" or one.record_variance_share < 0.1


@pytest.mark.parametrize("agree", [1, 2, 3])
def test_agreement_share_equal_in_all_earthquakes_has_an_interval_of_nonzero_width(agree: int) -> None:
    """In ten earthquakes the same share of motions agrees with the survey rule; the interval still has a width."""
    selected = np.ones((10, 4), np.bool_)
    events = np.array([f"earthquake {number}" for number in range(10)])
    found = share_of_compared_motions_with_interval(np.arange(4) < np.full((10, 1), agree), selected, events)
    assert found.value == agree / 4
    interval = mean_share_over_earthquakes(np.full(10, agree / 4), events)
    assert (found.low, found.high) == (interval.interval_low, interval.interval_high)
    assert found.low < found.value < found.high
