"""The kernels against closed forms: signs, thresholds, free rocking, sliding, bouncing, flat landings."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import run_cases, simulate_cases
from overturning.dem.trajectory import trajectory
from overturning.model.cases import Cases
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, Contact
from overturning.model.results import CaseResults
from overturning.model.scene import gravestone
from overturning.model.shapes import shape_from_name_or_sides
from overturning.model.status import CaseStatus
from overturning.motion.direction import cosine_and_sine_of_azimuth
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths
from tests.dem.paths import lower_corner_penetrations, trajectory_of_element_named_stone
from tests.dem.reference.particles import final_slip_with_flights_and_landings
from verification.reference.closed_forms import (
    rocking_amplitude_after_impact,
    rocking_threshold_acceleration,
    sliding_threshold_acceleration,
    time_and_velocity_at_end_of_bounce,
    time_from_tilt_to_first_impact,
)
from verification.reference.sliding import peak_and_final_slip

NO_ACCELERATION = np.zeros(400)


def motion_with_linear_ramp_of_north_acceleration(height: float, seconds: float, upward: float = 0.0) -> Motion:
    """Return a motion whose north acceleration, 0 for 1 s, rises linearly to `height` (m/s²) within `seconds`.

    In the first second the upward acceleration rises to `upward` (m/s²), where it stays.
    """
    t = np.arange(int((seconds + 1.0) / 0.005) + 1) * 0.005
    up = upward * np.minimum(t, 1.0)
    north = height * np.clip((t - 1.0) / seconds, 0.0, 1.0)
    return Motion(north, 0 * north, up, sampling_interval=0.005, trust_data=True)


def test_a_block_falls_against_a_steady_base_acceleration() -> None:
    steady = Motion(np.full(400, 4.0), NO_ACCELERATION, sampling_interval=0.005)
    found = run_cases(steady, Cases([0.0, 180.0, 90.0], 0.6, 0.2, 1.0))
    assert found.overturned.tolist() == [-1, 1, 0]


def test_a_block_at_rest_does_not_creep_within_a_minute() -> None:
    minute = np.zeros(6001)
    path = trajectory(
        Motion(minute, minute, sampling_interval=0.01),
        azimuth_deg=0, height=0.6, b_over_h=0.4, friction=0.6, leave_out=False,
    )  # fmt: skip
    assert float(path.time[-1]) >= 59.9
    for name in ("x", "z", "rotation"):
        assert (
            float(
                np.abs(
                    trajectory_of_element_named_stone(path)[name] - trajectory_of_element_named_stone(path)[name][0]
                ).max()
            )
            <= 1e-9
        )


@pytest.mark.parametrize("upward", [0.0, -0.3 * STANDARD_GRAVITY, 0.2 * STANDARD_GRAVITY])
@pytest.mark.parametrize("b_over_h", [0.1, 0.25, 0.5])
@pytest.mark.parametrize(("seconds", "penetration"), [(20.0, 2e-5), (4.0, 2e-6), (1.0, 2e-7)])
def test_uplift_begins_at_the_rocking_threshold(
    b_over_h: float, upward: float, seconds: float, penetration: float
) -> None:
    # The corner lags 2 ξ/ω behind the load: longer for a softer contact.
    threshold = rocking_threshold_acceleration(b_over_h, upward)
    path = trajectory(
        motion_with_linear_ramp_of_north_acceleration(1.2 * threshold, seconds, upward),
        gravestone(Contact(static_penetration=penetration)),
        azimuth_deg=0,
        height=0.6,
        b_over_h=b_over_h,
        friction=10.0,
        leave_out=False,
    )
    # The corner towards +s lifts off, when its penetration reaches 0.
    left = int(np.argmax(lower_corner_penetrations(path)[1] <= 0.0))
    assert left > 0
    assert float(path.ground_acceleration[left]) == pytest.approx(threshold, rel=1e-3)


@pytest.mark.parametrize("upward", [0.0, -0.3 * STANDARD_GRAVITY])
@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_squat_block_begins_to_slide_at_the_friction_threshold(friction: float, upward: float) -> None:
    threshold = sliding_threshold_acceleration(friction, upward)
    path = trajectory(
        motion_with_linear_ramp_of_north_acceleration(1.1 * threshold, 8.0, upward),
        gravestone(Contact(static_penetration=2e-6)),
        azimuth_deg=0,
        height=0.3,
        b_over_h=2.0,
        friction=friction,
        leave_out=False,
    )
    # The onset follows from the speed, which is the integral of the ramp's excess over the threshold.
    time, speed = path.time.values, -trajectory_of_element_named_stone(path).velocity_x.values
    late = speed > 0.02
    start = time[late] - np.sqrt(2.0 * speed[late] / (1.1 * threshold / 8.0))
    onset = np.interp(np.median(start), time, path.ground_acceleration.values)
    assert onset == pytest.approx(threshold, rel=1e-3)


def test_downward_base_acceleration_lowers_the_rocking_threshold() -> None:
    # 15 % above the threshold with a_up = −0.3 g, 15 % below without.
    level = 0.85 * rocking_threshold_acceleration(0.2)
    light, heavy = (
        motion_with_linear_ramp_of_north_acceleration(level, 1.5, -0.3 * STANDARD_GRAVITY),
        motion_with_linear_ramp_of_north_acceleration(level, 1.5),
    )
    assert run_cases(light, Cases(0.0, 0.6, 0.2, 10.0)).peak_rotation[0] > 1e-2
    assert run_cases(heavy, Cases(0.0, 0.6, 0.2, 10.0)).peak_rotation[0] == 0.0


@pytest.mark.parametrize(("b_over_h", "amplitude"), [(0.1, 5e-3), (0.2, 5e-3), (0.3, 5e-3), (0.4, 1e-2), (0.5, 2e-2)])
def test_free_rocking_agrees_with_housner(b_over_h: float, amplitude: float) -> None:
    height, tilt = 1.0, 0.5 * float(np.arctan(b_over_h))
    fine = Motion(np.zeros(1500), np.zeros(1500), sampling_interval=0.001)
    path = trajectory(
        fine, azimuth_deg=0, height=height, b_over_h=b_over_h, friction=10.0, initial_tilt=tilt, leave_out=False
    )
    angle, time = trajectory_of_element_named_stone(path).rotation.values, path.time.values
    crossing = int(np.argmax(angle < 0.0))
    share = angle[crossing - 1] / (angle[crossing - 1] - angle[crossing])
    quarter = time[crossing - 1] + share * (time[crossing] - time[crossing - 1])
    assert quarter == pytest.approx(time_from_tilt_to_first_impact(height, b_over_h, tilt), rel=5e-3)
    following = -angle[(time >= quarter) & (time < 3.2 * quarter)].min()
    assert following == pytest.approx(rocking_amplitude_after_impact(b_over_h, tilt), rel=amplitude)


@pytest.mark.parametrize("b_over_h", [0.1, 0.3, 0.5])
def test_energy_in_free_rocking_never_rises(b_over_h: float) -> None:
    height, tilt = 1.0, 0.5 * float(np.arctan(b_over_h))
    fine = Motion(np.zeros(3000), np.zeros(3000), sampling_interval=0.001)
    path = trajectory(
        fine, azimuth_deg=0, height=height, b_over_h=b_over_h, friction=10.0, initial_tilt=tilt, leave_out=False
    )
    inertia = height**2 * (1.0 + b_over_h**2) / 12.0
    stiffness = STANDARD_GRAVITY / (2.0 * DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO * b_over_h * height)
    sunk = np.maximum(lower_corner_penetrations(path), 0.0)
    energy = (
        0.5
        * (
            trajectory_of_element_named_stone(path).velocity_x ** 2
            + trajectory_of_element_named_stone(path).velocity_z ** 2
            + inertia * trajectory_of_element_named_stone(path).angular_velocity ** 2
        ).values
        + STANDARD_GRAVITY * (trajectory_of_element_named_stone(path).z.values - 0.5 * height)
        + 0.5 * stiffness * (sunk**2).sum(axis=0)
    )
    risen = energy - np.minimum.accumulate(energy)
    assert risen.max() <= 2e-4 * energy[0]


@pytest.mark.parametrize("friction", [0.05, 0.15, 0.25])
@pytest.mark.parametrize("period", [0.3, 1.0, 2.0])
def test_slip_under_a_pulse_equals_that_of_the_sliding_block(friction: float, period: float) -> None:
    t = np.arange(600) * 0.005
    pulse = 5.0 * np.sin(2 * np.pi * t / period) * (t < period)
    found = run_cases(Motion(pulse, 0 * pulse, sampling_interval=0.005), Cases(0.0, 0.3, 2.0, friction))
    peak, residual = peak_and_final_slip(pulse, 0.005, friction)
    assert found.overturned[0] == 0
    assert found.peak_slip[0] == pytest.approx(peak, rel=1e-2)
    assert found.residual_slip[0] == pytest.approx(residual, abs=2e-2 * peak)


SLIDING_PULSE = 5.0 * np.sin(0.5 * np.pi * 0.005 * np.arange(401))
"""Acceleration of the base that makes a block slide for long, m/s²; a sample every 0.005 s."""
LOW_FRICTIONS = (0.002, 0.01, 0.02)


@cache
def outcomes_of_sliding_block_by_friction(height: float, b_over_h: float, scheme: str) -> CaseResults:
    """Return the outcomes of a block with each of `LOW_FRICTIONS` under `SLIDING_PULSE`, computed together."""
    motion = Motion(SLIDING_PULSE, 0 * SLIDING_PULSE, sampling_interval=0.005)
    return run_cases(motion, Cases(0.0, height, b_over_h, LOW_FRICTIONS), scheme=scheme)


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
@pytest.mark.parametrize(("height", "b_over_h"), [(0.3, 2.0), (0.6, 0.3), (2.0, 0.1)])
@pytest.mark.parametrize("friction", LOW_FRICTIONS)
def test_a_long_slide_has_the_exact_slip(friction: float, height: float, b_over_h: float, scheme: str) -> None:
    """The block slides for 10 s to 4 min, longer than the usual end of a case, 20/p (Housner's p) after the record."""
    assert friction < 0.5 * b_over_h
    found, case = outcomes_of_sliding_block_by_friction(height, b_over_h, scheme), LOW_FRICTIONS.index(friction)
    peak, residual = peak_and_final_slip(SLIDING_PULSE, 0.005, friction)
    assert found.overturned[case] == 0
    assert found.peak_slip[case] == pytest.approx(peak, rel=5e-3)
    assert found.residual_slip[case] == pytest.approx(residual, rel=5e-3)


def test_a_drop_follows_the_exact_bounce_of_a_damped_spring() -> None:
    # a_up = −1.2 g for 0.2 s lifts the block off its base with 0.2 g; then it falls freely.
    interval, lifted = 0.001, 0.2 * STANDARD_GRAVITY
    t = np.arange(2500) * interval
    up = np.where(t < 0.2, -STANDARD_GRAVITY - lifted, 0.0)
    contact = Contact(stiffness=2e6, damping_ratio=0.1)
    path = trajectory(
        Motion(0 * t, 0 * t, up, sampling_interval=interval, trust_data=True), gravestone(contact),
        azimuth_deg=0, height=0.6, b_over_h=1.0, friction=0.5, leave_out=False,
        time_step="0.02 stable",
    )  # fmt: skip
    height, time = trajectory_of_element_named_stone(path).z.values, path.time.values
    # Free flight: the speed at touch follows from the energy at the last sample before.
    touch = int(np.argmax((time > 0.3) & (lower_corner_penetrations(path)[0] > 0))) - 1
    gap, fall = (
        -lower_corner_penetrations(path)[0][touch],
        -trajectory_of_element_named_stone(path).velocity_z.values[touch],
    )
    speed = float(np.sqrt(fall**2 + 2 * STANDARD_GRAVITY * gap))
    normal, _, dashpot = contact.corner_stiffness_and_damping_per_mass(0.6, 0.6, 2650.0)
    duration, rebound = time_and_velocity_at_end_of_bounce(speed, 2.0 * float(normal), 2.0 * float(dashpot))
    start = time[touch] + (speed - fall) / STANDARD_GRAVITY
    # Its highest point after the rebound follows from the rebound speed.
    away = (time > start + duration + 0.005) & (time < start + duration + 1.5 * rebound / STANDARD_GRAVITY)
    top = height[away].max()
    depth_at_release = float(dashpot) * rebound / float(normal)
    expected = 0.3 - depth_at_release + rebound**2 / (2.0 * STANDARD_GRAVITY)
    rest = 0.3
    assert top - rest == pytest.approx(expected - rest, rel=5e-3)


def base_acceleration_pulse_causing_slip(interval: float, friction: float) -> np.ndarray:
    """Return a horizontal base acceleration that makes a block slide: 2.2 μg for 0.2 s, with ramps of one sample."""
    time = np.arange(0.0, 3.0, interval) - 0.5
    return np.where((time > -1e-9) & (time < 0.2 + 1e-9), 2.2 * friction * STANDARD_GRAVITY, 0.0)


def peak_slips_of_slabs_by_kernel(
    acceleration: np.ndarray, interval: float, heights: list[float], friction: float
) -> dict[str, np.ndarray]:
    """Return the largest slip (m) of slabs of B/H 3 under a horizontal motion in the three kernels, by kernel."""
    motion = Motion(acceleration, 0.0 * acceleration, sampling_interval=interval)
    cases = Cases(0.0, np.array(heights), 3.0, friction)
    found = {
        str(general): simulate_cases(gravestone(), motion, cases, NumericalOptions(general=general)).peak_slip.ravel()
        for general in (False, True)
    }
    space = Cases(0.0, np.array(heights), 3.0, friction)
    return found | {"body": simulate_cases(shape_from_name_or_sides("rectangle"), motion, space).peak_slip}


@pytest.mark.parametrize("interval", [0.02, 0.01, 0.005])
def test_a_slab_under_coarse_samples_slides_as_far_as_the_sliding_block(interval: float) -> None:
    acceleration = base_acceleration_pulse_causing_slip(interval, 0.3)
    expected = peak_and_final_slip(acceleration, interval, 0.3)[0]
    for kernel, found in peak_slips_of_slabs_by_kernel(acceleration, interval, [0.3, 1.0, 3.0, 10.0], 0.3).items():
        assert np.abs(found / expected - 1.0).max() <= 0.01, (kernel, found / expected)


@pytest.mark.parametrize(
    ("number", "azimuth", "friction"),
    [(22, 127, 0.35), (22, 117, 0.35), (22, 127, 0.3), (22, 37, 0.35), (22, 127, 0.5), (22, 67, 0.6), (22, 67, 0.5),
     (10, 147, 0.5), (10, 107, 0.35), (7, 27, 0.35), (7, 107, 0.5)],
)  # fmt: skip
def test_a_slab_slides_as_far_under_a_record_and_its_interpolation(number: int, azimuth: int, friction: float) -> None:
    """Slabs 0.6 to 10 m high under records at 0.02 s, and interpolated to 0.01 s, slip like the rigid sliding block."""
    record = near_field_motion_and_fault_component_azimuths(number, pulse=number < 15)[0]
    north, east = cosine_and_sine_of_azimuth(azimuth)
    along = record.north * north + record.east * east
    expected = peak_and_final_slip(along, record.sampling_interval, friction)[0]
    between = np.interp(np.arange(2 * along.size - 1) * 0.5, np.arange(along.size), along)
    for samples, interval in ((along, record.sampling_interval), (between, 0.5 * record.sampling_interval)):
        for kernel, found in peak_slips_of_slabs_by_kernel(samples, interval, [0.6, 1.0, 3.0, 10.0], friction).items():
            assert np.abs(found / expected - 1.0).max() <= 0.01, (kernel, interval, found / expected)


def test_peak_rotation_of_a_squat_block_equals_that_of_housners_block() -> None:
    """At B/H 0.428 under the Sepulveda record the peak rotation equals that of Housner's block, which never bounces."""
    record, height, b_over_h = near_field_motion_and_fault_component_azimuths(23, pulse=False)[0], 1.597, 0.428
    north, east = cosine_and_sine_of_azimuth(41.24)
    along = 1.4508 * (record.north * north + record.east * east)
    motion, case = (
        Motion(along, 0 * along, sampling_interval=record.sampling_interval),
        Cases(0.0, height, b_over_h, 10.0),
    )
    expected = simulate_rigid_rocking(motion, case).peak_rotation[0]
    for general in (False, True):
        found = simulate_cases(gravestone(), motion, case, NumericalOptions(general=general))
        assert found.peak_rotation.ravel()[0] == pytest.approx(expected, abs=0.01)
    space = simulate_cases("rectangle", motion, case)
    assert np.radians(space.peak_tilt[0]) / np.arctan(b_over_h) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize("seed", [0, 4, 6])
def test_a_block_stays_flat_in_noise_that_throws_it_up(seed: int, general: bool, scheme: str) -> None:
    """With vertical noise up to 2 g the block flies and lands many times; with µ < B/H it only slides."""
    generator = np.random.default_rng(seed)
    along, up = (np.append(generator.uniform(-peak, peak, 120), 0.0) for peak in (8.0, 20.0))
    motion = Motion(along, 0 * along, up, sampling_interval=0.026, trust_data=True)
    found = run_cases(motion, Cases([0.0], 0.6, 0.4, 0.2), general=general, scheme=scheme)
    assert found.overturned.tolist() == [0]
    assert found.peak_rotation.max() < 0.01
    np.testing.assert_allclose(
        found.residual_slip, final_slip_with_flights_and_landings(along, up, 0.026, 0.2), rtol=0.03
    )


AMPLITUDES_NEAR_ONE = tuple(np.round(np.linspace(0.95, 1.05, 21), 4).tolist())
THROWN_UP_CASES = [
    (0.3, 0.2, 1.5, 0.5),
    (0.3, 0.25, 1.3, 0.5),
    (0.4, 0.3, 1.5, 0.6),
    (0.5, 0.3, 2.0, 0.8),
    (0.5, 0.4, 2.0, 0.8),
    (0.3, 0.2, 1.2, 0.3),
]
"""B/H and friction of sliding blocks, upward and horizontal acceleration (g) of the base that throws them up."""
THROWN_UP_CASES_WITH_VARIED_AMPLITUDE = [(0.3, 0.25, 1.3, 0.5), (0.3, 0.29, 1.3, 0.5), (0.5, 0.3, 2.0, 0.8)]
"""As `THROWN_UP_CASES`, for blocks that land at each of the amplitudes `AMPLITUDES_NEAR_ONE`."""


def base_accelerations_throwing_block_up(lift: float, push: float) -> tuple[np.ndarray, np.ndarray]:
    """Return accelerations of a base, along and up, m/s², that throw a block up; a sample every 0.01 s.

    `lift`: downward acceleration over g. `push`: horizontal acceleration over g.
    """
    along, up = np.zeros(200), np.zeros(200)
    along[5:40], up[10:40] = push * STANDARD_GRAVITY, -lift * STANDARD_GRAVITY
    return along, up


@cache
def thrown_up_block_outcomes_by_friction_azimuth_amplitude(
    b_over_h: float, lift: float, push: float, use_scene_kernel: bool, scheme: str
) -> dict[Any, tuple[int, Any, Any]]:
    """Return overturning flag, peak rotation and residual slip of all blocks of one B/H that a motion throws up.

    The keys are friction, azimuth (degrees) and amplitude.
    """
    along, up = base_accelerations_throwing_block_up(lift, push)
    motion = Motion(along, 0 * along, up, sampling_interval=0.01, trust_data=True)
    cells = {
        (mu, turn, 1.0) for b, mu, *base in THROWN_UP_CASES if (b, *base) == (b_over_h, lift, push) for turn in (0, 180)
    }
    cells |= {
        (mu, 0, a)
        for b, mu, *base in THROWN_UP_CASES_WITH_VARIED_AMPLITUDE
        if (b, *base) == (b_over_h, lift, push)
        for a in AMPLITUDES_NEAR_ONE
    }
    keys = sorted(cells)
    friction, azimuth, amplitude = np.array(keys).T
    cases = Cases(azimuth, 0.6, b_over_h, friction, amplitude=amplitude)
    found = run_cases(motion, cases, general=use_scene_kernel, scheme=scheme)
    return dict(zip(keys, zip(found.overturned, found.peak_rotation, found.residual_slip, strict=True), strict=True))


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize(("b_over_h", "friction", "lift", "push"), THROWN_UP_CASES)
def test_a_block_that_lands_flat_while_it_slides_stays_flat(
    b_over_h: float, friction: float, lift: float, push: float, general: bool, scheme: str
) -> None:
    """The block is thrown up and lands with µ < B/H: the impulse acts within its base, so that no end lifts."""
    found = thrown_up_block_outcomes_by_friction_azimuth_amplitude(b_over_h, lift, push, general, scheme)
    slip = final_slip_with_flights_and_landings(*base_accelerations_throwing_block_up(lift, push), 0.01, friction)
    for turn, expected in ((0, slip), (180, -slip)):
        overturned, rotation, residual = found[friction, turn, 1.0]
        assert overturned == 0
        assert rotation < 0.01
        assert residual == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize(
    ("push", "lift", "samples"), [(0.5, 12.0, 50), (0.5, 20.0, 50), (0.5, 9.9, 50), (1.0, 15.0, 40)]
)
@pytest.mark.parametrize("b_over_h", [0.2, 0.3])
def test_a_block_that_sticks_when_it_lands_flat_slips_in_flight_only(
    b_over_h: float, push: float, lift: float, samples: int, general: bool, scheme: str
) -> None:
    """The resultant of the impact passes through the base, so that the block stops; without contact nothing acts on it.

    Peaks of `push` (horizontal) and `lift` (downward), m/s², throw it up to 0.9 m; the base stops before it lands.
    """
    along, up = push * np.sin(0.08 * np.arange(samples)), np.full(samples, -lift)
    along[-1] = up[-1] = 0.0
    motion = Motion(along, 0 * along, up, sampling_interval=0.01, trust_data=True)
    found = run_cases(motion, Cases([0.0, 180.0], 0.6, b_over_h, 1.0), general=general, scheme=scheme)
    assert found.status.tolist() == [CaseStatus.SIMULATED] * 2
    assert found.overturned.tolist() == [0, 0]
    assert found.peak_rotation.max() < 0.15
    slip = final_slip_with_flights_and_landings(along, up, 0.01, 1.0)
    np.testing.assert_allclose(found.residual_slip, [slip, -slip], rtol=0.01)


@cache
def reference_slips_at_nearby_amplitudes(friction: float, lift: float, push: float) -> list[float]:
    """Return the slip (m) of a block that does not rotate, at each of the amplitudes `AMPLITUDES_NEAR_ONE`."""
    return [
        final_slip_with_flights_and_landings(
            *base_accelerations_throwing_block_up(lift, push), 0.01, friction, amplitude
        )
        for amplitude in AMPLITUDES_NEAR_ONE
    ]


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize(("b_over_h", "friction", "lift", "push"), THROWN_UP_CASES_WITH_VARIED_AMPLITUDE)
def test_a_thrown_up_block_lands_flat_at_all_of_many_nearby_amplitudes(
    b_over_h: float, friction: float, lift: float, push: float, general: bool, scheme: str
) -> None:
    """In flight the block rotates by less than 0.001 rad/s, so that one end touches microseconds earlier."""
    found = thrown_up_block_outcomes_by_friction_azimuth_amplitude(b_over_h, lift, push, general, scheme)
    overturned, rotation, residual = zip(
        *(found[friction, 0, amplitude] for amplitude in AMPLITUDES_NEAR_ONE), strict=True
    )
    assert not any(overturned)
    assert max(rotation) < 0.01
    np.testing.assert_allclose(residual, reference_slips_at_nearby_amplitudes(friction, lift, push), rtol=0.03)
