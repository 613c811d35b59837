"""Half of the azimuths give the same statistics as all: φ and φ + 180° are one plane."""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.figures.cells import extend_azimuths_to_full_circle
from overturning.figures.explore import explorer_page_data
from overturning.figures.rose import fall_roses_by_group_figure
from overturning.findings.exactness import ensemble_findings
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.settings import EnsembleSettings, StonePopulation
from overturning.statistics.earthquakes import fall_axes_from_fault_normal_by_earthquake
from overturning.statistics.elements import compare_falls_of_two_stones_over_earthquakes, count_falls_of_two_stones
from overturning.statistics.falls import (
    mask_of_blocks_for_direction_statistics,
    mean_fall_directions_and_axes_over_azimuths,
    mean_fall_probability_over_directions,
)
from overturning.statistics.opposite_azimuths import (
    fall_count_or_probability_by_fall_azimuth,
    overturned_shares_by_record,
)
from overturning.surveys.population import population_outcome_rates_by_record
from overturning.surveys.prediction import SiteFallPrediction
from overturning.surveys.stones import Stone

AZIMUTHS_DEG = np.arange(0, 360, 5)
INDICES_OF_AZIMUTHS_BELOW_180_DEG, INDICES_OF_AZIMUTHS_FROM_180_DEG = (
    np.flatnonzero(AZIMUTHS_DEG < 180),
    np.flatnonzero(AZIMUTHS_DEG >= 180),
)
DIMENSIONS = ("record", "azimuth", "height", "b_over_h", "friction")
BLOCK_PARAMETER_DIMENSIONS = ["height", "b_over_h", "friction"]


def copy_of_full_circle_cube() -> xr.Dataset:
    """Return a copy of the random cube of all azimuths, whose statistics are compared with those of its halves."""
    return random_cube_with_mirrored_half_circle().copy(deep=True)


@cache
def random_cube_with_mirrored_half_circle() -> xr.Dataset:
    """Return a cube of two records: random outcomes below 180°, their mirror images at the opposite azimuths."""
    generator = np.random.default_rng(3)
    shape = (2, INDICES_OF_AZIMUTHS_BELOW_180_DEG.size, 2, 4, 2)
    flag = generator.choice([-1.0, 0.0, 1.0, np.nan], size=shape, p=[0.25, 0.4, 0.25, 0.1])
    towards = np.where(generator.random(shape) < 0.5, generator.integers(0, 25, shape) / 24, np.nan)
    away = (1 - towards) * generator.integers(0, 2, shape)
    gaps = generator.random((2, *shape)) / 10
    slip, time = generator.normal(size=shape), np.where(np.abs(flag) == 1, 10 * generator.random(shape), np.nan)
    pairs = {
        "overturned": (flag, -flag), "residual_slip": (slip, -slip), "overturning_time": (time, time),
        "peak_rotation": (time, time), "members": (np.full(shape, 24.0),) * 2,
        "probability_towards": (towards, away), "probability_away": (away, towards),
        "scramble_difference_towards": gaps, "scramble_difference_away": gaps[::-1],
    }  # fmt: skip
    coordinates: dict[str, Any] = {
        "azimuth": AZIMUTHS_DEG.astype(np.int16), "height": [0.6, 0.9], "b_over_h": [0.3, 0.4, 0.5, 0.6],
        "friction": [0.5, 0.9],
        "record_id": ("record", ["a", "b"]), "event": ("record", ["A", "B"]), "station": ("record", ["s", "t"]),
        "fault_normal": ("record", [60.0, 215.0]), "pulse": ("record", [1, 1]),
    }  # fmt: skip
    return xr.Dataset({name: (DIMENSIONS, np.concatenate(pair, axis=1)) for name, pair in pairs.items()}, coordinates)


def rose_bar_heights(cube: xr.Dataset) -> list[float]:
    """Return the heights of all bars of the roses that show the falls of a cube."""
    return [bar.get_height() for axes in fall_roses_by_group_figure(cube).axes for bar in axes.patches]


def ensemble_findings_of_cube(cube: xr.Dataset) -> object:
    """Return the findings on the ensemble of a cube, as in a report."""
    study = SimpleNamespace(ensemble=EnsembleSettings())
    results = SimpleNamespace(
        reference_element_cube=cube, model=default_model_of_same_kind_as_results_cube(cube), study=study
    )
    return ensemble_findings(results)  # type: ignore[arg-type]


def predicted_azimuth_and_side_probabilities(cube: xr.Dataset) -> np.ndarray:
    """Return the predicted probabilities of fall azimuths, and of fall sides of a stone that faces 252°."""
    site = SiteFallPrediction(cube.isel(record=[0]))
    stone = Stone(fell=True, fall_azimuth_deg=0, has_octant_direction=False, b_over_h=0.3, face_azimuth_deg=252)
    return np.concatenate(
        [site.sector_probabilities_given_fall_for_unknown_face(), site.standing_and_side_probabilities(stone)]
    )


STATISTICS_EXACTLY_EQUAL_FOR_HALF_CIRCLE = {
    "population": lambda cube: population_outcome_rates_by_record(cube, StonePopulation(stones=256)),
    "population that faces 250": lambda cube: population_outcome_rates_by_record(
        cube, StonePopulation(stones=64, face=250, face_spread=0)
    ),
    "falls": fall_count_or_probability_by_fall_azimuth,
    "blocks that only just fall": mask_of_blocks_for_direction_statistics,
    "maps": extend_azimuths_to_full_circle,
    "explorer": explorer_page_data,
    "report of the ensemble": ensemble_findings_of_cube,
}
STATISTICS_NEARLY_EQUAL_FOR_HALF_CIRCLE = {
    "shares": lambda cube: mean_fall_probability_over_directions(cube, summed_dims=BLOCK_PARAMETER_DIMENSIONS),
    "means": lambda cube: mean_fall_directions_and_axes_over_azimuths(cube, summed_dims=BLOCK_PARAMETER_DIMENSIONS),
    "axes": fall_axes_from_fault_normal_by_earthquake,
    "prediction": predicted_azimuth_and_side_probabilities,
    "roses": rose_bar_heights,
}


@cache
def compute_statistic_of_full_circle_cube(name: str) -> Any:
    """Compute the named statistic of the cube of all azimuths, with which the statistic of each half is compared."""
    return (STATISTICS_EXACTLY_EQUAL_FOR_HALF_CIRCLE | STATISTICS_NEARLY_EQUAL_FOR_HALF_CIRCLE)[name](
        copy_of_full_circle_cube()
    )


@pytest.mark.parametrize(
    "half",
    [INDICES_OF_AZIMUTHS_BELOW_180_DEG, INDICES_OF_AZIMUTHS_FROM_180_DEG, np.arange(9, 45)],
    ids=["0…175", "180…355", "45…220"],
)
@pytest.mark.parametrize("name", [*STATISTICS_EXACTLY_EQUAL_FOR_HALF_CIRCLE, *STATISTICS_NEARLY_EQUAL_FOR_HALF_CIRCLE])
def test_half_of_the_azimuths_gives_the_statistics_of_the_full_circle(name: str, half: np.ndarray) -> None:
    found = (STATISTICS_EXACTLY_EQUAL_FOR_HALF_CIRCLE | STATISTICS_NEARLY_EQUAL_FOR_HALF_CIRCLE)[name](
        copy_of_full_circle_cube().isel(azimuth=half)
    )
    expected = compute_statistic_of_full_circle_cube(name)
    if not isinstance(expected, (xr.Dataset, xr.DataArray)):
        assert (
            found == expected
            if name in STATISTICS_EXACTLY_EQUAL_FOR_HALF_CIRCLE
            else np.allclose(found, expected, rtol=1e-6, atol=0)
        )
    elif name in STATISTICS_EXACTLY_EQUAL_FOR_HALF_CIRCLE:
        xr.testing.assert_identical(found, expected)
    else:
        xr.testing.assert_allclose(found, expected, rtol=1e-6)


def test_a_stone_facing_250_degrees_uses_the_outcome_of_the_plane_at_70() -> None:
    """A stone that faces 250° stands if the blocks in the planes of 70° and 160° stand.

    Blocks fall in all other planes, so that stones that face 175° or 245° fall.
    """
    cube = copy_of_full_circle_cube().isel(azimuth=INDICES_OF_AZIMUTHS_BELOW_180_DEG)
    stands = cube["azimuth"].isin([70, 160])
    cube["overturned"] = xr.where(stands, 0.0, 1.0).broadcast_like(cube["overturned"]).transpose(*DIMENSIONS)
    cube["overturning_time"] = cube["overturned"].where(cube["overturned"] != 0)
    rates = {
        face: population_outcome_rates_by_record(cube, StonePopulation(face=face, face_spread=0, stones=64))
        for face in (250, 175, 245)
    }
    assert [float(found["fall_rate"].max()) for found in rates.values()] == [0, 1, 1]


def full_circle_cube_without_mirror_symmetry(
    falls: Callable[[np.ndarray], np.ndarray], azimuth: np.ndarray = AZIMUTHS_DEG
) -> xr.Dataset:
    """Return a cube of one record and a stone before a wall: `falls` gives the overturning flag for each azimuth.

    The flag is 1, 0 or −1. The wall behind the stone breaks the mirror symmetry: the opposite motion is another case.
    """
    cube = copy_of_full_circle_cube().isel(record=[0], azimuth=np.flatnonzero(np.isin(AZIMUTHS_DEG, azimuth)))
    cube = cube[["overturned", "overturning_time", "residual_slip"]].load()
    flag = np.asarray(falls(azimuth), float)[None, :, None, None, None]
    cube["overturned"] = (DIMENSIONS, np.broadcast_to(flag, cube["overturned"].shape))
    cube["overturning_time"] = (DIMENSIONS, np.where(flag == 0, np.nan, 3.0) + 0 * cube["overturned"].values)
    cube["azimuth"].attrs["period"] = 360.0
    return cube


def test_prediction_for_a_stone_in_front_of_a_wall_never_uses_the_opposite_azimuth() -> None:
    """Blocks fall towards every azimuth, so that a stone that faces 250° falls forwards or to its right.

    The stone would fall backwards if the outcome of the opposite azimuth, 70°, were used.
    """
    stone = Stone(fell=True, fall_azimuth_deg=0, has_octant_direction=False, b_over_h=0.3, face_azimuth_deg=250)
    cube = full_circle_cube_without_mirror_symmetry(np.ones_like)
    stood, forwards, right, backwards, left = SiteFallPrediction(
        cube, random_outcome_stone_share=0
    ).standing_and_side_probabilities(stone)
    assert (stood, backwards, left) == (0, 0, 0)
    assert forwards + right == pytest.approx(1)


def test_fall_directions_predicted_in_front_of_walls_are_only_those_simulated() -> None:
    """Stones that face 180° to 355° fall backwards, towards 0° to 175°; the others stand."""
    prediction = SiteFallPrediction(
        full_circle_cube_without_mirror_symmetry(lambda azimuth: np.where(azimuth >= 180, -1, 0)),
        random_outcome_stone_share=0,
    )
    density = prediction.sector_probabilities_given_fall_for_unknown_face()
    assert density[prediction.azimuth < 180].sum() == pytest.approx(1)


def test_unsimulated_half_circle_of_an_asymmetric_scene_stays_missing() -> None:
    """Only the azimuths from 0° to 175° are simulated: for a stone that faces 250° the outcome is unknown."""
    half = full_circle_cube_without_mirror_symmetry(np.ones_like, AZIMUTHS_DEG[INDICES_OF_AZIMUTHS_BELOW_180_DEG])
    stone = Stone(fell=True, fall_azimuth_deg=0, has_octant_direction=False, b_over_h=0.3, face_azimuth_deg=250)
    assert SiteFallPrediction(half, random_outcome_stone_share=0).standing_and_side_probabilities(stone).tolist() == [
        0.5,
        *[0.125] * 4,
    ]
    populations = {face: StonePopulation(face=face, face_spread=0, stones=64) for face in (60, 250)}
    rates = {face: population_outcome_rates_by_record(half, stones) for face, stones in populations.items()}
    assert {face: float(found["unknown"].max()) for face, found in rates.items()} == {60: 0, 250: 1}
    flags = extend_azimuths_to_full_circle(half)["overturned"]
    assert flags.sel(azimuth=AZIMUTHS_DEG[INDICES_OF_AZIMUTHS_BELOW_180_DEG]).notnull().all()
    assert flags.sel(azimuth=slice(180, None)).isnull().all()


def test_missing_outcomes_are_not_filled_from_the_opposite_azimuth(
    make_cube_from_fall_rules: Callable[..., xr.Dataset],
) -> None:
    cube = make_cube_from_fall_rules(
        lambda azimuth, *_: np.where(azimuth < 180, np.nan, 1.0), azimuth=[0, 90, 180, 270]
    )
    assert fall_count_or_probability_by_fall_azimuth(cube).isel(azimuth=[0, 1]).isnull().all()


@pytest.mark.parametrize(
    "azimuths",
    [
        sorted([*range(0, 360, 45), 91, 92, 93, 94, 95, 96]),  # `also` of a study
        list(range(0, 250, 10)),  # the planes from 0 to 60° are given twice
        [0, 10, 20, 100],
    ],
    ids=len,
)
def test_comparison_of_two_stones_weights_azimuths_like_fall_shares(
    make_cube_from_fall_rules, azimuths: list[int]
) -> None:
    def cube_of_stone_falling_between_azimuths(first: int, last: int) -> xr.Dataset:
        """Return a cube of stones that, for B/H up to 0.3, fall in the planes from `first` to below `last`, degrees."""

        def falls_near_axis_signed_by_half_circle(
            azimuth: np.ndarray, _: np.ndarray, slender: np.ndarray, __: np.ndarray
        ) -> np.ndarray:
            falls = (azimuth % 180 >= first) & (azimuth % 180 < last) & (slender < 0.35)
            return np.where(falls, np.where(azimuth < 180, 1.0, -1.0), 0.0)

        cube = make_cube_from_fall_rules(
            falls_near_axis_signed_by_half_circle,
            azimuth=azimuths,
            height=[0.6],
            b_over_h=[0.2, 0.3, 0.4],
            friction=[1.0],
        )
        return cube.assign(overturning_time=cube["overturned"] * 0 + last)

    this, other = cube_of_stone_falling_between_azimuths(0, 95), cube_of_stone_falling_between_azimuths(15, 130)
    counts = count_falls_of_two_stones(this, other)
    found = compare_falls_of_two_stones_over_earthquakes(counts, np.array(["one"]))
    here, there = (float(overturned_shares_by_record(cube)[0]) for cube in (this, other))
    assert counts["compared"].item() == 3 * len(azimuths)
    assert 0.1 < here < 0.9
    assert found.share_of_cases_only_this_falls.mean + found.share_of_cases_both_fall.mean == pytest.approx(
        here, abs=1e-7
    )
    assert found.share_of_cases_only_other_falls.mean + found.share_of_cases_both_fall.mean == pytest.approx(
        there, abs=1e-7
    )
    assert found.this_earlier_share_if_both_fall.mean == 1.0
