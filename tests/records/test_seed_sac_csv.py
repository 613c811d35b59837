import struct

import numpy as np
import obspy
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from overturning.errors import RecordError
from overturning.records.catalogue import RecordTableRow
from overturning.records.check import check_records_in_files, format_record_check
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.files import read_components
from overturning.records.formats.table import find_format_by_name_or_none_if_auto
from overturning.records.read import read, read_record, read_record_without_processing
from overturning.records.record import processing_state_label
from overturning.records.source import SourceFile
from tests.expect import expect_error
from tests.records.seed_writers import (
    START,
    broadband_velocity_response,
    trace_of_samples,
    write_mseed,
    write_sac,
    write_stationxml_of_channels,
)

quick_hypothesis_settings = settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
random = np.random.default_rng(11)
N, E, Z = (random.integers(-400_000, 400_000, 500) for _ in range(3))
CHANNEL_AZIMUTHS_AND_DIPS = {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0), "HNZ": (0.0, -90.0)}


def test_miniseed_is_read_with_the_stationxml_in_its_folder(tmp_path):
    write_stationxml_of_channels(tmp_path / "XX.TST1.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    (tmp_path / "other.xml").write_text("<notes>not about stations</notes>")
    path = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E, "HNZ": Z})
    record = read_record_without_processing(path)
    np.testing.assert_allclose(record.north, N / 400_000, rtol=1e-12)
    np.testing.assert_allclose(record.east, E / 400_000, rtol=1e-12)
    np.testing.assert_allclose(record.up, Z / 400_000, rtol=1e-12)
    assert record.start == "2001-02-03T04:05:06.5Z"
    assert (record.station, record.latitude) == ("TST1", 35.2)
    lines = [
        line for finding in check_records_in_files([tmp_path]) for line in format_record_check(finding).splitlines()
    ]
    for channel, samples, direction in (("HNN", N, "azimuth 0"), ("HNE", E, "azimuth 90"), ("HNZ", Z, "up")):
        said = f"{direction}, 500 samples, peak {np.abs(samples).max() / 4000:.4g} Gal, header states none"
        assert any(channel in line and line.endswith(said) for line in lines), channel


def test_the_orientation_of_miniseed_channels_comes_from_the_stationxml(tmp_path):
    write_stationxml_of_channels(tmp_path / "s.xml", {"HN1": (60.0, 0.0), "HN2": (150.0, 0.0), "HNZ": (0.0, 90.0)})
    record = read_record_without_processing(
        [write_mseed(tmp_path / "x.mseed", {"HN1": N, "HN2": E, "HNZ": Z}), tmp_path / "s.xml"]
    )
    c, s = np.cos(np.radians(60)), np.sin(np.radians(60))
    np.testing.assert_allclose(record.north, (N * c - E * s) / 400_000, atol=1e-9)
    np.testing.assert_allclose(record.east, (N * s + E * c) / 400_000, atol=1e-9)
    np.testing.assert_allclose(record.up, -Z / 400_000, rtol=1e-12)  # dip +90 points down


def test_channels_of_two_location_codes_are_refused_as_one_record(tmp_path):
    both = {f"{location}.{code}": axes for location in ("00", "10") for code, axes in CHANNEL_AZIMUTHS_AND_DIPS.items()}
    write_stationxml_of_channels(tmp_path / "s.xml", both)
    mixed = write_mseed(tmp_path / "x.mseed", {"00.HNN": N, "10.HNE": E})
    with expect_error(RecordError, "components of '00' and '10'; they are not of one record"):
        read_record_without_processing(mixed)
    # Regression: the first sensor lacks its north component and used that of the second.
    write_mseed(tmp_path / "x.mseed", {"00.HNE": E, "00.HNZ": Z, "10.HNE": E, "10.HNN": N, "10.HNZ": Z})
    assert [
        len(finding.components) for finding in check_records_in_files([tmp_path]) if finding.unprocessed_record
    ] == [3]


def test_an_accelerometer_and_a_velocity_sensor_are_refused_as_one_record(tmp_path):
    """Regression: a north component and an east one of another station or location were joined into one record."""
    metadata = write_stationxml_of_channels(
        tmp_path / "s.xml", {"HNN": (0.0, 0.0), "BNE": (90.0, 0.0), "HNE": (90.0, 0.0)}
    )
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "BNE": E})
    with expect_error(RecordError, "components of 'BN' and 'HN'; they are not of one record"):
        read_record_without_processing([waves, metadata])
    paths = [write_sac(tmp_path / f"{c}.sac", x / 1e5, c, a, 90.0) for c, x, a in (("HNN", N, 0.0), ("HHE", E, 90.0))]
    with expect_error(RecordError, "components of 'HN' and 'HH'"):
        read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))


def test_an_axis_direction_that_contradicts_the_channel_code_is_noted(tmp_path):
    """SEED codes N and E mean within 5° of north and east, Z up; if metadata differ, they are used, with a note."""
    metadata = tmp_path / "s.xml"
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E, "HNZ": Z})
    write_stationxml_of_channels(metadata, {"HNN": (356.0, 0.0), "HNE": (86.0, 0.0), "HNZ": (0.0, -90.0)})
    assert read_record_without_processing(waves).notes == []
    write_stationxml_of_channels(metadata, {"HNN": (90.0, 0.0), "HNE": (0.0, 0.0), "HNZ": (0.0, 90.0)})
    record = read_record_without_processing(waves)
    np.testing.assert_allclose(record.east, N / 400_000, rtol=1e-12)
    says = (("HNE", "at 0°", "east"), ("HNN", "at 90°", "north"), ("HNZ", "down", "up"))
    assert sorted(record.notes) == [
        f"channel {code} is taken {where}, as the StationXML says; its code says {coded}" for code, where, coded in says
    ]
    paths = [write_sac(tmp_path / f"{c}.sac", x / 1e5, c, a, 90.0) for c, x, a in (("HNN", N, 270.0), ("HN2", E, 0.0))]
    metadata.unlink()
    (note,) = read_record_without_processing(paths, DeclaredFileProperties(unit="gal")).notes
    assert note == "channel HNN is taken at 270°, as its header says; its code says north"


@pytest.mark.parametrize("later", [0.0, 0.3, 40.0])
def test_stations_in_one_miniseed_file_become_separate_records(tmp_path, later):
    """Regression: stations with different start times made one record, and so did two incomplete stations."""
    motions = {"TST1": {"HNE": E, "HNZ": Z}, "TST2": {"HNE": Z, "HNN": N, "HNZ": E}, "TST3": {"HNE": N, "HNN": E}}
    stream = obspy.Stream(
        [
            trace_of_samples(np.asarray(x, dtype=np.int32), code, station=name, start=START + later * k)
            for k, (name, channels) in enumerate(motions.items())
            for code, x in channels.items()
        ]
    )
    stream.write(str(tmp_path / "x.mseed"), format="MSEED")
    for name in motions:
        write_stationxml_of_channels(tmp_path / f"{name}.xml", CHANNEL_AZIMUTHS_AND_DIPS, station=name)
    found = check_records_in_files([tmp_path])
    assert [[one.axis_name_in_file for one in each.components] for each in found] == [
        list(motion) for motion in motions.values()
    ]
    assert found[0].unprocessed_record is None
    for each, motion in zip(found[1:], list(motions.values())[1:], strict=True):
        np.testing.assert_allclose(each.unprocessed_record.north, motion["HNN"] / 4e5, rtol=1e-12)
        np.testing.assert_allclose(each.unprocessed_record.east, motion["HNE"] / 4e5, rtol=1e-12)
    with expect_error(RecordError, "3 records (TST1, TST2, TST3); cut the file to one of them"):
        read_record_without_processing(tmp_path / "x.mseed")


@pytest.mark.parametrize("dip", [3.0, -4.9, 0.5])
def test_axes_inclined_by_a_few_degrees_keep_their_azimuth_and_sense(tmp_path, dip):
    """Regression: for a dip above 1° the channel code's direction replaced the stated azimuth, and down became up."""
    first, second = (
        (np.cos(np.radians(37.0)), np.sin(np.radians(37.0))),
        (-np.sin(np.radians(37.0)), np.cos(np.radians(37.0))),
    )
    north, east = (N * a + E * b for a, b in zip(first, second, strict=True))
    axes = {"HNN": (37.0, dip), "HNE": (127.0, dip), "HNZ": (0.0, 90.0 - abs(dip))}
    write_stationxml_of_channels(tmp_path / "s.xml", axes)
    record = read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E, "HNZ": Z}))
    for samples, truth in zip(record.components, (north, east, -Z), strict=True):
        np.testing.assert_allclose(samples, truth / 4e5, atol=1e-9)
    read_as = [
        note.partition(f"dips by {dip:g}°; it is read as ")[2] for note in record.notes if f"by {dip:g}°" in note
    ]
    assert read_as == ([] if abs(dip) < 1 else ["horizontal", "horizontal"])
    paths = [
        write_sac(tmp_path / f"{code}.sac", x / 1e5, code, azimuth, angle + 90.0)
        for (code, (azimuth, angle)), x in zip(axes.items(), (N, E, Z), strict=True)
    ]
    record = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    for samples, truth in zip(record.components, (north, east, -Z), strict=True):
        np.testing.assert_allclose(samples, truth / 1e7, atol=1e-8)


@pytest.mark.parametrize("dip", [6.0, 35.3, -54.7, 84.0])
def test_an_axis_neither_horizontal_nor_vertical_is_refused(tmp_path, dip):
    write_stationxml_of_channels(tmp_path / "s.xml", {"HNN": (0.0, dip), "HNE": (90.0, 0.0)})
    words = f"HNN dips by {dip:g}°; only axes within 5° of horizontal or vertical are read"
    with expect_error(RecordError, words):
        read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E}))
    with expect_error(RecordError, words):
        read_record_without_processing(
            write_sac(tmp_path / "a.sac", N / 1e5, "HNN", 0.0, dip + 90.0), DeclaredFileProperties(unit="gal")
        )


def test_stated_azimuth_without_dip_overrides_channel_code(tmp_path):
    """Regression: the direction that the channel code means replaced the stated azimuth."""
    paths = [
        write_sac(tmp_path / f"{c}.sac", x / 1e5, c, a, None) for c, x, a in (("HNN", N, 180.0), ("HNE", E, 270.0))
    ]
    record = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    np.testing.assert_allclose(record.horizontal_components, [-N / 1e7, -E / 1e7], atol=1e-8)
    assert "channel HNN is taken at 180°, as its header says; its code says north" in record.notes


def test_a_blank_location_code_identifies_a_separate_sensor(tmp_path):
    write_stationxml_of_channels(tmp_path / "s.xml", {"HNN": (0.0, 0.0), "10.HNE": (90.0, 0.0)})
    with expect_error(RecordError, "components of '--' and '10'; they are not of one record"):
        read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNN": N, "10.HNE": E}))


@pytest.mark.parametrize(
    ("words", "values", "why"),
    [
        ((70,), (-12345,), "HNE of HNE.sac does not say when it begins, other components do"),
        ((31, 32), (35.3, 133.4), "at 35.2° N, 133.4° E and at 35.3° N, 133.4° E, 11.1 km apart"),
        ((152, 153), (b"YY  ", b"    "), "components of 'XX' and 'YY'"),
    ],
)
def test_sac_components_of_different_stations_or_unknown_start_are_refused(tmp_path, words, values, why):
    """SAC words NZYEAR, STLA, STLO, KNETWK. Regression: an undated component was aligned by its first sample."""
    paths = [write_sac(tmp_path / f"{c}.sac", x / 1e5, c, a, 90.0) for c, x, a in (("HNN", N, 0.0), ("HNE", E, 90.0))]
    header = bytearray(paths[1].read_bytes())
    for word, value in zip(words, values, strict=True):
        code = {int: "<i", float: "<f", bytes: "4s"}[type(value)]
        struct.pack_into(code, header, 4 * word, value)
    paths[1].write_bytes(bytes(header))
    with expect_error(RecordError, why, "--trust-data"):
        read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    trusting = read_record_without_processing(paths, DeclaredFileProperties(unit="gal", trust_data=True))
    assert why in trusting.extra["trusted"][0]


def test_a_channel_that_ends_before_the_strong_motion_is_refused(tmp_path):
    """Regression: all components were cut to the shortest one without a note: a peak of 4 Gal instead of 100 Gal."""
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    rise = np.linspace(0, 1, N.size) ** 2
    path = write_mseed(tmp_path / "x.mseed", {"HNN": N * rise, "HNE": E * rise, "HNZ": (Z * rise)[:100]})
    with expect_error(RecordError, "HNZ breaks off after 100 of 500 samples, before the largest motion along HN"):
        read_record_without_processing(path)
    trusting = read_record_without_processing(path, DeclaredFileProperties(trust_data=True))
    assert trusting.sample_count == 100
    assert all("breaks off" in why for why in trusting.extra["trusted"])
    path = write_mseed(
        tmp_path / "x.mseed", {"HNN": N * rise[::-1], "HNE": E * rise[::-1], "HNZ": (Z * rise[::-1])[:100]}
    )
    assert read_record_without_processing(path).sample_count == 100, "the coda of a record may be short"


def test_miniseed_with_gaps_is_refused(tmp_path):
    import obspy

    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    pieces = [
        trace_of_samples(N[:200].astype(np.int32), "HNN"),
        trace_of_samples(N[300:].astype(np.int32), "HNN", start=START + 3.0),
    ]
    stream = obspy.Stream([*pieces, trace_of_samples(E.astype(np.int32), "HNE")])
    stream.write(str(tmp_path / "x.mseed"), format="MSEED")
    with pytest.raises(RecordError, match="gap"):
        read_record_without_processing(tmp_path / "x.mseed")


@pytest.mark.parametrize("at", [200, 300, 400])
def test_miniseed_with_wrong_check_values_is_refused_unless_trusted(tmp_path, at):
    """Regression: a changed byte among differences of samples shifted all later samples, with a note alone."""
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    path = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E})
    data = bytearray(path.read_bytes())
    data[at] ^= 0x10
    path.write_bytes(data)
    with expect_error(
        RecordError, "x.mseed: obspy warns: ", "integrity check", "get the file again, or say --trust-data"
    ):
        read_record_without_processing(path)
    record = read_record_without_processing(path, DeclaredFileProperties(trust_data=True))
    assert any("integrity check" in text for text in record.extra["trusted"])
    assert not any("integrity check" in text for text in record.notes)


def test_the_response_of_a_velocity_sensor_is_deconvolved(tmp_path):
    """A 1-Hz sine of velocity V gives an acceleration of 2πV in the middle of the record."""
    time = np.arange(4000) / 100
    counts = np.round(1e6 * np.sin(2 * np.pi * time)).astype(np.int32)
    write_stationxml_of_channels(tmp_path / "s.xml", {"HHN": (0.0, 0.0), "HHE": (90.0, 0.0)}, gain=1e7, unit="M/S")
    record = read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HHN": counts, "HHE": counts // 2}))
    middle = record.north[1500:2500]
    assert np.abs(middle).max() == pytest.approx(0.1 * 2 * np.pi, rel=0.01)
    np.testing.assert_allclose(middle, 0.1 * 2 * np.pi * np.cos(2 * np.pi * time[1500:2500]), atol=0.01)
    assert processing_state_label(record) == "raw, response of a velocity sensor removed"


@pytest.mark.parametrize(
    ("frequency", "length", "shock", "rate"),
    [(0.3, 120, 60, 100), (5.0, 120, 60, 100), (20.0, 120, 60, 100), (35.0, 120, 60, 100), (1.0, 3600, 40, 20)],
)
def test_deconvolution_of_a_broadband_sensor_keeps_high_frequencies_and_early_motion(
    tmp_path, frequency, length, shock, rate
):
    """The counts are the sensor's closed-form response to a burst of acceleration a cos(2πft) with a peak of 1 Gal."""
    time = np.arange(length * rate) / rate
    wave = 0.01 * np.cos(2 * np.pi * frequency * time) * np.exp(-(((time - shock) / 6) ** 2))
    hertz = np.fft.rfftfreq(time.size, 1 / rate)
    speed = np.zeros(hertz.size, complex)
    speed[1:] = np.fft.rfft(wave)[1:] / (2j * np.pi * hertz[1:]) * broadband_velocity_response(hertz[1:])
    counts = 1e9 * np.fft.irfft(speed, time.size)
    axes = {"HHN": (0.0, 0.0), "HHE": (90.0, 0.0)}
    write_stationxml_of_channels(tmp_path / "s.xml", axes, gain=1e9, unit="M/S", broadband=True, rate=rate)
    traces = {"HHN": np.round(counts), "HHE": np.round(counts / 2)}
    record = read_record_without_processing(write_mseed(tmp_path / "x.mseed", traces, rate=rate))
    np.testing.assert_allclose(record.north, wave, atol=1e-4 * wave.max())
    # A burst of 35 Hz has PGV/PGA near 1/(2π 35 Hz) = 4.5 ms, which no earthquake has.
    assert [note for note in record.notes if "PGV/PGA is then" not in note] == []
    assert bool(record.notes) == (frequency == 35.0)


def test_an_overdriven_velocity_sensor_is_noted_and_a_wrong_unit_refused(tmp_path):
    counts = np.round(1e6 * np.sin(np.arange(4000) / 16)).astype(np.int32)  # 10 cm/s
    write_stationxml_of_channels(tmp_path / "s.xml", {"HHN": (0.0, 0.0), "HHE": (90.0, 0.0)}, gain=1e7, unit="M/S")
    notes = read_record_without_processing(
        write_mseed(tmp_path / "x.mseed", {"HHN": counts, "HHE": counts // 100})
    ).notes
    assert len(notes) == 1
    assert "channel HHN of a velocity sensor reaches 10 cm/s: most saturate" in notes[0]
    write_stationxml_of_channels(tmp_path / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)}, gain=1e7, unit="M/S")
    with expect_error(RecordError, "is of an accelerometer by its code (N), but in M/S in the StationXML"):
        read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNN": counts, "HNE": counts}))


def test_sac_needs_a_declared_unit_and_has_its_orientation_in_the_header(tmp_path):
    paths = [
        write_sac(tmp_path / "T.HN1.sac", N / 1e5, "HN1", 332.0, 90.0),
        write_sac(tmp_path / "T.HN2.sac", E / 1e5, "HN2", 62.0, 90.0),
        write_sac(tmp_path / "T.HNZ.sac", Z / 1e5, "HNZ", 0.0, 0.0),
    ]
    with pytest.raises(RecordError, match="unit"):
        read_record_without_processing(paths)
    record = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    c, s = np.cos(np.radians(332)), np.sin(np.radians(332))
    np.testing.assert_allclose(record.north, (N * c - E * s) / 1e7, atol=1e-7)
    np.testing.assert_allclose(record.up, Z / 1e7, atol=1e-8)
    assert record.start == "2001-02-03T04:05:06.5Z"
    same = read(paths, unit="gal", record_id="t", processing=[])
    np.testing.assert_allclose(same.up, record.up, atol=5.1e-10)
    assert same.record_id == "t"
    entry = RecordTableRow(id="t", source="T.HN1.sac T.HN2.sac T.HNZ.sac", unit="g")
    np.testing.assert_allclose(read_record(entry, tmp_path).up, Z / 1e5 * 9.80665, atol=1e-5)


def test_the_origin_of_a_sac_file_is_relative_to_its_reference_time(tmp_path):
    """The first sample is 3 s after the reference time (header word 5, B), the origin time 1 s after it (word 7, O)."""
    axes = (("HNN", N / 1e5, 0.0), ("HNE", E / 1e5, 90.0))
    paths = [write_sac(tmp_path / f"{name}.sac", x, name, azimuth, 90.0) for name, x, azimuth in axes]
    for path in paths:
        header = bytearray(path.read_bytes())
        for word, value in ((5, 3.0), (7, 1.0)):
            header[4 * word : 4 * word + 4] = struct.pack("<f", value)
        path.write_bytes(bytes(header))
    record = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    first, origin = (np.datetime64(text.rstrip("Z")) for text in (record.start, record.extra["origin_time"]))
    assert first - origin == np.timedelta64(2, "s")
    for path in paths:  # without a reference time (words 70 to 75) both are unknown
        header = bytearray(path.read_bytes())
        header[280:304] = struct.pack("<6i", *[-12345] * 6)
        path.write_bytes(bytes(header))
    undated = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    assert undated.start is None
    assert "origin_time" not in undated.extra


@pytest.mark.parametrize(("depth", "sensor"), [(0.0, "surface"), (2.0, "surface"), (100.0, "borehole")])
def test_the_depth_in_the_stationxml_identifies_a_borehole(tmp_path, depth, sensor):
    files = [write_mseed(tmp_path / "a.mseed", {"HNN": N, "HNE": E})]
    files.append(write_stationxml_of_channels(tmp_path / "a.xml", {"HNN": (0, 0), "HNE": (90, 0)}, depth=depth))
    other = "surface" if sensor == "borehole" else "borehole"
    assert read_record_without_processing(files, DeclaredFileProperties(sensor=sensor)).station == (
        "TST1" if sensor == "surface" else "TST1 (borehole)"
    )
    with pytest.raises(RecordError, match=f"is of the {sensor} sensor of TST1; declare it"):
        read_record_without_processing(files, DeclaredFileProperties(sensor=other))


@pytest.mark.parametrize(
    ("channels", "stationxml", "words"),
    [
        (("HNN", "HNE"), None, ["give the station's StationXML"]),
        (("HNN", "HNE"), {"HNN": (0, 0)}, ["XX.TST1..HNE", "not in the StationXML"]),
        (("HHN", "HHE"), {"HHN": (0, 0), "HHE": (90, 0)}, ["is of a velocity sensor by its code", "in M/S**2"]),
    ],
)
def test_miniseed_without_a_fitting_stationxml_is_refused(tmp_path, channels, stationxml, words):
    files = [write_mseed(tmp_path / "a.mseed", dict(zip(channels, (N, E), strict=True)))]
    if stationxml:
        files.append(write_stationxml_of_channels(tmp_path / "a.xml", stationxml))
    with expect_error(RecordError, "a.mseed", *words):
        read_record_without_processing(files)
    if "HHN" in channels:
        assert read_record_without_processing(files, DeclaredFileProperties(unit="m/s2")).station == "TST1"


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [("idep", 7, "velocity by its header (IDEP 7)"), ("stdp", 30.0, "is of the borehole sensor of TST1")],
)
def test_sac_whose_header_states_velocity_or_a_borehole_is_refused(tmp_path, key, value, words):
    for channel, azimuth in (("HNN", 0.0), ("HNE", 90.0)):
        path = write_sac(tmp_path / f"a.{channel}.sac", np.sin(np.arange(400) / 9), channel, azimuth, 90.0)
        trace = obspy.read(path)[0]
        trace.stats.sac[key] = value
        trace.write(str(path), format="SAC")
    with expect_error(RecordError, "a.HNE.sac" if key == "idep" else "a.HN", words):
        read_record_without_processing(path, DeclaredFileProperties(unit="m/s2"))


@pytest.mark.parametrize(
    ("word", "value", "words"),
    [(85, 2, "a spectrum"), (85, 3, "a spectrum"), (85, 4, "x and y"), (105, 0, "uneven times"), (86, 50, "volts")],
)
def test_sac_other_than_evenly_sampled_accelerations_is_refused(tmp_path, word, value, words):
    """Header words 85, 86 and 105 (IFTYPE, IDEP, LEVEN). Regression: such files were read as accelerations."""
    paths = [write_sac(tmp_path / f"{name}.sac", N / 1e5, name, 0.0, 90.0) for name in ("HNN", "HNE")]
    for path in paths:
        header = bytearray(path.read_bytes())
        struct.pack_into("<i", header, 4 * word, value)
        path.write_bytes(bytes(header))
    with expect_error(RecordError, "HNN.sac", words, "by its header"):
        read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))


@pytest.mark.parametrize(("unit", "scale"), [("M/S**2", 1.0), ("CM/S**2", 0.01), ("G", 9.80665)])
def test_the_unit_of_sac_samples_is_read_from_stationxml(tmp_path, unit, scale):
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, gain=4e5, unit=unit)
    paths = [write_sac(tmp_path / f"{name}.sac", x, name, 0.0, 90.0) for name, x in (("HNN", N), ("HNE", E))]
    np.testing.assert_allclose(
        read_record_without_processing([*paths, tmp_path / "s.xml"]).north, N / 4e5 * scale, rtol=1e-6
    )
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, unit="V")
    with expect_error(RecordError, "HNN.sac", "V in the StationXML"):
        read_record_without_processing([*paths, tmp_path / "s.xml"])


def test_the_scale_in_a_sac_header_is_not_applied_with_a_note(tmp_path):
    """Header word 3, SCALE, is not used by SAC itself; obspy multiplies by it."""
    paths = [write_sac(tmp_path / f"{c}.sac", x / 1e5, c, a, 90.0) for c, x, a in (("HNN", N, 0.0), ("HNE", E, 90.0))]
    plain = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    assert plain.notes == []
    for path in paths:
        header = bytearray(path.read_bytes())
        struct.pack_into("<f", header, 4 * 3, 0.5)
        path.write_bytes(bytes(header))
    scaled = read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))
    np.testing.assert_array_equal(scaled.north, plain.north)
    told = "its header's SCALE, 0.5, is not applied: samples are in gal, as declared"
    assert scaled.notes == [f"{name}.sac: {told}" for name in ("HNN", "HNE")]


@pytest.mark.parametrize("order", ["<", ">"])
def test_sac_is_recognised_by_version_and_length(tmp_path, order):
    """Words 76 and 79 of the header: NVHDR, 6 or 7, and NPTS, 32-bit whole numbers of either byte order."""
    header = write_sac(tmp_path / "a.sac", N, "HNN", 0.0, 90.0).read_bytes()[:632]
    for version, length, known in [(6, 10**8, True), (7, 0, True), (5, 500, False), (6, -1, False), (6, 2**30, False)]:
        words = bytearray(header)
        struct.pack_into(f"{order}i", words, 76 * 4, version)
        struct.pack_into(f"{order}i", words, 79 * 4, length)
        assert find_format_by_name_or_none_if_auto("sac").matches_file(SourceFile("a.sac", bytes(words))) is known, (
            version,
            length,
        )


def test_sac_whose_peak_contradicts_its_header_is_refused(tmp_path):
    path = write_sac(tmp_path / "a.sac", N / 1e5, "HNN", 0.0, 90.0)
    other = write_sac(tmp_path / "b.sac", E / 1e5, "HNE", 90.0, 90.0)
    data = bytearray(path.read_bytes())
    data[632:] = (np.frombuffer(bytes(data[632:]), "<f4") * 2).astype("<f4").tobytes()
    path.write_bytes(bytes(data))
    with pytest.raises(RecordError, match="states a peak"):
        read_record_without_processing([path, other], DeclaredFileProperties(unit="gal"))


def test_sac_samples_with_the_opposite_sign_of_the_header_extremes_are_refused(tmp_path):
    """A SAC header states the largest and the smallest sample (DEPMAX, DEPMIN) with their signs."""
    peak = np.where(np.arange(N.size) == 50, 600.0, N / 1e3)
    paths = [
        write_sac(tmp_path / f"{c}.sac", x, c, a, 90.0) for c, x, a in (("HNN", peak, 0.0), ("HNE", E / 1e3, 90.0))
    ]
    data = paths[0].read_bytes()
    samples = np.frombuffer(data[632:], "<f4")
    np.testing.assert_allclose(samples, peak, rtol=1e-6)
    paths[0].write_bytes(data[:632] + (-samples).tobytes())
    with expect_error(RecordError, "HNN.sac: the header states a peak of 600 Gal along HNN, the data has -600 Gal"):
        read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))


@pytest.mark.parametrize("separator", [",", ";", "\t", "  "])
def test_a_columns_file_is_read_as_declared(tmp_path, separator):
    path = tmp_path / "x.csv"
    rows = [
        separator.join(f"{v:g}" for v in row)
        for row in zip(np.arange(500) * 0.01, E / 100, N / 100, -Z / 100, strict=True)
    ]
    path.write_text("# mine\n" + separator.join(["t", "a_e", "a_n", "down"]) + "\n" + "\n".join(rows) + "\n")
    entry = RecordTableRow(
        id="x", format="csv", source="x.csv", processed=True, columns="time:s east:mm/s2 north:mm/s2 down:mm/s2"
    )
    record = read_record(entry, tmp_path)
    np.testing.assert_allclose(record.north, [float(f"{v / 100:g}") / 1000 for v in N], rtol=1e-12)
    np.testing.assert_allclose(record.up, [float(f"{v / 100:g}") / 1000 for v in Z], rtol=1e-12)
    assert record.sampling_interval == 0.01


@pytest.mark.parametrize(
    ("text", "columns", "interval", "words"),
    [
        ("1,2\n3,4\n", "", None, ["format is not recognised"]),
        ("1,2\n3,4\n", "north:gal east", None, ["'east'"]),
        ("1,2\n3,4\n", "north:gal east:feet", None, ["'east:feet'"]),
        ("1,2\n3,4\n", "north:gal east:gal", None, ["sampling_interval_s"]),
        ("1,2\n3\n", "north:gal east:gal", 0.01, ["line 2", "1 columns"]),
        ("1,2\n3,nan\n", "north:gal east:gal", 0.01, ["line 2", "nan"]),
        ("1,2\n3,\n", "north:gal east:gal", 0.01, ["line 2", "''"]),
        ("n,e\n1,2\nx,y\n", "north:gal east:gal", 0.01, ["line 3", "'x'"]),  # a word below numbers is no heading
        ("1 2 3\n4 5\n6 7 8\n", "north:gal*3", 0.01, ["line 2", "2 values, 3 are declared"]),
        ("1 2 3 4\n", "north:gal*3", 0.01, ["line 1", "4 values, 3 are declared"]),
        (" 1.00 2.00\n 3.0\n", "north:gal*2F5", 0.01, ["line 2", "of 5 characters"]),
        ("1 2\n", "north:gal*2 east:gal", 0.01, ["only a single column"]),
        ("1\n2\n", "y.csv=north:gal", 0.01, ["no columns are declared of it, only of y.csv"]),
        ("1\n2\n", "north:gal y.csv=east:gal", 0.01, ["'north:gal' stands before the name of its file"]),
        ("0,1,2\n1,3,4\n3,5,6\n", "time:s north:gal east:gal", None, ["line 2", "evenly"]),
        ("0,1,2\n0,3,4\n0,5,6\n", "time:s north:gal east:gal", None, ["evenly"]),
        ("0,1,2\n.1,3,4\n.2,5,6\n", "time:s north:gal east:gal", 0.2, ["0.1 s apart", "0.2"]),
        ("0,5;1,5\n0,6;1,6\n", "north:gal east:gal", 0.01, ["line 1", "'0,5'"]),
    ],
)
def test_a_columns_file_that_contradicts_its_declaration_is_refused(tmp_path, text, columns, interval, words):
    path = tmp_path / "x.csv"
    path.write_text(text)
    with expect_error(RecordError, "x.csv", *words):
        read_record_without_processing(
            path, DeclaredFileProperties(columns=columns, sampling_interval_s=interval, processed=True)
        )


@pytest.mark.parametrize(
    ("headings", "told"),
    [
        ("t,N,E", []),
        ("time (s),acc 1,acc 2", []),
        ('T,360 (cm/s/s),"E" [cm/s²]', []),
        ("t,E,N", ["'E' is taken as north in gal", "'N' is taken as 90 in gal"]),
        ("t,north (g),east", ["'north (g)' is taken as north in gal"]),
        ("t,N,Up", ["'Up' is taken as 90 in gal"]),
        ("time,HNE,HNN", ["'HNE' is taken as north in gal", "'HNN' is taken as 90 in gal"]),
        ("time,HNN,HNE", []),
        ("t,acc_e,acc_n", ["'acc_e' is taken as north in gal", "'acc_n' is taken as 90 in gal"]),
        ("t,aN (m s-2),aE", ["'aN (m s-2)' is taken as north in gal"]),
        (
            "t,Acc.E-W(gal),Acc. [N-S]",
            ["'Acc.E-W(gal)' is taken as north in gal", "'Acc. [N-S]' is taken as 90 in gal"],
        ),
        ("% t,E,N", ["'E' is taken as north in gal", "'N' is taken as 90 in gal"]),
        ("// t,E,N", ["'E' is taken as north in gal", "'N' is taken as 90 in gal"]),
        ("t,H1,H2", []),
        ("t,acc m/s/s,acc in gal", []),
    ],
)
def test_column_headings_that_contradict_the_declaration_are_noted(tmp_path, headings, told):
    """Regression: east declared as north was accepted without a note, although the heading contradicted it."""
    path = tmp_path / "x.csv"
    path.write_text(f"{headings}\n" + "".join(f"{n / 100},{n},{-2 * n}\n" for n in range(250)))
    record = read_record_without_processing(
        path, DeclaredFileProperties(columns="time:s north:gal 90:gal", processed=True)
    )
    assert record.notes == [f"x.csv: the column under {why}, as declared" for why in told]


@pytest.mark.parametrize(
    ("line", "unit"),
    [
        ("Units: g", "g"),
        ("# Acceleration in m/s^2", "m/s2"),
        ("% corrected acceleration (mm/s/s)", "mm/s2"),
        ("acceleration (cm/s/s) of Station X", ""),
        ("peak velocity 12 cm/s, peak acceleration 0.3 g", ""),
        ("Vs30 of 300 m/s by unit 5", ""),
    ],
)
def test_a_line_of_a_columns_file_naming_an_undeclared_unit_adds_a_note(tmp_path, line, unit):
    path = tmp_path / "x.txt"
    path.write_text(f"{line}\n" + "".join(f"{n / 100} {n} {n * n % 7} 0 0 0\n" for n in range(250)))
    record = read_record_without_processing(
        path, DeclaredFileProperties(columns="time:s north:gal east:gal skip skip skip", processed=True)
    )
    told = [f"x.txt: the line {line.lstrip('#% ')!r} names {unit}; columns are taken in gal, as declared"]
    assert record.notes == (told if unit else [])


@pytest.mark.parametrize("line", ["Velocity (cm/s)", "# corrected velocity", "Units: cm/s", "% Displacement in cm"])
def test_a_columns_file_whose_text_states_another_quantity_is_refused(tmp_path, line):
    path = tmp_path / "x.txt"
    path.write_text(f"{line}\n" + "".join(f"{n / 100} {n} {n * n % 7} 0 0 0\n" for n in range(250)))
    with expect_error(RecordError, "x.txt", f"the line {line.lstrip('#% ')!r} says", "--trust-data"):
        read_record_without_processing(
            path, DeclaredFileProperties(columns="time:s north:gal east:gal skip skip skip", processed=True)
        )


SCEC_HEADING = "#    time(sec)      E-W({0})      N-S({0})      U-D({0})"


@pytest.mark.parametrize(
    ("headings", "columns", "told"),
    [
        (SCEC_HEADING.format("cm/s/s"), "time:s east:gal north:gal up:gal", []),
        (SCEC_HEADING.format("cm/sec^2"), "time:s east:gal north:gal up:gal", []),
        (SCEC_HEADING.format("cm/s/s"), "time:s north:gal east:gal up:gal", ["E-W(cm/s/s)", "N-S(cm/s/s)"]),
        (SCEC_HEADING.format("m/s/s"), "time:s east:gal north:gal up:gal", ["E-W(m/s/s)", "N-S(m/s/s)", "U-D(m/s/s)"]),
        ("# by hand\nStation X, 5 km\nt;E;N;Z\ns;g;g;g", "time:s east:gal north:gal up:gal", ["g", "g", "g"]),
        (SCEC_HEADING.format("cm/s/s"), "time:ms east:gal north:gal up:gal", ["time(sec)"]),
    ],
)
def test_column_headings_after_a_hash_or_on_several_lines_are_read(tmp_path, headings, columns, told):
    """Regression: headings after # were ignored, and a second heading was refused."""
    separator = ";" if ";" in headings else "\t"
    rows = [separator.join(map(str, (n, n * n % 7, -2 * n, 3 * n))) for n in range(250)]
    path = tmp_path / "x.bbp"
    path.write_text("\n".join([*headings.split("\n"), *rows]) + "\n")
    record = read_record_without_processing(
        path, DeclaredFileProperties(columns=columns, processed=True, trust_data=True)
    )
    said = [note for note in record.notes if "as declared" in note]
    assert [
        note for note, text in zip(said, dict.fromkeys(told), strict=False) if f"under {text!r} is" not in note
    ] == []
    assert len(said) == len(told)
    first = [-2 * n / 100 for n in range(250)] if "east:gal north" in columns else [n * n % 7 / 100 for n in range(250)]
    np.testing.assert_allclose(record.north, first, rtol=1e-12)


@pytest.mark.parametrize(
    "unit", ["(cm/s)", "(m/s)", " velocity", "_vel", "(cm/sec)", " [mm/s]", "(cm)", " displ.", " counts"]
)
@pytest.mark.parametrize("mark", ["# ", ""])
def test_a_column_whose_heading_states_another_quantity_is_refused(tmp_path, unit, mark):
    """Regression: SCEC's .vel.bbp (velocity) was read as accelerations of 22 Gal."""
    path = tmp_path / "a.vel.bbp"
    path.write_text(f"{mark}time (s)\tN-S{unit}\tE-W{unit}\n" + "".join(f"{n / 100}\t{n}\t{-n}\n" for n in range(250)))
    declared = {"columns": "time:s north:gal east:gal", "processed": True}
    with expect_error(RecordError, "a.vel.bbp", "north in gal is declared", "--trust-data"):
        read_record_without_processing(path, DeclaredFileProperties(**declared))
    assert any(
        "trusted although" in note
        for note in read_record_without_processing(path, DeclaredFileProperties(**declared, trust_data=True)).notes
    )


def test_one_file_per_component_is_declared_by_file_names(tmp_path):
    """Regression: one file per component could not be declared."""
    axes = {"n": N / 1e3, "e": E / 1e3, "z": Z / 1e3}
    for stem in ("a", "b"):
        for axis, samples in axes.items():
            text = "".join(f"{v!r}\n" for v in (samples * (1 + (stem == "b"))).tolist())
            (tmp_path / f"{stem}_{axis}.txt").write_text(text)
    given_ = {"sampling_interval_s": 0.01, "processed": True}
    exact = DeclaredFileProperties(columns="a_n.txt=north:gal a_e.txt=east:gal a_z.txt=down:gal", **given_)
    starred = DeclaredFileProperties(columns="*_n.txt=north:gal *_e.txt=east:gal *_z.txt=down:gal", **given_)
    three = [tmp_path / f"a_{axis}.txt" for axis in "zne"]
    for paths, declared in (([three[1]], exact), (three, exact), (three, starred)):
        record = read_record_without_processing(paths, declared)
        for found, samples in ((record.north, N), (record.east, E), (record.up, -Z)):
            np.testing.assert_allclose(found, samples / 1e5, rtol=1e-12)
    found = check_records_in_files([tmp_path], starred)
    assert [finding.file_names for finding in found] == [tuple(f"{s}_{a}.txt" for a in "enz") for s in "ab"]
    np.testing.assert_allclose(found[1].unprocessed_record.north, 2 * N / 1e5, rtol=1e-12)
    entry = RecordTableRow(id="x", source="a_n.txt a_e.txt a_z.txt", columns=exact.columns, **given_)
    np.testing.assert_allclose(read_record(entry, tmp_path).up, -Z / 1e5, rtol=1e-12)


@pytest.mark.parametrize("begin", ["500", "500\n0.01", "500 0.01"])
def test_a_sample_count_before_the_samples_is_not_read_as_a_sample(tmp_path, begin):
    """Regression: a first line with the count of samples was read as a sample of several g."""
    declared = {"columns": "north:gal east:gal" if " " in begin else "north:gal", "sampling_interval_s": 0.01}
    rows = [f"{n} {e}" if " " in begin else f"{n}" for n, e in zip(N / 1e3, E / 1e3, strict=True)]
    source = SourceFile("x.txt", "\n".join([begin, *rows, ""]).encode())
    with expect_error(
        RecordError, "x.txt line 1: 500 is the count of the lines below, not a sample; write # before it"
    ):
        read_components([source], DeclaredFileProperties(**declared, processed=True))
    commented = SourceFile("x.txt", "\n".join([*(f"# {line}" for line in begin.split("\n")), *rows, ""]).encode())
    first = read_components([commented], DeclaredFileProperties(**declared, processed=True))[0]
    np.testing.assert_allclose(first.acceleration, N / 1e5, rtol=1e-12)
    assert read_components([source], DeclaredFileProperties(**declared, processed=True, trust_data=True))


@pytest.mark.parametrize("mark", ["999", "-999.99", "999.9", "9999.0", "99999"])
@pytest.mark.parametrize("wrapped", [False, True])
def test_a_mark_of_a_missing_sample_is_not_read_as_a_sample(tmp_path, mark, wrapped):
    """Regression: 999.99 in place of a missing sample was read as an acceleration of 1 g."""
    words = [f"{value}" for value in N[:80] / 1e4]  # up to 40 Gal
    declared = {"columns": "north:gal*8" if wrapped else "north:gal", "sampling_interval_s": 0.01, "processed": True}

    def source_file_of_printed_samples(words):
        rows = [" ".join(words[i : i + 8]) for i in range(0, 80, 8)] if wrapped else words
        return SourceFile("x.txt", "\n".join([*rows, ""]).encode())

    (whole,) = read_components([source_file_of_printed_samples(words)], DeclaredFileProperties(**declared))
    np.testing.assert_allclose(whole.acceleration, N[:80] / 1e6, rtol=1e-12)
    spoilt = source_file_of_printed_samples([*words[:30], mark, *words[31:]])
    line = 30 // 8 + 1 if wrapped else 31
    with expect_error(RecordError, f"x.txt line {line}: {abs(float(mark)):g} marks a missing sample"):
        read_components([spoilt], DeclaredFileProperties(**declared))
    assert read_components([spoilt], DeclaredFileProperties(**declared, trust_data=True))
    close = source_file_of_printed_samples(
        [*words[:30], mark, f"{0.6 * float(mark)}", *words[32:]]
    )  # a peak that is a number of nines
    assert read_components([close], DeclaredFileProperties(**declared))


def test_component_files_are_matched_by_all_variable_parts_of_their_names(tmp_path):
    """Regression: with two asterisks, the north of one record could be paired with the east of another."""
    given_ = {"sampling_interval_s": 0.01, "processed": True}
    for name, samples in (("a_e_1", N), ("a_e_2", E), ("a_n_2", Z)):
        (tmp_path / f"{name}.txt").write_text("".join(f"{v}\n" for v in samples / 1e3))
    declared = DeclaredFileProperties(columns="*_n_*.txt=north:gal *_e_*.txt=east:gal", **given_)
    alone, pair = check_records_in_files([tmp_path], declared)
    assert (alone.file_names, alone.unprocessed_record) == (("a_e_1.txt",), None)
    assert pair.file_names == ("a_e_2.txt", "a_n_2.txt")
    np.testing.assert_allclose(pair.unprocessed_record.horizontal_components, [Z / 1e5, E / 1e5], rtol=1e-12)
    twofold = DeclaredFileProperties(columns="*n*.txt=north:gal *a*.txt=east:gal", **given_)
    with expect_error(
        RecordError, "a_n_2.txt: its name fits *n*.txt and *a*.txt; write patterns that fit one axis each"
    ):
        read_record_without_processing(tmp_path / "a_n_2.txt", twofold)
    named = DeclaredFileProperties(columns="*.txt=east:gal a_n_2.txt=north:gal", **given_)
    paths = [tmp_path / "a_e_2.txt", tmp_path / "a_n_2.txt"]
    np.testing.assert_allclose(read_record_without_processing(paths, named).north, Z / 1e5, rtol=1e-12)


@pytest.mark.parametrize(("word", "width"), [("*8", 0), ("*8F10", 10), ("*8F10.3", 10)])
def test_samples_continued_over_several_lines_are_read_in_order(tmp_path, word, width):
    """Each line has eight values, the last one fewer; columns of fixed width touch each other."""
    for axis, samples in (("n", N), ("e", E)):
        cells = [f"{v / 1e3:.3f}".rjust(width) if width else f"{v / 1e3:.3f} " for v in samples[:403]]
        lines = ["STATION X", "ACCELERATION, 403 VALUES", *("".join(cells[i : i + 8]) for i in range(0, 403, 8))]
        (tmp_path / f"{axis}.dat").write_text("\n".join(lines) + "\n")
    columns = f"n.dat=north:gal{word} e.dat=east:gal{word}"
    declared = DeclaredFileProperties(columns=columns, sampling_interval_s=0.01, processed=True, trust_data=True)
    record = read_record_without_processing([tmp_path / "n.dat", tmp_path / "e.dat"], declared)
    np.testing.assert_allclose(record.north, np.round(N[:403] / 1e3, 3) / 100, rtol=1e-12)
    np.testing.assert_allclose(record.east, np.round(E[:403] / 1e3, 3) / 100, rtol=1e-12)


@quick_hypothesis_settings
@given(st.integers(2, 60).flatmap(lambda n: arrays(np.int64, (2, n), elements=st.integers(-99999, 99999))), st.data())
def test_any_written_columns_file_is_read_back(samples, data):
    unit, scale = data.draw(st.sampled_from([("g", 9.80665), ("gal", 0.01), ("m/s2", 1.0)]))
    text = "".join(f"{a!r},{b!r}\n" for a, b in (samples.T / 10).tolist())
    # Trusted, because the first sample may equal the number of rows.
    declared = DeclaredFileProperties(
        columns=f"north:{unit} east:{unit}", sampling_interval_s=0.01, processed=True, trust_data=True
    )
    for component, expected in zip(read_components([SourceFile("x", text.encode())], declared), samples, strict=True):
        np.testing.assert_allclose(component.acceleration, expected / 10 * scale, rtol=1e-15)


@quick_hypothesis_settings
@given(
    # Steim2 has 30 bits for the difference of two samples.
    st.integers(2, 60).flatmap(lambda n: arrays(np.int32, n, elements=st.integers(-(2**28), 2**28 - 1))),
    st.sampled_from([50.0, 100.0, 200.0]),
)
def test_any_written_miniseed_is_read_back(tmp_path_factory, counts, rate):
    folder = tmp_path_factory.mktemp("mseed")
    metadata = write_stationxml_of_channels(folder / "s.xml", {"HNN": (0.0, 0.0)}, rate=rate)
    paths = [write_mseed(folder / "x.mseed", {"HNN": counts}, rate=rate), metadata]
    (component,) = read_components([SourceFile(p.name, p.read_bytes()) for p in paths], DeclaredFileProperties())
    np.testing.assert_allclose(component.acceleration, counts / 400_000, rtol=1e-14)
    assert component.sampling_interval == pytest.approx(1 / rate)


@quick_hypothesis_settings
@given(arrays(np.float32, st.integers(2, 60), elements=st.floats(-1e4, 1e4, width=32)), st.floats(0, 359))
def test_any_written_sac_is_read_back(tmp_path_factory, samples, azimuth):
    path = write_sac(tmp_path_factory.mktemp("sac") / "x.sac", samples, "HN1", azimuth, 90.0)
    (component,) = read_components([SourceFile("x.sac", path.read_bytes())], DeclaredFileProperties(unit="gal"))
    np.testing.assert_array_equal(component.acceleration, samples.astype(np.float64) * 0.01)
    assert component.azimuth_deg == pytest.approx(azimuth, rel=1e-6)
