"""Formats of further networks, each read to the numbers it was written from, its header checked against its data."""

import numpy as np
import pytest

from overturning.errors import RecordError
from overturning.records.read import read_path
from overturning.records.source import Declarations
from tests.expect import refused
from tests.records.record_writers import cosmos_text, esm_text, smc_text
from tests.records.seed_writers import write_inventory, write_sac
from tests.records.world_writers import bhrc_text, counts_text, cwa_text, nsmn_text, renadic_text, unam_text

G = 9.80665
random = np.random.default_rng(17)
A, B, C = (np.round(random.normal(0, 50, 210), 1) for _ in range(3))


def put(tmp_path, name, text, **declared):
    (tmp_path / name).write_text(text)
    return read_path(tmp_path / name, Declarations(**declared))


def same(record, north, east, up, scale):
    for found, expected in ((record.north, north), (record.east, east), (record.up, up)):
        np.testing.assert_allclose(found, np.asarray(expected) * scale, atol=1e-9)


def test_cwa_with_its_signs_and_the_time_of_taiwan(tmp_path):
    record = put(tmp_path, "x.dat", cwa_text(A, B, C))
    same(record, A, B, C, 0.01)
    assert record.start == "2018-02-06T15:50:29Z"
    assert (record.station, record.latitude, record.extra["magnitude"]) == ("TST", 22.86, 6.0)
    other = put(tmp_path, "y.dat", cwa_text(A, B, C, sequence="Time E(-); U(-); N(+)"))
    same(other, A, -B, -C, 0.01)


@pytest.mark.parametrize("write", [cwa_text, nsmn_text])
def test_the_end_of_a_file_may_lack_its_line_end_or_have_more_but_no_digits_less(tmp_path, write):
    north, east, up = (np.append(x, end) for x, end in ((A, -12.3), (B, -1.2), (C, 123.4)))
    whole = write(north, east, up)
    for end in ("", "\n \n\n"):  # the last two numbers have unlike many digits, and as many decimals
        same(put(tmp_path, "x.txt", whole.rstrip("\n") + end), north, east, up, 0.01)
    with refused(RecordError, f"x.txt line {whole.count(chr(10))}", "is cut"):
        put(tmp_path, "x.txt", whole.rstrip("\n")[:-1])


def test_nsmn(tmp_path):
    record = put(tmp_path, "x.txt", nsmn_text(A, B, C))
    same(record, A, B, C, 0.01)
    assert record.start == "1999-08-17T00:01:47.5Z"
    assert (record.station, record.longitude, record.extra["event_latitude"]) == ("8101", 31.14888, 40.7)
    (tmp_path / "z.txt").write_bytes(nsmn_text(A, B, C).replace("TEST MERKEZ", "DÜZCE ĞI").encode("cp1254"))
    same(read_path(tmp_path / "z.txt"), A, B, C, 0.01)


def test_bhrc_turns_l_and_t_and_asks_which_way_v_points(tmp_path):
    a, b, c = (np.round(x / 100, 4) for x in (A, B, C))
    text = bhrc_text({"L": a, "V": c, "T": b}, azimuths=(90, 180))
    with refused(RecordError, "x.V1", "'V'", "up or down"):
        put(tmp_path, "x.V1", text)
    record = put(tmp_path, "x.V1", text, vertical_sense="up")
    same(record, -b, a, c, 0.1 * G)
    assert record.sampling_interval == 0.005
    assert (record.station, record.extra["magnitude"]) == ("Test Shir", 6.1)
    lines = text.splitlines()
    mark = lines.index("/&")
    for cut, last in ((lines[:mark] + lines[mark + 1 :], mark + 1), (lines[:-1], len(lines) - 1)):
        with refused(RecordError, f"x.V1 line {last}: no end mark"):
            put(tmp_path, "x.V1", "\n".join(cut))


def test_unam_has_bearings_and_a_day_after_midnight(tmp_path):
    text = unam_text({"N00E": A, "+V": C, "N90W": B})
    with refused(RecordError, "x.asa", "'+V'", "up or down"):
        put(tmp_path, "x.asa", text)
    record = put(tmp_path, "x.asa", text, vertical_sense="up")
    same(record, A, -B, C, 0.01)
    assert record.start == "1995-09-14T07:19:20.5Z"
    assert (record.station, record.longitude) == ("TEST", -100.642)
    late = unam_text({"N00E": A, "N90E": B}, first="00:00:03").replace("07:19:10.0", "23:59:50.0")
    assert put(tmp_path, "y.asa", late).start == "1995-09-15T00:00:03Z"


def test_renadic_asks_for_azimuths_and_up(tmp_path):
    a, b, c = (np.round(x / 100, 3) for x in (A, B, C))
    text = renadic_text({"L": a, "V": c, "T": b})
    with refused(RecordError, "x.v1", "says nothing about north"):
        put(tmp_path, "x.v1", text, vertical_sense="up")
    with refused(RecordError, "x.v1", "up or down"):
        put(tmp_path, "x.v1", text, azimuths_deg=(0, 90))
    record = put(tmp_path, "x.v1", text, azimuths_deg=(0, 90), vertical_sense="up")
    same(record, a, b, c, 0.1 * G)
    assert (record.station, record.latitude, record.start) == ("PRUEBA S/N 4561", None, "2010-02-27T06:34:50Z")
    never_set = renadic_text({"L": a, "T": b}, trigger="1/1/1980 0:00:00.000")
    assert put(tmp_path, "y.v1", never_set, azimuths_deg=(0, 90)).start is None


def test_cosmos_counts_with_their_sensitivity(tmp_path):
    a, b = (np.round(x * 2) for x in (A, B))
    record = put(tmp_path, "x.V0", counts_text(a, b))
    scale = 2.0e-3 / (1.25 * 2.0) * G
    c, s = np.cos(np.radians(340)), np.sin(np.radians(340))
    np.testing.assert_allclose(record.north, (a * c - b * s) * scale, atol=1e-9)
    assert record.extra["processed"] is False
    with refused(RecordError, "x.V0", "real 42", "not stated"):
        put(tmp_path, "x.V0", counts_text(a, b, volts_per_g=-999.0))


def test_cosmos_peaks_are_compared_to_half_a_count_or_to_the_decimals_of_the_samples(tmp_path):
    a, b = np.zeros(200), np.zeros(200)
    a[50], b[70] = 40.0, 30.0
    put(tmp_path, "x.V0", counts_text(a, b).replace(f"{40:13.6f}", f"{40.4:13.6f}"))
    text = cosmos_text({"340 deg": (340, a / 50), "70 deg": (70, b / 50)}, 0.01)
    put(tmp_path, "x.V2", text)
    with refused(RecordError, "x.V2", "states a peak of 0.808 Gal"):
        put(tmp_path, "x.V2", text.replace(f"{0.8:13.6f}", f"{0.808:13.6f}"))


def test_esm_raw_files_are_raw(tmp_path):
    texts = {
        s: esm_text(x, 0.01, s).replace("DATA_TYPE: ACCELERATION", "DATA_TYPE: Acceleration")
        for s, x in (("HNE", B), ("HNN", A))
    }
    for stream, text in texts.items():
        (tmp_path / f"x.{stream}.ASC").write_text(text.replace("BASELINE REMOVED", "BASELINE NOT REMOVED"))
    record = read_path([tmp_path / "x.HNE.ASC", tmp_path / "x.HNN.ASC"])
    np.testing.assert_allclose(record.north, A * 0.01, atol=1e-9)
    assert record.extra["processed"] is False


@pytest.mark.parametrize(("unit", "scale"), [("M/S**2", 1.0), ("CM/S**2", 0.01), ("G", G)])
def test_sac_takes_its_unit_from_stationxml(tmp_path, unit, scale):
    write_inventory(tmp_path / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)}, gain=4e5, unit=unit)
    paths = [write_sac(tmp_path / f"{name}.sac", 1000 * x, name, 0.0, 90.0) for name, x in (("HNN", A), ("HNE", B))]
    record = read_path([*paths, tmp_path / "s.xml"])
    np.testing.assert_allclose(record.north, 1000 * A / 4e5 * scale, rtol=1e-6)


def test_stationxml_in_a_unit_of_nothing_is_refused(tmp_path):
    write_inventory(tmp_path / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)}, unit="V")
    paths = [write_sac(tmp_path / f"{name}.sac", x, name, 0.0, 90.0) for name, x in (("HNN", A), ("HNE", B))]
    with refused(RecordError, "HNN.sac", "V in the StationXML"):
        read_path([*paths, tmp_path / "s.xml"])


@pytest.mark.parametrize("form", ["cwa", "nsmn", "unam"])
def test_header_peaks_are_compared(tmp_path, form):
    write = {"cwa": cwa_text, "nsmn": nsmn_text, "unam": lambda a, b, _c: unam_text({"N00E": a, "N90E": b})}[form]
    header, doubled = write(A, B, C), write(2 * A, 2 * B, 2 * C)
    at = {"cwa": "#Data:", "nsmn": "       N-S", "unam": "DATOS DE ACEL"}[form]
    spoilt = header[: header.index(at)] + doubled[doubled.index(at) :]
    with refused(RecordError, "x.txt", "states a peak", "--trust-data"):
        put(tmp_path, "x.txt", spoilt)
    record = put(tmp_path, "x.txt", spoilt, trust_data=True)
    assert len(record.extra["trusted"]) >= 2
    assert all("header states a peak" in why for why in record.extra["trusted"])


def test_smc_says_what_its_word_for_undefined_means(tmp_path):
    text = smc_text(A, 200.0, "360")
    where = text.index("2.0000000E+02")
    (tmp_path / "0a.smc").write_text(text[:where] + "1.7000000E+38" + text[where + 13 :])
    with refused(RecordError, "0a.smc line 18", "1.7e+38", "undefined"):
        read_path(tmp_path / "0a.smc")
