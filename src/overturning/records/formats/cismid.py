"""CISMID (Universidad Nacional de Ingeniería, Peru): three components in one file, cm/s².

The format, as its files describe themselves: five numbered sections. The sections on station, earthquake and record
have lines ``KEY : text``; the comments describe the processing; the data begin with a line that names their columns:
time, EW, NS and UD. Times are local times of Peru.
"""

import re
from datetime import datetime, timedelta
from typing import Final

from overturning.records.component import Component, Direction, HeaderPeak
from overturning.records.formats.header import Fields, Header, stated_time
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import SourceFile
from overturning.units import GAL

PERU: Final = timedelta(hours=-5)
SUMMERS: Final = (1986, 1987, 1990, 1994)
"""Years with summer time in Peru (January to April); the headers do not state whether they use it."""
CLOCK: Final = "%B %d, %Y %H:%M:%S"
AXES: Final[dict[str, Direction]] = {"NS": (0.0, 0), "EW": (90.0, 0), "UD": (None, 1)}
FILTERED: Final = re.compile(r"(?<!un)(?<!not )(?<!no )(?<!without )(?<!without a )filter", re.IGNORECASE)
"""Comments on samples that were filtered."""
STATION: Final[Fields] = {
    "station": r"^STATION CODE\s*:\s*(\S*)",
    "LATITUDE": rf"^LATITUDE\s*:\s*({FLOAT})",
    "LONGITUDE": rf"^LONGITUDE\s*:\s*({FLOAT})",
    "SAMPLING FREQUENCY (Hz)": rf"^SAMPLING FREQUENCY \(Hz\)\s*:\s*({FLOAT})",
    "section 2": r"^2\.\s*(INFORMATION ABOUT THE EARTHQUAKE)",
}
RECORD: Final[Fields] = {
    "DATE": r"^DATE\s*:\s*(.*)",
    "ORIGIN TIME": r"^ORIGIN TIME \(Local\)\s*:\s*(\S*)",
    "LATITUDE": rf"^LATITUDE\s*:\s*({FLOAT})",
    "LONGITUDE": rf"^LONGITUDE\s*:\s*({FLOAT})",
    "depth": rf"^DEPTH \(km\)\s*:\s*({FLOAT})",
    "magnitude": rf"^MAGNITUDE\s*:\s*({FLOAT})",
    "RECORD TIME": r"^RECORD TIME \(Local\)\s*:\s*(\S*)",
    "NUMBER OF SAMPLES": r"^NUMBER OF SAMPLES\s*:\s*(\S*)",
    "MAXIMUM ACCELERATION": rf"^MAXIMUM ACCELERATION\s*:\s*({FLOAT}\s+{FLOAT}\s+{FLOAT})\s*$",
    "DATA UNITS": r"^DATA UNITS\s*:\s*(.*)",
    "section 4": r"^4\.\s*(COMMENTS)",
    "the line T, EW, NS, UD": r"^\s*T\s+((?:EW|NS|UD)\s+(?:EW|NS|UD)\s+(?:EW|NS|UD))\s*$",
}


def read(source: SourceFile) -> list[Component]:
    """Read all components; a RecordError names the line where the file is cut or contradicts itself."""
    station = Header.of(source, STATION, 40)
    at = station.at("section 2")
    header = Header.of(Lines(source, source.lines[at:], at), RECORD, 40)
    header.check_unit("DATA UNITS", r"(cm/s2|cm/s\^2|gal)\s*$", "cm/s2")
    heading = header.at("the line T, EW, NS, UD")
    columns = header.text("the line T, EW, NS, UD").upper().split()
    if len(set(columns)) < len(AXES):
        raise header.error(heading, f"columns {', '.join(columns)}; one of them comes twice: correct it")
    interval = station.interval("SAMPLING FREQUENCY (Hz)")
    values, notes = header.stated_samples("NUMBER OF SAMPLES", header.rows(heading + 1, 1 + len(columns)))
    header.check_spacing(heading + 1, values[:, 0], interval, 1, "get the file again")
    comments = " ".join(" ".join(header.lines[header.at("section 4") + 1 : heading - 1]).split())
    origin, start = (_moment(header, name) for name in ("ORIGIN TIME", "RECORD TIME"))
    if origin and start and start < origin - timedelta(hours=12):  # The date is the earthquake's.
        start += timedelta(days=1)
    return [
        header.component(
            axis,
            AXES[axis],
            values[:, column] * GAL,
            interval,
            start=start,
            station=station.text("station"),
            event=f"earthquake of {header.text('DATE')} {header.text('ORIGIN TIME')} (Peru)",
            origin=origin,
            coordinates=(station.optional("LATITUDE"), station.optional("LONGITUDE")),
            peak=_peak(header, column - 1),
            epicentre=(header.optional("LATITUDE"), header.optional("LONGITUDE")),
            # A baseline correction alone leaves long-period noise in the samples; a filter removes it.
            processed=bool(FILTERED.search(comments)),
            extra=header.numbers({"depth_km": "depth"}) | ({"agency_processing": comments} if comments else {}),
            notes=notes,
        )
        for column, axis in enumerate(columns, 1)
    ]


def _moment(header: Header, name: str) -> datetime | None:
    """Return the UTC time for the earthquake's date and a local time of day; None in years of summer time."""
    moment = stated_time(f"{header.text('DATE')} {header.text(name)}", CLOCK, ahead=PERU)
    return None if moment and moment.year in SUMMERS and moment.month <= 4 else moment


def _peak(header: Header, place: int) -> HeaderPeak | None:
    """Return the stated peak of the component in a column, counted from 0; None if the header states none."""
    stated = header.text("MAXIMUM ACCELERATION").split()
    return header.peak("MAXIMUM ACCELERATION", GAL, stated[place]) if stated else None
