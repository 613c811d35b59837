"""Dead and clipped axes, and sampling intervals that no accelerograph has."""

import numpy as np
import pytest

from overturning.errors import RecordError
from overturning.motion.plausible import clipped_sample_count_and_level, reasons_to_doubt_sampling_interval
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.read import read_record_without_processing
from overturning.records.record import processing_peaks_and_notes_of_record
from tests.expect import expect_error

SAMPLING_RATE_HZ = 100.0
TIME = np.arange(2000) / SAMPLING_RATE_HZ
random = np.random.default_rng(5)


def band_limited_shaking(scale=1.0):
    """Band-limited noise under an envelope; its peak is ``scale``."""
    hertz = np.fft.rfftfreq(TIME.size, 1 / SAMPLING_RATE_HZ)
    noise = np.fft.irfft(np.fft.rfft(random.normal(size=TIME.size)) * ((hertz > 0.3) & (hertz < 12.0)), TIME.size)
    wave = noise * np.exp(-(((TIME - 8.0) / 3.0) ** 2))
    return scale * wave / np.abs(wave).max()


NORTH, EAST, UP = band_limited_shaking(1.8), band_limited_shaking(1.2), band_limited_shaking(0.6)


def write_columns(path, *axes, time=TIME):
    """Write a file with a column of times and a column for each axis."""
    np.savetxt(path, np.column_stack([time, *axes]), fmt="%.9g", delimiter=",")
    return path


def read_record_from_columns(path, declared="time:s north:m/s2 east:m/s2", **more):
    """Read a file of columns, whose quantities and units are in `declared`, without processing."""
    return read_record_without_processing(
        path, DeclaredFileProperties(columns=declared, processed=more.pop("processed", True), **more)
    )


CONSTANT_ACCELERATION = 0.3 + 0.0 * EAST
"""Raw samples only: an offset of processed samples is refused because of its velocity."""


@pytest.mark.parametrize(
    ("dead", "processed"),
    [
        (CONSTANT_ACCELERATION, False),
        *((one, state) for one in (0.0 * EAST, 5e-13 * EAST, 0.0066 * EAST) for state in (True, False)),
    ],
)
def test_a_horizontal_component_without_motion_is_refused_unless_trusted(tmp_path, dead, processed):
    path = write_columns(tmp_path / "x.csv", NORTH, dead)
    with expect_error(RecordError, "x.csv: axis 'east' is dead", "less than 1/100 of that of 'north'", "--trust-data"):
        read_record_from_columns(path, processed=processed)
    trusted = read_record_from_columns(path, processed=processed, trust_data=True)
    assert "axis 'east' is dead" in processing_peaks_and_notes_of_record(trusted)["trusted"][0]
    assert read_record_from_columns(write_columns(path, NORTH, 0.02 * EAST), processed=processed).notes == []


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_horizontal_components_with_the_same_samples_are_reported(tmp_path, sign):
    """Equal or opposite columns, such as of one file given twice, are reported; blocks would fall along one line."""
    path = write_columns(tmp_path / "x.csv", NORTH, 0.01 + sign * NORTH)
    (note,) = read_record_from_columns(path, processed=False).notes
    assert "x.csv: axes 'north' and 'east' have the same samples" in note
    assert read_record_from_columns(write_columns(path, NORTH, 0.98 * NORTH + 0.02 * EAST)).notes == []


def test_two_horizontal_components_without_motion_are_refused(tmp_path):
    """A record with vertical motion only is refused, because every block would stand under it."""
    declared = "time:s north:m/s2 east:m/s2 up:m/s2"
    path = write_columns(tmp_path / "x.csv", 1e-9 * NORTH, 1e-9 * EAST, UP)
    with expect_error(
        RecordError, "x.csv: axis 'east' and axis 'north' are dead", "vertical axis 'up'", "--trust-data"
    ):
        read_record_from_columns(path, declared)
    assert read_record_from_columns(write_columns(path, 0.02 * NORTH, 0.02 * EAST, UP), declared).notes == []


def test_a_component_that_turns_constant_during_the_motion_is_reported(tmp_path):
    """East is constant from 6 s on, although the ground still moves: north has its peak at 8 s."""
    path = write_columns(tmp_path / "x.csv", NORTH, np.where(TIME < 6.0, EAST, EAST[600]))
    (note,) = read_record_from_columns(path, processed=False).notes
    assert "x.csv: axis 'east' stands still from 6 to 19.99 s while the ground moves" in note
    quiet = TIME < 14.0
    assert read_record_from_columns(write_columns(path, NORTH * quiet, EAST * quiet)).notes == [], "zeros after both"
    assert read_record_from_columns(write_columns(path, NORTH, np.round(EAST / 0.4) * 0.4)).notes == [], (
        "a coarse digitiser"
    )


def test_a_vertical_component_without_motion_is_reported(tmp_path):
    declared = "time:s north:m/s2 east:m/s2 up:m/s2"
    (note,) = read_record_from_columns(write_columns(tmp_path / "x.csv", NORTH, EAST, 1e-9 * UP), declared).notes
    assert "vertical axis 'up' is dead" in note
    assert read_record_from_columns(write_columns(tmp_path / "x.csv", NORTH, EAST, UP), declared).notes == []


def test_a_clipped_component_is_reported_with_its_number_of_clipped_samples(tmp_path):
    clipped = np.clip(NORTH, -1.0, 1.0)
    at_rail = [run.size for run in np.split(clipped, np.flatnonzero(np.diff(clipped)) + 1) if abs(run[0]) == 1.0]
    count = sum(size for size in at_rail if size >= 3)
    assert count > 10
    record = read_record_from_columns(write_columns(tmp_path / "x.csv", clipped, EAST))
    (note,) = record.notes
    assert f"axis 'north' is clipped: {count} samples stand at its rail, 100 Gal" in note
    assert processing_peaks_and_notes_of_record(record)["notes"] == [note], "the report prints the account's notes"


@pytest.mark.parametrize("bits", [4, 6, 8, 10, 14])
@pytest.mark.parametrize("hertz", [0.1, 0.5, 1.0, 3.0])
def test_the_rounded_top_of_a_smooth_wave_is_not_taken_for_clipping(bits, hertz):
    """Coarse digitisers repeat samples at a peak, which is no clipping; a wave cut at 70 % of its peak is clipped."""
    wave = np.sin(2 * np.pi * hertz * TIME + 0.3) * np.exp(-TIME / 15)
    counts = np.round(wave * 2**bits)
    assert clipped_sample_count_and_level(counts) == (0, 0.0)
    level = np.floor(0.7 * np.abs(counts).max())
    cut = np.clip(counts, -level, level)
    if bits >= 8:
        assert clipped_sample_count_and_level(cut)[0] >= 3
        assert clipped_sample_count_and_level(cut)[1] == level
    assert clipped_sample_count_and_level(np.zeros(9)) == (0, 0.0)


def test_times_in_seconds_declared_as_milliseconds_are_refused(tmp_path):
    path = write_columns(tmp_path / "x.csv", NORTH, EAST)
    for more in ({"columns": "time:ms north:m/s2 east:m/s2"}, {"interval": 1e-5}):
        declared = more.get("columns", "skip north:m/s2 east:m/s2")
        with expect_error(
            RecordError,
            "x.csv: sampling interval 1e-05 s is doubtful: 0.0005 to 0.05 s are usual",
            "2000 samples then last 0.02 s",
            "--trust-data",
        ):
            read_record_from_columns(path, declared, sampling_interval_s=more.get("interval"))


@pytest.mark.parametrize(
    ("interval", "count", "said"),
    [
        (0.0004, 20000, "0.0005 to 0.05 s are usual"),
        (0.1, 200, "0.0005 to 0.05 s are usual"),
        (0.01, 150, "150 samples then last 1.5 s, less than 2 s"),
        (0.01, 2000, ""),
        (0.0005, 20000, ""),
        (0.05, 400, ""),
    ],
)
def test_a_doubtful_sampling_interval_is_noted(tmp_path, interval, count, said):
    time = np.arange(count) * interval
    # 1 Hz: PGV/PGA is 1/(2π) s.
    wave = np.sin(2 * np.pi * time)
    record = read_record_from_columns(write_columns(tmp_path / "x.csv", wave, wave / 2, time=time))
    assert len(record.notes) == bool(said)
    assert all(f"sampling interval {interval:g} s is doubtful: {said}" in note for note in record.notes)


@pytest.mark.parametrize(("hertz", "doubted"), [(25.0, False), (40.0, True)])
def test_a_sampling_interval_is_doubted_if_pgv_is_too_small_for_pga(hertz, doubted):
    time = np.arange(4000) / 1000.0
    doubts = reasons_to_doubt_sampling_interval([np.cos(2 * np.pi * hertz * time)], 0.001)
    assert [f"{1000 / (2 * np.pi * hertz):.2g} ms" in doubt for doubt in doubts] == [True] * doubted


def test_an_implausible_velocity_is_first_explained_by_the_sampling_interval(tmp_path):
    path = write_columns(tmp_path / "x.csv", NORTH, EAST)
    with expect_error(RecordError, "x.csv: sampling interval 0.5 s (0.0005 to 0.05 s are usual): peak velocity"):
        read_record_from_columns(path, "skip north:g east:g", sampling_interval_s=0.5)
