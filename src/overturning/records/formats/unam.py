"""UNAM's ASA 2.0 (Archivo Estándar de Aceleración, Mexico): up to six channels in one file, Gal.

The format: lines ``KEY : text``; lists have a slash before each value of the channels C1 to C6. After the line ``DATOS
DE ACELERACION`` and a heading, each line holds one sample of every channel. Axes are bearings, or ``V``, ``+V`` and
``-V`` of unknown sense. The time of the first sample has no date: it is within half a day of the origin time.
"""

import re
from datetime import datetime, timedelta
from typing import Final

from overturning.records.axis_direction import UNKNOWN_DIRECTION, parse_axis_direction
from overturning.records.component import RecordComponent
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields, signed_coordinate_from_hemisphere
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.records.source import SourceFile
from overturning.units import GAL

HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "CLAVE DE LA ESTACION": r"^\s*CLAVE DE LA ESTACION\s*:(.*)",
    "COORDENADAS DE LA ESTACION": r"^\s*COORDENADAS DE LA ESTACION\s*:(.*)",
    "ORIENTACION": r"^\s*ORIENTACION C1-C6[^:]*:(.*)",
    "INTERVALO DE MUESTREO": r"^\s*INTERVALO DE MUESTREO, C1-C6[^:]*:(.*)",
    "NUM. TOTAL DE MUESTRAS": r"^\s*NUM\. TOTAL DE MUESTRAS, C1-C6[^:]*:(.*)",
    "DURACION DEL REGISTRO": r"^\s*DURACION DEL REGISTRO[^:]*:(.*)",
    "ACEL. MAX.": r"^\s*ACEL\. MAX\.\(GAL\), C1-C6[^:]*:(.*)",
    "UNIDADES DE LOS DATOS": r"^\s*UNIDADES DE LOS DATOS[^:]*:(.*)",
    "FECHA DEL SISMO": r"^\s*FECHA DEL SISMO[^:]*:(.*)",
    "HORA EPICENTRO": r"^\s*HORA EPICENTRO[^:]*:(.*)",
    "HORA DE LA PRIMERA MUESTRA": r"^\s*HORA DE LA PRIMERA MUESTRA[^:]*:(.*)",
    "DATOS DE ACELERACION": r"(DATOS DE ACELERACION)",
}
DAY: Final = timedelta(days=1)


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the components of a UNAM file (Mexico); a RecordError names the line of an error."""
    header, lines = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS), source_file.lines
    heading = header.line_index_of_field("DATOS DE ACELERACION") + 1
    found = (i for i, line in enumerate(lines[: heading + 10]) if re.match(rf"\s*{FLOAT_PATTERN}(\s|$)", line))
    first = next((i for i in found if i >= heading), None)
    if first is None:
        raise header.line_error(len(lines) - 1, "no samples after DATOS DE ACELERACION; the file is cut: get it again")
    if header.field_text("UNIDADES DE LOS DATOS"):
        header.check_field_pattern("UNIDADES DE LOS DATOS", r"gal|cm/s(eg)?(/s|\^?2|\*\*2)", "Gal")
    axes, intervals, counts = (
        _field_values_per_channel(header, n) for n in ("ORIENTACION", "INTERVALO DE MUESTREO", "NUM. TOTAL DE MUESTRAS")
    )
    if not len(axes) == len(intervals) == len(counts):
        why = f"{len(axes)} axes, {len(intervals)} intervals, {len(counts)} counts; get the file again"
        raise header.line_error("ORIENTACION", why)
    values = header.read_number_rows(first, len(axes))
    stated = [header.cut_to_stated_sample_count_with_notes("NUM. TOTAL DE MUESTRAS", values, count) for count in counts]
    lengths = (
        _field_values_per_channel(header, "DURACION DEL REGISTRO") if header.field_text("DURACION DEL REGISTRO") else []
    )
    for count, interval, length in zip(counts, intervals, lengths, strict=False):
        samples, step = (
            header.number_in_field("NUM. TOTAL DE MUESTRAS", count),
            header.number_in_field("INTERVALO DE MUESTREO", interval),
        )
        header.check_stated_duration("DURACION DEL REGISTRO", int(samples), step, length)
    peaks = _field_values_per_channel(header, "ACEL. MAX.") if header.field_pattern_match("ACEL. MAX.") else []
    origin, start = _origin_and_start_times_utc(header)
    return [
        header.create_component(
            axis,
            # The sense of a vertical axis is unknown, even of +V.
            UNKNOWN_DIRECTION if "V" in axis.upper() else parse_axis_direction(axis),
            stated[column][0][:, column] * GAL,
            header.number_in_field("INTERVALO DE MUESTREO", intervals[column]),
            start_time_utc=start,
            station=header.field_text("CLAVE DE LA ESTACION"),
            event=f"earthquake of {header.field_text('FECHA DEL SISMO')} {header.field_text('HORA EPICENTRO')} GMT",
            origin_time_utc=origin,
            station_latitude_longitude_deg=_station_latitude_and_longitude_deg(header),
            header_peak=header.field_peak_acceleration(
                "ACEL. MAX.", GAL, peaks[column], format_states_sign_of_peak=True
            )
            if column < len(peaks)
            else None,
            notes=stated[column][1],
        )
        for column, axis in enumerate(axes)
    ]


def _field_values_per_channel(header: HeaderFields, field_name: str) -> list[str]:
    """Split a header field that has one value per channel, separated by ``/``."""
    header.line_index_of_field(field_name)
    values = [part.partition(";")[0].strip() for part in header.field_text(field_name).strip("/").split("/")]
    while values and not values[-1]:
        values.pop()
    if not values or not all(values):
        raise header.line_error(
            field_name, f"{header.field_text(field_name)!r} where /…/…/…/ belongs; get the file again"
        )
    return values


def _station_latitude_and_longitude_deg(header: HeaderFields) -> tuple[float, float]:
    """Return the station's latitude and longitude, degrees, which the header states in either order."""
    at = header.line_index_of_field("COORDENADAS DE LA ESTACION")
    below = " ".join(header.lines[at : at + 2])
    latitude, longitude = (
        re.search(rf"({FLOAT_PATTERN})\s*{name}\S*\s+([{letters}])", below, re.IGNORECASE)
        for name, letters in (("LAT", "NS"), ("LON", "EWO"))
    )
    if latitude is None or longitude is None:
        raise header.line_error(at, "no place like 17.0 LAT. N and 100.0 LONG. W; correct it")
    north, east = (signed_coordinate_from_hemisphere(float(f[1]), f[2]) for f in (latitude, longitude))
    return north, east


def _origin_and_start_times_utc(header: HeaderFields) -> tuple[datetime, datetime]:
    """Return the UTC times of origin and first sample; the latter's day, not stated, is the nearest to the origin."""
    day = header.field_text("FECHA DEL SISMO")
    origin, start = (
        header.field_utc_time(
            name, "%Y/%m/%d %H:%M:%S.%f", "%Y/%m/%d %H:%M:%S", override_text=f"{day} {header.field_text(name)}"[:26]
        )
        for name in ("HORA EPICENTRO", "HORA DE LA PRIMERA MUESTRA")
    )
    return origin, start + round((origin - start) / DAY) * DAY
