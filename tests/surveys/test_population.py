"""Fall rates of a population whose stones are known."""

import numpy as np
import pytest

from overturning.dem.cases import Cases
from overturning.dem.run import run_cases
from overturning.motion.motion import Motion
from overturning.study.population import Population, Spread
from overturning.surveys.population import OUTCOMES, Stones, draw_stones, rates, stone_outcomes

INTERVAL = 0.01


def pulse(peak: float, period: float, azimuth_deg: float = 0.0) -> Motion:
    """One sine towards an azimuth, m/s² and s."""
    sine = peak * np.sin(2 * np.pi * np.arange(0, period + INTERVAL, INTERVAL) / period)
    sine = np.concatenate([sine, np.zeros(5)])
    phi = np.radians(azimuth_deg)
    return Motion(sine * np.cos(phi), sine * np.sin(phi), sampling_interval=INTERVAL)


def test_stones_are_those_of_the_population() -> None:
    population = Population(face=90, face_spread=5, stones=512)
    stones = draw_stones(population)
    assert stones.height.mean() == pytest.approx(0.75, abs=0.002)
    width = stones.height * stones.b_over_h
    assert (width.min() >= 0.3, width.max() <= 0.4) == (True, True)
    assert (np.abs(stones.face - 90) <= 5).all()
    # Square plan, independent width and height: the mean of B/H is E[B] E[1/H].
    assert stones.b_over_h.mean() == pytest.approx(0.35 * np.log(0.9 / 0.6) / 0.3, rel=0.002)


def test_a_stone_falls_in_the_plane_of_the_pulse() -> None:
    # A pulse towards the east throws a slender stone west, or east after an impact: never north or south.
    stones = Stones(np.array([0.7, 0.7]), np.array([0.15, 0.15]), np.array([0.8, 0.8]), np.array([90.0, 0.0]))
    outcome, azimuth = stone_outcomes(pulse(4.0, 1.0, 90), stones, np.array([0.01, 1.0]))
    assert (outcome[0] == OUTCOMES.index("stands")).all()
    assert (outcome[1] == OUTCOMES.index("fell")).all()
    assert np.isnan(azimuth[0]).all()
    assert np.abs(np.sin(np.radians(azimuth[1]))) == pytest.approx([1, 1])


def test_rate_against_stones_one_by_one() -> None:
    population = Population(width=Spread(low=0.1, high=0.3), face=0, face_spread=0, stones=64, amplitude=[0.5, 1.0])
    motion = pulse(4.0, 0.8)
    stones = draw_stones(population)
    found = rates(*stone_outcomes(motion, stones, np.array(population.amplitude)))
    # The motion has no component across, so the plane along it decides alone.
    alone = run_cases(motion, Cases(0.0, stones.height, stones.b_over_h, stones.friction))
    assert found["fall_rate"][1] == pytest.approx(np.mean(alone.overturned != 0))
    assert 0 < found["fall_rate"][1] < 1
    assert found["fall_octant"].sum(axis=1) == pytest.approx(found["fall_rate"])


def test_a_stone_that_slides_is_shifted() -> None:
    # µ far below B/H: it slides and cannot rock.
    stones = Stones(np.array([0.5]), np.array([0.8]), np.array([0.1]), np.array([0.0]))
    outcome, _ = stone_outcomes(pulse(4.0, 1.0), stones, np.array([1.0]), shifted=0.001)
    assert outcome[0, 0] == OUTCOMES.index("shifted")
