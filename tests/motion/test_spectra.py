"""Spectra and intensity measures compared with closed forms and with pyrotd, eqsig, pykooh and pyshindo."""

import importlib
import importlib.metadata
import math
import os
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.signal
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from overturning.errors import ArgumentError
from overturning.motion.direction import cosine_and_sine_of_azimuth, north_east_cosines_of_azimuths
from overturning.motion.fourier import fourier_amplitude_spectrum, konno_ohmachi_smoothed_amplitude
from overturning.motion.intensity import (
    MEASURE_UNITS_AND_LONG_NAMES,
    arias_intensity,
    cumulative_absolute_velocity,
    intensity_dataset_by_azimuth,
    intensity_measures_by_azimuth,
    jma_intensity_and_raw_and_processed_peaks,
    significant_duration,
)
from overturning.motion.jma_intensity import (
    JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION,
    is_published_intensity_in_range,
    jma_filter_gain,
    jma_instrumental_intensity,
    round_and_truncate_to_published_intensity,
)
from overturning.motion.motion import Motion
from overturning.motion.oscillator import OscillatorResponseCalculator, oscillator_filter_coefficients
from overturning.motion.peaks import largest_filtered_motion_along_azimuths, largest_motion_along_azimuths
from overturning.motion.spectra import housner_spectrum_intensity, response_spectra_by_azimuth, rotd_percentile_measures
from overturning.records.catalogue import read_record_table
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.records.record import Record
from overturning.records.steps import Highpass, Scale

DEFAULT_RECORD_TABLE_PATH = Path(__file__).parents[2] / "config" / "records.tsv"


def import_reference_package_or_skip(name: str) -> Any:
    """Import a package to compare with; if it is missing, skip the test, or fail if skipping is forbidden."""
    import_package = importlib.import_module if "OVERTURNING_NO_SKIP" in os.environ else pytest.importorskip
    with pytest.MonkeyPatch.context() as patch:
        if name == "pyrotd" and "pkg_resources" not in sys.modules:
            # It asks pkg_resources for its own version, which newer setuptools no longer bring. The stub goes again:
            # pytest uses the real module where it finds one.
            stub: Any = types.ModuleType("pkg_resources")
            stub.get_distribution = lambda name: types.SimpleNamespace(version=importlib.metadata.version(name))
            patch.setitem(sys.modules, "pkg_resources", stub)
        return import_package(name)


@pytest.fixture(scope="module")
def rinaldi_record() -> Record:
    """The Rinaldi record of the record table."""
    return read_record(read_record_table(DEFAULT_RECORD_TABLE_PATH)["rinaldi"], Path("unused"))


@settings(max_examples=60, deadline=None)
@given(
    arrays(np.float64, (2, 300), elements=st.floats(-1e3, 1e3)), st.lists(st.floats(0, 360), min_size=1, max_size=40)
)
def test_largest_motion_along_azimuths_matches_a_search_of_all_samples(pair, azimuths):
    cosines = north_east_cosines_of_azimuths(np.array(azimuths))
    expected = np.abs(cosines[:, :1] * pair[0] + cosines[:, 1:] * pair[1]).max(axis=1)
    np.testing.assert_array_equal(largest_motion_along_azimuths(pair, cosines), expected)


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10**6),
    st.floats(0.02, 20.0),
    st.floats(0.0, 0.9),
    st.sampled_from([(0, 180, 1), (30, 31, 1), (90, 800, 47)]),
)
def test_oscillator_peaks_are_bit_identical_to_those_of_scipys_filter(seed, period, damping, azimuths):
    pair = np.random.default_rng(seed).normal(size=(2, 2000)) * np.hanning(2000)
    cosines = north_east_cosines_of_azimuths(np.arange(*azimuths))
    *above, below = oscillator_filter_coefficients(period, damping, 0.005)
    for numerator in above:
        north, east = scipy.signal.lfilter(numerator, below, pair, axis=1)
        expected = np.abs(cosines[:, :1] * north + cosines[:, 1:] * east).max(axis=1)
        found = largest_filtered_motion_along_azimuths(pair, numerator, below, cosines)
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [(0, 0), (1, 150), (0, 299)])
def test_a_non_finite_sample_gives_a_missing_peak(value, place):
    pair = np.random.default_rng(5).normal(size=(2, 300))
    pair[place] = value
    *above, below = oscillator_filter_coefficients(0.5, 0.05, 0.01)
    cosines = north_east_cosines_of_azimuths(np.arange(0.0, 180.0, 10.0))
    assert np.isnan(largest_motion_along_azimuths(pair, cosines)).all()
    for numerator in above:
        assert np.isnan(largest_filtered_motion_along_azimuths(pair, numerator, below, cosines)).all()


def test_largest_motion_along_azimuths_is_exact_for_motion_along_one_line():
    """For motion along N60E only, the lower bound of the peak across this line is zero: no sample may be skipped."""
    wave = np.random.default_rng(0).normal(size=5000)
    pair = np.stack([wave * 0.5, wave * math.sqrt(0.75)])
    azimuths = np.arange(0.0, 360.0, 7.5)
    expected = np.abs(wave).max() * np.abs(np.cos(np.radians(azimuths - 60)))
    np.testing.assert_allclose(
        largest_motion_along_azimuths(pair, north_east_cosines_of_azimuths(azimuths)), expected, atol=1e-11
    )


def pseudo_acceleration_spectrum_of_component(samples, interval, periods, damping=0.05):
    """Pseudo-acceleration spectrum of one component, m/s²."""
    motion = Motion(samples, np.zeros_like(samples), sampling_interval=interval, trust_data=True)
    return response_spectra_by_azimuth(motion, periods, 0.0, damping_ratio=damping)["acceleration"][:, 0]


@pytest.mark.parametrize("count", [64, 75])
def test_the_interpolated_motion_passes_through_its_samples(count):
    """White noise reaches the Nyquist frequency, which has a separate term if the number of samples is even."""
    noise = np.random.default_rng(count).normal(size=(2, count))
    finer = OscillatorResponseCalculator(noise, 0.01, longest_oscillator_period_s=0.0)._interpolated_components(4)
    np.testing.assert_allclose(finer[:, ::4], noise, atol=1e-12)


@pytest.mark.parametrize("period", [0.05, 0.3, 1.0, 4.0])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.2])
def test_oscillator_response_to_an_acceleration_step_matches_the_closed_form(period, damping):
    """Acceleration step a, damping ratio h: peak D = a/ω² (1 + exp(−πh/√(1−h²))) at half a period."""
    steady = np.concatenate([np.zeros(100), np.full(4000, 2.0)])
    omega = 2 * math.pi / period
    overshoot = 1 + math.exp(-math.pi * damping / math.sqrt(1 - damping**2))
    found = pseudo_acceleration_spectrum_of_component(steady, 0.0025, [period], damping=damping)[0]
    # The step rises within one sample and is band-limited where it is interpolated: 1 % for the shortest period.
    assert found == pytest.approx(2.0 * overshoot, rel=0.002 if period > 0.1 else 0.1)
    assert omega > 0


@pytest.mark.parametrize("period", [10.0, 20.0, 100.0, 1000.0])
@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_response_spectra_include_free_vibration_after_the_motion(period, damping):
    """After a short pulse of velocity V: D = V/ω exp(−h/√(1−h²) arccos h), a quarter of a period later."""
    pulse = np.where((np.arange(300) > 100) & (np.arange(300) < 120), 1.0, 0.0)
    omega, speed = 2 * math.pi / period, 0.005 * pulse.sum()
    motion = Motion(pulse, 0 * pulse, sampling_interval=0.005)
    found = response_spectra_by_azimuth(motion, [period], 0.0, damping_ratio=damping)["displacement"][0, 0]
    expected = speed / omega * math.exp(-damping / math.sqrt(1 - damping**2) * math.acos(damping))
    assert found == pytest.approx(expected, rel=1e-3)


def test_oscillator_response_to_a_sine_matches_the_transfer_function():
    time = np.arange(0, 100, 0.01)
    for forcing, period in ((1.0, 0.5), (1.0, 1.0), (0.7, 2.0)):
        ratio = period / forcing
        expected = 1 / math.sqrt((1 - ratio**2) ** 2 + (2 * 0.05 * ratio) ** 2)
        envelope = np.sin(np.pi / 2 * np.clip(np.minimum(time / 30, (100 - time) / 30), 0, 1)) ** 2
        found = pseudo_acceleration_spectrum_of_component(
            envelope * np.sin(2 * np.pi * time / forcing), 0.01, [period]
        )[0]
        assert found == pytest.approx(expected, rel=0.01)


def test_response_spectra_have_the_limits_of_stiff_and_soft_oscillators(rinaldi_record):
    """A stiff oscillator responds with PGA; a soft one stays at rest, so its relative displacement is the ground's."""
    pga = np.abs(rinaldi_record.north).max()
    assert pseudo_acceleration_spectrum_of_component(rinaldi_record.north, rinaldi_record.sampling_interval, [0.001])[
        0
    ] == pytest.approx(pga, rel=0.01)
    short = np.concatenate(
        [np.sin(2 * np.pi * np.arange(0, 1, 0.01)), -np.sin(2 * np.pi * np.arange(0, 1, 0.01)), np.zeros(50)]
    )
    found = pseudo_acceleration_spectrum_of_component(short, 0.01, [1000.0])[0] / (2 * np.pi / 1000.0) ** 2
    assert found == pytest.approx(1 / (2 * np.pi), rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize("name", ["rinaldi", "petrolia"])
def test_rotd_spectra_agree_with_pyrotd(name):
    pyrotd = import_reference_package_or_skip("pyrotd")
    pyrotd.processes = 1
    record = read_record(read_record_table(DEFAULT_RECORD_TABLE_PATH)[name], Path("unused"))
    # pyrotd convolves in a circle: rest before and after keeps one end's motion from ringing into the other.
    ends = round(5 / record.sampling_interval), round(50 / record.sampling_interval)
    pair = np.pad(np.stack([record.north, record.east]), ((0, 0), ends))
    periods = np.geomspace(0.01, 4.0, 6)
    mine = rotd_percentile_measures(Motion(*pair, sampling_interval=record.sampling_interval), periods)["psa"]
    theirs = pyrotd.calc_rotated_spec_accels(
        record.sampling_interval,
        *pair,
        1 / periods,
        0.05,
        percentiles=[0, 50, 100],
        max_freq_ratio=25,
        method="rigorous",
    )
    np.testing.assert_allclose(mine.T, theirs.spec_accel.reshape(-1, 3), rtol=0.005)


def test_rotd_percentiles_of_motion_along_one_line_match_the_closed_form():
    """Over half a turn |cos| has the median cos 45°, the largest 1 and the smallest 0."""
    wave = np.sin(2 * np.pi * np.arange(0, 5, 0.01))
    found = rotd_percentile_measures(Motion(wave * 0.5, wave * math.sqrt(0.75), sampling_interval=0.01), [0.5, 2.0])
    for values in (found["pga"], found["pgv"], found["psa"][:, 0], found["psa"][:, 1]):
        assert values[0] == pytest.approx(0, abs=1e-9 * values[2])
        assert values[1] / values[2] == pytest.approx(math.cos(math.pi / 4), rel=0.01)


def test_intensity_measures_agree_with_eqsig(rinaldi_record):
    eqsig = import_reference_package_or_skip("eqsig")
    motion = Motion.of(rinaldi_record)
    for azimuth in (0.0, 32.0, 122.0):
        along = motion.acceleration_along(azimuth)
        signal = eqsig.AccSignal(along, rinaldi_record.sampling_interval)
        arias = eqsig.im.calc_arias_intensity(signal)[-1]
        assert arias_intensity(motion, azimuth)[0] == pytest.approx(arias, rel=0.005)
        assert cumulative_absolute_velocity(motion, azimuth)[0] == pytest.approx(
            eqsig.im.calc_cav(signal)[-1], rel=0.005
        )
        start, end = eqsig.im.calc_sig_dur(signal, se=True)
        assert significant_duration(motion, azimuth)[0] == pytest.approx(
            end - start, abs=2 * rinaldi_record.sampling_interval
        )
        periods = np.geomspace(0.3, 5, 10)
        theirs = eqsig.sdof.pseudo_response_spectra(along, rinaldi_record.sampling_interval, periods, xi=0.05)
        mine = response_spectra_by_azimuth(motion, periods, azimuth)
        np.testing.assert_allclose(mine["displacement"][:, 0], theirs[0], rtol=0.005)
        np.testing.assert_allclose(mine["acceleration"][:, 0], theirs[2], rtol=0.005)


# pyshindo 0.3.2 (Python 3.12 or newer) for Rinaldi's north and east and, as the vertical, half of east turned round in
# time.
PYSHINDO_RESULTS_FOR_RINALDI = {
    "intensity": 6.378077963459177,
    "si20": (148.24809147, 82.41052249),
    "si05": (204.06229183, 115.5137774),
}


def motion_with_vertical_from_time_reversed_east(record: Record) -> Motion:
    """Return the motion of a record, whose vertical is half the east component reversed in time."""
    return Motion(record.north, record.east, 0.5 * record.east[::-1], sampling_interval=record.sampling_interval)


def test_jma_and_spectrum_intensity_agree_with_pyshindo(rinaldi_record):
    motion = motion_with_vertical_from_time_reversed_east(rinaldi_record)
    assert jma_instrumental_intensity(motion) == pytest.approx(PYSHINDO_RESULTS_FOR_RINALDI["intensity"], abs=1e-9)
    np.testing.assert_allclose(
        housner_spectrum_intensity(motion, [0, 90]) * 100, PYSHINDO_RESULTS_FOR_RINALDI["si20"], rtol=0.005
    )
    np.testing.assert_allclose(
        housner_spectrum_intensity(motion, [0, 90], damping_ratio=0.05) * 100,
        PYSHINDO_RESULTS_FOR_RINALDI["si05"],
        rtol=0.005,
    )


if sys.version_info >= (3, 12):

    def test_stored_pyshindo_values_match_the_package(rinaldi_record):
        pyshindo = import_reference_package_or_skip("pyshindo")
        motion = motion_with_vertical_from_time_reversed_east(rinaldi_record)
        gal = np.column_stack([motion.north, motion.east, motion.up]) * 100
        assert pyshindo.calculate_measured_intensity(gal, 100.0).intensity_raw == pytest.approx(
            PYSHINDO_RESULTS_FOR_RINALDI["intensity"], abs=1e-9
        )
        si = pyshindo.calculate_spectrum_intensity(gal[:, :2], 100.0).si_cm_s
        np.testing.assert_allclose(si, PYSHINDO_RESULTS_FOR_RINALDI["si20"], rtol=1e-6)


def test_jma_intensity_of_a_steady_sine_matches_the_closed_form():
    """For a sine of 1 Gal on one axis for a minute, the level exceeded for 0.3 s is nearly the filtered amplitude."""
    time = np.arange(0, 60, 0.01)
    for frequency in (0.5, 1.0, 5.0):
        wave = 0.01 * np.sin(2 * np.pi * frequency * time)
        x = frequency / 10
        cut = (
            1 + 0.694 * x**2 + 0.241 * x**4 + 0.0557 * x**6 + 0.009664 * x**8 + 0.00134 * x**10 + 0.000155 * x**12
        ) ** -0.5
        gain = frequency**-0.5 * cut * math.sqrt(1 - math.exp(-((frequency / 0.5) ** 3)))
        found = jma_instrumental_intensity(Motion(wave, 0 * wave, 0 * wave, sampling_interval=0.01))
        assert found == pytest.approx(2 * math.log10(gain) + 0.94, abs=0.005)


def test_shares_of_fallen_stones_are_assigned_to_degrees_of_the_jma_scale():
    """By a rule of surveys, 40 to below 90 % overturned mean 6 upper (6.0 to below 6.5), more mean 7 (from 6.5 on)."""
    (low, high, *upper), (then, whole, *seven) = JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION
    assert low < high == then < whole == 1
    assert upper == [6.0, 6.5, "6 upper"]
    assert (seven[0], seven[2]) == (6.5, "7")


def test_horizontal_jma_intensity_equals_that_with_zero_vertical_motion(rinaldi_record):
    level = Motion(
        rinaldi_record.north,
        rinaldi_record.east,
        0 * rinaldi_record.north,
        sampling_interval=rinaldi_record.sampling_interval,
    )
    both = Motion(
        rinaldi_record.north,
        rinaldi_record.north,
        rinaldi_record.north / np.sqrt(2),
        sampling_interval=rinaldi_record.sampling_interval,
    )
    assert jma_instrumental_intensity(level, horizontal_only=True) == jma_instrumental_intensity(level)
    # A vertical motion half as strong as the horizontal vector at every moment adds log₁₀ 1.25.
    added = jma_instrumental_intensity(both) - jma_instrumental_intensity(both, horizontal_only=True)
    assert added == pytest.approx(np.log10(1.25))


def test_jma_intensity_needs_three_components_and_0_3_seconds():
    with pytest.raises(ArgumentError, match="vertical"):
        jma_instrumental_intensity(Motion([0, 1], [0, 1], sampling_interval=0.01))
    with pytest.raises(ArgumentError, match=r"0\.3 s"):
        jma_instrumental_intensity(Motion([0, 1], [0, 1], [0, 1], sampling_interval=0.01))
    assert jma_instrumental_intensity(Motion(*np.zeros((3, 50)), sampling_interval=0.01)) == -math.inf


def test_arias_intensity_cav_and_duration_of_a_sine_match_the_closed_form():
    """Whole cycles of A sin: Arias πA²T/(4g), CAV 2AT/π; 90 % of the energy comes in 90 % of the time."""
    time = np.arange(0, 10.0005, 0.001)
    motion = Motion(3 * np.sin(2 * np.pi * 2 * time), 0 * time, sampling_interval=0.001)
    azimuths = [0, 60, 90]
    factor = np.array([1, 0.25, 0])
    np.testing.assert_allclose(arias_intensity(motion, azimuths), factor * math.pi * 9 * 10 / (4 * 9.80665), atol=1e-6)
    np.testing.assert_allclose(
        cumulative_absolute_velocity(motion, azimuths), np.sqrt(factor) * 2 * 3 * 10 / math.pi, rtol=1e-4, atol=1e-9
    )
    np.testing.assert_allclose(significant_duration(motion, azimuths)[:2], 9.0, atol=0.1)
    assert significant_duration(motion, [90])[0] == 0.0


def test_fourier_amplitudes_of_a_sine_and_an_impulse_match_the_closed_forms():
    time = np.arange(0, 10, 0.01)
    frequency, amplitude = fourier_amplitude_spectrum(2.0 * np.sin(2 * np.pi * 3 * time), 0.01)
    assert frequency[amplitude.argmax()] == pytest.approx(3.0)
    assert amplitude.max() == pytest.approx(2.0 * 10 / 2)  # half of amplitude times duration
    spike = np.zeros(1000)
    spike[500] = 7.0
    np.testing.assert_allclose(fourier_amplitude_spectrum(spike, 0.01)[1], 0.07)


def test_konno_ohmachi_smoothing_matches_its_formula_and_pykooh():
    """Reference: the window [sin(b log₁₀ f/f_c)/(b log₁₀ f/f_c)]⁴, normalised to sum 1, and pykooh."""
    random = np.random.default_rng(3)
    frequency = np.arange(0, 25, 0.05)
    amplitude = random.uniform(0.5, 2, frequency.size)
    for at in (0.5, 1.0, 7.0):
        f, a = frequency[1:], amplitude[1:]
        x = 40.0 * np.log10(f / at)
        with np.errstate(invalid="ignore"):
            window = np.where(np.abs(x) < 1e-12, 1.0, (np.sin(x) / x) ** 4)
        expected = (window * a).sum() / window.sum()
        assert konno_ohmachi_smoothed_amplitude(frequency, amplitude, at)[0] == pytest.approx(expected, rel=1e-12)
        # The function `smooth` of pykooh does the same, but Numba compiles it first.
        smoother = import_reference_package_or_skip("pykooh").CachedSmoother(f, np.array([at]), 40.0)
        assert smoother(a)[0] == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(
        konno_ohmachi_smoothed_amplitude(frequency, np.full_like(frequency, 3.0), [0.3, 2, 20]), 3.0, rtol=1e-9
    )
    # 10 s have frequencies of 0.1, 0.2, 0.3 Hz. At 0.14 Hz the next ones weigh (sin x/x)⁴ of x = −5.8 and 6.2:
    # nothing.
    short = np.arange(0, 25, 0.1)
    assert np.isnan(konno_ohmachi_smoothed_amplitude(short, np.ones(short.size), [0.1, 0.14, 2.0])).tolist() == [
        False,
        True,
        False,
    ]
    with pytest.raises(ArgumentError, match="positive"):
        konno_ohmachi_smoothed_amplitude(frequency, amplitude, [0.0])


@pytest.mark.parametrize("frequency", [8.0, 15.0, 20.0])
def test_velocity_spectrum_of_soft_oscillators_matches_the_closed_form_for_fast_motion(frequency):
    """Far above its own frequency an oscillator's velocity is that of the ground: A/ω, in closed form to 1 %."""
    time = np.arange(0, 20, 0.02)
    bell = np.sin(np.pi * time / 20) ** 2
    motion = Motion(3.0 * bell * np.sin(2 * np.pi * frequency * time), 0 * time, sampling_interval=0.02)
    omega, own = 2 * np.pi * frequency, 2 * np.pi / np.array([1.5, 2.5])
    exact = 3.0 * omega / np.abs(own**2 - omega**2 + 2j * 0.2 * own * omega)
    found = response_spectra_by_azimuth(
        motion, [1.5, 2.5], [0], damping_ratio=0.2, interpolated_points_per_oscillator_period=24
    )["velocity"][:, 0]
    assert found == pytest.approx(exact, rel=0.02)


def test_intensity_dataset_by_azimuth_has_units_and_repeats_after_180_degrees(rinaldi_record):
    motion = Motion.of(rinaldi_record)
    table = intensity_dataset_by_azimuth(motion, np.arange(0, 360, 30))
    assert set(table) == set(MEASURE_UNITS_AND_LONG_NAMES)
    for name, (unit, _) in MEASURE_UNITS_AND_LONG_NAMES.items():
        assert table[name].attrs["units"] == unit
        np.testing.assert_array_equal(table[name][:6], table[name][6:])
        assert np.isfinite(table[name]).all()
    assert (table.duration > 1).all()
    assert (table.si05 > table.si20).all()


def test_the_predominant_period_of_a_sine_is_its_period():
    time = np.arange(0, 30, 0.01)
    motion = Motion(np.sin(2 * np.pi * time / 0.8), np.sin(2 * np.pi * time / 0.3), sampling_interval=0.01)
    np.testing.assert_allclose(
        intensity_measures_by_azimuth(motion, [0, 90])["predominant_period"], [0.8, 0.3], rtol=0.04
    )


def test_predominant_period_is_clipped_to_0_04_and_4_s():
    """For a motion outside the range, the closest end of the range is returned."""
    time = np.arange(0, 40, 0.002)
    motion = Motion(np.sin(2 * np.pi * time / 0.01), np.sin(2 * np.pi * time / 10), sampling_interval=0.002)
    np.testing.assert_allclose(intensity_measures_by_azimuth(motion, [0, 90])["predominant_period"], [0.04, 4.0])


@pytest.mark.parametrize("azimuth", [0.0, 60.0, 123.456])
def test_motion_along_one_line_has_no_predominant_period_perpendicular_to_it(azimuth):
    wave = 3.0 * np.sin(0.03 * np.arange(3000)) * np.hanning(3000)
    cosine, sine = cosine_and_sine_of_azimuth(azimuth)
    motion = Motion(wave * cosine, wave * sine, sampling_interval=0.01)
    found = intensity_measures_by_azimuth(motion, azimuth + np.array([0.0, 89.0, 90.0, 270.0]))
    assert np.isnan(found["predominant_period"]).tolist() == [False, False, True, True]
    for name in set(MEASURE_UNITS_AND_LONG_NAMES) - {"predominant_period"}:
        assert (found[name] >= 0).all(), name
        np.testing.assert_allclose(found[name][2:], 0.0, atol=1e-9)
    at_rest = intensity_measures_by_azimuth(Motion([0, 0, 0], [0, 0, 0], sampling_interval=0.01), [0.0])
    assert {name for name, value in at_rest.items() if np.isnan(value[0])} == {"predominant_period"}


def test_measures_of_a_record_have_peaks_before_and_after_processing(rinaldi_record):
    done = process_record(rinaldi_record, [Scale(factor=2), Highpass(corner_hz=0.2)])
    found = jma_intensity_and_raw_and_processed_peaks(Motion.of(done), done.processing)
    assert found["pga_unprocessed"] == pytest.approx(
        max(np.abs(rinaldi_record.north).max(), np.abs(rinaldi_record.east).max())
    )
    assert found["pgd_processed"] < 0.9 * 2 * found["pgd_unprocessed"]
    assert found["jma_intensity"] is None
    assert (
        jma_intensity_and_raw_and_processed_peaks(Motion.of(rinaldi_record), rinaldi_record.processing)["pga_processed"]
        is None
    )


@pytest.mark.parametrize(("seconds", "defined"), [(0.2, False), (0.4, True)])
def test_a_motion_shorter_than_0_3_s_has_no_jma_intensity(seconds, defined):
    """The definition counts the acceleration that is exceeded for 0.3 s."""
    wave = np.sin(np.linspace(0.0, 6.0, round(100 * seconds) + 1))
    found = jma_intensity_and_raw_and_processed_peaks(Motion(wave, wave, wave, sampling_interval=0.01), [])
    assert [found[name] is not None for name in ("jma_intensity", "jma_intensity_horizontal")] == [defined] * 2


@pytest.mark.parametrize("periods", [[], [0.0], [-1.0], [math.nan], [math.inf], [1001.0], [[1.0]], "long"])
def test_invalid_spectral_periods_are_refused(periods):
    with pytest.raises(ArgumentError, match="period_s"):
        rotd_percentile_measures(Motion([0, 1], [0, 1], sampling_interval=0.01), periods)


@pytest.mark.long
def test_intensity_measures_do_not_hold_all_rotated_motions_in_memory():
    """The 360 rotated motions of 300 s would take 86 MB for each of acceleration, velocity and displacement."""
    import tracemalloc

    motion = Motion(*np.random.default_rng(2).normal(size=(2, 30_000)), sampling_interval=0.01)
    intensity_measures_by_azimuth(motion, [0.0])
    tracemalloc.start()
    intensity_measures_by_azimuth(motion, np.arange(360))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 40e6


def test_pga_pgv_and_pgd_of_a_sine_match_the_closed_form():
    """A sin ωt from rest: v = A/ω (1 − cos ωt), PGV 2A/ω; d = A/ω t − A/ω² sin ωt, 2πA/ω² at last."""
    amplitude, period = 3.0, 1.0
    omega = 2 * np.pi / period
    time = np.arange(0, 1.0005, 0.001)
    motion = Motion(amplitude * np.sin(omega * time), np.zeros_like(time), sampling_interval=0.001)
    found = intensity_dataset_by_azimuth(motion, [0, 60, 90, 180])
    np.testing.assert_allclose(found.pga, amplitude * np.array([1, 0.5, 0, 1]), atol=1e-9)
    np.testing.assert_allclose(found.pgv, 2 * amplitude / omega * np.array([1, 0.5, 0, 1]), rtol=1e-5)
    np.testing.assert_allclose(found.pgd, 2 * np.pi * amplitude / omega**2 * np.array([1, 0.5, 0, 1]), rtol=1e-4)
    assert found.pga.attrs["units"] == "m s-2"
    assert found.azimuth.attrs["units"] == "degree"


@pytest.mark.parametrize("azimuths", [[], [[0, 1]], [np.nan], "north", [0, "E"]])
def test_invalid_azimuths_of_intensity_measures_are_refused(azimuths):
    with pytest.raises(ArgumentError, match="azimuth_deg"):
        intensity_dataset_by_azimuth(Motion([0, 1], [0, 1], sampling_interval=1), azimuths)


def test_published_intensity_follows_jma_rounding():
    """The third decimal is rounded, the second dropped (JMA's explanation of the computation of seismic intensity)."""
    assert round_and_truncate_to_published_intensity([6.4949, 6.4951, 6.46, 4.5, 5.999, 0.299]).tolist() == [
        6.4,
        6.5,
        6.4,
        4.5,
        6.0,
        0.3,
    ]


def test_the_degree_of_the_jma_scale_follows_from_the_published_intensity():
    """5.996 is rounded to 6.00 and published as 6.0, which is 6 upper; 6.494 is published as 6.4, which is not 7."""
    intensity = [5.994, 5.996, 6.494, 6.496, np.nan, -np.inf]
    assert is_published_intensity_in_range(intensity, 6.0, 6.5).tolist() == [False, True, True, False, False, False]
    assert is_published_intensity_in_range(intensity, 6.5, np.inf).tolist() == [False, False, False, True, False, False]


def test_the_jma_filter_matches_its_formula_at_special_frequencies():
    """The gain is the product of three factors in JMA's notice of 1996.

    The factors are f^-½, the high cut (1 + 0.694 x² + … + 0.000155 x¹²)^-½ with x = f/10, and the low cut
    √(1 − exp(−(f/0.5)³)). At 10 Hz the high cut is 2.001859^-½ (the sum of its coefficients) and the low cut
    is 1; at 0.5 Hz the low cut is √(1 − 1/e) and the high cut is nearly 1.
    """
    at = jma_filter_gain(np.array([0.0, 0.5, 10.0, 0.01]))
    assert at[0] == 0
    assert at[1] == pytest.approx(math.sqrt(2.0 * (1 - math.exp(-1)) / (1 + 0.694 / 400 + 0.241 / 160000)), rel=1e-8)
    assert at[2] == pytest.approx(1 / math.sqrt(10 * 2.001859), rel=1e-7)
    assert at[3] == pytest.approx(math.sqrt((0.01 / 0.5) ** 3 / 0.01), rel=1e-5)  # 1 − e^−y is y for small y
