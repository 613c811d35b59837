"""The rigid block against closed forms and SciPy's integrator on real records; bit-equal mirror images."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.near_field import strong_part_of_near_field_record
from tests.dem.reference.rigid_impact import fall_side_and_peak_rotation, normalised_restoring_moment
from verification.reference.closed_forms import (
    angular_velocity_after_over_before_impact,
    rocking_frequency_parameter,
)

G = STANDARD_GRAVITY


def closed_form_peak_rotation_under_half_sine(strength: float, frequency_ratio: float) -> float:
    """Return the largest θ/α of a slender block under a half sine, from its closed form; inf if it overturns.

    The half sine has ω = `frequency_ratio` · p and `strength` times the rocking threshold as amplitude. Solution of
    θ̈ = p² (θ − α + a/g) from lift-off, free motion after the pulse (Housner 1963, section 4); NaN if the block
    turns back during the pulse.
    """
    lift_off = math.asin(1.0 / strength)
    share, end = 1.0 / (1.0 + frequency_ratio**2), (math.pi - lift_off) / frequency_ratio  # time in 1/p
    a, b = strength * frequency_ratio * math.cos(lift_off) * share, -(frequency_ratio**2) * share
    away = a * math.sinh(end) + b * math.cosh(end)
    rate = a * math.cosh(end) + b * math.sinh(end) + strength * frequency_ratio * share
    if rate < 0.0:
        return math.nan
    return math.inf if away + rate > 0.0 else 1.0 - math.sqrt(away**2 - rate**2)


@pytest.mark.parametrize("ratio", [3.0, 6.0, 8.0])
def test_a_slender_block_under_a_half_sine_follows_the_closed_form(ratio: float) -> None:
    height, slender, samples = 1.0, 0.01, 1000
    period = math.pi / (ratio * float(rocking_frequency_parameter(height, slender)))
    wave = np.append(np.sin(np.pi * np.arange(samples + 1) / samples), 0.0)
    motion = Motion(wave, 0 * wave, sampling_interval=period / samples, trust_data=True)
    strengths = np.linspace(1.1, 12.0, 110)
    found = simulate_rigid_rocking(motion, Cases(0.0, height, slender, 1.0, amplitude=strengths * slender * G))
    expected = np.array([closed_form_peak_rotation_under_half_sine(strength, ratio) for strength in strengths])
    falls, stands = np.isinf(expected), np.isfinite(expected)
    assert falls.sum() > 8
    assert stands.sum() > 8
    np.testing.assert_array_equal(found.overturned, -1 * falls)
    np.testing.assert_allclose(found.peak_rotation[stands], expected[stands], rtol=5e-4)


def fall_side_and_peak_rotation_by_scipy(motion: Motion, height: float, b_over_h: float) -> tuple[int, float]:
    """Return the fall side (±1, 0: none) and largest |θ|/α of a block rocking along north, by SciPy's DOP853."""
    alpha, square = math.atan(b_over_h), rocking_frequency_parameter(height, b_over_h) ** 2
    time = np.arange(motion.sample_count + 3) * motion.sampling_interval
    waves = [np.append(wave, np.zeros(3)) / G for wave in (motion.north, motion.up)]
    fine = np.arange(0.0, time[-1], motion.sampling_interval / 64)
    excess = np.abs(np.interp(fine, time, waves[0])) - b_over_h * (1.0 + np.interp(fine, time, waves[1]))
    now, end, peak = 0.0, time[-1] + 8.0 / math.sqrt(square), 0.0
    state, side = [0.0, 0.0], 0
    while now < end:
        if side == 0:
            later = np.flatnonzero((fine >= now) & (excess > 0))
            if not later.size:
                break
            now, state = fine[later[0]], [0.0, 0.0]
            side = -1 if np.interp(now, time, waves[0]) > 0 else 1

        def sliding_plate_state_derivative(t: float, y: np.ndarray, side: int = side) -> list[float]:
            """Return the time derivatives of a rocking block's rotation and angular velocity."""
            return [
                y[1],
                -square * normalised_restoring_moment(t, alpha * side - y[0], *waves, motion.sampling_interval),
            ]

        def landing_event(t: float, y: np.ndarray, side: int = side) -> float:
            """Event function: 0 where the block lands on its base."""
            return y[0] * side

        def fall_event(t: float, y: np.ndarray) -> float:
            """Event function: 0 where the block lies on its side."""
            return abs(y[0]) - 0.5 * math.pi

        landing_event.terminal, landing_event.direction, fall_event.terminal = True, -1, True
        how = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11, "max_step": motion.sampling_interval}
        done = solve_ivp(
            sliding_plate_state_derivative,
            (now, end),
            state,
            events=(landing_event, fall_event),
            dense_output=True,
            **how,
        )
        peak = max(peak, float(np.abs(done.sol(np.linspace(now, done.t[-1], 2000))[0]).max()))
        now = done.t[-1]
        if done.t_events[1].size:
            return side, 0.5 * math.pi / alpha
        state = [0.0, angular_velocity_after_over_before_impact(b_over_h) * done.y[1, -1]]
        side = -side if abs(state[1]) > 1e-5 * math.sqrt(square) else 0
    return 0, peak / alpha


@pytest.mark.parametrize(
    ("number", "height", "b_over_h", "factor"),
    [(9, 0.6, 0.25, 1.0), (9, 1.2, 0.45, 1.0), (7, 0.6, 0.3, 1.5), (10, 2.0, 0.15, 1.0), (6, 0.02, 0.5, 2.0),
     (6, 0.6, 1.0, 3.0)],
)  # fmt: skip
def test_rocking_under_records_agrees_with_scipy(number: int, height: float, b_over_h: float, factor: float) -> None:
    """One block is only 2 cm high, so that a sample is divided into several steps."""
    part = strong_part_of_near_field_record(number, 2.0, 3.0)
    north, up = factor * part.north, 0.5 * factor * part.east
    motion = Motion(north, 0 * north, up, sampling_interval=part.sampling_interval, trust_data=True)
    found = simulate_rigid_rocking(motion, Cases([0.0, 180.0], height, b_over_h, 1.0))
    side, peak = fall_side_and_peak_rotation_by_scipy(motion, height, b_over_h)
    assert found.overturned.tolist() == [side, -side]
    assert found.peak_rotation[0] == pytest.approx(peak, rel=1e-3 if side == 0 else 1e-9)
    assert peak > 0.05


def test_mirrored_or_separate_rigid_cases_have_bit_equal_peak_rotations() -> None:
    part = strong_part_of_near_field_record(9, 2.0, 6.0)
    motion = Motion(part.north, part.east, 0.4 * part.north, sampling_interval=part.sampling_interval)
    azimuth, ratio = (one.ravel() for one in np.meshgrid(np.arange(0.0, 360.0, 10.0), [0.1, 0.25, 0.4, 1.5]))
    found = simulate_rigid_rocking(motion, Cases(azimuth, 0.6, ratio, 1.0))
    assert np.unique(found.overturned).size == 3
    turned = simulate_rigid_rocking(motion, Cases((azimuth + 180.0) % 360.0, 0.6, ratio, 1.0))
    np.testing.assert_array_equal(turned.overturned, -found.overturned)
    np.testing.assert_array_equal(turned.peak_rotation, found.peak_rotation)
    alone = simulate_rigid_rocking(motion, Cases(azimuth[5:6], 0.6, ratio[5:6], 1.0))
    assert alone.peak_rotation.tobytes() == found.peak_rotation[5:6].tobytes()


def test_a_block_released_from_a_tilt_never_exceeds_it() -> None:
    quiet = Motion(np.zeros(4000), np.zeros(4000), sampling_interval=0.005)
    found = simulate_rigid_rocking(quiet, Cases(0.0, 1.0, 0.3, 1.0, initial_tilt=[0.1, -0.1]))
    assert found.overturned.tolist() == [0, 0]
    np.testing.assert_array_equal(found.peak_rotation, 0.1 / np.round(np.arctan(0.3), 12))


def block_fall_side_and_peak_rotation_by_small_steps(
    along: np.ndarray, interval: float, height: float, b_over_h: float
) -> tuple[int, float]:
    """Return the fall side and largest |θ|/α of a block by short Runge–Kutta steps, with bisection at impacts."""
    alpha, square = math.atan(b_over_h), rocking_frequency_parameter(height, b_over_h) ** 2
    wave = np.append(along, 0.0) / G
    return fall_side_and_peak_rotation(
        wave, interval, b_over_h, alpha, float(square), float(angular_velocity_after_over_before_impact(b_over_h))
    )


@pytest.mark.parametrize(
    ("start", "interval", "height", "b_over_h"),
    [([-1.1, 8.0], 0.02, 0.6, 0.2), ([-1.01, 8.0], 0.005, 0.6, 0.2), ([0.0, -1.2, 8.0, 0.0, -3.0], 0.01, 0.4, 0.3),
     ([0.0, 1.028, -4.054, 2.816], 0.01, 1.2659, 0.1608), ([0.0, -1.115, 1.672, 0.522], 0.005, 0.4155, 0.2649)],
)  # fmt: skip
def test_a_block_that_changes_motion_twice_within_a_sample_agrees_with_small_steps(
    start: list[float], interval: float, height: float, b_over_h: float
) -> None:
    """The first three blocks lift off and land within one sampling interval; the others turn back twice in one."""
    along = np.append(start, np.zeros(round(0.4 / interval))) * b_over_h * G
    motion = Motion(along, 0 * along, sampling_interval=interval, trust_data=True)
    found = simulate_rigid_rocking(motion, Cases([0.0, 180.0], height, b_over_h, 1.0))
    side, peak = block_fall_side_and_peak_rotation_by_small_steps(along, interval, height, b_over_h)
    assert found.overturned.tolist() == [side, -side]
    assert found.peak_rotation == pytest.approx([peak, peak], rel=5e-3)


@cache
def fall_sides_and_peaks_under_resampled_noise(refinement_factor: int) -> list[np.ndarray]:
    """Return fall sides and peaks, shape (2, 3 amplitudes, 40 blocks), of 9 noise records sampled more finely."""
    generator, answers = np.random.default_rng(5), []
    for interval in (0.005, 0.01, 0.02):
        for strength in (3.0, 6.0, 12.0):
            along = generator.normal(size=round(1.5 / interval)) * strength
            along[-1] = 0.0
            fine = np.interp(
                np.arange((along.size - 1) * refinement_factor + 1) / refinement_factor, np.arange(along.size), along
            )
            height, ratio = np.exp(generator.uniform(-1.2, 1.1, 40)), generator.uniform(0.05, 0.4, 40)
            motion = Motion(fine, 0 * fine, sampling_interval=interval / refinement_factor, trust_data=True)
            amplitude = np.repeat([0.999, 1.0, 1.001], 40)
            found = simulate_rigid_rocking(
                motion, Cases(0.0, np.tile(height, 3), np.tile(ratio, 3), 1.0, amplitude=amplitude)
            )
            answers.append(np.stack([found.overturned, found.peak_rotation]).reshape(2, 3, 40))
    return answers


@pytest.mark.parametrize("parts", [2, 3, 5, 10])
def test_linear_interpolation_of_a_record_changes_no_fall_and_no_peak(parts: int) -> None:
    """The records are white noise; chaotic cases, whose peak changes with 0.1 % of amplitude, are left out."""
    cells, worst = 0, 0.0
    for coarse, split in zip(
        fall_sides_and_peaks_under_resampled_noise(1), fall_sides_and_peaks_under_resampled_noise(parts), strict=True
    ):
        robust = np.ptp(split[1], axis=0) < 0.01
        np.testing.assert_array_equal(coarse[0][1, robust], split[0][1, robust])
        cells += int(robust.sum())
        worst = max(worst, float(np.abs(coarse[1] - split[1])[1, robust].max()))
    assert cells > 200
    assert worst < 1e-3
