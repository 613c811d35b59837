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
from overturning.model.falls import model_of_cube
from overturning.settings import EnsembleSettings, StonePopulation
from overturning.statistics.earthquakes import fall_axes_by_earthquake
from overturning.statistics.elements import count_falls_of_two_stones, mean_fall_contrast
from overturning.statistics.falls import (
    fall_counts_towards_azimuths,
    informative_block_mask,
    mean_fall_directions,
    overturned_shares_by_record,
    shares_of_directions_with_fall,
)
from overturning.surveys.population import population_rates_by_record
from overturning.surveys.prediction import SiteFallPrediction
from overturning.surveys.stones import Stone

AZIMUTH = np.arange(0, 360, 5)
FIRST, SECOND = np.flatnonzero(AZIMUTH < 180), np.flatnonzero(AZIMUTH >= 180)
DIMENSIONS = ("record", "azimuth", "height", "b_over_h", "friction")
BLOCK = ["height", "b_over_h", "friction"]


def whole() -> xr.Dataset:
    """A copy of the cube that is compared with its halves."""
    return made_whole().copy(deep=True)


@cache
def made_whole() -> xr.Dataset:
    """Two records with an ensemble, drawn at random in planes below 180°, the others their mirror images by hand."""
    generator = np.random.default_rng(3)
    shape = (2, FIRST.size, 2, 4, 2)
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
        "azimuth": AZIMUTH.astype(np.int16), "height": [0.6, 0.9], "b_over_h": [0.3, 0.4, 0.5, 0.6],
        "friction": [0.5, 0.9],
        "record_id": ("record", ["a", "b"]), "event": ("record", ["A", "B"]), "station": ("record", ["s", "t"]),
        "fault_normal": ("record", [60.0, 215.0]), "pulse": ("record", [1, 1]),
    }  # fmt: skip
    return xr.Dataset({name: (DIMENSIONS, np.concatenate(pair, axis=1)) for name, pair in pairs.items()}, coordinates)


def of_roses(cube: xr.Dataset) -> list[float]:
    return [bar.get_height() for axes in fall_roses_by_group_figure(cube).axes for bar in axes.patches]


def of_the_ensemble(cube: xr.Dataset) -> object:
    study = SimpleNamespace(ensemble=EnsembleSettings())
    results = SimpleNamespace(cube=cube, model=model_of_cube(cube), study=study)
    return ensemble_findings(results)  # type: ignore[arg-type]


def of_prediction(cube: xr.Dataset) -> np.ndarray:
    site = SiteFallPrediction(cube.isel(record=[0]))
    stone = Stone(fell=True, azimuth_deg=0, octant=False, b_over_h=0.3, face_azimuth_deg=252)
    return np.concatenate([site.fall_sector_probabilities(), site.fall_side_probabilities(stone)])


THE_SAME = {
    "population": lambda cube: population_rates_by_record(cube, StonePopulation(stones=256)),
    "population that faces 250": lambda cube: population_rates_by_record(
        cube, StonePopulation(stones=64, face=250, face_spread=0)
    ),
    "falls": fall_counts_towards_azimuths,
    "blocks that only just fall": informative_block_mask,
    "maps": extend_azimuths_to_full_circle,
    "explorer": explorer_page_data,
    "report of the ensemble": of_the_ensemble,
}
CLOSE = {
    "shares": lambda cube: shares_of_directions_with_fall(cube, summed_dims=BLOCK),
    "means": lambda cube: mean_fall_directions(cube, summed_dims=BLOCK),
    "axes": fall_axes_by_earthquake,
    "prediction": of_prediction,
    "roses": of_roses,
}


@cache
def of_whole(name: str) -> Any:
    """What all azimuths give, which three halves are compared with."""
    return (THE_SAME | CLOSE)[name](whole())


@pytest.mark.parametrize("half", [FIRST, SECOND, np.arange(9, 45)], ids=["0…175", "180…355", "45…220"])
@pytest.mark.parametrize("name", [*THE_SAME, *CLOSE])
def test_half_of_the_azimuths_give_the_same_result(name: str, half: np.ndarray) -> None:
    found, expected = (THE_SAME | CLOSE)[name](whole().isel(azimuth=half)), of_whole(name)
    if not isinstance(expected, (xr.Dataset, xr.DataArray)):
        assert found == expected if name in THE_SAME else np.allclose(found, expected, rtol=1e-6, atol=0)
    elif name in THE_SAME:
        xr.testing.assert_identical(found, expected)
    else:
        xr.testing.assert_allclose(found, expected, rtol=1e-6)


def test_a_stone_that_faces_250_is_answered_by_the_mirrored_plane_70() -> None:
    """Every plane falls towards its azimuth but 70 and 250, which stand; of 160 and 340 a face of 250 stands."""
    cube = whole().isel(azimuth=FIRST)
    stands = cube["azimuth"].isin([70, 160])
    cube["overturned"] = xr.where(stands, 0.0, 1.0).broadcast_like(cube["overturned"]).transpose(*DIMENSIONS)
    cube["overturning_time"] = cube["overturned"].where(cube["overturned"] != 0)
    rates = {
        face: population_rates_by_record(cube, StonePopulation(face=face, face_spread=0, stones=64))
        for face in (250, 175, 245)
    }
    assert [float(found["fall_rate"].max()) for found in rates.values()] == [0, 1, 1]


def before_a_wall(falls: Callable[[np.ndarray], np.ndarray], azimuth: np.ndarray = AZIMUTH) -> xr.Dataset:
    """One record of a scene without mirror image: `falls` (1, 0, −1) of one that faces each of the azimuths.

    Its stone has a wall behind it: under the opposite motion it is another case, that of a scene that faces away.
    """
    cube = whole().isel(record=[0], azimuth=np.flatnonzero(np.isin(AZIMUTH, azimuth)))
    cube = cube[["overturned", "overturning_time", "residual_slip"]].load()
    flag = np.asarray(falls(azimuth), float)[None, :, None, None, None]
    cube["overturned"] = (DIMENSIONS, np.broadcast_to(flag, cube["overturned"].shape))
    cube["overturning_time"] = (DIMENSIONS, np.where(flag == 0, np.nan, 3.0) + 0 * cube["overturned"].values)
    cube["azimuth"].attrs["period"] = 360.0
    return cube


def test_a_stone_before_a_wall_does_not_fall_against_it() -> None:
    """All fall forwards, whatever they face: one that faces 250 never backwards, which is not the answer of 70."""
    stone = Stone(fell=True, azimuth_deg=0, octant=False, b_over_h=0.3, face_azimuth_deg=250)
    cube = before_a_wall(np.ones_like)
    stood, forwards, right, backwards, left = SiteFallPrediction(cube, background=0).fall_side_probabilities(stone)
    assert (stood, backwards, left) == (0, 0, 0)
    assert forwards + right == pytest.approx(1)


def test_directions_of_stones_in_front_of_walls() -> None:
    """Stones that face 180° to 355° fall backwards, towards 0° to 175°; the others stand."""
    prediction = SiteFallPrediction(before_a_wall(lambda azimuth: np.where(azimuth >= 180, -1, 0)), background=0)
    density = prediction.fall_sector_probabilities()
    assert density[prediction.azimuth < 180].sum() == pytest.approx(1)


def test_half_a_circle_leaves_the_other_half_of_a_scene_missing() -> None:
    """A stone that faces 250°, in the gap of 185° between 175° and 0°, has no answer."""
    half = before_a_wall(np.ones_like, AZIMUTH[FIRST])
    stone = Stone(fell=True, azimuth_deg=0, octant=False, b_over_h=0.3, face_azimuth_deg=250)
    assert SiteFallPrediction(half, background=0).fall_side_probabilities(stone).tolist() == [0.5, *[0.125] * 4]
    unknown = {face: population_rates_by_record(half, StonePopulation(face=face, face_spread=0, stones=64))["unknown"]
               for face in (60, 250)}  # fmt: skip
    assert {face: float(found.max()) for face, found in unknown.items()} == {60: 0, 250: 1}
    flags = extend_azimuths_to_full_circle(half)["overturned"]
    assert flags.sel(azimuth=AZIMUTH[FIRST]).notnull().all()
    assert flags.sel(azimuth=slice(180, None)).isnull().all()


def test_missing_outcomes_are_not_copied_from_the_opposite_azimuth(make_cube: Callable[..., xr.Dataset]) -> None:
    cube = make_cube(lambda azimuth, *_: np.where(azimuth < 180, np.nan, 1.0), azimuth=[0, 90, 180, 270])
    assert fall_counts_towards_azimuths(cube).isel(azimuth=[0, 1]).isnull().all()


@pytest.mark.parametrize(
    "azimuths",
    [
        sorted([*range(0, 360, 45), 91, 92, 93, 94, 95, 96]),  # `also` of a study
        list(range(0, 250, 10)),  # the planes from 0 to 60° are given twice
        [0, 10, 20, 100],
    ],
    ids=len,
)
def test_a_comparison_of_two_stones_weighs_azimuths_as_shares_of_falls_do(make_cube, azimuths: list[int]) -> None:
    def stone(first: int, last: int) -> xr.Dataset:
        """Stone of B/H up to 0.3 that falls in the planes from `first` to `last`, degrees."""

        def rule(azimuth: np.ndarray, _: np.ndarray, slender: np.ndarray, __: np.ndarray) -> np.ndarray:
            falls = (azimuth % 180 >= first) & (azimuth % 180 < last) & (slender < 0.35)
            return np.where(falls, np.where(azimuth < 180, 1.0, -1.0), 0.0)

        cube = make_cube(rule, azimuth=azimuths, height=[0.6], b_over_h=[0.2, 0.3, 0.4], friction=[1.0])
        return cube.assign(overturning_time=cube["overturned"] * 0 + last)

    this, other = stone(0, 95), stone(15, 130)
    counts = count_falls_of_two_stones(this, other)
    found = mean_fall_contrast(counts, np.array(["one"]))
    here, there = (float(overturned_shares_by_record(cube)[0]) for cube in (this, other))
    assert counts["compared"].item() == 3 * len(azimuths)
    assert 0.1 < here < 0.9
    assert found.only_this.value + found.both.value == pytest.approx(here, abs=1e-7)
    assert found.only_other.value + found.both.value == pytest.approx(there, abs=1e-7)
    assert found.earlier.value == 1.0
