"""The exact rigid block against closed forms, against SciPy's integrator on real records, and bit for bit mirrored."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from overturning.dem.block.rigid import rocking
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.near_field import strong_part
from verification.reference.closed_forms import frequency_parameter, restitution

G = STANDARD_GRAVITY


def slender_under_half_sine(strength: float, ratio: float) -> float:
    """Largest θ/α of a slender block under a half sine of a multiple of its threshold, ω = ratio p; inf: it falls.

    θ̈ = p² (θ − α + a/g) in closed form from the lift-off on, free after the pulse (Housner 1963, section 4);
    not a number where it comes back before the pulse is over.
    """
    lift_off = math.asin(1.0 / strength)
    share, end = 1.0 / (1.0 + ratio**2), (math.pi - lift_off) / ratio  # time in 1/p
    a, b = strength * ratio * math.cos(lift_off) * share, -(ratio**2) * share
    away = a * math.sinh(end) + b * math.cosh(end)
    rate = a * math.cosh(end) + b * math.sinh(end) + strength * ratio * share
    if rate < 0.0:
        return math.nan
    return math.inf if away + rate > 0.0 else 1.0 - math.sqrt(away**2 - rate**2)


@pytest.mark.parametrize("ratio", [3.0, 6.0, 8.0])
def test_a_slender_block_under_a_half_sine_follows_the_closed_form(ratio: float) -> None:
    height, slender, samples = 1.0, 0.01, 4000
    period = math.pi / (ratio * float(frequency_parameter(height, slender)))
    wave = np.append(np.sin(np.pi * np.arange(samples + 1) / samples), 0.0)
    motion = Motion(wave, 0 * wave, sampling_interval=period / samples, trust_data=True)
    strengths = np.linspace(1.1, 12.0, 110)
    found = rocking(motion, Cases(0.0, height, slender, 1.0, amplitude=strengths * slender * G))
    expected = np.array([slender_under_half_sine(strength, ratio) for strength in strengths])
    falls, stands = np.isinf(expected), np.isfinite(expected)
    assert falls.sum() > 8
    assert stands.sum() > 8
    np.testing.assert_array_equal(found.overturned, -1 * falls)
    np.testing.assert_allclose(found.peak_rotation[stands], expected[stands], rtol=5e-4)


def by_scipy(motion: Motion, height: float, b_over_h: float) -> tuple[int, float]:
    """Side and largest |θ|/α along north, by a Runge–Kutta pair of eighth order between events."""
    alpha, square = math.atan(b_over_h), frequency_parameter(height, b_over_h) ** 2
    time = np.arange(motion.samples + 3) * motion.sampling_interval
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

        def slope(t: float, y: np.ndarray, side: int = side) -> list[float]:
            a, up = (np.interp(t, time, wave, right=0.0) for wave in waves)
            lean = alpha * side - y[0]
            return [y[1], -square * ((1.0 + up) * math.sin(lean) + a * math.cos(lean))]

        def lands(t: float, y: np.ndarray, side: int = side) -> float:
            return y[0] * side

        def lies(t: float, y: np.ndarray) -> float:
            return abs(y[0]) - 0.5 * math.pi

        lands.terminal, lands.direction, lies.terminal = True, -1, True
        how = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11, "max_step": motion.sampling_interval}
        done = solve_ivp(slope, (now, end), state, events=(lands, lies), dense_output=True, **how)
        peak = max(peak, float(np.abs(done.sol(np.linspace(now, done.t[-1], 2000))[0]).max()))
        now = done.t[-1]
        if done.t_events[1].size:
            return side, 0.5 * math.pi / alpha
        state = [0.0, restitution(b_over_h) * done.y[1, -1]]
        side = -side if abs(state[1]) > 1e-5 * math.sqrt(square) else 0
    return 0, peak / alpha


@pytest.mark.parametrize(
    ("number", "height", "b_over_h", "factor"),
    [(9, 0.6, 0.25, 1.0), (9, 1.2, 0.45, 1.0), (7, 0.6, 0.3, 1.5), (10, 2.0, 0.15, 1.0), (6, 0.02, 0.5, 2.0),
     (6, 0.6, 1.0, 3.0)],
)  # fmt: skip
def test_under_a_real_record_it_is_scipys_solution(number: int, height: float, b_over_h: float, factor: float) -> None:
    """The fourth is as low as two centimetres, so that a sample is divided."""
    part = strong_part(number, 2.0, 3.0)
    north, up = factor * part.north, 0.5 * factor * part.east
    motion = Motion(north, 0 * north, up, sampling_interval=part.sampling_interval, trust_data=True)
    found = rocking(motion, Cases([0.0, 180.0], height, b_over_h, 1.0))
    side, peak = by_scipy(motion, height, b_over_h)
    assert found.overturned.tolist() == [side, -side]
    assert found.peak_rotation[0] == pytest.approx(peak, rel=1e-3 if side == 0 else 1e-9)
    assert peak > 0.05


def test_a_mirrored_case_and_a_case_among_others_have_the_same_bits() -> None:
    part = strong_part(9, 2.0, 6.0)
    motion = Motion(part.north, part.east, 0.4 * part.north, sampling_interval=part.sampling_interval)
    azimuth, ratio = (one.ravel() for one in np.meshgrid(np.arange(0.0, 360.0, 10.0), [0.1, 0.25, 0.4, 1.5]))
    found = rocking(motion, Cases(azimuth, 0.6, ratio, 1.0))
    assert np.unique(found.overturned).size == 3
    turned = rocking(motion, Cases((azimuth + 180.0) % 360.0, 0.6, ratio, 1.0))
    np.testing.assert_array_equal(turned.overturned, -found.overturned)
    np.testing.assert_array_equal(turned.peak_rotation, found.peak_rotation)
    alone = rocking(motion, Cases(azimuth[5:6], 0.6, ratio[5:6], 1.0))
    assert alone.peak_rotation.tobytes() == found.peak_rotation[5:6].tobytes()


def test_a_tilted_block_at_rest_comes_back_and_swings_less() -> None:
    quiet = Motion(np.zeros(4000), np.zeros(4000), sampling_interval=0.005)
    found = rocking(quiet, Cases(0.0, 1.0, 0.3, 1.0, initial_tilt=[0.1, -0.1]))
    assert found.overturned.tolist() == [0, 0]
    np.testing.assert_array_equal(found.peak_rotation, 0.1 / np.round(np.arctan(0.3), 12))
