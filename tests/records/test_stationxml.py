"""StationXML: epochs, gains, units and orientation; axes that only the code of their channel names."""

import re
import warnings

import numpy as np
import obspy
import pytest
from obspy.core.inventory.response import CoefficientsTypeResponseStage, PolesZerosResponseStage

from overturning.errors import RecordError
from overturning.records.check import check_records_in_files
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats.stationxml import (
    _gain_at_channel_over_at_stage_frequency,
    acceleration_unit_in_m_s2,
    is_metre_per_second,
)
from overturning.records.read import read_record_without_processing
from tests.expect import expect_error
from tests.records.record_writers import peer_text
from tests.records.seed_writers import START, write_mseed, write_sac, write_stationxml_of_channels

random = np.random.default_rng(11)
N, E, Z = (random.integers(-400_000, 400_000, 500) for _ in range(3))
CHANNEL_AZIMUTHS_AND_DIPS = {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0), "HNZ": (0.0, -90.0)}


def overwrite_total_channel_gains_in_stationxml_file(metadata, gain):
    """Replace the total gain of each channel in a StationXML file, but not the gains of its response stages."""
    text = re.sub(r"(<InstrumentSensitivity>\s*<Value>)[\d.]+", f"\\g<1>{gain!r}", metadata.read_text())
    metadata.write_text(text)


@pytest.mark.parametrize(("factor", "noted"), [(1.0, ""), (1.004, ""), (1.006, "0.6"), (1.025, "2.5"), (0.96, "4.2")])
def test_a_gain_that_differs_slightly_from_its_stages_is_noted(tmp_path, factor, noted):
    """Regression: differences of up to 5 % were read without a note."""
    overwrite_total_channel_gains_in_stationxml_file(
        write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS), 400_000 * factor
    )
    record = read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E}))
    np.testing.assert_allclose(record.north, N / (400_000 * factor), rtol=1e-12)
    gain = f"{400_000 * factor:g}"
    what = (
        f"gain of {gain} in the StationXML, whose stages make 400000, a difference of {noted} %; computed with {gain}"
    )
    expected = [f"x.mseed: channel XX.TST1..{code} has a {what}" for code in ("HNE", "HNN")] if noted else []
    assert record.notes == expected


def test_a_velocity_sensor_gain_that_differs_from_its_stages_is_noted(tmp_path, capfd):
    """Regression: evalresp printed three lines on the terminal for each channel, and the record had no note."""
    channels = {code.replace("HN", "HH"): direction for code, direction in CHANNEL_AZIMUTHS_AND_DIPS.items()}
    metadata = write_stationxml_of_channels(tmp_path / "s.xml", channels, gain=7.9e8, unit="M/S", broadband=True)
    overwrite_total_channel_gains_in_stationxml_file(metadata, 4e8)
    waves = write_mseed(tmp_path / "x.mseed", {code: x // 10 for code, x in zip(channels, (N, E, Z), strict=True)})
    record = read_record_without_processing(waves)
    assert capfd.readouterr() == ("", "")
    for code in channels:
        (told,) = [note for note in record.notes if f"channel XX.TST1..{code} has a gain" in note]
        assert "gain of 4e+08 in the StationXML, whose stages make 7.9e+08, a difference of 98 %" in told
        assert told.endswith("computed with the stages")
    overwrite_total_channel_gains_in_stationxml_file(metadata, 3.9e8)
    with expect_error(
        RecordError, "has a gain of 3.9e+08 in the StationXML, whose stages make 7.9e+08", "--trust-data"
    ):
        read_record_without_processing(waves)


def test_a_stationxml_filter_whose_coefficients_do_not_sum_to_1_is_noted(tmp_path, capfd):
    """Regression: evalresp divided by the sum of the coefficients, and printed a line on the terminal."""
    channels = {"HHN": (0.0, 0.0), "HHE": (90.0, 0.0)}
    metadata = write_stationxml_of_channels(tmp_path / "s.xml", channels, gain=4e8, unit="M/S", broadband=True)
    waves, inventory = (
        write_mseed(tmp_path / "x.mseed", {"HHN": N // 100, "HHE": E // 100}),
        obspy.read_inventory(metadata),
    )
    decimation = dict.fromkeys(("offset", "delay", "correction"), 0) | {"input_sample_rate": 200.0, "factor": 2}
    for channel in inventory[0][0]:
        channel.response.response_stages[0].output_units = "V"
        channel.response.response_stages.append(None)

    def read_with_filter_coefficients(coefficients):
        for channel in inventory[0][0]:
            channel.response.response_stages[1] = CoefficientsTypeResponseStage(
                *(2, 1.0, 1.0, "V", "COUNTS", "DIGITAL"), numerator=coefficients, denominator=[],
                **{f"decimation_{name}": value for name, value in decimation.items()},
            )  # fmt: skip
        inventory.write(str(metadata), format="STATIONXML")
        return read_record_without_processing(waves)

    coefficients = [0.3, 0.6, 0.2]
    changed, right = (
        read_with_filter_coefficients(coefficients),
        read_with_filter_coefficients([one / sum(coefficients) for one in coefficients]),
    )
    assert capfd.readouterr() == ("", "")
    np.testing.assert_allclose(changed.north, right.north, rtol=1e-9)
    notes = [f"channel XX.TST1..{code}: the coefficients of its filter in stage 2" for code in ("HHE", "HHN")]
    told = [note for note in changed.notes if note not in right.notes]
    assert [note.split(" have the sum 1.1 in the StationXML")[0] for note in told] == [f"x.mseed: {n}" for n in notes]


def test_stage_gains_stated_at_another_frequency_agree_with_the_channel(tmp_path):
    """A 120-s seismometer: stage gain 4e8 at 1 Hz; the channel states the gain at the corner, 0.707 times as large."""
    channels = {"HHN": (0.0, 0.0), "HHE": (90.0, 0.0)}
    metadata = write_stationxml_of_channels(tmp_path / "s.xml", channels, gain=4e8, unit="M/S", broadband=True)
    inventory, corner = obspy.read_inventory(metadata), abs(-0.037 + 0.037j) / (2 * np.pi)
    for channel in inventory[0][0]:
        channel.response.instrument_sensitivity.value = 4e8 * np.sqrt(0.5)
        channel.response.instrument_sensitivity.frequency = corner
    inventory.write(str(metadata), format="STATIONXML")
    waves = write_mseed(tmp_path / "x.mseed", {"HHN": N // 100, "HHE": E // 100})
    assert not [note for note in read_record_without_processing(waves).notes if "stages make" in note]


def test_gains_are_not_compared_where_the_response_is_zero():
    """Regression: for a stage gain at a frequency of zero response, numpy warned of a division by zero."""
    stage = PolesZerosResponseStage(
        1, 1.0, 1.0, "M/S", "V", "LAPLACE (HERTZ)", 1.0, [1j, -1j], [-0.1 + 0.1j, -0.1 - 0.1j]
    )
    assert _gain_at_channel_over_at_stage_frequency(stage, 2.0) == 1.0
    stage.stage_gain_frequency = 4.0
    gains = [abs((1j * f) ** 2 + 1.0) / abs((1j * f + 0.1) ** 2 + 0.01) for f in (2.0, 4.0)]
    assert _gain_at_channel_over_at_stage_frequency(stage, 2.0) == pytest.approx(gains[0] / gains[1], rel=1e-12)


@pytest.mark.parametrize("factor", [10.0, 2.0, 1.06, 0.1])
def test_a_channel_gain_that_its_response_stages_contradict_is_refused(tmp_path, factor):
    """Regression: a gain wrong by a factor of ten only gave a warning."""
    metadata = write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E})
    assert read_record_without_processing(waves).notes == []
    overwrite_total_channel_gains_in_stationxml_file(metadata, 400_000 * factor)
    what = f"has a gain of {400_000 * factor:g} in the StationXML, whose stages make 400000"
    with expect_error(RecordError, f"channel XX.TST1..HNE {what}", f"channel XX.TST1..HNN {what}", "--trust-data"):
        read_record_without_processing(waves)
    record = read_record_without_processing(waves, DeclaredFileProperties(trust_data=True))
    np.testing.assert_allclose(record.north, N / (400_000 * factor), rtol=1e-12)
    assert record.extra["trusted"][:2] == [f"x.mseed: channel XX.TST1..{code} {what}" for code in ("HNE", "HNN")]


def test_two_matching_stationxml_epochs_that_differ_are_refused(tmp_path):
    """Two epochs without an end fit the record: obspy uses the first, here with a quarter of the correct gain."""
    older, newer = (
        obspy.read_inventory(write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, gain=g))
        for g in (1e5, 4e5)
    )
    for inventory, year in ((older, 1990), (newer, 2000)):
        for channel in inventory[0][0]:
            channel.start_date = obspy.UTCDateTime(year, 1, 1)
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E})
    (older + newer).write(str(tmp_path / "s.xml"), format="STATIONXML")
    what = "has 2 epochs in the StationXML that fit"
    with expect_error(
        RecordError, f"HNE {what}", f"HNN {what}", "gain 100000", "1990-01-01", "gain 400000", "--trust-data"
    ):
        read_record_without_processing(waves)
    trusted = read_record_without_processing(waves, DeclaredFileProperties(trust_data=True))
    np.testing.assert_allclose(trusted.north, N / 4e5, rtol=1e-12)  # gain of the epoch that began last
    assert all(what in text for text in trusted.extra["trusted"][:2])
    for channel in older[0][0]:
        channel.end_date = obspy.UTCDateTime(2000, 1, 1)
    (older + newer).write(str(tmp_path / "s.xml"), format="STATIONXML")
    np.testing.assert_allclose(read_record_without_processing(waves).north, N / 4e5, rtol=1e-12)
    (newer + newer).write(str(tmp_path / "s.xml"), format="STATIONXML")
    assert read_record_without_processing(waves).notes == [], "the same channel twice is no contradiction"


def test_a_response_change_within_the_trace_is_refused(tmp_path):
    """Regression: a gain that changes 2 s after the start was ignored. The end of an epoch alone is no change."""
    older, newer = (
        obspy.read_inventory(write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, gain=g))
        for g in (1e5, 4e5)
    )
    for channel in older[0][0]:
        channel.end_date = START + 2
    for channel in newer[0][0]:
        channel.start_date = START + 2
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E})
    older.write(str(tmp_path / "s.xml"), format="STATIONXML")
    assert read_record_without_processing(waves).notes == []
    (older + newer).write(str(tmp_path / "s.xml"), format="STATIONXML")
    with expect_error(RecordError, "HNN changes in the StationXML while it records", "gain 100000", "gain 400000"):
        read_record_without_processing(waves)
    np.testing.assert_allclose(
        read_record_without_processing(waves, DeclaredFileProperties(trust_data=True)).north, N / 1e5, rtol=1e-12
    )


def test_a_stationxml_unit_that_its_first_stage_contradicts_is_refused(tmp_path):
    metadata = write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E})
    inventory = obspy.read_inventory(metadata)
    for channel in inventory[0][0]:
        channel.response.response_stages[0].input_units = "M/S"
    inventory.write(str(metadata), format="STATIONXML")
    with expect_error(RecordError, "HNE is in M/S**2 in the StationXML, whose first stage is in M/S", "--trust-data"):
        read_record_without_processing(waves)
    for unit in ("m/s^2", "V", ""):
        for channel in inventory[0][0]:
            channel.response.response_stages[0].input_units = unit
        inventory.write(str(metadata), format="STATIONXML")
        assert read_record_without_processing(waves).notes == []


@pytest.mark.parametrize(("rate", "contradicts"), [(100.5, False), (200.0, True), (50.0, True)])
def test_a_sampling_rate_that_the_stationxml_contradicts_is_refused(tmp_path, rate, contradicts):
    """Regression: the StationXML of another epoch, or a wrong rate in the file, was not noticed."""
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, rate=100.0)
    path = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E}, rate=rate)
    assert read_record_without_processing(path, DeclaredFileProperties(trust_data=True)).north.size == N.size
    if contradicts:
        with expect_error(RecordError, f"is sampled at {rate:g} Hz, but at 100 Hz in the StationXML", "--trust-data"):
            read_record_without_processing(path)
    else:
        assert read_record_without_processing(path).sampling_interval == pytest.approx(1 / rate)


def test_a_negative_channel_gain_reverses_the_polarity_with_a_note(tmp_path):
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, gain=-4e5)
    record = read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E, "HNZ": Z}))
    np.testing.assert_allclose(record.north, -N / 4e5, rtol=1e-12)
    np.testing.assert_allclose(record.up, -Z / 4e5, rtol=1e-12)
    assert len(record.notes) == 3
    assert all("a negative gain, -400000" in note for note in record.notes)
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS, gain=0.0)
    with expect_error(RecordError, "HNN has a gain of 0.0; correct the StationXML"):
        read_record_without_processing(tmp_path / "x.mseed")


@pytest.mark.parametrize(("code", "unit"), [("HN", "M/S**2"), ("HH", "M/S")])
def test_only_velocity_sensors_need_response_stages(tmp_path, code, unit):
    """An accelerometer needs only the gain, a velocity sensor its stages (regression: IndexError)."""
    path = write_stationxml_of_channels(
        tmp_path / "s.xml", {f"{code}N": (0.0, 0.0), f"{code}E": (90.0, 0.0)}, unit=unit
    )
    inventory = obspy.read_inventory(path)
    for channel in inventory[0][0]:
        channel.response.response_stages = []
    inventory.write(str(path), format="STATIONXML")
    waves = write_mseed(tmp_path / "x.mseed", {f"{code}N": N, f"{code}E": E})
    if code == "HN":
        np.testing.assert_allclose(read_record_without_processing(waves).north, N / 4e5, rtol=1e-12)
    else:
        with expect_error(RecordError, "x.mseed: response of XX.TST1..HHE has no stages", "get level=response"):
            read_record_without_processing(waves)
    for channel in inventory[0][0]:
        channel.response = None
    inventory.write(str(path), format="STATIONXML")
    with expect_error(
        RecordError, f"x.mseed: channel XX.TST1..{code}E has no gain in the StationXML; get it with level="
    ):
        read_record_without_processing(waves)


@pytest.mark.parametrize(
    ("unit", "scale"),
    [
        *[(unit, 1.0) for unit in ("M/S**2 ", "m/(s^2)", "M/SEC^2", "M/(SEC**2)", "m/s/s", "m s-2", "M/S²", "m*s**-2")],
        *[("CM/SEC**2", 0.01), ("cm/(s^2)", 0.01), ("Gal", 0.01), ("nm/s**2", 1e-9), ("G", 9.80665)],
        *[("METER/SECOND**2", 1.0), ("centimeters/second^2", 0.01), ("m s^{-2}", 1.0)],
        *[(unit, None) for unit in ("M/S", "m / sec", "V", "M", "M/S**3", "COUNTS", "")],
    ],
)
def test_units_in_stationxml_are_read_in_every_spelling(unit, scale):
    assert acceleration_unit_in_m_s2(unit) == scale
    assert is_metre_per_second(unit) == (unit in ("M/S", "m / sec"))


@pytest.mark.parametrize(
    "text",
    [
        *("Sensor orientation not known", "orientation is unknown", "Azimuth unknown", "not oriented"),
        *("unoriented sensor", "uncertain orientation", "azimuth not yet measured"),
    ],
)
def test_an_unknown_orientation_in_stationxml_is_not_read_as_north(tmp_path, text):
    """GeoNet writes azimuths of 0° and 90° next to a comment that the orientation is unknown."""
    path = write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    inventory = obspy.read_inventory(path)
    for channel in inventory[0][0]:
        channel.comments = [obspy.core.inventory.Comment(text)]
    inventory.write(str(path), format="STATIONXML")
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E, "HNZ": Z})
    with expect_error(RecordError, "axis 'HNE', 'HNN' says nothing about north"):
        read_record_without_processing(waves)
    record = read_record_without_processing(waves, DeclaredFileProperties(azimuths_deg=(90.0, 0.0)))
    np.testing.assert_allclose(record.north, N / 4e5, rtol=1e-12)
    np.testing.assert_allclose(record.up, Z / 4e5, rtol=1e-12)
    assert sum(f"the StationXML says {text!r}" in note for note in record.notes) == 2


def test_channel_codes_name_the_axes_if_sac_and_stationxml_do_not(tmp_path):
    """SAC files from obspy have no azimuth (CMPAZ). Regression: azimuths by order of file names made HNE north."""
    files = {
        code: write_sac(tmp_path / f"T.{code}.sac", x / 1e5, code, None, None)
        for code, x in zip(CHANNEL_AZIMUTHS_AND_DIPS, (N, E, Z), strict=True)
    }
    record = read_record_without_processing(files["HNE"], DeclaredFileProperties(unit="gal"))
    for samples, truth in zip(record.components, (N, E, Z), strict=True):
        np.testing.assert_allclose(samples, truth / 1e7, atol=1e-8)
    assert sum("its header states no direction (CMPAZ, CMPINC); the code of channel" in x for x in record.notes) == 3
    turned = read_record_without_processing(files["HNE"], DeclaredFileProperties(unit="gal", azimuths_deg=(0.0, 90.0)))
    np.testing.assert_allclose(turned.north, E / 1e7, atol=1e-8)
    assert "axis 'HNE' is taken at 0°, as declared; its file says 90°" in turned.notes
    assert "axis 'HNN' is taken at 90°, as declared; its file says 0°" in turned.notes
    for path in files.values():
        path.unlink()
    write_stationxml_of_channels(tmp_path / "s.xml", dict.fromkeys(CHANNEL_AZIMUTHS_AND_DIPS, (None, None)))
    record = read_record_without_processing(write_mseed(tmp_path / "x.mseed", {"HNE": E, "HNN": N, "HNZ": Z}))
    np.testing.assert_allclose(record.north, N / 4e5, rtol=1e-12)
    assert sum("the StationXML states no azimuth and dip; the code of" in note for note in record.notes) == 3


def test_sac_files_whose_channel_codes_name_no_axis_are_refused(tmp_path):
    paths = [write_sac(tmp_path / f"{c}.sac", x / 1e5, c, None, None) for c, x in (("HN1", N), ("HN2", E))]
    with expect_error(RecordError, "axis 'HN1', 'HN2' says nothing about north"):
        read_record_without_processing(paths, DeclaredFileProperties(unit="gal"))


def test_a_channel_code_gives_the_axis_of_a_peer_file(tmp_path):
    samples = {"HNN": N / 4e5, "HNE": E / 4e5, "HNZ": Z / 4e5}
    for code, wave in samples.items():
        (tmp_path / f"RSN1_A_{code}.AT2").write_text(peer_text(wave, 0.01, code))
    record = read_record_without_processing([tmp_path / f"RSN1_A_{code}.AT2" for code in ("HNE", "HNZ", "HNN")])
    for found, wave in zip(record.components, samples.values(), strict=True):
        np.testing.assert_allclose(found, wave * 9.80665, atol=1e-5)
    assert sum("its header states no azimuth; the code of channel" in note for note in record.notes) == 3


def test_two_sampling_bands_of_one_sensor_become_two_records(tmp_path):
    """HN? at 100 Hz and BN? at 20 Hz in a folder, as FDSN servers deliver them."""
    both = CHANNEL_AZIMUTHS_AND_DIPS | {f"BN{code[2]}": axis for code, axis in CHANNEL_AZIMUTHS_AND_DIPS.items()}
    write_stationxml_of_channels(tmp_path / "s.xml", both, rates={"BN": 20.0})
    for code, samples in zip(CHANNEL_AZIMUTHS_AND_DIPS, (N, E, Z), strict=True):
        write_mseed(tmp_path / f"{code}.mseed", {code: samples})
        write_mseed(tmp_path / f"BN{code[2]}.mseed", {f"BN{code[2]}": samples[::5]}, rate=20.0)
    first, second = check_records_in_files([tmp_path])
    assert first.file_names == ("BNE.mseed", "BNN.mseed", "BNZ.mseed")
    assert second.file_names == ("HNE.mseed", "HNN.mseed", "HNZ.mseed")
    np.testing.assert_allclose(first.unprocessed_record.north, N[::5] / 4e5, rtol=1e-12)
    np.testing.assert_allclose(second.unprocessed_record.north, N / 4e5, rtol=1e-12)
    np.testing.assert_allclose(read_record_without_processing(tmp_path / "HNE.mseed").north, N / 4e5, rtol=1e-12)


def test_the_stationxml_of_another_station_does_not_block_a_declared_unit(tmp_path):
    write_stationxml_of_channels(tmp_path / "other.xml", CHANNEL_AZIMUTHS_AND_DIPS, station="OTHER")
    paths = [write_sac(tmp_path / f"{c}.sac", x / 1e5, c, a, 90.0) for c, x, a in (("HNN", N, 0.0), ("HNE", E, 90.0))]
    (finding,) = check_records_in_files([tmp_path], DeclaredFileProperties(unit="gal"))
    np.testing.assert_allclose(finding.unprocessed_record.north, N / 1e7, atol=1e-8)
    np.testing.assert_allclose(
        read_record_without_processing(paths[0], DeclaredFileProperties(unit="gal")).east, E / 1e7, atol=1e-8
    )
    with expect_error(RecordError, "HNN", "is not in the StationXML given"):
        read_record_without_processing([*paths, tmp_path / "other.xml"])
    # Its own goes before the declaration, as ever.
    write_stationxml_of_channels(tmp_path / "own.xml", CHANNEL_AZIMUTHS_AND_DIPS, gain=1e3)
    np.testing.assert_allclose(
        read_record_without_processing(paths[0], DeclaredFileProperties(unit="gal")).north, N / 1e8, rtol=1e-6
    )


def test_an_obspy_warning_becomes_a_note_on_the_file(tmp_path, monkeypatch):
    """Regression: obspy's warning was printed with its path and source line."""
    write_stationxml_of_channels(tmp_path / "s.xml", CHANNEL_AZIMUTHS_AND_DIPS)
    waves = write_mseed(tmp_path / "x.mseed", {"HNN": N, "HNE": E})
    merge = obspy.Stream.merge

    def merge_after_emitting_warnings(stream, *given, **more):
        warnings.warn_explicit("two\nlines", UserWarning, "/somewhere/obspy/core/stream.py", 1)
        warnings.warn_explicit("old name", DeprecationWarning, "/somewhere/obspy/core/stream.py", 2)
        return merge(stream, *given, **more)

    monkeypatch.setattr(obspy.Stream, "merge", merge_after_emitting_warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_record_without_processing(waves).notes == ["x.mseed: obspy warns: two lines"]
