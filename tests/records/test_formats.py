"""Each format: written from numbers by the tests, read back as those numbers, in m/s², towards north, east and up."""

import math
import re

import numpy as np
import pytest

from overturning.errors import RecordError
from overturning.records.catalogue import RecordEntry
from overturning.records.component import channel_axis, parse_axis
from overturning.records.read import read_path, read_record
from overturning.records.source import Declarations
from tests.records.record_writers import (
    cosmos_text,
    csmip_pairs_text,
    csmip_text,
    esm_text,
    geonet_text,
    peer_text,
    smc_text,
)

G = 9.80665
MG = G / 1000
random = np.random.default_rng(7)
A, B, C = (np.round(random.normal(0, 50, 210), 1) for _ in range(3))


def turned(first, first_deg, second, second_deg):
    """North and east by projecting onto each axis's own direction (right angles only), not by the package's solver."""
    north = first * math.cos(math.radians(first_deg)) + second * math.cos(math.radians(second_deg))
    east = first * math.sin(math.radians(first_deg)) + second * math.sin(math.radians(second_deg))
    return north, east


def check(record, north, east, up=None, rtol=1e-9):
    scale = max(np.abs(north).max(), np.abs(east).max())
    np.testing.assert_allclose(record.north, north, atol=rtol * scale)
    np.testing.assert_allclose(record.east, east, atol=rtol * scale)
    if up is None:
        assert record.up is None
    else:
        np.testing.assert_allclose(record.up, up, atol=rtol * scale)


@pytest.mark.parametrize(
    ("text", "azimuth", "vertical"),
    [
        ("N28W", 332, 0),
        ("S62W", 242, 0),
        ("S90E", 90, 0),
        ("N00E", 0, 0),
        ("S74E", 106, 0),
        ("270", 270, 0),
        ("360 Deg", 0, 0),
        ("N", 0, 0),
        ("East", 90, 0),
        ("Up", None, 1),
        ("DWN", None, -1),
        ("H1", None, 0),
        ("RAD", None, 0),
        ("--L", None, 0),
        ("Vert", None, 0),
        ("N95E", None, 0),
        ("400", None, 0),
    ],
)
def test_axis_names(text, azimuth, vertical):
    assert parse_axis(text) == (azimuth, vertical)


def test_channel_codes():
    assert channel_axis("HNE") == (90.0, 0)
    assert channel_axis("HNZ") == (None, 1)
    assert channel_axis("HN1") == (None, 0)


@pytest.mark.parametrize("corrected", [True, False])
def test_geonet_with_odd_axes(tmp_path, corrected):
    path = tmp_path / "x.V2A"
    path.write_text(geonet_text({"N28W": (332, A), "S62W": (242, B), "Up": (0, C)}, 0.02, corrected=corrected))
    record = read_path(path)
    check(record, *turned(A * 1e-3, 332, B * 1e-3, 242), C * 1e-3)
    assert record.start == "2016-11-13T11:02:19Z"
    assert record.extra["processed"] is corrected
    assert (round(record.latitude, 4), round(record.longitude, 4)) == (-42.6194, 173.0536)
    epicentre = record.extra["event_latitude"], record.extra["event_longitude"]
    assert epicentre == pytest.approx((-42.6925, 173.0219), abs=1e-4)
    assert record.component_azimuths_deg == (332.0, 242.0)


def test_geonet_counts_samples_put_before_the_buffer(tmp_path):
    path = tmp_path / "x.V2A"
    path.write_text(geonet_text({"N00E": (0, A), "N90E": (90, B)}, 0.02, prepended=250))
    assert read_path(path).start == "2016-11-13T11:02:14Z"


def test_geonet_writes_0_for_a_magnitude_that_is_not_known(tmp_path):
    path = tmp_path / "x.V2A"
    path.write_text(geonet_text({"N00E": (0, A), "N90E": (90, B)}, 0.02))
    assert read_path(path).extra["magnitude"] == 7.82
    path.write_text(geonet_text({"N00E": (0, A), "N90E": (90, B)}, 0.02, magnitude=0.0))
    assert "magnitude" not in read_path(path).extra


def test_csmip_volume_1_and_2(tmp_path):
    a, b, c = A / 1000, B / 1000, C / 1000
    path = tmp_path / "x.v1"
    path.write_text(csmip_text({"90 Deg": (90, a), "360 Deg": (360, b), "Up": (0, c)}, 100))
    record = read_path(path)
    check(record, b * G, a * G, c * G)
    assert record.start == "2019-07-06T03:16:08Z"
    assert (record.station, record.latitude, record.longitude) == ("CLC", 35.816, -117.598)
    path = tmp_path / "x.v2"
    path.write_text(
        csmip_text({"90 Deg": (90, A), "360 Deg": (360, B), "Up": (0, C)}, 100, volume=2).replace("\n", "\r\n")
    )
    check(read_path(path), B * 0.01, A * 0.01, C * 0.01)
    assert read_path(path).extra["processed"] is True


def test_csmip_volume_2_of_the_eighties(tmp_path):
    """Capitals, CMS/SEC/SEC, and a data line without unit and format: the unit is that of the stated peak."""
    text = csmip_text({"90 Deg": (90, A), "360 Deg": (360, B)}, 100, volume=2).upper()
    text = text.replace("CM/SEC/SEC", "CMS/SEC/SEC").replace(", IN CM/SEC2. (8F10.4)", ".")
    path = tmp_path / "x.V2"
    path.write_text(text)
    check(read_path(path), B * 0.01, A * 0.01)
    path.write_text(text.replace("CMS/SEC/SEC", "FURLONGS"))
    with pytest.raises(RecordError, match="unit 'missing'"):
        read_path(path)


def test_csmip_raw_with_pairs_of_time_and_acceleration(tmp_path):
    a, b = np.round(A / 100, 3), np.round(B / 100, 3)
    path = tmp_path / "x.RAW"
    text = csmip_pairs_text({"090 DEG": (90, a), "180 DEG": (180, b)}, 0.02)
    path.write_text(text)
    check(read_path(path), -b * G / 10, a * G / 10, rtol=1e-6)
    path.write_text(text.replace("  0.200", "  0.207"))
    with pytest.raises(RecordError, match="not evenly spaced"):
        read_path(path)


@pytest.mark.parametrize(("unit", "scale"), [(2, G), (4, 0.01)])
def test_cosmos(tmp_path, unit, scale):
    path = tmp_path / "x.v2"
    a, b, c = (x / 100 if unit == 2 else x for x in (A, B, C))
    path.write_text(cosmos_text({"340 deg": (340, a), "70 deg": (70, b), "Up": (400, c)}, 0.01, unit=unit))
    record = read_path(path)
    check(record, *turned(a * scale, 340, b * scale, 70), c * scale)
    assert record.start == "2005-06-16T20:53:04.4Z"


@pytest.mark.parametrize(
    ("place", "deep"),
    [
        ("Downhole", True),
        ("Borehole -12m", True),
        ("Depth: 30 m", True),
        ("100 ft below ground", True),
        ("1.5 m deep vault", False),
        ("Ground floor", False),
    ],
)
@pytest.mark.parametrize("form", ["cosmos", "csmip"])
def test_the_location_of_a_channel_tells_a_borehole(tmp_path, form, place, deep):
    if form == "cosmos":
        text = cosmos_text({"360 Deg": (360, A), "90 Deg": (90, B)}, 0.01)
        text = text.replace("Location: free field", f"Location: {place}")
    else:
        text = csmip_text({"360 Deg": (360, A), "90 Deg": (90, B)}, 100, volume=2)
        text = re.sub(r"(?m)^(Chan .*?Deg)\s*$", rf"\1   Location: {place}", text)
    (tmp_path / "a.v").write_text(text)
    if deep:
        with pytest.raises(RecordError, match="of the borehole sensor"):
            read_path(tmp_path / "a.v")
    assert read_path(tmp_path / "a.v", Declarations(sensor="borehole" if deep else "surface")).north.size == A.size


@pytest.mark.parametrize(("unit", "words"), [(5, "only acceleration"), (50, "counts, but real 22 .* is not stated")])
def test_cosmos_of_other_quantities_is_refused(tmp_path, unit, words):
    path = tmp_path / "x.v2"
    path.write_text(cosmos_text({"340 deg": (340, A), "70 deg": (70, B)}, 0.01, unit=unit))
    with pytest.raises(RecordError, match=words):
        read_path(path)


def test_smc_with_touching_columns_and_its_sisters(tmp_path):
    values = np.array([float(f"{v:.4E}") for v in -np.abs(A) * 1.237]), np.array([float(f"{v:.4E}") for v in B]), C
    for name, samples, axis, vertical in (
        ("a", values[0], "360", 90),
        ("b", values[2], "up", 0),
        ("c", values[1], "270", 90),
    ):
        (tmp_path / f"0111{name}.smc").write_text(smc_text(samples, 200.0, axis, vertical=vertical))
    text = (tmp_path / "0111a.smc").read_text()
    assert "E+1-" in text
    for name in ("a", "b", "c"):
        record = read_path(tmp_path / f"0111{name}.smc")
        check(record, values[0] * 0.01, -values[1] * 0.01, values[2] * 0.01, rtol=1e-4)
    assert record.start == "1989-10-18T00:04:12.5Z"
    assert record.station == "Test, 1 Main Street"


def test_smc_velocity_is_refused(tmp_path):
    (tmp_path / "x.smc").write_text(smc_text(A, 200.0, "360", kind="3 VELOCITY"))
    with pytest.raises(RecordError, match="line 1: '3 VELOCITY'"):
        read_path(tmp_path / "x.smc")


@pytest.mark.parametrize("header", ["new", "old", "oldest"])
def test_peer_with_each_header(tmp_path, header):
    for name, samples, axis in (("228", A, "228"), ("318", B, "318"), ("-UP", C, "UP")):
        (tmp_path / f"RSN1_TEST_TRS{name}.AT2").write_text(peer_text(samples / 1000, 0.01, axis, header=header))
    record = read_path(tmp_path / "RSN1_TEST_TRS228.AT2")
    check(record, *turned(A / 1000 * G, 228, B / 1000 * G, 318), C / 1000 * G, rtol=1e-6)
    assert "94" in record.event


def test_a_sample_beyond_all_numbers_is_refused_without_a_warning(tmp_path):
    text = peer_text(A / 1000, 0.01, "228")
    (tmp_path / "x228.AT2").write_text(text.replace(text.split()[-1], "1.7e308"))
    (tmp_path / "x318.AT2").write_text(peer_text(B / 1000, 0.01, "318"))
    with pytest.raises(RecordError, match=r"x228.AT2: sample 209 of 228 is not a number"):
        read_path(tmp_path / "x228.AT2")


def test_peer_velocity_is_refused(tmp_path):
    (tmp_path / "x.VT2").write_text(
        peer_text(A / 1000, 0.01, "228").replace(
            "ACCELERATION TIME SERIES IN UNITS OF G", "VELOCITY TIME SERIES IN UNITS OF CM/S"
        )
    )
    with pytest.raises(RecordError, match=r"line 3: .*AT2"):
        read_path(tmp_path / "x.VT2")


def test_esm(tmp_path):
    for stream, samples in (("HNE", A), ("HNN", B), ("HNZ", C)):
        text = esm_text(samples, 0.005, stream)
        event = "EVENT_LATITUDE_DEGREE: 42.8322\nEVENT_LONGITUDE_DEGREE: 13.1107\nMAGNITUDE_W:"
        (tmp_path / f"IT.AMT.00.{stream}.D.20161030.C.ACC.ASC").write_text(text.replace("MAGNITUDE_W:", event))
    record = read_path(tmp_path / "IT.AMT.00.HNE.D.20161030.C.ACC.ASC")
    check(record, B * 0.01, A * 0.01, C * 0.01)
    assert record.start == "2016-10-30T06:40:10.45Z"
    assert record.extra["magnitude"] == 6.5
    assert (record.extra["event_latitude"], record.extra["event_longitude"]) == (42.8322, 13.1107)


@pytest.mark.parametrize(("axes", "word"), [(("H1", "H2"), "H1"), (("RAD", "TAN"), "RAD"), (("--L", "--T"), "--L")])
def test_axes_that_do_not_say_where_north_is_are_refused_unless_given(tmp_path, axes, word):
    paths = [tmp_path / "x1.AT2", tmp_path / "x2.AT2"]
    for path, samples, axis in zip(paths, (A, B), axes, strict=True):
        path.write_text(peer_text(samples / 1000, 0.01, axis))
    with pytest.raises(RecordError, match=f"{word}.*says nothing about north.*azimuths"):
        read_path(paths)
    check(read_path(paths, Declarations(azimuths_deg=(60, 330))), *turned(A * MG, 60, B * MG, 330), rtol=1e-6)


@pytest.mark.parametrize("axis", ["V", "VER", "Vert"])
def test_a_vertical_axis_of_unknown_sense_is_refused_unless_declared(tmp_path, axis):
    for name, samples, word in (("1", A, "0"), ("2", B, "90"), ("3", C, axis)):
        (tmp_path / f"x{name}.AT2").write_text(peer_text(samples / 1000, 0.01, word))
    with pytest.raises(RecordError, match="whether up or down"):
        read_path(tmp_path / "x1.AT2")
    for sense, up in (("up", C * MG), ("down", -C * MG), ("none", None)):
        entry = RecordEntry(id="x", source="x1.AT2 x2.AT2 x3.AT2", vertical_sense=sense)
        check(read_record(entry, tmp_path), A * MG, B * MG, up, rtol=1e-6)


def test_a_fault_normal_pulse_keeps_its_sense(tmp_path):
    """N60E positive comes out of S60W recorded negative: the flip that would turn every gravestone round."""
    paths = [tmp_path / "x1.AT2", tmp_path / "x2.AT2"]
    paths[0].write_text(peer_text(-A / 1000, 0.01, "240"))
    paths[1].write_text(peer_text(B / 1000, 0.01, "150"))
    check(read_path(paths), *turned(A * MG, 60, B * MG, 150), rtol=1e-6)


def test_components_of_unlike_length_are_cut_and_far_apart_refused(tmp_path):
    paths = [tmp_path / "x1.AT2", tmp_path / "x2.AT2"]
    paths[0].write_text(peer_text(A / 1000, 0.01, "0"))
    paths[1].write_text(peer_text(B[:160] / 1000, 0.01, "90"))
    check(read_path(paths), A[:160] * MG, B[:160] * MG, rtol=1e-6)
    paths[1].write_text(peer_text(B[:159] / 1000, 0.01, "90"))
    with pytest.raises(RecordError, match=r"210 and 159 samples, 0\.51 s apart"):
        read_path(paths)
    assert read_path(paths, Declarations(trust_data=True)).north.size == 159


def test_unlike_starts_are_aligned(tmp_path):
    paths = [tmp_path / "x.HNN.ASC", tmp_path / "x.HNE.ASC"]
    paths[0].write_text(esm_text(A, 0.01, "HNN"))
    late = esm_text(B, 0.01, "HNE").replace("064010.450", "064010.520")
    paths[1].write_text(late)
    record = read_path(paths)
    check(record, A[7:] * 0.01, B[:-7] * 0.01)
    assert record.start == "2016-10-30T06:40:10.52Z"
    paths[1].write_text(late.replace("064010.520", "064011.000"))
    with pytest.raises(RecordError, match=r"start 0\.55 s apart"):
        read_path(paths)


def test_unlike_rates_parallel_axes_and_doubled_components_are_refused(tmp_path):
    paths = [tmp_path / "x1.AT2", tmp_path / "x2.AT2"]
    paths[0].write_text(peer_text(A / 1000, 0.01, "0"))
    paths[1].write_text(peer_text(B / 1000, 0.02, "90"))
    with pytest.raises(RecordError, match=r"sampling interval 0.02 s"):
        read_path(paths)
    paths[1].write_text(peer_text(B / 1000, 0.01, "30"))
    with pytest.raises(RecordError, match="right angle"):
        read_path(paths)
    with pytest.raises(RecordError, match="two horizontal components"):
        read_path([*paths, paths[0]])


@pytest.mark.parametrize("form", ["geonet", "csmip", "cosmos", "smc", "esm"])
def test_every_header_peak_is_compared(tmp_path, form):
    """Samples doubled behind the header's back are refused, and read only on trust."""
    one, two = {"N": A, "E": B}, {"N": 2 * A, "E": 2 * B}

    def text(c, axis="N"):
        match form:
            case "geonet":
                return geonet_text({"N00E": (0, c["N"]), "N90E": (90, c["E"])}, 0.02)
            case "csmip":
                return csmip_text({"360 Deg": (360, c["N"] / 1e3), "90 Deg": (90, c["E"] / 1e3)}, 100)
            case "cosmos":
                return cosmos_text({"360 deg": (360, c["N"]), "90 deg": (90, c["E"])}, 0.01)
            case "smc":
                return smc_text(c[axis], 100.0, {"N": "360", "E": "90"}[axis])
        return esm_text(c[axis], 0.01, f"HN{axis}")

    first_sample = {"geonet": 26, "csmip": 28, "cosmos": 45, "smc": 29, "esm": 23}[form]
    paths = []
    for axis in ("N", "E") if form in ("smc", "esm") else ("N",):
        head, data = text(one, axis).splitlines(), text(two, axis).splitlines()
        path = tmp_path / f"x.{axis}"
        last = len(head) if form in ("smc", "esm") else first_sample + 20
        path.write_text("\n".join(head[:first_sample] + data[first_sample:last] + head[last:]) + "\n")
        paths.append(path)
    with pytest.raises(RecordError, match=r"the header states a peak of .*--trust-data"):
        read_path(paths)
    assert read_path(paths, Declarations(trust_data=True)).extra["trusted_data"] is True
