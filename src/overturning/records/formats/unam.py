"""UNAM's ASA 2.0 (Archivo Estándar de Aceleración, Mexico): up to six channels in one file, Gal.

The format: lines ``KEY : text`` whose lists have a slash before and between the values of channels C1 to C6; after the
line ``DATOS DE ACELERACION`` and a heading, one line per sample with a column per channel. The axes are bearings, or
``V``, ``+V`` and ``-V``, of which nobody says which way is up. The start has no date of its own: it is that of the
earthquake, or the next day.
"""

import re
from datetime import datetime, timedelta
from typing import Final

from overturning.errors import RecordError
from overturning.records.component import UNKNOWN, Component, Direction, StatedPeak, parse_axis
from overturning.records.formats.lines import FLOAT, Header, Lines, resolution
from overturning.records.source import SourceFile
from overturning.units import GAL

TITLE: Final = "ARCHIVO ESTANDAR DE ACELERACION"
_KEYS: Final = {
    "axes": "ORIENTACION C1-C6",
    "intervals": "INTERVALO DE MUESTREO, C1-C6",
    "counts": "NUM. TOTAL DE MUESTRAS, C1-C6",
    "peaks": "ACEL. MAX.(GAL), C1-C6",
    "unit": "UNIDADES DE LOS DATOS",
    "day": "FECHA DEL SISMO",
    "origin": "HORA EPICENTRO",
    "first": "HORA DE LA PRIMERA MUESTRA",
}
LATE: Final = timedelta(hours=12)


def detect(source: SourceFile) -> bool:
    """Whether a file has ASA's title."""
    return TITLE.encode() in source.data[:2000].upper()


def read(source: SourceFile) -> list[Component]:
    """Read all channels; a RecordError names the line where the file is cut or contradicts itself."""
    lines = Lines.of(source)
    marked = lines.find(r"DATOS DE ACELERACION")
    first = None if marked is None else next(
        (i for i in range(marked[1] + 1, len(lines.lines)) if re.match(rf"\s*{FLOAT}(\s|$)", lines.lines[i])), None
    )  # fmt: skip
    if marked is None or first is None or first - marked[1] > 10:
        raise lines.error(
            len(lines.lines) - 1, "no samples after a line DATOS DE ACELERACION; the file is cut: get it again"
        )
    header = Header.of(lines, marked[1])
    keys = {name: next((k for k in header.texts if k.upper().startswith(key)), key) for name, key in _KEYS.items()}
    unit = header.text(keys["unit"])
    if unit and not re.match(r"gal|cm/s", unit, re.IGNORECASE):
        raise header.error(keys["unit"], f"unit {unit!r}; only Gal is read")
    axes, intervals, counts = (_list(header, keys[name]) for name in ("axes", "intervals", "counts"))
    if not len(axes) == len(intervals) == len(counts):
        raise header.error(
            keys["axes"], f"{len(axes)} axes, {len(intervals)} intervals, {len(counts)} counts; get it again"
        )
    values = lines.rows(first, len(axes))
    lines.check_last_number(source.text[-200:])
    for text in counts:
        if header.number(keys["counts"], text) != values.shape[0]:
            raise header.error(
                keys["counts"],
                f"header promises {text} samples, the file has {values.shape[0]}; it is cut: get it again",
            )
    peaks = _list(header, keys["peaks"]) if keys["peaks"] in header.texts else []
    latitude, longitude = _place(header, "COORDENADAS DE LA ESTACION")
    return [
        Component.of(
            source,
            axis,
            _direction(axis),
            values[:, column] * GAL,
            header.number(keys["intervals"], intervals[column]),
            start=_moments(header, keys)[1],
            station=header.text("CLAVE DE LA ESTACION"),
            event=f"earthquake of {header.text(keys['day'])} {header.text(keys['origin'])} GMT",
            origin=_moments(header, keys)[0],
            latitude=latitude,
            longitude=longitude,
            peak=_peak(header, keys["peaks"], peaks, column),
        )
        for column, axis in enumerate(axes)
    ]


def _list(header: Header, key: str) -> list[str]:
    """Values of the channels that there are."""
    header.at(key)
    values = [part.partition(";")[0].strip() for part in header.text(key).strip("/").split("/")]
    while values and not values[-1]:
        values.pop()
    if not values or not all(values):
        raise header.error(key, f"{header.text(key)!r} where /…/…/…/ belongs; get the file again")
    return values


def _direction(axis: str) -> Direction:
    """Bearings as they read; a vertical axis says nothing that is known about up, a ``+V`` included."""
    return UNKNOWN if "V" in axis.upper() else parse_axis(axis)


def _peak(header: Header, key: str, peaks: list[str], column: int) -> StatedPeak | None:
    if column >= len(peaks):
        return None
    size = abs(header.number(key, peaks[column]))
    return StatedPeak(size * GAL, resolution(peaks[column]) * GAL, line=header.at(key) + 1)


def _place(header: Header, key: str) -> tuple[float, float]:
    """Latitude and longitude, degrees, from the line of a key and the one below it, in either order."""
    at = header.at(key)
    below = "\n".join(header.lines.lines[at : at + 2])
    found = {
        name: re.search(rf"({FLOAT})\s*{name}\S*\s+([{letters}])", below, re.IGNORECASE)
        for name, letters in (("LAT", "NS"), ("LON", "EW"))
    }
    latitude, longitude = found["LAT"], found["LON"]
    if latitude is None or longitude is None:
        raise RecordError(f"{header.lines.file} line {at + 1}: no place like 17.0 LAT. N and 100.0 LONG. W; correct it")
    north = float(latitude[1]) * (1 if latitude[2].upper() == "N" else -1)
    return north, float(longitude[1]) * (1 if longitude[2].upper() == "E" else -1)


def _moments(header: Header, keys: dict[str, str]) -> tuple[datetime, datetime]:
    """Origin time and that of the first sample: its clock on the day of the earthquake, or the next where nearer."""
    day = header.text(keys["day"])
    moments = []
    for key in (keys["origin"], keys["first"]):
        clock = header.text(key)
        whole = f"{day} {clock}" + ("" if "." in clock else ".0")
        moments.append(header.time(key, "%Y/%m/%d %H:%M:%S.%f", whole[:26]))
    origin, start = moments
    return origin, start + timedelta(days=1) if origin - start > LATE else start
