"""Which format a file has, by its content."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from overturning.errors import RecordError
from overturning.records.component import Component
from overturning.records.formats import (
    bhrc,
    cosmos,
    csmip,
    csv_columns,
    cwa,
    esm,
    geonet,
    knet,
    miniseed,
    nsmn,
    peer,
    sac,
    smc,
    unam,
)
from overturning.records.source import ReadOptions, SourceFile

Reader = Callable[[SourceFile, ReadOptions], list[Component]]


@dataclass(frozen=True)
class Format:
    """A file format: how the record table writes it, how a person calls it, whether a file has it, its components."""

    name: str
    title: str
    detect: Callable[[SourceFile], bool]
    read: Reader
    agency: str = ""  # who processes the files that are processed; empty where the file names it, or nobody does


def _plain(read: Callable[[SourceFile], list[Component]]) -> Reader:
    """A reader of files that say all about themselves."""
    return lambda source, _options: read(source)


FORMATS: Final = (
    Format("kik-net", "K-NET / KiK-net ASCII", knet.detect, _plain(knet.read)),
    Format("geonet", "GeoNet V1A / V2A", geonet.detect, _plain(geonet.read), "GNS Science"),
    Format("cosmos", "COSMOS V0 / V1 / V2", cosmos.detect, _plain(cosmos.read)),
    Format("csmip", "CSMIP / CGS V1, V2, RAW", csmip.detect, _plain(csmip.read), "CSMIP / CGS"),
    Format("smc", "USGS SMC", smc.detect, _plain(smc.read), "USGS"),
    Format("peer-at2", "PEER AT2", peer.detect, _plain(peer.read), "PEER"),
    Format("esm-dyna", "ESM / DYNA ASCII", esm.detect, _plain(esm.read), "ESM / ITACA"),
    Format("cwa", "CWA (Taiwan)", cwa.detect, _plain(cwa.read)),
    Format("nsmn", "NSMN / AFAD (Türkiye)", nsmn.detect, _plain(nsmn.read)),
    Format("bhrc", "BHRC (Iran)", bhrc.detect, _plain(bhrc.read)),
    Format("unam-asa", "UNAM ASA 2.0 (Mexico)", unam.detect, _plain(unam.read)),
    Format("miniseed", "MiniSEED with StationXML", miniseed.detect, miniseed.read),
    Format("sac", "SAC", sac.detect, sac.read),
    # Never by content: columns of numbers say nothing about themselves.
    Format("csv", "columns as declared", lambda _source: False, csv_columns.read),
)
"""In the order in which they are tried; the first that recognises a file reads it."""


def detect_format(source: SourceFile) -> Format:
    """The format of a file; a RecordError where none recognises it."""
    for form in FORMATS:
        if form.detect(source):
            return form
    if source.data[:400].lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"<"):
        raise RecordError(
            f"{source.name}: a web page or XML, not a record; sign in where you downloaded it, and get it again"
        )
    raise RecordError(
        f"{source.name}: the format is not recognised; known are {', '.join(f.name for f in FORMATS)} "
        "(docs/formats.md); declare columns to read it as csv, or get it again"
    )
