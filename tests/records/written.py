"""One record of three components in every text format, and the values that must be read back."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from overturning.records.declared_properties import DeclaredFileProperties
from tests.records.record_writers import (
    cosmos_text,
    csmip_pairs_text,
    csmip_text,
    esm_text,
    geonet_text,
    knet_text,
    peer_text,
    smc_text,
)
from tests.records.world_writers import (
    bhrc_text,
    cismid_text,
    cosmos_counts_text,
    csmnc_text,
    cwa_text,
    jma_text,
    nsmn_text,
    renadic_text,
    unam_text,
    usc_text,
)

G = 9.80665


@dataclass(frozen=True)
class TextFormatWithWriter:
    """Text format of records: function that writes test files, units and steps, and metadata expected on reading."""

    make_file_texts: Callable[..., dict[str, str]]  # first and second axis and, but for ``up`` None, vertical samples
    smallest_sample_increment: float  # smallest step of samples, in the unit of the file
    unit_m_s2: float  # m/s²
    axis_azimuths_deg: tuple[float, float]  # azimuths of the first two axes
    header_line_count: int  # header lines of the first component
    sampling_interval_s: float
    expected_record_fields: dict[str, Any] = field(
        default_factory=dict
    )  # expected fields of the record, or of its ``extra``
    has_peak_in_header: bool = True  # whether the header states it
    declared: DeclaredFileProperties | None = None

    def file_texts_by_name(self, *samples: np.ndarray) -> dict[str, str]:
        """Return the file texts of a record by file name; samples are multiples of the format's smallest step."""
        return self.make_file_texts(*(np.round(x * self.smallest_sample_increment, 6) for x in samples))

    def expected_north_east(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Return expected north and east samples, m/s², projected without the package from perpendicular axes."""
        angles = np.radians(self.axis_azimuths_deg)
        return (
            self.smallest_sample_increment
            * self.unit_m_s2
            * np.array([f(angles[0]) * first + f(angles[1]) * second for f in (np.cos, np.sin)])
        )


def writer_of_one_file_with_axis_names(
    name: str, text: Callable[..., str], *axes: Any, **more: Any
) -> Callable[..., dict[str, str]]:
    """Return a function that writes all components into one file; ``text`` gets their samples by axis name."""
    return lambda *samples: {name: text(dict(zip(axes, samples, strict=False)), **more)}


def writer_of_one_file_with_axis_codes(
    name: str, text: Callable[..., str], *axes: tuple[str, int], **more: Any
) -> Callable[..., dict[str, str]]:
    """Return a function that writes all components into one file; ``text`` gets (code, samples) by axis name."""

    def file_text_by_name_with_axis_codes(*samples: np.ndarray) -> dict[str, str]:
        return {name: text({a: (code, x) for (a, code), x in zip(axes, samples, strict=False)}, **more)}

    return file_text_by_name_with_axis_codes


def writer_of_one_file_per_component(text: Callable[..., str], **axes: Any) -> Callable[..., dict[str, str]]:
    """Return a function that writes one file per component; keywords are file names, with ``__`` for the dot."""
    names = {name.replace("__", "."): more for name, more in axes.items()}
    return lambda *samples: {n: text(x, **more) for (n, more), x in zip(names.items(), samples, strict=False)}


def writer_of_one_file_with_columns(name: str, text: Callable[..., str]) -> Callable[..., dict[str, str]]:
    """Return a function that writes one file with a column for each component."""
    return lambda first, second, up=None: {name: text(first, second, 0 * first if up is None else up)}


def peer_files_writer(header: str) -> Callable[..., dict[str, str]]:
    """Return a function that writes three PEER files with a header of the given kind."""
    text = partial(peer_text, interval=0.01, header=header)
    return writer_of_one_file_per_component(
        text, x228__AT2={"axis": "228"}, x318__AT2={"axis": "318"}, x_UP__AT2={"axis": "UP"}
    )


DECLARED_VERTICAL_SENSE_UP = DeclaredFileProperties(vertical_sense="up")
GEONET_WRITER = writer_of_one_file_with_axis_codes(
    "x.V2A", geonet_text, ("N28W", 332), ("S62W", 242), ("Up", 0), interval=0.02
)
GEONET_RAW_WRITER = writer_of_one_file_with_axis_codes(
    "x.V1A", geonet_text, ("N28W", 332), ("S62W", 242), ("Up", 0), interval=0.02, corrected=False
)
SMC_WRITER = writer_of_one_file_per_component(
    partial(smc_text, rate=200.0), a__smc={"axis": "360"}, b__smc={"axis": "270"}, c__smc={"axis": "up", "vertical": 0}
)
ESM_WRITER = writer_of_one_file_per_component(
    partial(esm_text, interval=0.01), **{f"x__{s}__ASC": {"stream": s} for s in ("HNE", "HNN", "HNZ")}
)
GEONET_RECORD_FIELDS = {
    "start": "2016-11-13T11:02:19Z", "station": "TEST", "latitude": -42.61944, "longitude": 173.05361,
    "origin_time": "2016-11-13T11:02:56Z", "event_latitude": -42.6925, "event_longitude": 173.02194, "magnitude": 7.82,
}  # fmt: skip
CSMIP_RECORD_FIELDS = {"start": "2019-07-06T03:16:08Z", "station": "CLC", "latitude": 35.816, "longitude": -117.598}
COSMOS_RECORD_FIELDS = {
    "start": "2005-06-16T20:53:04.4Z", "station": "CE-J2236", "latitude": 34.046, "longitude": -117.035,
    "origin_time": "2005-06-16T20:53:26Z", "event_latitude": 34.058, "event_longitude": -117.011, "magnitude": 4.8,
}  # fmt: skip
EAST_NORTH_AXIS_NAMES_AND_CODES = (("90 Deg", 90), ("360 Deg", 360), ("Up", 0))
ROTATED_AXIS_NAMES_AND_CODES = (("340 deg", 340), ("70 deg", 70), ("Up", 400))
TEXT_FORMATS_WITH_WRITERS: dict[str, TextFormatWithWriter] = {
    "knet": TextFormatWithWriter(
        writer_of_one_file_per_component(
            knet_text, T__NS={"direction": "N-S"}, T__EW={"direction": "E-W"}, T__UD={"direction": "U-D"}
        ),
        1, 2000 / 8388608 * 0.01, (0, 90), 17, 0.01,
        {"start": "2001-02-03T04:05:06Z", "station": "TST001", "latitude": 35.2289, "longitude": 133.3904,
         "origin_time": "2001-02-03T04:05:01Z", "event_latitude": 35.275, "event_longitude": 133.348, "magnitude": 6.1},
    ),
    "geonet": TextFormatWithWriter(GEONET_WRITER, 0.1, 1e-3, (332, 242), 26, 0.02,
    GEONET_RECORD_FIELDS | {"processed": True}),
    "geonet-raw": TextFormatWithWriter(GEONET_RAW_WRITER, 0.1, 1e-3, (332, 242), 26, 0.02,
    GEONET_RECORD_FIELDS | {"processed": False}),
    "csmip1": TextFormatWithWriter(
        writer_of_one_file_with_axis_codes("x.v1", csmip_text, *EAST_NORTH_AXIS_NAMES_AND_CODES, rate=100), 1e-4, G,
        (90, 0), 28, 0.01, CSMIP_RECORD_FIELDS
    ),
    "csmip2": TextFormatWithWriter(
        writer_of_one_file_with_axis_codes("x.v2", csmip_text, *EAST_NORTH_AXIS_NAMES_AND_CODES, rate=100, volume=2),
        0.1, 0.01, (90, 0), 46, 0.01,
        CSMIP_RECORD_FIELDS | {
            "processed": True, "event": "Fri Jul 5, 2019 20:16:08.0 PDT", "magnitude": 7.1,
            "origin_time": "2019-07-06T03:19:53Z", "event_latitude": 35.77, "event_longitude": -117.6,
        },
    ),
    "csmip-pairs": TextFormatWithWriter(
        writer_of_one_file_with_axis_codes("x.RAW", csmip_pairs_text, ("090 DEG", 90), ("180 DEG", 180), ("UP", 0),
        interval=0.02),
        1e-3, 0.1 * G, (90, 180), 27, 0.02, {"station": "24436"},
    ),
    "cosmos": TextFormatWithWriter(
        writer_of_one_file_with_axis_codes("x.v2c", cosmos_text, *ROTATED_AXIS_NAMES_AND_CODES, interval=0.01), 0.1,
        0.01, (340, 70), 45, 0.01,
        COSMOS_RECORD_FIELDS | {"processed": True},
    ),
    "cosmos-g": TextFormatWithWriter(
        writer_of_one_file_with_axis_codes("x.v2", cosmos_text, *ROTATED_AXIS_NAMES_AND_CODES, interval=0.01, unit=2),
        1e-4, G, (340, 70), 45, 0.01,
    ),
    "cosmos0": TextFormatWithWriter(
        lambda *x: {"x.V0": cosmos_counts_text(*x[:2])}, 1, 2.0e-3 / (1.25 * 2.0) * G, (340, 70), 45, 0.01,
        {"processed": False, "up": None},
    ),
    "smc": TextFormatWithWriter(
        SMC_WRITER,
        0.1, 0.01, (0, 270), 29, 0.005,
        {"start": "1989-10-18T00:04:12.5Z", "station": "Test, 1 Main Street", "latitude": 37.728, "magnitude": 7.1},
    ),
    "peer": TextFormatWithWriter(
        peer_files_writer("new"), 1e-4, G, (228, 318), 4, 0.01, {"event": "Test-01 1/17/1994"}, has_peak_in_header=False
    ),
    "peer-old": TextFormatWithWriter(
        peer_files_writer("old"), 1e-4, G, (228, 318), 4, 0.01, {"event": "TEST 01/17/94 12:31"},
        has_peak_in_header=False,
    ),
    "peer-oldest": TextFormatWithWriter(
        peer_files_writer("oldest"), 1e-4, G, (228, 318), 4, 0.01, {"station": "TEST RECEIVING STA"},
        has_peak_in_header=False,
    ),
    "renadic": TextFormatWithWriter(
        writer_of_one_file_with_axis_names("x.v1", renadic_text, "NS", "EW", "V"), 1e-3, 0.1 * G, (0, 90), 27, 0.005,
        {"start": "2010-02-27T06:34:50.6Z", "station": "PRUEBA S/N 4561", "latitude": None},
        declared=DECLARED_VERTICAL_SENSE_UP,
    ),
    "cwa": TextFormatWithWriter(
        writer_of_one_file_with_columns("x.dat", cwa_text), 0.1, 0.01, (0, 90), 22, 0.01,
        {"start": "2018-02-06T15:50:29Z", "station": "TST", "latitude": 22.86, "magnitude": 6.0, "depth_km": 10.0,
         "origin_time": "2018-02-06T15:50:42Z", "event_latitude": 24.14, "event_longitude": 121.69},
    ),
    "nsmn": TextFormatWithWriter(
        writer_of_one_file_with_columns("x.txt", nsmn_text), 0.1, 0.01, (0, 90), 18, 0.01,
        {"start": "1999-08-17T00:01:47.5Z", "station": "8101", "latitude": 40.8437, "longitude": 31.14888,
         "origin_time": "1999-08-17T00:01:39Z", "event_latitude": 40.7, "event_longitude": 29.987},
    ),
    "csmnc": TextFormatWithWriter(
        writer_of_one_file_per_component(
            csmnc_text, ua0001__dat={"axis": "NS"}, ua0002__dat={"axis": "EW"}, ua0003__dat={"axis": "UD"}
        ),
        0.1, 0.01, (0, 90), 16, 0.01,
        {"start": "2024-01-01T04:00:06Z", "station": "99TST", "latitude": 39.7, "longitude": 77.6, "magnitude": 5.0,
         "origin_time": "2024-01-01T04:00:04Z", "event_latitude": 39.9, "event_longitude": 77.3, "depth_km": 9.0,
         "event": "NOWHERE EARTHQUAKE, NOWHERE,CHN", "processed": False},
    ),
    "jma": TextFormatWithWriter(
        writer_of_one_file_with_columns("99999.csv", jma_text), 0.1, 0.01, (0, 90), 7, 0.01,
        {"start": "2024-01-01T07:10:05Z", "station": "99999架空市本町", "latitude": 32.648, "longitude": 130.686,
         "processed": False},
        has_peak_in_header=False,
    ),
    "cismid": TextFormatWithWriter(
        writer_of_one_file_with_columns("x.txt", cismid_text), 0.1, 0.01, (0, 90), 36, 0.02,
        {"start": "1966-10-17T21:41:08Z", "station": "TST", "latitude": -12.07, "longitude": -77.04, "magnitude": 8.1,
         "origin_time": "1966-10-17T21:41:00Z", "event_latitude": -10.7, "event_longitude": -78.7, "depth_km": 24.0,
         "processed": False, "agency_processing": "BASELINE CORRECTED"},
    ),
    "bhrc": TextFormatWithWriter(
        writer_of_one_file_with_axis_names("x.V1", bhrc_text, "L", "T", "V"), 1e-3, 0.1 * G, (324, 54), 27, 0.005,
        {"station": "Test Shir", "latitude": 37.485, "longitude": 45.891, "magnitude": 6.1, "event_latitude": 38.52},
        has_peak_in_header=False, declared=DECLARED_VERTICAL_SENSE_UP,
    ),
    "unam": TextFormatWithWriter(
        writer_of_one_file_with_axis_names("x.asa", unam_text, "N00E", "N90W", "+V"), 0.1, 0.01, (0, 270), 23, 0.01,
        {"start": "1995-09-14T07:19:20.5Z", "station": "TEST", "latitude": 17.211, "longitude": -100.642,
         "origin_time": "1995-09-14T07:19:10Z"},
        declared=DECLARED_VERTICAL_SENSE_UP,
    ),
    "usc": TextFormatWithWriter(
        writer_of_one_file_with_axis_names("x.v1", usc_text, "N28W", "S62W", "UP"), 1e-3, 0.1 * G, (332, 242), 27,
        0.005,
        {"station": "USC 0099, 1 TEST RD., TESTING, CA", "latitude": 34.41917, "longitude": -118.42611,
         "event_latitude": 34.21333, "event_longitude": -118.53694, "magnitude": 6.7, "processed": False,
         "origin_time": "1994-01-17T12:30:00Z", "event": "TEST EARTHQUAKE JAN 17, 1994 -1230 GMT"},
        has_peak_in_header=False,
    ),
    "esm": TextFormatWithWriter(
        ESM_WRITER,
        0.1, 0.01, (90, 0), 23, 0.01,
        {"start": "2016-10-30T06:40:10.45Z", "station": "AMT", "latitude": 42.6325, "magnitude": 6.5, "vs30": 670.0,
         "origin_time": "2016-10-30T06:40:18Z"},
    ),
}  # fmt: skip
"""Formats by name; names that are not in the record table are volumes or versions of a format."""
