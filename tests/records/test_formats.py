"""Every text format is read to the numbers it was written from, in m/s², towards north, east and up."""

import re

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from overturning.errors import ArgumentError, RecordError
from overturning.records.assembly import assemble_record
from overturning.records.axis_direction import direction_from_channel_code, parse_axis_direction
from overturning.records.catalogue import RecordTableRow
from overturning.records.check import check_records_in_files
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.files import read_components
from overturning.records.read import read_record, read_record_without_processing
from overturning.records.record import Record, processing_peaks_and_notes_of_record, processing_state_label
from overturning.records.source import SourceFile
from tests.expect import expect_error
from tests.records.malformed_corpus import UNDETECTABLE_MUTATIONS
from tests.records.record_writers import (
    cosmos_text,
    csmip_pairs_text,
    csmip_text,
    esm_text,
    geonet_text,
    peer_text,
    smc_text,
)
from tests.records.world_writers import (
    bhrc_text,
    cismid_text,
    cosmos_counts_text,
    cwa_text,
    jma_text,
    nsmn_text,
    renadic_text,
    unam_text,
    usc_text,
)
from tests.records.written import COSMOS_RECORD_FIELDS, ROTATED_AXIS_NAMES_AND_CODES, TEXT_FORMATS_WITH_WRITERS, G

MILLI_G = G / 1000
SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION = np.random.default_rng(7).integers(-999, 999, (3, 210))
A, B, C = SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION / 10


def write_files_and_read_record(folder, files: dict[str, str] | str, **declared) -> Record:
    """Write files (or one text as a file) and read them as a record, with declared properties."""
    files = {"x.txt": files} if isinstance(files, str) else files
    for name, text in files.items():
        (folder / name).write_text(text)
    return read_record_without_processing([folder / name for name in files], DeclaredFileProperties(**declared))


def assert_components(record, north, east, up=None, rtol=1e-9):
    """Check the components of a record, to a tolerance relative to the largest sample."""
    scale = max(np.abs(north).max(), np.abs(east).max())
    np.testing.assert_allclose(record.north, north, atol=rtol * scale)
    np.testing.assert_allclose(record.east, east, atol=rtol * scale)
    assert (record.up is None) == (up is None)
    if up is not None:
        np.testing.assert_allclose(record.up, up, atol=rtol * scale)


def project_to_north_and_east(first, first_deg, second, second_deg):
    """Return the north and east components of samples along two axes of the given azimuths."""
    angles = np.radians([first_deg, second_deg])
    return [f(angles[0]) * first + f(angles[1]) * second for f in (np.cos, np.sin)]


@pytest.mark.parametrize("form", TEXT_FORMATS_WITH_WRITERS)
def test_every_text_format_gives_its_samples_and_header_fields(tmp_path, form):
    written = TEXT_FORMATS_WITH_WRITERS[form]
    for name, text in written.file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION).items():
        (tmp_path / name).write_text(text)
    if written.declared:
        undeclared = read_record_without_processing(next(tmp_path.iterdir()))
        assert undeclared.up is None
        assert "does not say whether up or down" in undeclared.extra["notes"][0]
    # The other files of a record are found next to the first.
    record = read_record_without_processing(next(tmp_path.iterdir()), written.declared)
    up = (
        None
        if "up" in written.expected_record_fields
        else SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION[2] * written.smallest_sample_increment * written.unit_m_s2
    )
    assert_components(
        record, *written.expected_north_east(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION[:2]), up, rtol=1e-8
    )
    assert record.sampling_interval == pytest.approx(written.sampling_interval_s, rel=1e-9)
    for name, value in written.expected_record_fields.items():
        found = getattr(record, name) if hasattr(record, name) else record.extra[name]
        assert found == (pytest.approx(value, abs=1e-4) if isinstance(value, float) else value), name


@pytest.mark.parametrize("form", TEXT_FORMATS_WITH_WRITERS)
@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.integers(2, 60).flatmap(lambda n: arrays(np.int64, (2, n), elements=st.integers(-99999, 99999))))
def test_any_samples_written_in_a_text_format_are_read_back(form, samples):
    written = TEXT_FORMATS_WITH_WRITERS[form]
    if form == "cosmos":
        samples = samples // 11  # F10.5 holds -999.9
    files = [SourceFile(name, text.encode()) for name, text in written.file_texts_by_name(*samples).items()]
    declared = DeclaredFileProperties(vertical_sense="none", trust_data=True)
    record = assemble_record(read_components(files, declared), "x", declared)
    north, east = written.expected_north_east(*samples)
    np.testing.assert_allclose([record.north, record.east], [north, east], atol=1e-8 * max(1, np.abs(samples).max()))


@pytest.mark.parametrize("form", ["knet", "peer", "csmnc", "esm"])
def test_a_file_with_a_sample_split_in_two_is_refused(tmp_path, form):
    """Regression: a blank inside a number shifted all later samples, and only a note told of one sample too many."""
    files = TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)
    name, text = next(iter(files.items()))
    lines = text.splitlines(keepends=True)
    at = TEXT_FORMATS_WITH_WRITERS[form].header_line_count + 4
    spoilt = re.sub(r"(\d)(\d)", r"\1 \2", lines[at], count=1)
    assert len(spoilt.split()) == len(lines[at].split()) + 1
    with expect_error(RecordError, f"{name} line {at + 1}", "the line is damaged: get the file again"):
        write_files_and_read_record(tmp_path, files | {name: "".join([*lines[:at], spoilt, *lines[at + 1 :]])})


@pytest.mark.parametrize("form", [form for form in TEXT_FORMATS_WITH_WRITERS if form not in UNDETECTABLE_MUTATIONS])
def test_samples_beyond_the_count_in_the_header_are_left_out_with_a_note(tmp_path, form):
    """Ten samples that follow the 200 of the first component, as stated in its header, are left out."""
    written = TEXT_FORMATS_WITH_WRITERS[form]
    files, longer = (
        written.file_texts_by_name(*samples)
        for samples in (SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION[:, :200], SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)
    )
    first = next(iter(files))
    lines, more = files[first].splitlines(), longer[first].splitlines()
    end = next(i for i in range(written.header_line_count, len(more)) if lines[i : i + 1] != more[i : i + 1])
    surplus_notes = more[end : end + -(-10 * (end - written.header_line_count) // 200)]
    files[first] = "\n".join([*lines[:end], *surplus_notes, *lines[end:]]) + "\n"
    record = write_files_and_read_record(tmp_path, files, vertical_sense="none")
    assert_components(
        record, *written.expected_north_east(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION[:2, :200]), record.up, rtol=1e-8
    )
    (note,) = [note for note in record.notes if "is doubtful: 200 samples then last" not in note]  # 1 s is short
    assert f"{first} goes on after the 200 samples that its header promises: " in note
    assert note.endswith("left out")
    assert " 1 lines " not in note


@pytest.mark.parametrize(
    ("form", "stated"),
    [
        ("geonet", r"(Acceleration:  peak +)(-?[\d.]+)"),
        ("esm", r"(PGA_CM/S\^2: )(\S+)"),
        ("unam", r"(ACEL\. MAX\.\(Gal\), C1-C6 +: /)([\d.-]+)"),
        ("csmnc", r"(PEAK VALUE: +)(-?[\d.]+)"),
        ("csmip1", r"(Max  = *)(-?[\d.]+)"),
        ("csmip2", r"(Peak acceleration = *)(-?[\d.]+)"),
        ("renadic", r"(MAX  = *)(-?[\d.]+)"),
    ],
)
@pytest.mark.parametrize("sense", [1, -1])
def test_samples_with_the_opposite_sign_of_the_header_peak_are_refused(tmp_path, form, stated, sense):
    """Regression: samples of reversed sign agreed with the header, whose peak was compared without its sign."""
    steps = SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION.copy()
    steps[0, 50] = sense * 1500
    files = TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*steps)
    name, text = next(iter(files.items()))
    right = re.sub(stated, lambda m: f"{m[1]}{sense * abs(float(m[2]))}", text, count=1)
    wrong = re.sub(stated, lambda m: f"{m[1]}{-sense * abs(float(m[2]))}", text, count=1)
    declared = {"vertical_sense": "up"} if form in ("unam", "renadic") else {}
    north, _ = TEXT_FORMATS_WITH_WRITERS[form].expected_north_east(*steps[:2])
    assert_components(
        write_files_and_read_record(tmp_path, files | {name: right}, **declared),
        *TEXT_FORMATS_WITH_WRITERS[form].expected_north_east(*steps[:2]),
        write_files_and_read_record(tmp_path, files, **declared).up,
    )
    if sense < 0 and form == "csmnc":  # A peak without a minus may be an absolute value there.
        assert write_files_and_read_record(tmp_path, files | {name: wrong}, **declared).north.size == north.size
        return
    with expect_error(
        RecordError, name, "the header states a peak of", "the sign of its samples is reversed", "--trust-data"
    ):
        write_files_and_read_record(tmp_path, files | {name: wrong}, **declared)
    assert write_files_and_read_record(tmp_path, files | {name: wrong}, trust_data=True, **declared).extra["trusted"]


@pytest.mark.parametrize(("from_up", "refusal"), [(90, ""), (87, ""), (45, "dips by -45°"), (84, "dips by -6°")])
def test_smc_of_an_inclined_axis_is_refused(tmp_path, from_up, refusal):
    """Regression: the inclination in the header integers was ignored unless it was that of a vertical axis."""
    files = {"a.smc": smc_text(A, 100, "360", vertical=from_up), "b.smc": smc_text(B, 100, "90")}
    if refusal:
        with expect_error(
            RecordError, "a.smc: axis 360", refusal, "only axes within 5° of horizontal or vertical are read"
        ):
            write_files_and_read_record(tmp_path, files)
    else:
        assert (
            "a.smc: axis 360 dips by -3°; it is read as horizontal"
            in write_files_and_read_record(tmp_path, files).notes
        ) is (from_up == 87)


def test_smc_samples_with_the_opposite_sign_of_the_header_extremes_are_refused(tmp_path):
    """The header of an SMC file states the largest and the smallest sample with their signs."""
    peak = np.where(np.arange(A.size) == 50, 150.0, A)
    texts = [smc_text(sense * peak, 100, "360").splitlines(keepends=True) for sense in (1, -1)]
    reversed_samples = "".join(
        [
            *texts[0][: TEXT_FORMATS_WITH_WRITERS["smc"].header_line_count],
            *texts[1][TEXT_FORMATS_WITH_WRITERS["smc"].header_line_count :],
        ]
    )
    files = {"a.smc": reversed_samples, "b.smc": smc_text(B, 100, "90")}
    with expect_error(
        RecordError, "a.smc line 23: the header states a peak of 150 Gal along 360, the data has -150 Gal"
    ):
        write_files_and_read_record(tmp_path, files)


@pytest.mark.parametrize(
    "form", [form for form, written in TEXT_FORMATS_WITH_WRITERS.items() if written.has_peak_in_header]
)
def test_every_header_peak_is_compared_with_the_samples(tmp_path, form):
    """A file with twice the samples of its header is refused, and read only if trusted."""
    written = TEXT_FORMATS_WITH_WRITERS[form]
    files = written.file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)
    for name, text in written.file_texts_by_name(*(2 * SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)).items():
        head, data = files[name].splitlines(), text.splitlines()
        last = len(head) if len(files) > 1 or written.header_line_count < 25 else written.header_line_count + 20
        lines = head[: written.header_line_count] + data[written.header_line_count : last] + head[last:]
        files[name] = "\n".join(lines) + "\n"
    declared = {"vertical_sense": "up"}
    with expect_error(RecordError, "the header states a peak of", "--trust-data"):
        write_files_and_read_record(tmp_path, files, **declared)
    record = write_files_and_read_record(tmp_path, files, **declared, trust_data=True)
    assert record.extra["trusted_data"] is True
    assert record.extra["trusted"]
    assert all("header states a peak" in why for why in record.extra["trusted"])


@pytest.mark.parametrize(
    ("text", "azimuth", "vertical"),
    [
        *(("N28W", 332, 0), ("S62W", 242, 0), ("S90E", 90, 0), ("N00E", 0, 0), ("S74E", 106, 0), ("270", 270, 0)),
        *(("360 Deg", 0, 0), ("N", 0, 0), ("East", 90, 0), ("Up", None, 1), ("DWN", None, -1), ("H1", None, 0)),
        *(("RAD", None, 0), ("--L", None, 0), ("Vert", None, 0), ("N95E", None, 0), ("400", None, 0)),
    ],
)
def test_axis_names_are_parsed_to_azimuth_and_vertical_sense(text, azimuth, vertical):
    assert parse_axis_direction(text) == (azimuth, vertical)


@pytest.mark.parametrize("suffix", ["", "2"])
def test_japanese_components_from_peer_are_north_east_and_up(tmp_path, suffix):
    """NGA-West2 has EW, NS, UD of K-NET and EW2, NS2, UD2 of KiK-net's surface sensors."""
    named = {"EW": A, "NS": B, "UD": C}
    files = {f"x_{axis}.AT2": peer_text(x / 1000, 0.01, f"{axis}{suffix}") for axis, x in named.items()}
    assert_components(write_files_and_read_record(tmp_path, files), B * MILLI_G, A * MILLI_G, C * MILLI_G, rtol=1e-6)
    assert write_files_and_read_record(tmp_path, files, vertical_sense="none").up is None


def test_borehole_components_from_peer_are_refused_unless_declared(tmp_path):
    """Regression: NS1, EW1 and UD1 of KiK-net (borehole) were read as surface components."""
    named = {"EW1": A, "NS1": B, "UD1": C}
    files = {f"x_{axis}.AT2": peer_text(x / 1000, 0.01, axis) for axis, x in named.items()}
    with expect_error(RecordError, "of the borehole sensor"):
        write_files_and_read_record(tmp_path, files)
    record = write_files_and_read_record(tmp_path, files, sensor="borehole")
    assert_components(record, B * MILLI_G, A * MILLI_G, C * MILLI_G, rtol=1e-6)
    assert record.station.endswith("(borehole)")


@pytest.mark.parametrize(
    "axes", [("90", "360", "HNQ"), ("HN1", "HN2", "HN3"), ("H1", "H2", "H3"), ("NS", "EW", "third")]
)
def test_a_third_axis_of_unknown_name_is_omitted_with_a_note_unless_declared(tmp_path, axes):
    """Regression: components with an unknown third axis were refused, whatever `vertical_sense` was."""
    files = {f"x_{axis}.AT2": peer_text(x / 1000, 0.01, axis) for axis, x in zip(axes, (A, B, C), strict=True)}
    known = parse_axis_direction(axes[0])[0] is not None
    turn = {} if known else {"azimuths_deg": (90, 0)}
    north, east = (A, B) if axes[0] == "NS" else (B, A)
    record = write_files_and_read_record(tmp_path, files, **turn)
    assert_components(record, north * MILLI_G, east * MILLI_G, rtol=1e-6)
    assert f"vertical axis '{axes[2]}' left out: " in record.notes[0]
    for sense, sign in (("up", 1), ("down", -1)):
        assert_components(
            write_files_and_read_record(tmp_path, files, vertical_sense=sense, **turn),
            north * MILLI_G,
            east * MILLI_G,
            sign * C * MILLI_G,
            rtol=1e-6,
        )
    assert write_files_and_read_record(tmp_path, files, vertical_sense="none", **turn).up is None
    with expect_error(RecordError, "two horizontal components and at most one vertical"):
        write_files_and_read_record(tmp_path, {f"y_{n}.AT2": peer_text(A / 1000, 0.01, n) for n in ("90", "H1", "H2")})


def test_channel_codes_give_azimuth_and_vertical_sense():
    assert [direction_from_channel_code(code) for code in ("HNE", "HNZ", "HN1")] == [(90.0, 0), (None, 1), (None, 0)]


def test_geonet_start_allows_for_prepended_samples_and_magnitude_0_is_unknown(tmp_path):
    axes = {"N00E": (0, A), "N90E": (90, B)}
    record = write_files_and_read_record(tmp_path, geonet_text(axes, 0.02, prepended=250, magnitude=0.0))
    assert record.start == "2016-11-13T11:02:14Z"
    assert "magnitude" not in record.extra


@pytest.mark.parametrize(("volume", "stated"), [(1, r"Format: \(8f9\.6\)"), (2, r"\(8f10\.4\)")])
def test_csmip_column_width_is_inferred_where_no_format_is_stated(tmp_path, volume, stated):
    """Regression: columns of nine characters were read as ten, which was refused."""
    scale, unit = (1e4, G) if volume == 1 else (1.0, 0.01)
    text = csmip_text({"360 Deg": (360, A / scale), "90 Deg": (90, B / scale)}, 100, volume=volume)
    spoilt = re.sub(stated, "", text)
    assert spoilt != text
    assert_components(write_files_and_read_record(tmp_path, spoilt), A / scale * unit, B / scale * unit)
    first = re.search(r" points (?:of accel|at).*\n(.*)", spoilt)[1]
    with expect_error(RecordError, "x.txt line"):
        write_files_and_read_record(tmp_path, spoilt.replace(first, first[:64], 1))


def test_csmip_volume_2_files_of_the_1980s_are_read(tmp_path):
    """Capital letters, CMS/SEC/SEC, and no unit or format in the data line: the unit of the stated peak is used."""
    text = csmip_text({"90 Deg": (90, A), "360 Deg": (360, B)}, 100, volume=2).upper()
    text = text.replace("CM/SEC/SEC", "CMS/SEC/SEC").replace(", IN CM/SEC2. (8F10.4)", ".")
    assert_components(write_files_and_read_record(tmp_path, text), B * 0.01, A * 0.01)
    with expect_error(RecordError, "unit 'missing'"):
        write_files_and_read_record(tmp_path, text.replace("CMS/SEC/SEC", "FURLONGS"))


@pytest.mark.parametrize(
    "place", ["Downhole", "Borehole -12m", "Depth: 30 m", "100 ft below ground", "", "1.5 m deep vault"]
)
@pytest.mark.parametrize("form", ["cosmos", "csmip2"])
def test_the_location_of_a_channel_identifies_a_borehole(tmp_path, form, place):
    (text,) = TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION).values()
    text = text.replace("Location: free field", f"Location: {place or 'Ground floor'}")
    text = re.sub(r"(?m)^(Chan .*?(?:Deg|Up))[ ]*$", rf"\1   Location: {place or 'Ground floor'}", text)
    deep = place not in ("", "1.5 m deep vault")
    if deep:
        with expect_error(RecordError, "of the borehole sensor"):
            write_files_and_read_record(tmp_path, text)
    assert write_files_and_read_record(tmp_path, text, sensor="borehole" if deep else "surface").north.size == A.size


@pytest.mark.parametrize("form", ["cosmos", "csmip2"])
def test_channels_of_several_places_in_a_structure_are_refused_as_one_record(tmp_path, form):
    """Regression: north of the roof and east of the third floor made a record without a note."""
    (written,) = TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION).values()

    def file_text_with_sensor_locations(*places: str) -> str:
        channels = zip(re.split(r"(?m)(?<=----------\n)", written), places, strict=False)
        located = ((re.sub("Location: free field", "", channel), place) for channel, place in channels)
        chan = re.compile(r"(?m)^(Chan .*?(?:Deg|Up)|Sta Cha: .*?\))\s*$")
        return "".join(chan.sub(rf"\1  (Sta Chn: 7)   Location: {place}", channel) for channel, place in located)

    with expect_error(
        RecordError, "components of 'Roof - North' and '3rd Floor' and 'Ground'; they are not of one record"
    ):
        write_files_and_read_record(tmp_path, file_text_with_sensor_locations("Roof - North", "3rd Floor", "Ground"))
    (told,) = write_files_and_read_record(tmp_path, file_text_with_sensor_locations(*["3rd Floor"] * 3)).notes
    assert told == "a sensor at '3rd Floor' has the motion of a structure, not of the ground"
    for place in ("Pier 3 top", "Top of tower", "Bent 2: cap", "Level 5", "Upper gallery", "Column, 20 ft below deck"):
        (told,) = write_files_and_read_record(tmp_path, file_text_with_sensor_locations(*[place] * 3)).notes
        assert told == f"a sensor at {place!r} has the motion of a structure, not of the ground"
    for place in ("Ground Floor", "Level 1", "Base of tower", "Pier 3: footing", "Top of hill", "Basement"):
        assert write_files_and_read_record(tmp_path, file_text_with_sensor_locations(*[place] * 3)).notes == []
    both = file_text_with_sensor_locations(*["Ground Floor"] * 3) + file_text_with_sensor_locations(*["Roof"] * 3)
    (tmp_path / "both.v2").write_text(both)
    assert [{c.sensor_location for c in f.components} for f in check_records_in_files([tmp_path / "both.v2"])] == [
        {"Ground Floor"},
        {"Roof"},
    ]


def test_files_of_two_places_at_one_station_are_separate_records(tmp_path):
    """Regression: CESMD files of footing and deck made one record; a free-field file made all files unreadable."""
    channels = {"90 Deg": (90, A), "360 Deg": (360, B), "Up": (0, C)}

    def write_channel_files(first: int, place: str, axes: dict[str, tuple[int, np.ndarray]]) -> None:
        for number, (axis, one) in enumerate(axes.items(), first):
            text = re.sub(r"(?m)^(Chan .*?)$", rf"\1      Location: {place}", csmip_text({axis: one}, 100, volume=2))
            (tmp_path / f"CHAN00{number}.V2").write_text(text)

    write_channel_files(1, "Freefield", channels)
    write_channel_files(4, "Bent 2: deck", {"Tran": (0, A), "Long": (0, B)})
    for paths in ([tmp_path], [tmp_path / "CHAN001.V2"]):
        found = check_records_in_files(paths)
        record = found[0].unprocessed_record
        assert record is not None
        assert_components(record, B * 0.01, A * 0.01, C * 0.01)
        assert [f.file_names[0] for f in found if f.unprocessed_record is None] == ["CHAN004.V2"][
            : len(paths[0].suffix) == 0
        ]
    both = [check_records_in_files([tmp_path / "CHAN001.V2", tmp_path / "CHAN005.V2"])]
    for finding in both[0]:
        assert "components of 'Freefield' and 'Bent 2: deck' are not of one record" in finding.refusal_or_skip_reason
    with expect_error(RecordError, "'Freefield' and 'Bent 2: deck'"):
        read_record_without_processing([tmp_path / "CHAN001.V2", tmp_path / "CHAN005.V2"])


def test_csmip_volume_2_header_gives_filter_event_and_origin(tmp_path):
    """Headers of 1983 and of today: ramps or corners, name of the event, agency after ORIGIN."""
    text = csmip_text({"90 Deg": (90, A), "360 Deg": (360, B)}, 100, volume=2)
    record = write_files_and_read_record(tmp_path, text)
    assert record.extra["agency_processing"] == "band-pass filter .30 to 40.00 Hz"
    assert record.event == "Fri Jul 5, 2019 20:16:08.0 PDT"
    old = re.sub(r"(?m)^Record of .*? PDT", "COALINGA EARTHQUAKE    ", text).replace(
        "with 3 dB pts at   .30 and 40.00 cyc", "WITH RAMPS AT  .050- .100 AND 23.00-25.00 CYC"
    )
    record = write_files_and_read_record(
        tmp_path, old.replace("(Origin(CGS): 07/06/19, 03:19:53.0", "(ORIGIN(BRK): 05/02/83, 23:42:38.5")
    )
    assert record.extra["agency_processing"] == "band-pass filter .100 to 23.00 Hz"
    assert (record.event, record.extra["origin_time"]) == ("COALINGA EARTHQUAKE", "1983-05-02T23:42:38Z")
    with expect_error(RecordError, "x.txt line 8: axis '180', but line 1 says '90'"):
        write_files_and_read_record(tmp_path, re.sub(r"(?m)^Chan  1: 90", "Chan  1: 180", text))
    with expect_error(RecordError, "x.txt line 16", "samples"):
        write_files_and_read_record(
            tmp_path, text.replace("   210 points of instrument", "   200 points of instrument", 1)
        )


@pytest.mark.parametrize(
    ("agency", "named"), [("USGS", "USGS"), ("Werner 85", "Werner 85"), ("CDMG", "CSMIP / CGS"), (" ", "CSMIP / CGS")]
)
def test_an_old_csmip_header_gives_its_agency_and_minute_of_origin(tmp_path, agency, named):
    """Regression: the origin was not read, and a file of the USGS in this format had been processed by CSMIP / CGS."""
    channels = {"UP": (500, C), "360 DEG": (360, A), "270 DEG": (270, B)}
    record = write_files_and_read_record(tmp_path, csmip_text(channels, 100, volume=2, old_agency=agency))
    assert record.extra["origin_time"] == "1975-05-03T04:59:00Z"
    assert processing_state_label(record) == f"processed by {named}"
    assert (record.event, record.station, record.start) == ("TEST VALLEY, CA EARTHQUAKE", "9999", None)
    assert (record.extra["event_latitude"], record.extra["event_longitude"]) == (33.0, -116.1)
    np.testing.assert_allclose(record.north, A * 0.01, atol=1e-6)


@pytest.mark.parametrize("month", ["SEPT", "Sep.", "SEPTEMBER"])
def test_the_month_of_a_csmip_origin_time_may_be_abbreviated_to_any_length(tmp_path, month):
    """Regression: with the month "SEPT" a record had no origin time, and no note said so."""
    text = csmip_text({"UP": (500, C), "360 DEG": (360, A), "270 DEG": (270, B)}, 100, volume=2, old_agency="USGS")
    assert re.search(r"\bMAY\b", text, re.IGNORECASE)
    record = write_files_and_read_record(tmp_path, re.sub(r"\bMAY\b", month, text, flags=re.IGNORECASE))
    assert record.extra["origin_time"] == "1975-09-03T04:59:00Z"


def test_the_last_line_of_a_file_may_lack_its_line_end_but_no_digits(tmp_path):
    for write in (cwa_text, nsmn_text):
        north, east, up = (np.append(x, end) for x, end in ((A, -12.3), (B, -1.2), (C, 123.4)))
        whole = write(north, east, up)
        for end in ("", "\n \n\n"):  # the last two numbers have unlike many digits, and as many decimals
            assert_components(
                write_files_and_read_record(tmp_path, whole.rstrip("\n") + end), north / 100, east / 100, up / 100
            )
        with expect_error(RecordError, f"x.txt line {whole.count(chr(10))}", "is cut"):
            write_files_and_read_record(tmp_path, whole.rstrip("\n")[:-1])


def test_cwa_columns_are_read_in_any_order_and_sense(tmp_path):
    record = write_files_and_read_record(tmp_path, cwa_text(A, B, C, sequence="Time E(-); U(-); N(+)"))
    assert_components(record, A / 100, -B / 100, -C / 100)


def test_jma_csv_is_read_in_shift_jis_with_columns_in_any_order(tmp_path):
    """Files from the web site and from a spreadsheet are read, and old ones (``Sampling Freq``, two-digit years)."""
    text = jma_text(A, B, C)
    (tmp_path / "a.csv").write_bytes(text.encode("shift_jis").replace(b"\n", b"\r\n"))
    record = read_record_without_processing(tmp_path / "a.csv")
    assert_components(record, A / 100, B / 100, C / 100)
    assert record.station == "99999架空市本町"
    old = text.replace("SAMPLING RATE", "Sampling Freq").replace("2024 01 01", "98 01 01").replace("NS,EW", "EW,NS")
    record = write_files_and_read_record(tmp_path, re.sub(r"(?m),?$", ",,,", old).removesuffix(",,,"))
    assert_components(record, B / 100, A / 100, C / 100)
    assert record.start == "1998-01-01T07:10:05Z"
    for wrong in (text.replace(",", ",,", 9), text.replace("NS,EW,UD", "X,Y,Z"), text.replace(f"{A[0]:.3f},", "1,5,")):
        with expect_error(RecordError, "x.txt line"):
            write_files_and_read_record(tmp_path, wrong)


def test_csmnc_files_without_recorder_time_are_read(tmp_path):
    files = TEXT_FORMATS_WITH_WRITERS["csmnc"].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)
    files = {n: re.sub(r" *RECORDER TIME.*", "", t).replace("UNCORRECTED", "CORRECTED") for n, t in files.items()}
    record = write_files_and_read_record(tmp_path, files)
    assert_components(record, A / 100, B / 100, C / 100)
    assert (record.start, record.extra["origin_time"]) == (None, "2024-01-01T04:00:04Z")
    assert record.extra["processed"] is True
    assert record.extra["processed_by"] == "CSMNC"


@pytest.mark.parametrize(
    ("comment", "processed"),
    [
        ("BASELINE CORRECTED", False),
        ("BANDPASS FILTERED 0.1 - 25 Hz", True),
        ("Butterworth filter of order 4", True),
        ("UNFILTERED", False),
        ("BASELINE CORRECTED, NOT FILTERED", False),
        ("no filter", False),
    ],
)
def test_a_cismid_file_counts_as_processed_if_its_comments_name_a_filter(tmp_path, comment, processed):
    """A baseline correction alone does not count; a file that counts as processed keeps its long-period noise."""
    record = write_files_and_read_record(tmp_path, cismid_text(A, B, C).replace("BASELINE CORRECTED", comment))
    assert record.extra["processed"] == processed


def test_cismid_stated_peaks_are_checked_and_date_is_read(tmp_path):
    text = cismid_text(A, B, C)
    late = text.replace("16:41:00", "23:59:58").replace("16:41:08", "00:00:06")
    record = write_files_and_read_record(tmp_path, late)
    assert_components(record, A / 100, B / 100, C / 100)
    assert (record.extra["origin_time"], record.start) == ("1966-10-18T04:59:58Z", "1966-10-18T05:00:06Z")
    summer = write_files_and_read_record(tmp_path, text.replace("October 17, 1966", "February 2, 1990"))
    assert (summer.start, summer.extra.get("origin_time")) == (None, None)
    assert (
        write_files_and_read_record(tmp_path, text.replace("BASELINE CORRECTED", "BAND-PASS FILTERED")).extra[
            "processed"
        ]
        is True
    )
    with expect_error(RecordError, "line 28", "along EW"):
        write_files_and_read_record(
            tmp_path, re.sub(r"(ACCELERATION +:) +(\S+)( +)(\S+)", r"\1 \4\3\2", cismid_text(A, 2 * B, C))
        )


@pytest.mark.parametrize("stated", ["17/08/1999 00:01:39.07 (GMT)", "1999/08/17 00:01:39 (GMT)", "17/08/1999 00:01:39"])
def test_nsmn_dates_may_begin_with_the_day_or_the_year(tmp_path, stated):
    """Regression: an origin with the year first was not read."""
    (text,) = TEXT_FORMATS_WITH_WRITERS["nsmn"].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION).values()
    assert "17/08/1999 00:01:39.07 (GMT)" in text
    record = write_files_and_read_record(tmp_path, text.replace("17/08/1999 00:01:39.07 (GMT)", stated))
    assert record.extra["origin_time"] == "1999-08-17T00:01:39Z"


@pytest.mark.parametrize(
    ("second", "millis", "start"),
    [
        (12, 500, "1989-10-18T00:04:12.5Z"), (0, 0, "1989-10-18T00:04:00Z"), (12, -32768, "1989-10-18T00:04:12Z"),
        (0, -32768, None), (-32768, -32768, None),
    ],
)  # fmt: skip
def test_an_smc_file_of_film_has_an_origin_minute_and_no_start_time(tmp_path, second, millis, start):
    """Regression: the minute of the earthquake was taken as the time of the first sample."""
    more = {5: (second, millis)}
    files = {f"x{n}.smc": smc_text(x, 100, a, more=more) for n, (x, a) in enumerate([(A, "360"), (B, "90")])}
    record = write_files_and_read_record(tmp_path, files)
    assert record.start == start
    assert record.extra["origin_time"] == "1989-10-18T00:04:00Z"


def test_nsmn_files_are_decoded_from_the_turkish_code_page(tmp_path):
    (tmp_path / "z.txt").write_bytes(nsmn_text(A, B, C).replace("TEST MERKEZ", "DÜZCE ĞI").encode("cp1254"))
    assert_components(read_record_without_processing(tmp_path / "z.txt"), A / 100, B / 100, C / 100)


@pytest.mark.parametrize("name", ["Chi-Chi, Taiwan", "Chi-Chi, Taiwan-06", "Northridge-01"])
def test_earthquake_names_in_peer_files_may_have_commas(tmp_path, name):
    """Regression: main shock and aftershocks were all "Chi-Chi", at stations like "Taiwan-06, 9/25/1999, TCU065"."""
    title = f"{name}, 9/25/1999, TCU065, Taichung"
    files = {f"{axis}.AT2": peer_text(A * 1e-3, 0.01, axis).replace("Test-01, 1/17/1994, Test Receiving Sta", title)
             for axis in ("000", "090")}  # fmt: skip
    record = write_files_and_read_record(tmp_path, files)
    assert (record.event, record.station) == (f"{name} 9/25/1999", "TCU065, Taichung")


@pytest.mark.parametrize(("year", "stated"), [("33", 1933), ("52", 1952), ("94", 1994), ("19", 2019), ("1952", 1952)])
def test_two_digit_years_are_not_before_the_first_accelerogram(tmp_path, year, stated):
    text = csmip_text({"90 Deg": (90, A / 1000), "360 Deg": (360, B / 1000)}, 100)
    text = text.replace("(Origin:  To be determined)", f"Origin: 07/21/{year}, 11:52:14.0 GMT")
    record = write_files_and_read_record(tmp_path, text.replace("Start time:  7/06/19", f"Start time:  7/21/{year}"))
    assert record.extra["origin_time"] == f"{stated}-07-21T11:52:14Z"
    assert record.start == f"{stated}-07-21T03:16:08Z"


@pytest.mark.parametrize(("axis", "code", "sense"), [("Up", 500, 1), ("Down", 600, -1)])
def test_csmip_vertical_axis_text_is_compared_with_its_code(tmp_path, axis, code, sense):
    """Code 500 is up, as in CSMIP's own files, and 600 is down; the text Up or Down must agree with the code."""
    channels = {"360 Deg": (360, A / 1000), "270 Deg": (270, B / 1000), axis: (code, C / 1000)}
    assert_components(
        write_files_and_read_record(tmp_path, csmip_text(channels, 100)),
        A * MILLI_G,
        -B * MILLI_G,
        sense * C * MILLI_G,
        rtol=1e-6,
    )
    other = {500: "down", 600: "up"}[code]
    with expect_error(RecordError, f"axis {axis!r}, but the numbers below it say {other}; components may be swapped"):
        write_files_and_read_record(tmp_path, csmip_text(channels | {axis: (1100 - code, C / 1000)}, 100))


@pytest.mark.parametrize("begins", ["Sta Cha:  {}", "Sta Chan:  {}", "Sta Chan   {}"])
def test_cosmos_axis_text_is_compared_with_its_code(tmp_path, begins):
    """Regression: the axis in the text after `Sta Cha:` was not read, only the code."""

    def cosmos_text_with_axis_codes(**codes: int) -> str:
        axes = {
            name: (codes.get(name.split()[0], code), x)
            for (name, code), x in zip(ROTATED_AXIS_NAMES_AND_CODES, (A, B, C), strict=True)
        }
        return re.sub(r"Sta Cha:  (\d)", lambda number: begins.format(number[1]), cosmos_text(axes, 0.01))

    record = write_files_and_read_record(tmp_path, cosmos_text_with_axis_codes())
    assert_components(record, *project_to_north_and_east(A / 100, 340, B / 100, 70), C / 100)
    assert_components(
        write_files_and_read_record(tmp_path, cosmos_text_with_axis_codes(**{"340": -999})),
        record.north,
        record.east,
        record.up,
    )
    for wrong, says in (({"340": 70}, "70 degrees"), ({"Up": 401}, "down")):
        with expect_error(RecordError, f"the numbers below it say {says}; components may be swapped"):
            write_files_and_read_record(tmp_path, cosmos_text_with_axis_codes(**wrong))


def test_cosmos_unit_text_is_compared_with_its_code(tmp_path):
    text = cosmos_text(
        {name: (code, x) for (name, code), x in zip(ROTATED_AXIS_NAMES_AND_CODES, (A, B, C), strict=True)}, 0.01
    )
    assert_components(
        write_files_and_read_record(tmp_path, text.replace("=cm/sec2(04)", "=cm/sec^2 (04)")),
        *project_to_north_and_east(A / 100, 340, B / 100, 70),
        C / 100,
    )
    with expect_error(RecordError, "x.txt line 45", "samples in g, but the code says 4"):
        write_files_and_read_record(tmp_path, text.replace("units=cm/sec2(04)", "units=g(04)"))


@pytest.mark.parametrize(
    ("clock", "start"), [("UTC", COSMOS_RECORD_FIELDS["start"]), ("GMT", COSMOS_RECORD_FIELDS["start"]), ("PDT", None)]
)
def test_cosmos_start_time_is_used_only_if_its_clock_is_utc(tmp_path, clock, start):
    """Regression: local time was read as UTC, seven hours early."""
    text = cosmos_text(
        {name: (code, x) for (name, code), x in zip(ROTATED_AXIS_NAMES_AND_CODES, (A, B, C), strict=True)}, 0.01
    )
    assert (
        write_files_and_read_record(tmp_path, text.replace("20:53:04.400 UTC", f"20:53:04.400 {clock}")).start == start
    )


@pytest.mark.parametrize(
    ("name", "encoding"),
    [
        ("VIÑA DEL MAR", "latin-1"),
        ("CURICÓ", "latin-1"),
        ("VIÑA", "utf-8"),
        ("長野", "shift_jis"),
        ("ﾅｶﾞﾉ", "shift_jis"),
    ],
)
def test_station_names_are_decoded_with_their_accented_letters(name, encoding):
    """Regression: VIÑA in Latin-1 was decoded as Shift-JIS, VIﾑA."""
    source = SourceFile("x.v1", f"STATION {name} 1".encode(encoding))
    assert source.text == f"STATION {name} 1"


def test_bhrc_components_without_an_end_mark_are_refused(tmp_path):
    lines = bhrc_text({"L": A / 100, "V": C / 100, "T": B / 100}).splitlines()
    mark = lines.index("/&")
    for cut, last in ((lines[:mark] + lines[mark + 1 :], mark + 1), (lines[:-1], len(lines) - 1)):
        with expect_error(RecordError, f"x.txt line {last}: no end mark"):
            write_files_and_read_record(tmp_path, "\n".join(cut))


def test_a_sampling_interval_that_contradicts_the_length_is_refused(tmp_path):
    """Regression: an interval of 20 instead of 10 ms in the header doubled the length, against the stated duration."""
    texts = [esm_text(A, 0.01, "HNE"), esm_text(B, 0.01, "HNN"), unam_text({"N00E": A, "N90E": B})]
    stated = ("SAMPLING_INTERVAL_S: 0.01", "SAMPLING_INTERVAL_S: 0.01", "/0.01/")
    wrong = [text.replace(old, old.replace("1", "2")) for text, old in zip(texts, stated, strict=True)]
    assert all(text != other for text, other in zip(texts, wrong, strict=True))
    for files in ({"a.HNE.ASC": wrong[0], "a.HNN.ASC": wrong[1]}, {"x.asa": wrong[2]}):
        with expect_error(RecordError, "210 samples every 0.02 s, but the header's length is 2.1 s"):
            write_files_and_read_record(tmp_path, files)
    rounded = {
        f"a.{s}.ASC": text.replace("DURATION_S: 2.100", "DURATION_S: 2") for s, text in zip("EN", texts, strict=False)
    }
    assert write_files_and_read_record(tmp_path, rounded).duration == pytest.approx(2.09)


@pytest.mark.parametrize(("unit", "known"), [("cm/s2", True), ("cm/seg/seg", True), ("cm/s", False), ("g", False)])
def test_unam_files_are_read_only_in_gal(tmp_path, unit, known):
    text = unam_text({"N00E": A, "N90E": B}).replace("Gal (cm/s/s)", unit)
    if known:
        assert_components(write_files_and_read_record(tmp_path, text), A / 100, B / 100)
    else:
        with expect_error(RecordError, f"UNIDADES DE LOS DATOS {unit!r}; only Gal is read"):
            write_files_and_read_record(tmp_path, text)


@pytest.mark.parametrize(
    ("form", "old", "new", "place"),
    [
        ("unam", ": 100.642 LONG. W", ": -100.642 LONG. W", (17.211, -100.642)),
        ("unam", ": 100.642 LONG. W", ": 100.642 LONG. O", (17.211, -100.642)),
        ("unam", ": 17.211 LAT. N", ": -17.211 LAT. S", (-17.211, -100.642)),
        ("csmip2", "35.816N, 117.598W", "-35.816S, -117.598W", (-35.816, -117.598)),
        ("csmip2", "35.816N, 117.598W", "-35.816N, -117.598E", (-35.816, -117.598)),
        ("csmip2", "35.816N, 117.598W", "35.816N, 242.402E", (35.816, -117.598)),
        ("csmip2", "35.816N, 117.598W", "117.598N, 35.816E", None),
        ("csmip2", "35.816N, 117.598W", " " * 17, ()),  # The hypocentre, in a later line, is no place of a station.
        ("csmnc", "39.700N 77.600E", "-39.700S -77.600W", (-39.7, -77.6)),
        ("csmnc", "39.700N 77.600E", "39.700N 377.600E", None),
        ("cismid", "LATITUDE                   :  -12.07\n", "", ()),
        ("cismid", "-12.07", "12.07 S", (-12.07, -77.04)),
        ("cismid", "-77.04", "-77.04° W", (-12.07, -77.04)),
    ],
)
def test_signed_station_coordinates_are_read_and_those_out_of_range_left_out(tmp_path, form, old, new, place):
    """Regression: a minus sign next to S or W moved a station to the other hemisphere."""
    files = {
        name: text.replace(old, new)
        for name, text in TEXT_FORMATS_WITH_WRITERS[form]
        .file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)
        .items()
    }
    assert files != TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION)
    record = write_files_and_read_record(tmp_path, files)
    if place == ():  # is not stated
        assert record.latitude is None
    else:
        assert (record.latitude, record.longitude) == (pytest.approx(place) if place else (None, None))
    assert any("no place on the globe" in note for note in record.notes) is (place is None)


def test_epicentre_with_sign_and_letter_is_read_and_out_of_range_omitted(tmp_path):
    (text,) = (
        TEXT_FORMATS_WITH_WRITERS["csmip2"].file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION).values()
    )
    for stated, longitude in (("-117.60W", -117.6), ("417.60W", None)):
        spoilt = text.replace("35.77N,117.60W", f"35.77N,{stated}")
        assert spoilt != text
        assert write_files_and_read_record(tmp_path, spoilt).extra.get("event_longitude") == longitude


def test_unam_start_may_be_on_the_day_before_or_after_the_origin(tmp_path):
    late = unam_text({"N00E": A, "N90E": B}, first="00:00:03").replace("07:19:10.0", "23:59:50.0")
    assert write_files_and_read_record(tmp_path, late).start == "1995-09-15T00:00:03Z"
    memory = unam_text({"N00E": A, "N90E": B}, first="23:59:58").replace("07:19:10.0", "00:00:07.0")
    assert write_files_and_read_record(tmp_path, memory).start == "1995-09-13T23:59:58Z"


def uneven_times_of_digitised_film(step: float, size: int) -> np.ndarray:
    """Return times of digitised film, three decimals: steps vary by up to a third, and one gap is three steps long."""
    time = np.cumsum(step * (1 + np.random.default_rng(3).uniform(-1 / 3, 1 / 3, size)))
    time[size // 2 :] += 2 * step
    return np.round(time - time[0], 3)


def test_usc_samples_are_resampled_to_even_times_with_a_note(tmp_path):
    """Sines of 2 and 7 Hz at uneven times are resampled correctly; frequencies above 100 Hz are removed."""
    time = uneven_times_of_digitised_film(0.00423, 7000)
    first, second = (9 * np.sin(2 * np.pi * f * time) for f in (2.0, 7.0))
    record = write_files_and_read_record(
        tmp_path, {"x.s0a": usc_text({"N28W": first}, time), "x.e0a": usc_text({"S62W": second}, time)}
    )
    assert record.sampling_interval == 0.005
    even = np.arange(record.north.size) * 0.005
    expected = project_to_north_and_east(
        *(y for f, a in ((2.0, 332), (7.0, 242)) for y in (0.9 * G * np.sin(2 * np.pi * f * even), a))
    )
    inside = slice(20, -20)
    error = max(np.abs(x - y)[inside].max() for x, y in zip((record.north, record.east), expected, strict=True))
    assert error < 0.005 * 0.9 * G
    (note,) = {re.sub(r"^x\.\w+: ", "", note) for note in record.extra["notes"]}
    assert note.startswith("uneven times, 4.2 ms apart on average and 1")
    assert note.endswith("resampled to 5 ms (monotone cubic, anti-alias filter at 100 Hz)")
    # 150 Hz, which every fifth sample alone would show as 50 Hz; a few samples are missing, so the times are uneven.
    fast = np.delete(np.arange(12000), [100, 4000, 9000]) * 0.001
    wave = 9 * np.sin(2 * np.pi * 150 * fast)
    both = {"x.s0a": usc_text({"N28W": wave}, fast), "x.e0a": usc_text({"S62W": wave}, fast)}
    assert np.std(write_files_and_read_record(tmp_path, both).north[inside]) < 0.01 * np.std(wave) * 0.1 * G


def test_both_usc_layouts_are_read_and_axis_text_is_compared_with_its_code(tmp_path):
    a, b, c = (np.round(x / 100, 3) for x in (A, B, C))
    narrow = usc_text({"N28W": a, "S62W": b, "DOWN": c}, narrow=True)
    expected = project_to_north_and_east(a * G / 10, 332, b * G / 10, 242)
    assert_components(write_files_and_read_record(tmp_path, narrow), *expected, -c * G / 10)
    assert_components(
        write_files_and_read_record(tmp_path, usc_text({"N28W": a, "S62W": b, "VERT": c}, code={"VERT": 500})),
        *expected,
        c * G / 10,
    )
    assert_components(
        write_files_and_read_record(tmp_path, usc_text({"N28W": a, "S62W": b, "UP": c}, code={"UP": 400})),
        *expected,
        c * G / 10,
    )
    record = write_files_and_read_record(tmp_path, usc_text({"N28W": a, "S62W": b, "VERT": c}))
    assert_components(record, *expected)
    assert "vertical axis 'VERT' left out" in record.extra["notes"][0]
    for axis, code, words in (
        ("UP", 600, "line 147: axis 'UP'"),
        ("UP", 90, "line 147"),
        ("N28W", 242, "line 7: axis"),
    ):
        with expect_error(RecordError, "x.txt", words):
            write_files_and_read_record(tmp_path, usc_text({"N28W": a, "S62W": b, "UP": c}, code={axis: code}))
    # Film is digitised trace by trace, as far as each can be read.
    files = {"x.s0a": usc_text({"N28W": a}), "x.e0a": usc_text({"S62W": b[:90]})}
    cut = write_files_and_read_record(tmp_path, files)
    assert cut.north.size == 90
    assert cut.processing[0]["step"] == "common_window"
    corrected = "CORRECTED ACCELEROGRAM  IIBB127  94.610.0 COMP N08W   FILE   0  CORRESPONDING T\n" + files["x.s0a"]
    with expect_error(RecordError, "x.txt line 1", "only volume 1 is read"):
        write_files_and_read_record(tmp_path, corrected)


@pytest.mark.parametrize(
    ("recorder", "first", "trigger", "start"),
    [
        # Arica, 2009: P waves arrived 17 s after the origin, 03:05:57, and 49.7 s after the first sample.
        ("ETNA", "11/13/2009 3:05:27", "11/13/2009 3:06:17.600", "2009-11-13T03:05:27.6Z"),
        # Angol and Santiago, 2010: the earthquake of 06:34 is at 03:53 and 03:35 of the local clocks.
        ("QDR", "02/27/2010 3:53:52", "2/27/2010 3:54:12.000", None),
        ("SSA2", "02/27/2010 3:35:22", "2/27/2010 3:35:36.840", None),
        ("ETNA", "02/27/2010 6:35:20", "2/27/2010 7:35:40.800", None),
    ],
)
def test_renadic_start_time_precedes_its_trigger_and_is_converted_from_local_time(
    tmp_path, recorder, first, trigger, start
):
    """Regression: the time of the trigger was taken as that of the first sample, 20 to 50 s too late."""
    a, b = (np.round(x / 100, 3) for x in (A, B))
    text = renadic_text({"NS": a, "EW": b}, first=first, trigger=trigger, recorder=recorder)
    assert write_files_and_read_record(tmp_path, text).start == start


def test_renadic_needs_declared_azimuths_and_ignores_unset_clocks(tmp_path):
    a, b = (np.round(x / 100, 3) for x in (A, B))
    never_set = renadic_text({"L": a, "T": b}, first="01/01/1980 0:00:00", trigger="1/1/1980 0:00:00.000")
    with expect_error(RecordError, "x.txt", "says nothing about north"):
        write_files_and_read_record(tmp_path, never_set)
    record = write_files_and_read_record(tmp_path, never_set, azimuths_deg=(0, 90))
    assert_components(record, a * G / 10, b * G / 10)
    assert record.start is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (cosmos_text({"340 deg": (340, A), "70 deg": (70, B)}, 0.01, unit=5), ["only acceleration"]),
        (
            cosmos_text({"340 deg": (340, A), "70 deg": (70, B)}, 0.01, unit=50),
            ["counts, but real 22", "is not stated"],
        ),
        (cosmos_counts_text(np.round(A), np.round(B), volts_per_g=-999.0), ["real 42", "not stated"]),
        (smc_text(A, 200.0, "360", kind="3 VELOCITY"), ["line 1: '3 VELOCITY'"]),
        (csmip_pairs_text({"N": (0, A / 100)}, 0.02).replace("  0.200", "  0.207"), ["line 30", "not evenly spaced"]),
        (smc_text(A, 200.0, "360").replace("2.0000000E+02", "1.7000000E+38", 1), ["line 18", "1.7e+38", "undefined"]),
        (peer_text(A, 0.01, "0").replace("ACCELERATION TIME SERIES IN UNITS OF G", "VELOCITY"), ["line 3", "AT2"]),
        (peer_text(A, 0.01, "228").replace(peer_text(A, 0.01, "228").split()[-1], "1.7e308"), ["sample 209 of 228"]),
    ],
)
def test_quantities_other_than_acceleration_and_invalid_numbers_are_refused(tmp_path, text, words):
    with expect_error(RecordError, "x.txt", *words):
        write_files_and_read_record(tmp_path, text)


def test_cosmos_peaks_are_compared_within_the_rounding_of_the_samples(tmp_path):
    a, b = np.zeros(200), np.zeros(200)
    a[50], b[70] = 40.0, 30.0
    write_files_and_read_record(tmp_path, cosmos_counts_text(a, b).replace(f"{40:13.6f}", f"{40.4:13.6f}"))
    text = cosmos_text({"340 deg": (340, a / 50), "70 deg": (70, b / 50)}, 0.01)
    write_files_and_read_record(tmp_path, text)
    with expect_error(RecordError, "x.txt", "states a peak of 0.808 Gal"):
        write_files_and_read_record(tmp_path, text.replace(f"{0.8:13.6f}", f"{0.808:13.6f}"))


def test_esm_raw_files_count_as_raw_and_may_state_the_epicentre(tmp_path):
    place = "EVENT_LATITUDE_DEGREE: 42.8322\nEVENT_LONGITUDE_DEGREE: 13.1107\nMAGNITUDE_W:"
    changes = {"DATA_TYPE: ACCELERATION": "DATA_TYPE: Acceleration", "LINE REM": "LINE NOT REM", "MAGNITUDE_W:": place}
    files = {f"x.{stream}.ASC": esm_text(x, 0.01, stream) for stream, x in (("HNE", B), ("HNN", A))}
    for old, new in changes.items():
        files = {name: text.replace(old, new) for name, text in files.items()}
    extra = write_files_and_read_record(tmp_path, files).extra
    assert (extra["processed"], extra["event_latitude"], extra["event_longitude"]) == (False, 42.8322, 13.1107)


def peer_file_pair(first, second, axes=("0", "90"), intervals=(0.01, 0.01)) -> dict[str, str]:
    """Return names and texts of two PEER files; the samples are in thousandths of g."""
    texts = zip((first, second), axes, intervals, strict=True)
    return {f"x{n}.AT2": peer_text(x / 1000, dt, axis) for n, (x, axis, dt) in enumerate(texts, 1)}


@pytest.mark.parametrize(("this", "that"), [("Test Receiving Sta", "Another Sta"), ("Test-01", "Kobe")])
def test_components_of_two_stations_or_earthquakes_are_refused(tmp_path, this, that):
    files = peer_file_pair(A, B)
    files["x2.AT2"] = files["x2.AT2"].replace(this, that)
    with expect_error(RecordError, this, that, "not of one record"):
        write_files_and_read_record(tmp_path, files)
    trusting = write_files_and_read_record(tmp_path, files, trust_data=True)
    assert_components(trusting, A * MILLI_G, B * MILLI_G, rtol=1e-6)
    (told,) = trusting.extra["trusted"]
    assert all(name in told for name in (this, that)), "what is trusted is said"
    files["x2.AT2"] = files["x2.AT2"].replace(that, f" {this.upper()}")
    assert_components(write_files_and_read_record(tmp_path, files), A * MILLI_G, B * MILLI_G, rtol=1e-6)


def test_different_agency_filters_are_listed_for_each_component(tmp_path):
    """Regression: the corner frequencies of the first component were reported for all."""
    files = {f"x{axis}.AT2": peer_text(x / 1000, 0.01, axis, header="old") for axis, x in (("N", A), ("E", B))}
    assert (
        processing_peaks_and_notes_of_record(write_files_and_read_record(tmp_path, files))["agency"]
        == "band-pass filter 0.1 to 30.0 Hz"
    )
    files["xE.AT2"] = files["xE.AT2"].replace("HP=0.1 Hz", "HP=0.4 Hz")
    agency = processing_peaks_and_notes_of_record(write_files_and_read_record(tmp_path, files))["agency"]
    assert agency == "N: band-pass filter 0.1 to 30.0 Hz; E: band-pass filter 0.4 to 30.0 Hz"


def test_esm_components_of_two_locations_at_one_station_are_refused(tmp_path):
    files = {f"x.{s}.ASC": esm_text(x, 0.01, s) for s, x in (("HNE", A), ("HNN", B))}
    code = {"x.HNE.ASC": "00", "x.HNN.ASC": "10"}
    files = {n: text.replace("STATION_NAME:", f"LOCATION: {code[n]}\nSTATION_NAME:") for n, text in files.items()}
    with expect_error(RecordError, "components of '00' and '10'"):
        write_files_and_read_record(tmp_path, files)


@pytest.mark.parametrize(("axes", "told"), [(("5", "90"), False), (("10", "85"), True), (("350", "280"), True)])
def test_horizontal_axes_far_from_a_right_angle_are_noted(tmp_path, axes, told):
    """Regression: one azimuth with an error of up to 26° rotated the motion without a note."""
    record = write_files_and_read_record(tmp_path, peer_file_pair(A, B, axes))
    first, second = (np.radians(float(axis)) for axis in axes)
    for samples, azimuth in ((A, first), (B, second)):
        projected = record.north * np.cos(azimuth) + record.east * np.sin(azimuth)
        np.testing.assert_allclose(projected, samples * MILLI_G, atol=1e-6)
    which = f"horizontal axes at {axes[0]}° and {axes[1]}°, "
    assert [note.startswith(which) for note in record.notes] == [True] * told


def test_declarations_that_a_file_contradicts_are_ignored_with_a_note(tmp_path):
    raw = "1 UNCORRECTED ACCELEROGRAM"
    files = {f"x{n}.smc": smc_text(x, 100, axis, kind=raw) for n, (x, axis) in enumerate([(A, "0"), (B, "90")])}
    plain = write_files_and_read_record(tmp_path, files, processed=False, sampling_interval_s=0.01)
    assert plain.notes == []
    told = write_files_and_read_record(tmp_path, files, unit="g", processed=True, sampling_interval_s=0.02)
    assert_components(told, plain.north, plain.east)
    assert told.notes[0].endswith("(unit g, processed, 0.02 s) is not taken: x0.smc states its own")
    assert len(told.notes) == 2
    assert (told.extra["processed"], told.sampling_interval) == (False, 0.01)
    with expect_error(ArgumentError, "columns: only csv has them, the format is 'smc'"):
        write_files_and_read_record(tmp_path, files, format="smc", columns="north:gal east:gal")


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"more": {24: (12,)}}, "a sensor at '12th floor' has the motion of a structure, not of the ground"),
        ({"more": {26: (3,)}}, "a sensor at 'deck above a pier' has"),
        ({"more": {27: (2,)}}, "a sensor at 'crest of a dam' has"),
        ({"more": {17: (1,)}}, "x0.smc: its header flags a problem with the record; read its comments"),
        ({"longitude": 122.385}, "longitude 122.385 is taken as east; give station_longitude_deg where it counts"),
        ({"more": {24: (1,)}}, None),
    ],
)
def test_location_and_flags_in_an_smc_header_are_noted(tmp_path, stated, words):
    """Regression: header integers 18 (problem flag) and 25, 27, 28 (place in a structure) were read without a note."""
    files = {f"x{n}.smc": smc_text(x, 100, axis, **stated) for n, (x, axis) in enumerate([(A, "0"), (B, "90")])}
    notes = write_files_and_read_record(tmp_path, files).notes
    assert any(words in note for note in notes) if words else notes == []


def test_a_raw_and_a_processed_component_are_refused_as_one_record(tmp_path):
    kinds = ("1 UNCORRECTED ACCELEROGRAM", "2 CORRECTED ACCELEROGRAM")
    files = {
        f"x{n}.smc": smc_text(x, 100, axis, kind=kind)
        for n, (x, axis, kind) in enumerate(zip((A, B), ("0", "90"), kinds, strict=True))
    }
    with expect_error(RecordError, "'raw' and 'processed'", "not of one record"):
        write_files_and_read_record(tmp_path, files)


@pytest.mark.parametrize(("axes", "word"), [(("H1", "H2"), "H1"), (("RAD", "TAN"), "RAD"), (("--L", "--T"), "--L")])
def test_axes_without_a_direction_are_refused_unless_declared(tmp_path, axes, word):
    with expect_error(RecordError, word, "says nothing about north", "azimuths"):
        write_files_and_read_record(tmp_path, peer_file_pair(A, B, axes))
    assert_components(
        write_files_and_read_record(tmp_path, peer_file_pair(A, B, axes), azimuths_deg=(60, 330)),
        *project_to_north_and_east(A * MILLI_G, 60, B * MILLI_G, 330),
        rtol=1e-6,
    )


def test_declared_azimuths_follow_the_order_of_files_with_a_note(tmp_path):
    """Regression: a file named alone got the first azimuth, even if second; no note told the azimuth of each axis."""
    files = peer_file_pair(A, B, ("H1", "H2"))
    first, second = files
    for (one, x), (other, y) in (((first, A), (second, B)), ((second, B), (first, A))):
        record = write_files_and_read_record(
            tmp_path, {name: files[name] for name in (one, other)}, azimuths_deg=(-30, 60)
        )
        assert_components(record, *project_to_north_and_east(x * MILLI_G, 330, y * MILLI_G, 60), rtol=1e-6)
        names = {first: "H1", second: "H2"}
        assert record.extra["declared"] == [
            f"axis '{names[one]}' of {one} at -30°",
            f"axis '{names[other]}' of {other} at 60°",
        ]
    alone = DeclaredFileProperties(azimuths_deg=(60, 330))
    assert_components(
        read_record_without_processing(tmp_path / first, alone),
        *project_to_north_and_east(A * MILLI_G, 60, B * MILLI_G, 330),
        rtol=1e-6,
    )
    with expect_error(
        RecordError, f"{second}: azimuths_deg are those of the files in their order", f"{first} {second}", "name both"
    ):
        read_record_without_processing(tmp_path / second, alone)


@pytest.mark.parametrize("axis", ["V", "+V", "VER", "Vert"])
def test_a_vertical_axis_of_unknown_sense_is_omitted_with_a_note_unless_declared(tmp_path, axis):
    files = peer_file_pair(A, B) | {"x3.AT2": peer_text(C / 1000, 0.01, axis)}
    record = write_files_and_read_record(tmp_path, files)
    assert_components(record, A * MILLI_G, B * MILLI_G, rtol=1e-6)
    (note,) = record.extra["notes"]
    assert f"vertical axis {axis!r} left out: x3.AT2 does not say whether up or down" in note
    assert "declare vertical_sense up or down (in the record table;" in note
    for sense, up in (("up", C * MILLI_G), ("down", -C * MILLI_G), ("none", None)):
        entry = RecordTableRow(id="x", source=" ".join(files), vertical_sense=sense)
        record = read_record(entry, tmp_path)
        assert_components(record, A * MILLI_G, B * MILLI_G, up, rtol=1e-6)
        assert "notes" not in record.extra
    files["x3.AT2"] = files["x3.AT2"].replace(axis, "DWN")
    for sense, notes in (("down", []), ("none", []), ("up", ["axis 'DWN' is not taken up"])):
        record = write_files_and_read_record(tmp_path, files, vertical_sense=sense)
        assert_components(record, A * MILLI_G, B * MILLI_G, None if sense == "none" else -C * MILLI_G, rtol=1e-6)
        assert [note.partition(",")[0] for note in record.notes] == notes


def test_all_errors_of_a_record_are_reported_at_once(tmp_path):
    files = peer_file_pair(1e6 * A, B[:100], ("H1", "H2"))
    with expect_error(RecordError, "says nothing about north", "210 and 100 samples", "peak acceleration 9"):
        write_files_and_read_record(tmp_path, files)
    with expect_error(RecordError, "x1.AT2 line 3", "x2.AT2 line 4: header promises 999"):
        spoilt = [
            text.replace(old, new)
            for text, old, new in zip(
                peer_file_pair(A, B).values(),
                ("UNITS OF G", "NPTS=    210"),
                ("UNITS OF M", "NPTS=    999"),
                strict=True,
            )
        ]
        write_files_and_read_record(tmp_path, dict(zip(files, spoilt, strict=True)))


def test_samples_towards_s60w_become_opposite_motion_towards_n60e(tmp_path):
    """Samples recorded towards S60W give the opposite motion towards N60E."""
    assert_components(
        write_files_and_read_record(tmp_path, peer_file_pair(-A, B, ("240", "150"))),
        *project_to_north_and_east(A * MILLI_G, 60, B * MILLI_G, 150),
        rtol=1e-6,
    )


def test_components_of_different_length_are_cut_to_the_shortest_or_refused(tmp_path):
    assert_components(
        write_files_and_read_record(tmp_path, peer_file_pair(A, B[:160])),
        A[:160] * MILLI_G,
        B[:160] * MILLI_G,
        rtol=1e-6,
    )
    with expect_error(RecordError, "210 and 159 samples, 0.51 s apart"):
        write_files_and_read_record(tmp_path, peer_file_pair(A, B[:159]))
    trusting = write_files_and_read_record(tmp_path, peer_file_pair(A, B[:159]), trust_data=True)
    assert (trusting.north.size, len(trusting.extra["trusted"])) == (159, 1)


def test_components_with_slightly_different_starts_are_aligned(tmp_path):
    files = {"x.HNN.ASC": esm_text(A, 0.01, "HNN"), "x.HNE.ASC": esm_text(B, 0.01, "HNE")}
    late = files | {"x.HNE.ASC": files["x.HNE.ASC"].replace("064010.450", "064010.520")}
    record = write_files_and_read_record(tmp_path, late)
    assert_components(record, A[7:] * 0.01, B[:-7] * 0.01)
    assert record.start == "2016-10-30T06:40:10.52Z"
    with expect_error(RecordError, "start 0.55 s apart"):
        write_files_and_read_record(
            tmp_path, files | {"x.HNE.ASC": files["x.HNE.ASC"].replace("064010.450", "064011.000")}
        )


def test_unequal_rates_parallel_axes_and_repeated_components_are_refused(tmp_path):
    for files, words in (
        (peer_file_pair(A, B, intervals=(0.01, 0.02)), "sampling interval 0.02 s"),
        (peer_file_pair(A, B, ("0", "30")), "right angle"),
        (peer_file_pair(A, B) | {"x3.AT2": peer_text(A / 1000, 0.01, "0")}, "two horizontal components"),
    ):
        with expect_error(RecordError, words):
            write_files_and_read_record(tmp_path, files)


@given(
    arrays(np.int64, (2, 20), elements=st.integers(-999, 999)),
    st.floats(0, 360),
    st.booleans(),
    st.floats(-20, 20),
)
@settings(max_examples=30, deadline=None)
def test_rotation_to_north_and_east_preserves_motion_along_sensor_axes(samples, azimuth, left_handed, correction):
    """Motion along a sensor's axis is what that sensor recorded, whichever way the axes run."""
    azimuths = (azimuth, azimuth - 90 if left_handed else azimuth + 90)
    declared = DeclaredFileProperties(azimuths_deg=azimuths, correction_deg=correction, trust_data=True)
    files = [SourceFile(name, text.encode()) for name, text in peer_file_pair(*samples, intervals=(0.01, 0.01)).items()]
    record = assemble_record(read_components(files, declared), "x", declared)
    for along, expected in zip(np.radians(np.add(azimuths, correction)), samples, strict=True):
        found = record.north * np.cos(along) + record.east * np.sin(along)
        np.testing.assert_allclose(found, expected * MILLI_G, atol=1e-8)
