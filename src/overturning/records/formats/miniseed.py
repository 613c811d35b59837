"""MiniSEED with StationXML, through obspy: counts alone are no acceleration."""

from overturning.errors import RecordError
from overturning.records.component import Component
from overturning.records.formats.stationxml import components_of, read_inventory, read_stream
from overturning.records.source import ReadOptions, SourceFile


def detect(source: SourceFile) -> bool:
    """Whether a file begins like MiniSEED: a record number of six digits and a quality letter."""
    head = source.data[:8]
    return len(head) == 8 and head[:6].isdigit() and head[6:7] in b"DRQM" and head[7:8] in b" \x00"


def read(source: SourceFile, options: ReadOptions) -> list[Component]:
    """Read all channels; a RecordError says so where the file is damaged, has gaps, or no StationXML goes with it."""
    if len(source.data) % 128:
        raise RecordError(
            f"{source.name}: {len(source.data)} bytes are no whole number of MiniSEED records; it is cut: get it again"
        )
    stream = read_stream(source, "MSEED")
    inventory = read_inventory(options.metadata)
    if inventory is None:
        raise RecordError(
            f"{source.name}: MiniSEED holds counts without gain or orientation; give the station's StationXML with it"
        )
    return components_of(stream, inventory, source, options.unit)
