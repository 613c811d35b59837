"""Pulses against calculus: each against an independent integral or derivative of its formula."""

import math
from dataclasses import replace

import numpy as np
import pytest

from overturning.errors import ConfigError, RecordError
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordTableRow
from overturning.records.earthquakes import assign_records_to_earthquakes
from overturning.records.pulses import parse_pulse, record_of_pulse
from overturning.records.read import read_record
from overturning.records.record import processing_state_label
from overturning.study.load import read_record_table_rows_of_study, study_from_content
from tests.expect import expect_error


def pulse_times_acceleration_and_parameters(line: str):
    """Return times from the start of a pulse, its acceleration along its azimuth, and its parameters."""
    pulse = parse_pulse(line)
    record = record_of_pulse(pulse)
    time = np.arange(record.north.size) * record.sampling_interval - pulse.before_s
    return time, Motion.of(record).acceleration_along(pulse.azimuth_deg), pulse


def test_a_pulse_line_in_the_record_table_becomes_a_record(tmp_path):
    entry = RecordTableRow(
        id="sine", format="synthetic", source="sine amplitude_gal=300 period_s=1 azimuth_deg=60", event="made"
    )
    record = read_record(entry, tmp_path)
    motion = Motion.of(record)
    assert np.abs(motion.acceleration_along(60)).max() == pytest.approx(3.0, rel=1e-12)
    assert np.abs(motion.acceleration_along(150)).max() < 1e-12
    assert (record.record_id, record.event, record.up) == ("sine", "made", None)
    assert read_record(entry, tmp_path).sha256 == record.sha256
    assert processing_state_label(record) == "synthetic"  # a formula is no agency that has processed a recording
    # At rest it is 0 whichever way the pulse goes: −0 has another byte.
    back = record_of_pulse(parse_pulse("sine amplitude_gal=300 period_s=1 azimuth_deg=240"))
    for samples in (back.north, back.east):
        assert samples[:100].tobytes() == np.zeros(100).tobytes()


def test_a_pulse_has_the_descriptive_data_of_its_record_table_row(tmp_path):
    line = "sine amplitude_gal=300 period_s=1 azimuth_deg=60"
    place = {"station_latitude_deg": 35.0, "station_longitude_deg": 133.0}
    said = {"pulse": True, "event_id": "one", "magnitude": 6.5, "site_class": "C", "wall": "foot"}
    record = read_record(RecordTableRow(id="p", format="synthetic", source=line, **said, **place), tmp_path)
    assert said.items() <= record.extra.items()
    assert (record.latitude, record.longitude) == (35.0, 133.0)
    other = replace(record, record_id="q", extra=record.extra | {"event_id": "two"})
    assert len(set(assign_records_to_earthquakes([record, other]).earthquake_labels_in_record_order)) == 2
    with expect_error(RecordError, "SHA-256"):
        read_record(RecordTableRow(id="p", format="synthetic", source=line, sha256="0" * 64), tmp_path)
    for column in ({"orientation_correction_deg": 10.0}, {"unit": "g"}, {"sensor": "borehole"}):
        with pytest.raises(ConfigError, match=f"record p: {next(iter(column))}: of files alone"):
            read_record(RecordTableRow(id="p", format="synthetic", source=line, **column), tmp_path)


def test_a_pulse_given_on_one_line_of_a_study_becomes_a_record():
    study = study_from_content(
        {"name": "x", "records": {"pulses": {"paper-sine": "sine amplitude_gal=300 period_s=1"}}}, "x.yaml"
    )
    assert study.records.use == ("paper-sine",)
    assert read_record_table_rows_of_study(study, "x.yaml")["paper-sine"].format == "synthetic"
    both = study_from_content(
        {"name": "x", "records": {"use": ["rinaldi"], "pulses": {"r": "ricker amplitude_gal=1 period_s=1"}}}, "x"
    )
    assert list(read_record_table_rows_of_study(both, "x")) == ["rinaldi", "r"]
    with pytest.raises(ConfigError, match=r"x\.yaml: records\.pulses: 'rinaldi' is also in"):
        read_record_table_rows_of_study(
            study_from_content(
                {"name": "x", "records": {"pulses": {"rinaldi": "sine amplitude_gal=1 period_s=1"}}}, ""
            ),
            "x.yaml",
        )


def test_all_wrong_pulses_of_a_study_are_named_with_file_key_and_value():
    pulses = {"a": "sine amplitud=300 period_s=0", "b": "sinus azimuth_deg=60", "c": "sine amplitude_gal=1 period_s=1"}
    with pytest.raises(ConfigError) as found:
        read_record_table_rows_of_study(study_from_content({"name": "x", "records": {"pulses": pulses}}, ""), "x.yaml")
    first, second = str(found.value).splitlines()
    assert first.startswith("x.yaml: records.pulses.a: pulse 'sine amplitud=300 period_s=0': ")
    for words in ("amplitude_gal: this key is needed", "amplitud '300': unknown key", "period_s '0': "):
        assert words in first
    assert second.strip().startswith("x.yaml: records.pulses.b: pulse 'sinus azimuth_deg=60': shape 'sinus'; known are")


def test_sine_and_cosine_pulses_match_their_formulas():
    time, a, _ = pulse_times_acceleration_and_parameters(
        "sine amplitude_gal=100 period_s=0.8 sampling_interval_s=0.01 before_s=0.5 azimuth_deg=350"
    )
    for t, value in zip(time, a, strict=True):
        expected = math.sin(2 * math.pi * t / 0.8) if -1e-9 < t < 0.8 + 1e-9 else 0.0
        assert value == pytest.approx(expected, abs=1e-11)
    time, a, _ = pulse_times_acceleration_and_parameters("cosine amplitude_gal=100 period_s=1 cycles=2")
    assert a[np.abs(time).argmin()] == pytest.approx(1.0)
    assert np.count_nonzero(np.abs(a) > 1e-9) == pytest.approx(401, abs=5)


def test_a_ricker_pulse_is_the_second_derivative_of_a_gaussian():
    time, a, pulse = pulse_times_acceleration_and_parameters(
        "ricker amplitude_gal=100 period_s=1 sampling_interval_s=0.001"
    )
    middle = 0.5 * pulse.duration
    gauss = np.exp(-((np.pi * (time - middle)) ** 2))
    second = -np.gradient(np.gradient(gauss, 0.001), 0.001) / (2 * np.pi**2)
    np.testing.assert_allclose(a[2:-2], second[2:-2], atol=2e-5)
    assert abs(a.sum() * 0.001) < 1e-8
    assert a.max() == pytest.approx(1.0)


def velocity_by_mavroeidis_papageorgiou(pulse, time):
    """Return the velocity of a pulse by equation 3 of Mavroeidis & Papageorgiou (2003), m/s, with V = A T/(2π)."""
    after_the_middle = time - 0.5 * pulse.gamma * pulse.period_s
    envelope = 1 + np.cos(2 * np.pi * after_the_middle / (pulse.gamma * pulse.period_s))
    peak = pulse.amplitude_gal / 100 * pulse.period_s / (2 * np.pi)
    return 0.5 * peak * envelope * np.cos(2 * np.pi * after_the_middle / pulse.period_s + math.radians(pulse.phase_deg))


@pytest.mark.parametrize(("gamma", "phase"), [(1.5, 0), (2.2, 90), (3.0, 217)])
def test_mavroeidis_papageorgiou_acceleration_is_the_derivative_of_its_velocity(gamma, phase):
    time, a, pulse = pulse_times_acceleration_and_parameters(
        f"mavroeidis-papageorgiou amplitude_gal=100 period_s=1.3 gamma={gamma} phase_deg={phase} "
        "sampling_interval_s=0.0005"
    )
    inside = (time > 0.01) & (time < pulse.duration - 0.01)
    moment = time[inside]
    h = 1e-5
    derivative = (
        velocity_by_mavroeidis_papageorgiou(pulse, moment + h) - velocity_by_mavroeidis_papageorgiou(pulse, moment - h)
    ) / (2 * h)
    np.testing.assert_allclose(a[inside], derivative, atol=1e-8)
    assert abs(velocity_by_mavroeidis_papageorgiou(pulse, np.array([0.0, pulse.duration]))).max() < 1e-12
    # Peak velocity of the symmetric pulse: V at its middle.
    if phase == 0:
        assert np.abs(velocity_by_mavroeidis_papageorgiou(pulse, time)).max() == pytest.approx(
            1.3 / (2 * np.pi), rel=1e-6
        )


def test_a_constant_pulse_is_zero_outside_its_stated_duration():
    time, a, _ = pulse_times_acceleration_and_parameters(
        "constant amplitude_gal=50 duration_s=2 sampling_interval_s=0.01"
    )
    np.testing.assert_array_equal(a != 0, (time > -1e-6) & (time < 2 + 1e-6))
    assert set(np.round(a, 12)) == {0.0, 0.5}


@pytest.mark.parametrize("interval", [0.002, 0.01, 0.05])
@pytest.mark.parametrize(("line", "long"), [("constant duration_s=2", 2.0), ("cosine period_s=0.5 cycles=3", 0.0)])
def test_a_jump_at_a_pulse_end_lengthens_it_by_half_a_sampling_interval(
    line: str, long: float, interval: float
) -> None:
    """Straight lines join samples: the ramp at each end of a pulse adds A Δt/2 to the velocity (A: acceleration)."""
    record = record_of_pulse(parse_pulse(f"{line} amplitude_gal=50 sampling_interval_s={interval}"))
    assert record.velocity[0, -1] == pytest.approx(0.5 * (long + interval), rel=1e-9)


def test_a_noise_pulse_has_a_flat_spectrum_only_in_its_band():
    pulse = parse_pulse(
        "noise amplitude_gal=100 duration_s=40 low_hz=1 high_hz=10 seed=3 sampling_interval_s=0.01 before_s=0 after_s=0"
    )
    time = np.arange(4000) * 0.01
    a = pulse.acceleration(time) / np.maximum(np.sin(np.pi * time / 40) ** 2, 1e-12)
    spectrum = np.abs(np.fft.rfft(np.where(time > 0, a, a[1])))
    frequency = np.fft.rfftfreq(4000, 0.01)
    band = (frequency >= 1) & (frequency <= 10)
    inside = spectrum[band]
    assert inside.std() / inside.mean() < 0.01
    assert spectrum[~band].max() < 0.02 * inside.mean()
    assert math.sqrt(np.mean(a[1:] ** 2)) == pytest.approx(1.0, rel=0.01)
    other = parse_pulse("noise amplitude_gal=100 duration_s=40 low_hz=1 high_hz=10 seed=4")
    assert np.abs(np.corrcoef(pulse.acceleration(time), other.acceleration(time))[0, 1]) < 0.2


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("", ["shape ''"]),
        ("sinus amplitude_gal=1 period_s=1", ["'sinus'", "sine"]),
        ("sine period_s=1", ["amplitude_gal"]),
        ("sine amplitude_gal=1 period_s=0", ["period_s '0'", "greater than 0"]),
        ("sine amplitude_gal=1 period_s=1 periods=2", ["periods"]),
        ("sine amplitude_gal=1 period_s", ["key=value"]),
        ("sine amplitude_gal=x period_s=1", ["amplitude_gal 'x'"]),
    ],
)
def test_the_error_names_an_invalid_pulse(line, words):
    with expect_error(ConfigError, *words):
        parse_pulse(line)


def test_a_pulse_with_too_coarse_sampling_is_refused():
    with pytest.raises(ConfigError, match="ten samples"):
        record_of_pulse(parse_pulse("sine amplitude_gal=1 period_s=0.05 sampling_interval_s=0.01"))


def test_a_pulse_of_too_many_samples_is_refused():
    with expect_error(ConfigError, "record pulse", "1e+11 samples, at most 3e+07", "sampling_interval_s"):
        record_of_pulse(parse_pulse("sine amplitude_gal=1 period_s=1000 cycles=1000 sampling_interval_s=1e-5"))


@pytest.mark.parametrize(("duration", "low", "high"), [(25, 2.2, 4), (30, 1, 4.1), (100, 1.1, 2.3)])
def test_a_noise_pulse_contains_both_ends_of_its_band(duration: float, low: float, high: float) -> None:
    """2.2 Hz × 25 s is 55.00000000000001 and 4.1 Hz × 30 s is 122.99999999999999 in double precision."""
    time, a, _ = pulse_times_acceleration_and_parameters(
        f"noise amplitude_gal=100 duration_s={duration} low_hz={low} high_hz={high} sampling_interval_s=0.01 before_s=0"
    )
    bell = np.sin(np.pi * np.clip(time / duration, 0, 1)) ** 2
    inside = bell > 1e-4
    flat = a[inside] / bell[inside]
    first, last = round(low * duration), round(high * duration)
    waves = np.arange(first - 1, last + 2) * 2 * np.pi / duration
    columns = np.concatenate([np.cos(np.outer(time[inside], waves)), np.sin(np.outer(time[inside], waves))], axis=1)
    cosines, sines = np.split(np.linalg.lstsq(columns, flat, rcond=None)[0], 2)
    equal = math.sqrt(2.0 / (last - first + 1))
    np.testing.assert_allclose(np.hypot(cosines, sines), [0.0, *[equal] * (last - first + 1), 0.0], atol=1e-6)


@pytest.mark.parametrize(
    "line",
    ["sine amplitude_gal=300 period_s=0.006 cycles=200", "noise amplitude_gal=300 duration_s=5 low_hz=150 high_hz=190"],
)
def test_a_pulse_aliased_to_a_longer_period_is_refused(line):
    """A sine of 6 ms sampled at 5 ms has the samples of a sine of 30 ms with reversed sign."""
    with expect_error(ConfigError, "record pulse", "four samples", "sampling_interval_s ≤ 0.001"):
        record_of_pulse(parse_pulse(line))
