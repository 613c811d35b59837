"""SAC, through obspy: one component per file; unit from StationXML or declared, for the header leaves it open."""

import io
import struct
from datetime import UTC
from typing import Any, Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.component import Component, StatedPeak
from overturning.records.formats.stationxml import components_of, read_inventory
from overturning.records.options import UNITS, ReadOptions
from overturning.records.source import SourceFile

NAME: Final = "sac"
UNDEFINED: Final = -12345.0


def detect(source: SourceFile) -> bool:
    """Whether a file has SAC's header version, 6 or 7, in word 76, either byte order, and a length that fits."""
    if len(source.data) < 632:
        return False
    for order in "<>":
        version, npts = (
            struct.unpack(f"{order}i", source.data[304:308])[0],
            struct.unpack(f"{order}i", source.data[316:320])[0],
        )
        if version in (6, 7) and 0 <= npts < 2**28:
            return True
    return False


def read(source: SourceFile, options: ReadOptions) -> list[Component]:
    """Read one component.

    Raises
    ------
    RecordError
        If it is damaged, or neither StationXML nor a declared unit says what its numbers are.
    """
    import obspy

    # obspy divides by the interval before anybody can look at it.
    intervals = [struct.unpack(f"{order}f", source.data[:4])[0] for order in "<>"]
    if not any(1e-6 < interval < 1e3 for interval in intervals):
        raise RecordError(f"{source.name}: sampling interval {intervals[0]:g} s in the header; get the file again")
    try:
        stream = obspy.read(io.BytesIO(source.data), format="SAC", checksize=True)
    except Exception as problem:  # struct, obspy and numpy each raise their own
        raise RecordError(f"{source.name}: damaged SAC ({problem}); get it again") from problem
    inventory = read_inventory(options.metadata)
    if inventory is not None:
        return components_of(stream, inventory, source, NAME)
    if options.unit is None:
        raise RecordError(
            f"{source.name}: SAC does not say its unit; declare it (unit in the record table, --unit here: {', '.join(UNITS)}) "
            "or give StationXML"
        )
    return [_component(stream[0], source, UNITS[options.unit])]


def _component(trace: Any, source: SourceFile, scale: float) -> Component:
    header = trace.stats.sac

    def known(key: str) -> float | None:
        value = header.get(key)
        return None if value is None or value == UNDEFINED else float(value)

    azimuth, vertical = _orientation(known("cmpaz"), known("cmpinc"))
    peaks = [abs(v) for key in ("depmin", "depmax") if (v := known(key)) is not None and np.isfinite(v)]
    moment = trace.stats.starttime
    return Component(
        samples=np.asarray(trace.data, dtype=np.float64) * scale,
        sampling_interval=round(float(trace.stats.delta), 9),
        axis=trace.stats.channel or "unnamed",
        azimuth_deg=azimuth,
        vertical=vertical,
        file=source.name,
        sha256=source.sha256,
        format=NAME,
        start=moment.datetime.replace(tzinfo=UTC) if moment.timestamp > 0 else None,
        station=trace.stats.station,
        event=str(header.get("kevnm", "")).strip(),
        latitude=known("stla"),
        longitude=known("stlo"),
        peak=StatedPeak(max(peaks) * scale, 2e-7 * max(peaks) * scale) if peaks else None,
        extra={"network": trace.stats.network},
    )


def _orientation(azimuth: float | None, inclination: float | None) -> tuple[float | None, int]:
    """SAC's CMPINC is the angle from up: 0 up, 90 horizontal, 180 down."""
    if inclination is not None and inclination in (0.0, 180.0):
        return None, 1 if inclination == 0.0 else -1
    if azimuth is None or inclination != 90.0:
        return None, 0
    return azimuth % 360.0, 0
