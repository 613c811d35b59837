"""Fault traces in the record table: pieces separated by semicolons, each with points separated by commas."""

from typing import TypeAlias

FaultTracePiecesInLatLonDeg: TypeAlias = tuple[tuple[tuple[float, float], ...], ...]
"""Pieces of a fault trace; each is a sequence of points (latitude and longitude, degrees)."""


def parse_fault_trace(fault_trace_text: str) -> FaultTracePiecesInLatLonDeg:
    """Return the pieces of a fault trace from text such as ``40.71 29.34, 40.73 29.52; 40.71 29.61, 40.75 29.88``.

    Raises a ValueError that names an invalid point, a point off the globe, or a piece of one point.
    """
    pieces = []
    for piece in filter(str.strip, fault_trace_text.split(";")):
        points = tuple(_parse_latitude_and_longitude_deg(point) for point in piece.split(","))
        if len(points) < 2:
            raise ValueError(f"{piece.strip()!r} is one point; a piece needs two: '40.71 29.34, 40.73 29.52'")
        pieces.append(points)
    return tuple(pieces)


def _parse_latitude_and_longitude_deg(point_text: str) -> tuple[float, float]:
    """Return the latitude and longitude, degrees, of one point of a fault trace."""
    words = point_text.split()
    try:
        latitude, longitude = map(float, words)
    except ValueError:
        raise ValueError(f"{point_text.strip()!r} is no point; give latitude and longitude: '40.71 29.34'") from None
    # NaN fails both comparisons.
    if not (abs(latitude) <= 90 and abs(longitude) <= 180):
        raise ValueError(f"{point_text.strip()!r} is off the globe; latitude is −90 to 90, longitude −180 to 180")
    return latitude, longitude


def checked_fault_trace_text(fault_trace_text: str) -> str:
    """Return the text of a fault trace unchanged; raise a ValueError if it cannot be parsed."""
    parse_fault_trace(fault_trace_text)
    return fault_trace_text
