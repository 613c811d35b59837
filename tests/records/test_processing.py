"""Each step against a known answer: ramps, steps, single sines."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import signal

from overturning.errors import RecordError
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.records.check import RecordCheckResult, format_record_check
from overturning.records.component import RecordComponent
from overturning.records.processing import Step, default_processing_steps, process_record
from overturning.records.record import (
    Record,
    as_record,
    displacement_drift_evidence,
    processing_entry_text,
    processing_peaks_and_notes_of_record,
)
from overturning.records.steps import Baseline, Cut, Detrend, Highpass, Lowpass, RemoveMean, Resample, Scale, Taper
from tests.expect import expect_error

DT = 0.01
TIME = np.arange(6000) * DT


def trusted_record_of_components(north, east=None, interval=DT) -> Record:
    """Return a record of one or two horizontal components; it is marked as trusted, so it may be implausible."""
    east = np.zeros_like(north) if east is None else east
    known = {"trusted_data": True}  # ramps and steps are no ground motions
    return Record("r", north, east, None, interval, start="2001-02-03T04:05:06Z", extra=known)


def tapered_sine(frequency: float) -> np.ndarray:
    """Return a sine under a sin² envelope that lasts for the whole of `TIME`."""
    return np.sin(2 * np.pi * frequency * TIME) * np.sin(np.pi * TIME / TIME[-1]) ** 2


def test_drift_is_detected_at_the_end_of_velocity_and_displacement() -> None:
    """Two opposite velocity pulses of 1/π m/s have no drift; with an offset in acceleration, drift is reported."""
    cycle = np.where(TIME < 1, np.sin(2 * np.pi * TIME), 0.0)
    swing = np.where(TIME < 2, cycle - np.roll(cycle, 100), 0.0)  # forward and backward pulse: no residual displacement
    assert displacement_drift_evidence(trusted_record_of_components(swing, swing)) == ""
    # An offset of c for 60 s ends the velocity at 60 c: 1 % of 1/π with c = 5.3e-5, 5 % with 2.65e-4.
    little, more = (trusted_record_of_components(swing, swing + share / np.pi / 60) for share in (0.01, 0.05))
    assert "velocity" not in displacement_drift_evidence(little)
    assert "velocity of east ends at 5 % of its peak" in displacement_drift_evidence(more)
    assert "displacement of east is largest at the last sample" in displacement_drift_evidence(more)
    assert "north" not in displacement_drift_evidence(more)
    assert processing_peaks_and_notes_of_record(more)["drift"] == displacement_drift_evidence(more)
    axis = RecordComponent(more.east, DT, "E", 90.0, 0, "x", "")
    text = format_record_check(RecordCheckResult(("x",), (axis,), replace(more, extra=more.extra | {"format": "csv"})))
    assert ") cm as the file is\n  drift, so its PGD is none: velocity of east ends at 5 %" in text
    assert displacement_drift_evidence(replace(more, extra={"format": "synthetic"})) == "", "a formula is what it is"


@pytest.mark.parametrize("zone", ["Asia/Tokyo", "America/Los_Angeles"])
def test_a_record_start_without_zone_is_utc_on_every_machine(monkeypatch, zone) -> None:
    """Regression: the start of a `Record` made in Python was read as local time, nine hours off in Japan."""
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    try:
        naive = replace(trusted_record_of_components(tapered_sine(1.0)), start="2001-02-03T04:05:06")
        assert process_record(naive, [Cut(start_s=1)]).start == "2001-02-03T04:05:07Z"
        abroad = replace(naive, start="2001-02-03T13:05:06+09:00")
        assert process_record(abroad, [Cut(start_s=1)]).start == "2001-02-03T04:05:07Z"
    finally:
        monkeypatch.undo()
        time.tzset()


def test_a_motion_from_python_is_not_labelled_processed() -> None:
    motion = Motion(tapered_sine(1.0), tapered_sine(2.0), sampling_interval=DT)
    given = as_record(motion)
    assert processing_peaks_and_notes_of_record(process_record(given, None))["data"] == "as given"
    assert process_record(given, None).processing == ()


def test_remove_mean_subtracts_the_mean_of_the_whole_or_the_pre_event_part():
    north = np.concatenate([np.full(1000, 0.3), np.full(1000, 2.3)])
    np.testing.assert_allclose(
        process_record(trusted_record_of_components(north), [RemoveMean()]).north, north - 1.3, atol=1e-12
    )
    np.testing.assert_allclose(
        process_record(trusted_record_of_components(north), [RemoveMean(first_s=10)]).north, north - 0.3, atol=1e-12
    )


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_detrend_removes_its_polynomial_but_not_the_next_order(order):
    polynomial = sum((k + 1) * (TIME / 60) ** k for k in range(order + 1))
    np.testing.assert_allclose(
        process_record(trusted_record_of_components(polynomial), [Detrend(order=order)]).north, 0, atol=1e-10
    )
    left = process_record(trusted_record_of_components((TIME / 60) ** (order + 1)), [Detrend(order=order)]).north
    assert np.abs(left).max() > 1e-3


def test_the_taper_is_half_a_cosine_bell():
    done = process_record(trusted_record_of_components(np.ones(6000)), [Taper(length_s=2)]).north
    assert done[0] == 0
    assert done[100] == pytest.approx(0.5)
    assert (done[200:-200] == 1).all()
    np.testing.assert_allclose(done, done[::-1], atol=1e-15)


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("frequency", [0.25, 0.5, 1.0, 2.0])
def test_filters_have_the_squared_butterworth_gain_and_no_phase_shift(order, frequency):
    """After two passes the gain is |H|² = 1/(1 + (f/f_c)^2n), for a high-pass with f_c/f: ½ at the corner."""
    ratio = frequency / 0.5
    for step, gain in (
        (Lowpass(corner_hz=0.5, order=order), 1 / (1 + ratio ** (2 * order))),
        (Highpass(corner_hz=0.5, order=order), 1 / (1 + ratio ** (-2 * order))),
    ):
        done = process_record(trusted_record_of_components(tapered_sine(frequency)), [step])
        pad = (done.north.size - 6000) // 2
        middle = slice(pad + 2000, pad + 4000)
        np.testing.assert_allclose(done.north[middle], gain * tapered_sine(frequency)[2000:4000], atol=0.03)


def test_a_high_pass_filter_leaves_no_drift_and_shifts_the_start():
    """An offset in acceleration gives 18 m of displacement without the filter, and less than 2 mm with it."""
    done = process_record(trusted_record_of_components(tapered_sine(1.0) + 0.01), [Highpass(corner_hz=0.2, order=2)])
    velocity = integrate(done.north, DT)
    displacement = integrate(velocity, DT)
    assert abs(velocity[-1]) < 1e-4
    assert abs(displacement[-1]) < 2e-3
    assert done.start == "2001-02-03T04:04:51Z"  # 1.5 · 2 / 0.2 = 15 s earlier
    assert done.processing[0]["effect"]["pgd"][0] > 10 * done.processing[0]["effect"]["pgd"][1]


@pytest.mark.parametrize("offset", [0.3, -0.05])
def test_a_high_pass_filter_of_an_offset_leaves_no_step(offset):
    """The offset is subtracted before the filter: steps at its ends would double the peak velocity."""
    shaken = tapered_sine(1.0) * np.hanning(TIME.size)
    for first in ([], [RemoveMean()], [RemoveMean(), Taper(length_s=2.0)], [Detrend(order=0)]):
        speed = integrate(
            process_record(trusted_record_of_components(shaken + offset), [*first, Highpass(corner_hz=0.1)]).north, DT
        )
        assert np.abs(speed).max() == pytest.approx(np.abs(integrate(shaken, DT)).max(), rel=0.01)


@pytest.mark.parametrize("step", [Lowpass(corner_hz=20), *(Resample(sampling_interval_s=s) for s in (0.004, 0.02))])
def test_no_processing_step_turns_an_offset_into_spikes_at_the_ends(step):
    """Regression: the zeros next to an offset of 50 Gal caused spikes of 15 to 25 Gal."""
    weak = 0.01 * tapered_sine(1.0)
    for steps in ([step, RemoveMean()], [RemoveMean(), step]):
        done = process_record(trusted_record_of_components(weak + 0.5), steps).north
        assert np.abs(done).max() == pytest.approx(0.01, rel=0.01)
    assert process_record(trusted_record_of_components(weak + 0.5), [step]).north[0] == pytest.approx(0.5, abs=1e-4)


def test_a_motion_between_periods_of_rest_is_not_treated_as_an_offset():
    """A pulse between periods of rest is padded with zeros on both sides and filtered; no offset is removed."""
    pulse = np.where(np.abs(TIME - TIME[-1] / 2) < 5.0, 1.0, 0.0)
    done = process_record(trusted_record_of_components(pulse), [Highpass(corner_hz=0.1)]).north
    between_zeros = np.pad(pulse, (done.size - pulse.size) // 2)
    sections = signal.butter(2, 0.1, btype="highpass", fs=1 / DT, output="sos")
    np.testing.assert_allclose(done, signal.sosfiltfilt(sections, between_zeros, padtype=None), atol=1e-12)


def test_boore_2001_correction_removes_known_offsets():
    """Offsets of 0.05 m/s² from 20 to 25 s and of 0.002 m/s² afterwards are as in the scheme's own model."""
    motion = tapered_sine(2.0)
    offset = np.where((TIME >= 20) & (TIME < 25), 0.05, 0.0) + np.where(TIME >= 25, 0.002, 0.0)
    done = process_record(
        trusted_record_of_components(motion + offset), [Baseline(fit_from_s=55, t1_s=20, t2_s=25)]
    ).north
    np.testing.assert_allclose(done, motion, atol=2e-4)
    for begin in (0.5, 20):
        single = np.where(begin <= TIME, 0.01, 0.0)
        done = process_record(trusted_record_of_components(motion + single), [Baseline(fit_from_s=55)]).north
        wrong = np.abs(done - motion) > 1e-4
        assert wrong.sum() <= 10  # the time of the step is found within 0.1 s
    assert abs(integrate(integrate(done, DT), DT)[-1]) < 0.05 * abs(integrate(integrate(motion + single, DT), DT)[-1])


@pytest.mark.parametrize("interval", [0.01, 0.0371, 0.1])
@pytest.mark.parametrize(("t1", "t2"), [(20.0, 25.0), (0.0, 7.013), (20.02, 20.13), (20.02, 20.1201)])
def test_boore_2001_correction_leaves_zero_final_velocity_at_any_sampling(
    interval: float, t1: float, t2: float
) -> None:
    """The correction subtracts the line fitted to the end of the velocity: fitted again, this line is zero."""
    time = np.arange(round(60 / interval)) * interval
    pulse = np.where(time < 30, np.sin(2 * np.pi * time) * np.sin(np.pi * time / 30), 0.0)
    tilted = pulse + np.where(time >= 8, 0.01, 0.0)
    done = process_record(
        trusted_record_of_components(tilted, interval=interval), [Baseline(fit_from_s=50, t1_s=t1, t2_s=t2)]
    ).north
    end = time >= 50
    np.testing.assert_allclose(np.polyfit(time[end], integrate(done, interval)[end], 1), 0.0, atol=1e-12)


def test_a_baseline_correction_without_effect_is_noted() -> None:
    """Regression: a velocity line that crosses zero only before the record has no effect, but was noted as used."""
    sunk = tapered_sine(2.0) + np.where(
        TIME < 0.05, 5.0, 0.01
    )  # the line at the end is zero 25 s before the first sample
    stepped = tapered_sine(2.0) + np.where(TIME > 20, 0.01, 0.0)
    done = process_record(trusted_record_of_components(sunk, stepped), [Baseline(fit_from_s=55)])
    np.testing.assert_array_equal(done.north, sunk)
    assert not np.array_equal(done.east, stepped)
    why = "nothing taken from north, as the line is zero at no time before the fit"
    assert processing_entry_text(done.processing[0]) == f"baseline boore-2001, fit from 55 s ({why})"
    plain = process_record(trusted_record_of_components(stepped, stepped), [Baseline(fit_from_s=55)])
    assert processing_entry_text(plain.processing[0]) == "baseline boore-2001, fit from 55 s"


@pytest.mark.parametrize("interval", [0.005, 0.02, 0.008])
def test_resampling_preserves_a_sine_and_removes_frequencies_above_nyquist(interval):
    done = process_record(trusted_record_of_components(tapered_sine(2.0)), [Resample(sampling_interval_s=interval)])
    time = np.arange(done.north.size) * interval
    expected = np.sin(2 * np.pi * 2 * time) * np.sin(np.pi * time / TIME[-1]) ** 2
    np.testing.assert_allclose(done.north[200:-200], expected[200:-200], atol=2e-3)
    assert done.sampling_interval == interval
    if interval > DT:
        high = process_record(
            trusted_record_of_components(tapered_sine(0.8 / (2 * DT))), [Resample(sampling_interval_s=interval)]
        ).north
        assert np.abs(high).max() < 0.05 or 0.5 / interval > 0.8 / (2 * DT)


def test_resampling_to_too_many_samples_is_refused():
    with expect_error(RecordError, "resample.sampling_interval_s 1e-05", "4e+07 samples, at most 3e+07"):
        process_record(trusted_record_of_components(np.zeros(40_000)), [Resample(sampling_interval_s=1e-5)])


def test_cut_preserves_the_samples_and_shifts_the_start_time():
    done = process_record(trusted_record_of_components(TIME.copy()), [Cut(start_s=1.5, end_s=3)])
    np.testing.assert_array_equal(done.north, TIME[150:301])
    assert done.start == "2001-02-03T04:05:07.5Z"


def test_processing_steps_run_in_order_and_are_recorded():
    done = process_record(trusted_record_of_components(np.full(6000, 2.0)), [Scale(factor=3), RemoveMean()])
    assert [s["step"] for s in done.processing] == ["scale", "remove_mean"]
    assert done.processing[0]["factor"] == 3
    assert done.processing[0]["effect"]["pga"] == [2.0, 6.0]
    assert done.processing[1]["effect"]["pga"] == [6.0, 0.0]
    twice = process_record(done, [Scale(factor=1)])
    assert len(twice.processing) == 3


def test_default_processing_changes_raw_but_not_processed_records():
    raw = trusted_record_of_components(tapered_sine(1.0) + 1.0)
    assert [s.step for s in default_processing_steps(raw)] == ["remove_mean", "taper", "highpass"]
    assert np.abs(process_record(raw, None).north).max() < 1.1
    agency = Record("r", raw.north, raw.east, None, DT, extra={"processed": True})
    assert process_record(agency, None) is agency


@pytest.mark.parametrize("count", [2, 5, 10])
def test_a_record_too_short_for_default_processing_is_refused(count):
    with expect_error(RecordError, f"record r: {count} samples are too few for the default processing", "processed"):
        process_record(trusted_record_of_components(np.arange(count, dtype=float)), None)


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (Lowpass(corner_hz=50), ["lowpass.corner_hz", "50 Hz"]),
        (Taper(length_s=40), ["taper.length_s", "half"]),
        (Lowpass(corner_hz=1e-9), ["lowpass.corner_hz 1e-09", "added zeros", "6e+11 samples, at most 3e+07"]),
        (Highpass(corner_hz=1e-12), ["highpass.corner_hz 1e-12", "added zeros", "6e+14 samples"]),  # 190 000 years
        (Cut(start_s=70), ["cut from 70 s to the end", "59.99"]),
        (Cut(end_s=61), ["cut", "59.99"]),
        (RemoveMean(first_s=100), ["remove_mean.first_s"]),
        (Resample(sampling_interval_s=math.e / 300), ["resample.sampling_interval_s"]),
        (Baseline(fit_from_s=59.95), ["baseline.fit_from_s"]),
        (Baseline(fit_from_s=50, t1_s=20.001, t2_s=20.002), ["baseline.t1_s 20.001 and t2_s 20.002", "0.01 s apart"]),
    ],
)
def test_the_error_names_a_processing_step_that_does_not_fit_the_record(step, words):
    with expect_error(RecordError, "record r", *words):
        process_record(trusted_record_of_components(TIME.copy()), [step])


@pytest.mark.parametrize(
    "data",
    [
        {"step": "bandpass"},
        {"step": "highpass"},
        {"step": "highpass", "corner_hz": 0},
        {"step": "highpass", "corner": 1},
        {"step": "baseline", "fit_from_s": 10, "t1_s": 5},
        {"step": "baseline", "fit_from_s": 10, "t1_s": 7, "t2_s": 5},
        {"step": "baseline", "scheme": "mine", "fit_from_s": 10},
        {"step": "cut", "start_s": 5, "end_s": 4},
        {"step": "taper", "length_s": -1},
        {"step": "detrend", "order": 9},
        *({"step": "taper", "length_s": length} for length in (math.inf, math.nan)),
        {"step": "cut", "end_s": math.inf},
        {"step": "remove_mean", "first_s": math.inf},
        {"step": "scale", "factor": math.inf},
    ],
)
def test_impossible_processing_steps_are_refused_in_a_study(data):
    with pytest.raises(ValidationError):
        TypeAdapter(Step).validate_python(data)


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ({"step": "cut", "start_s": 2.0, "end_s": None}, "cut from 2 s"),
        ({"step": "cut", "start_s": 2.0, "end_s": 7.5}, "cut from 2 s to 7.5 s"),
        ({"step": "resample", "sampling_interval_s": 0.005}, "resampled to 0.005 s"),
        ({"step": "taper", "length_s": 1.5}, "taper 1.5 s"),
    ],
)
def test_a_processing_step_has_a_short_description(step: dict[str, object], words: str) -> None:
    assert processing_entry_text(step) == words
