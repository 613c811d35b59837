"""Surveys simulated with a known motion give that motion back, as often as is stated."""

import math
from pathlib import Path

import numpy as np
import pytest

from overturning.dem.cases import Cases
from overturning.dem.run import run_cases
from overturning.errors import ResultError
from overturning.motion.motion import Motion
from overturning.report.sections.backwards import backwards_sentences
from overturning.study.population import Population
from overturning.surveys.inversion import PLANES, STEP_DEG, STOOD, WAYS, Kind, Responses, drawn, first_way
from overturning.surveys.inversion_file import Backwards, read_backwards, write_backwards
from overturning.surveys.stones import Stone

SIZES = ((0.9, 0.2), (1.2, 0.25), (1.6, 0.3))
"""Heights, m, and B/H of the columns of a ruin: four of each."""

AMPLITUDE = np.geomspace(0.5, 4.0, 13)


def pulse(period: float) -> Motion:
    """One sine towards the north, 2 m/s², and rest."""
    time = np.arange(0, period + 0.05, 0.01)
    sine = np.where(time <= period, 2.0 * np.sin(2 * np.pi * time / period), 0.0)
    return Motion(sine, 0 * sine, sampling_interval=0.01)


@pytest.fixture(scope="module")
def motions() -> dict[str, Motion]:
    return {f"{period:g} s": pulse(period) for period in (0.5, 0.8, 1.2)}


@pytest.fixture(scope="module")
def responses(motions: dict[str, Motion]) -> Responses:
    return Responses(motions, [Kind(*size, round=True) for size in SIZES], amplitude=AMPLITUDE)


def column(height: float, shape: float, way: int, noise_deg: float = 0.0) -> Stone:
    """A column that fell a way, or stood."""
    fell = way != STOOD
    azimuth = (STEP_DEG * way + noise_deg) % 360 if fell else math.nan
    return Stone(fell=fell, azimuth_deg=azimuth, octant=False, b_over_h=shape, height=height, round=True)


def test_without_stones_the_posterior_is_the_prior(responses: Responses) -> None:
    prior = np.arange(1.0, 4.0)[:, None, None] * np.linspace(1, 2, 13)[:, None]
    found = responses.posterior([], prior=prior)
    assert found.probability == pytest.approx(found.prior)
    assert found.of_sources() == pytest.approx(np.arange(1, 4) / 6)
    # Even over the factors: the middle 90 % of the logarithm.
    low, high = responses.posterior([]).interval(AMPLITUDE)
    half = np.log(AMPLITUDE[1] / AMPLITUDE[0]) / 2
    width = np.log(4.0 / 0.5) + 2 * half
    assert np.log([low / 0.5, high / 0.5]) == pytest.approx([0.05 * width - half, 0.95 * width - half])


def test_turning_the_survey_turns_the_azimuth(responses: Responses) -> None:
    def survey(turn: int) -> list[Stone]:
        return [column(*size, (way + turn) % WAYS) for size, way in zip(SIZES, (0, 1, PLANES), strict=True)]

    first, turned = (responses.posterior(survey(turn)).of_azimuths() for turn in (0, 7))
    assert turned == pytest.approx(np.roll(first, 7))


def test_a_pulse_along_north_throws_along_north(responses: Responses) -> None:
    found = responses.posterior([column(*size, way) for size in SIZES for way in (0, 0, 0, PLANES)])
    axis = np.radians(2 * found.azimuth)
    mean = np.hypot(*(found.of_azimuths() @ np.column_stack([np.cos(axis), np.sin(axis)])))
    assert mean > 0.8
    assert np.argmax(found.of_azimuths()) % PLANES in (0, 1, PLANES - 1)


def test_stones_that_stand_bound_the_motion_from_above(responses: Responses) -> None:
    stood = responses.posterior([column(*size, STOOD) for size in SIZES] * 4).interval(AMPLITUDE)
    fell = responses.posterior([column(*size, 0) for size in SIZES] * 4).interval(AMPLITUDE)
    everything = responses.posterior([]).interval(AMPLITUDE)
    assert stood[1] < 0.7 * everything[1]
    assert fell[0] > 1.5 * everything[0]


def test_fixed_stones_say_less(responses: Responses) -> None:
    stones = [column(*size, STOOD) for size in SIZES] * 4
    bound, loose = (responses.posterior(stones, fixed=share).interval(AMPLITUDE)[1] for share in (0.0, 0.8))
    assert loose > bound


def simulated(motion: Motion, amplitude: float, turn: int, generator: np.random.Generator) -> list[Stone]:
    """Twelve columns under a motion that the responses have not seen: own friction, shape and measured direction each."""
    stones, plane = [], STEP_DEG * np.arange(PLANES)
    sizes = [size for size in SIZES for _ in range(4)]
    rows = [drawn(Kind(*size, round=True), Population(seed=int(generator.integers(1 << 30))), 1) for size in sizes]
    height, shape, friction = (np.repeat(np.concatenate(values), PLANES) for values in zip(*rows, strict=True))
    found = run_cases(motion, Cases(np.tile(plane, 12), height, shape, friction, amplitude=amplitude))
    ways = first_way(found.overturned.reshape(12, -1), found.overturning_time.reshape(12, -1), np.arange(PLANES))
    for size, way in zip(sizes, ways, strict=True):
        turned = STOOD if way == STOOD else (way + turn) % WAYS
        if generator.random() < 0.05:  # the share of stones that do anything
            turned = STOOD if generator.random() < 0.5 else int(generator.integers(WAYS))
        stones.append(column(*size, turned, generator.normal(0, 10)))
    return stones


def test_the_stated_interval_covers_the_truth_as_often_as_it_says(
    motions: dict[str, Motion], responses: Responses
) -> None:
    generator = np.random.default_rng(5)
    half = np.log(AMPLITUDE[1] / AMPLITUDE[0]) / 2
    inside = 0
    for number in range(300):
        name = list(motions)[number % 3]
        # The truth is drawn from the prior, between the factors that were computed.
        truth = float(np.exp(generator.uniform(np.log(AMPLITUDE[0]) - half, np.log(AMPLITUDE[-1]) + half)))
        stones = simulated(motions[name], truth, int(generator.integers(WAYS)), generator)
        low, high = responses.posterior(stones).interval(AMPLITUDE)
        inside += low <= truth <= high
    print(f"coverage of the 90 % interval: {inside / 300:.3f}")
    assert 0.85 <= inside / 300 <= 0.95


def test_the_file_gives_the_posterior_back(tmp_path: Path, motions: dict[str, Motion], responses: Responses) -> None:
    stones = [column(*SIZES[0], 0), column(*SIZES[1], STOOD)]
    found = Backwards.of("ruin.csv", stones, responses.posterior(stones), motions, 0.1)
    write_backwards(found, tmp_path / "motion.nc")
    back = read_backwards(tmp_path / "motion.nc")
    assert (back.fell, back.stood, back.fixed, back.along_north) == (1, 1, 0.1, True)
    assert back.posterior.probability == pytest.approx(found.posterior.probability)
    # One sine of amplitude A and period T along an axis: PGA A, PGV A T/π.
    assert back.pga == pytest.approx(2.0, rel=5e-3)
    assert back.pgv == pytest.approx(2.0 * np.array([0.5, 0.8, 1.2]) / np.pi, rel=0.01)
    assert backwards_sentences(back)[0].startswith("From 1 stone that fell and 1 that stood, with 90")
    with pytest.raises(ResultError, match="run the study again"):
        read_backwards(tmp_path / "nothing.nc")
