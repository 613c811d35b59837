"""Onset and signal-to-noise ratio of motions with known noise and a known signal."""

import warnings

import numpy as np
import pytest
from scipy.signal.windows import tukey

from overturning.motion.fourier import rms_fourier_amplitude_in_bands
from overturning.motion.noise import motion_onset_index, signal_and_noise_spectra
from overturning.records.processing import (
    AUTO_HIGHPASS_CORNER_BOUNDS_HZ,
    FALLBACK_HIGHPASS_CORNER_HZ,
    choose_highpass_corner_hz_and_reason,
    default_processing_steps,
    process_record,
)
from overturning.records.record import Record

DT = 0.01
TIME = np.arange(0, 60, DT)


def noise_with_decaying_signal_from_onset(
    onset_s: float, noise_standard_deviation: float, seed: int = 3, drift: float = 0.0
) -> np.ndarray:
    """Return white noise with a decaying signal of standard deviation 1 from the onset on, and a linear drift."""
    random = np.random.default_rng(seed)
    envelope = np.where(onset_s <= TIME, np.exp(-(TIME - onset_s) / 10), 0.0)
    return (
        noise_standard_deviation * random.normal(size=TIME.size)
        + envelope * random.normal(size=TIME.size)
        + drift * TIME
    )


@pytest.mark.parametrize("ahead", [5.0, 20.0])
@pytest.mark.parametrize("drift", [0.0, 0.05])
def test_the_onset_of_the_signal_is_found_within_a_tenth_of_a_second(ahead, drift):
    samples = noise_with_decaying_signal_from_onset(ahead, 0.01, drift=drift)
    assert motion_onset_index(samples) * DT == pytest.approx(ahead, abs=0.1)
    assert motion_onset_index(samples * 2.0**-24) == motion_onset_index(samples)  # in any unit


def test_signal_to_noise_ratio_of_white_signals_matches_their_amplitudes():
    found = signal_and_noise_spectra(
        [noise_with_decaying_signal_from_onset(20.0, 0.01), noise_with_decaying_signal_from_onset(20.0, 0.01, seed=4)],
        DT,
    )
    assert found is not None
    assert found.onset_s == pytest.approx(20.0, abs=0.1)
    assert found.band_centre_frequencies_hz[0] == pytest.approx(3 / found.onset_s)  # three cycles of the slowest
    # exp(−t/10) to 95 % of its energy, 15 s: root mean square 0.56 of the first amplitude.
    middle = (found.band_centre_frequencies_hz > 1) & (found.band_centre_frequencies_hz < 30)
    assert np.median(found.signal_over_noise_plus_offset_spectrum[:, middle]) == pytest.approx(56, rel=0.15)


@pytest.mark.parametrize("lasting", [12, 3000])
def test_spectral_windows_are_tapered_over_five_per_cent_at_each_end(lasting):
    """The spectra equal those with scipy's Tukey window of the same length, tapered over 5 % of the samples per end."""
    random = np.random.default_rng(8)
    samples = 0.01 * random.normal(size=5200)
    samples[2000 : 2000 + lasting] += random.normal(size=lasting)
    found = signal_and_noise_spectra([samples], DT)
    assert found is not None
    first, moving = round(found.onset_s / DT), samples - samples.mean()
    energy = np.cumsum(moving[first:] ** 2)
    last = first + int((energy < 0.95 * energy[-1]).sum()) + 1
    assert (last - first < 20) == (lasting == 12)
    for part, spectrum in (
        (moving[first:last], found.signal_amplitude_per_root_duration[0]),
        (moving[:first], found.noise_amplitude_per_root_duration[0]),
    ):
        window = tukey(part.size, 2 * max(1, part.size // 20) / (part.size - 1))
        expected = rms_fourier_amplitude_in_bands(
            (part - part.mean()) * window, DT, found.band_centre_frequencies_hz
        ) / np.sqrt(part.size * DT)
        np.testing.assert_allclose(spectrum, expected, rtol=1e-9)


def test_a_constant_offset_does_not_count_as_noise():
    """A tilted sensor has an offset between the samples before and after the onset."""
    level, shifted = (
        noise_with_decaying_signal_from_onset(20.0, 0.01),
        noise_with_decaying_signal_from_onset(20.0, 0.01) - np.where(TIME < 20.0, 0.05, 0.0),
    )
    first, second = signal_and_noise_spectra([level], DT), signal_and_noise_spectra([shifted], DT)
    assert first is not None
    assert second is not None
    assert first.onset_s == second.onset_s
    np.testing.assert_allclose(
        first.noise_amplitude_per_root_duration, second.noise_amplitude_per_root_duration, rtol=1e-6
    )


def test_there_is_no_signal_to_noise_ratio_without_noise_before_the_onset():
    assert signal_and_noise_spectra([noise_with_decaying_signal_from_onset(1.0, 0.01)], DT) is None
    assert signal_and_noise_spectra([np.zeros(100)], DT) is None
    quiet = noise_with_decaying_signal_from_onset(20.0, 0.0)
    assert signal_and_noise_spectra([quiet], DT) is None  # zeros put before a record are no noise


def record_of_components(north, east) -> Record:
    """Return a record of two horizontal components."""
    return Record("r", north, east, None, DT)


@pytest.mark.parametrize("interval", [0.1, 0.15, 0.3, 0.5, 1.0])
@pytest.mark.parametrize("ahead", [2.1, 3.0, 5.0, 20.0])
def test_signal_to_noise_ratio_at_long_sampling_intervals_is_finite_or_missing(interval, ahead):
    """The ratio is finite over at least an octave, or missing if the noise is too short, such as 7 samples of 0.3 s."""
    count = round(ahead / interval)
    noise = 1e-3 * np.random.default_rng(1).normal(size=count)
    signal = np.random.default_rng(2).normal(size=400) * np.exp(-np.arange(400) / 60)
    with warnings.catch_warnings(action="error"):
        found = signal_and_noise_spectra([np.append(noise, 10.0 * signal)], interval)
    if found is not None:
        assert found.onset_s >= 15.0 * interval
        assert found.band_centre_frequencies_hz[-1] >= 2.0 * found.band_centre_frequencies_hz[0] * (1 - 1e-9)
        assert np.isfinite(found.signal_over_noise_plus_offset_spectrum).all()
    assert found is not None or motion_onset_index(np.append(noise, 10.0 * signal)) * interval < max(2.0, 15 * interval)


def test_the_reason_for_the_default_corner_frequency_names_the_missing_data():
    wave = np.random.default_rng(2).normal(size=400)
    still = Record("r", np.zeros(400), np.zeros(400), noise_with_decaying_signal_from_onset(20.0, 0.01)[:400], DT)
    assert choose_highpass_corner_hz_and_reason(still) == (FALLBACK_HIGHPASS_CORNER_HZ, "no horizontal motion")
    coarse = Record("r", wave, wave[::-1].copy(), None, 0.5)
    assert choose_highpass_corner_hz_and_reason(coarse) == (
        FALLBACK_HIGHPASS_CORNER_HZ,
        "no noise of 7.5 s before the onset to compare with",
    )


def test_the_automatic_corner_frequency_is_where_signal_exceeds_noise():
    """The noise exceeds the signal below 0.4 Hz, so the corner is at 0.4 Hz."""
    rumble = 0.05 * np.sin(2 * np.pi * 0.2 * TIME) + 0.05 * np.sin(2 * np.pi * 0.33 * TIME + 1)
    corner, reason = choose_highpass_corner_hz_and_reason(
        record_of_components(
            noise_with_decaying_signal_from_onset(30.0, 0.01) + rumble,
            noise_with_decaying_signal_from_onset(30.0, 0.01, seed=5) + rumble,
        )
    )
    assert 0.33 < corner < 0.6
    assert "less than 3 times the noise of the first 30" in reason


def test_the_automatic_corner_frequency_is_the_default_if_noise_is_too_short():
    corner, reason = choose_highpass_corner_hz_and_reason(
        record_of_components(
            noise_with_decaying_signal_from_onset(0.5, 0.01), noise_with_decaying_signal_from_onset(0.5, 0.01)
        )
    )
    assert corner == FALLBACK_HIGHPASS_CORNER_HZ
    assert "no noise of 2 s before the onset" in reason
    clean, reason = choose_highpass_corner_hz_and_reason(
        record_of_components(
            noise_with_decaying_signal_from_onset(30.0, 0.001),
            noise_with_decaying_signal_from_onset(30.0, 0.001, seed=6),
        )
    )
    assert clean == pytest.approx(0.1, rel=0.01)  # three cycles in 30 s
    assert "as far down as that tells" in reason
    ahead = 0.001 * np.random.default_rng(7).normal(size=(2, 6000))
    long, _ = choose_highpass_corner_hz_and_reason(
        record_of_components(
            *(np.append(ahead[n], noise_with_decaying_signal_from_onset(30.0, 0.001, seed=3 + n)) for n in range(2))
        )
    )
    assert AUTO_HIGHPASS_CORNER_BOUNDS_HZ[0] <= long <= 0.05
    # Three seconds of noise tell nothing of what is slower than a hertz.
    short, reason = choose_highpass_corner_hz_and_reason(
        record_of_components(
            noise_with_decaying_signal_from_onset(3.0, 0.001), noise_with_decaying_signal_from_onset(3.0, 0.001, seed=6)
        )
    )
    assert short == FALLBACK_HIGHPASS_CORNER_HZ
    assert "noise of the first 3.0 s as far down as that tells, 1" in reason


@pytest.mark.parametrize("tilt", [0.03, 0.3])
def test_sensor_tilt_raises_the_corner_frequency_to_recover_displacement(tilt):
    """Known truth: a velocity pulse of 4 s in weak noise, and a sensor that tilts during the pulse."""
    time = np.arange(0, 120, DT)
    random, away = np.random.default_rng(9), time - 48
    ground = [np.exp(-((away / 5) ** 2)) * np.cos(2 * np.pi * away / 4 + phase) for phase in (0.0, 1.0)]
    noise = [1e-4 * random.normal(size=time.size) for _ in ground]
    level, tilted = (
        record_of_components(*(g + n + (away > 0) * a for g, n in zip(ground, noise, strict=True))) for a in (0.0, tilt)
    )
    corner, reason = choose_highpass_corner_hz_and_reason(tilted)
    assert 1.2 * choose_highpass_corner_hz_and_reason(level)[0] < corner < 0.25
    assert "offset that the shock leaves" in reason
    found, true = (
        np.hypot(*process_record(r, default_processing_steps(r, corner)).displacement).max()
        for r in (tilted, record_of_components(*ground))
    )
    assert found == pytest.approx(true, rel=0.1)


def test_the_automatic_corner_frequency_is_stored_in_hz_with_its_reason():
    raw = record_of_components(
        noise_with_decaying_signal_from_onset(30.0, 0.01), noise_with_decaying_signal_from_onset(30.0, 0.01, seed=5)
    )
    done = process_record(raw, None)
    step = done.processing[-1]
    assert isinstance(step["corner_hz"], float)
    assert "times the noise" in step["chosen"]
    assert step["shift_s"] == pytest.approx(-3.0 / step["corner_hz"], abs=DT)
