"""Record: a ground motion with its metadata and processing, and texts that describe them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.motion.integration import integrate
from overturning.motion.motion import Accelerogram


@dataclass(frozen=True, repr=False, eq=False)
class Record(Accelerogram):
    """Strong-motion record: acceleration towards north, east and (optionally) up, with metadata.

    Parameters
    ----------
    record_id : str
        Name in the record table.
    north, east : ndarray, shape (n,)
        Ground acceleration towards true north and east, m/s².
    up : ndarray, shape (n,), or None
        Upward ground acceleration, m/s²; None for a record without vertical component.
    sampling_interval : float
        Time between samples, s.
    start : str, optional
        Time of the first sample, ISO 8601 in UTC, if the file states it.
    station, event : str
        Names from the record table or the file.
    source : str
        Source of the data, without folders of the local machine.
    sha256 : str
        SHA-256 of the file; of the samples, if a file holds many records.
    licence : str
        Terms under which the data may be used.
    fault_strike_deg : float, optional
        Strike of the fault, degrees clockwise from north; the fault normal is strike + 90°.
    component_azimuths_deg : tuple of float
        Azimuths of the two recorded axes after corrections, degrees clockwise from north.
    latitude, longitude : float, optional
        Place of the station, degrees.
    processing : tuple of dict
        Processing steps in order, with parameters and effect.
    extra : dict
        Other metadata: magnitude, epicentre, header peaks.
    """

    record_id: str
    north: FloatArray
    east: FloatArray
    up: FloatArray | None
    sampling_interval: float
    start: str | None = None
    station: str = ""
    event: str = ""
    source: str = ""
    sha256: str = ""
    licence: str = ""
    fault_strike_deg: float | None = None
    component_azimuths_deg: tuple[float, ...] = ()
    latitude: float | None = None
    longitude: float | None = None
    processing: tuple[dict[str, Any], ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, samples in zip(("north", "east", "up"), self.components, strict=False):
            if not isinstance(samples, np.ndarray) or samples.dtype != np.float64:
                what = f"{type(samples).__name__} of {np.asarray(samples).dtype} numbers"
                raise RecordError(f"record {self.record_id}: {name}: {what}; give an array of float64")
        self.check_samples_and_sampling_interval(RecordError, f"record {self.record_id}: ")

    def with_changed_components(
        self, change_component: Callable[[FloatArray], FloatArray], **replaced_fields: Any
    ) -> "Record":
        """Return a copy of the record with a function applied to each component, and with some fields replaced."""
        up = None if self.up is None else change_component(self.up)
        return replace(
            self, north=change_component(self.north), east=change_component(self.east), up=up, **replaced_fields
        )

    @property
    def _label_in_repr(self) -> str:
        """Id, station and earthquake of the record, for its printed representation."""
        place = ", ".join(text for text in (self.station, self.event) if text)
        return f"Record {self.record_id}" + (f" ({place})" if place else "")

    @property
    def notes(self) -> list[str]:
        """Notes on reading the record, such as omitted files, resampling or doubtful samples."""
        return list(self.extra.get("notes") or ())

    @property
    def user_trusts_data(self) -> bool:  # type: ignore[override]
        """True if the user accepts contradictions between samples and header, and implausible amplitudes."""
        return bool(self.extra.get("trusted_data", False))


def as_record(motion: Accelerogram, record_id: str = "motion") -> Record:
    """Convert a ground motion to a record with the given id; a motion that already is a record is unchanged."""
    if isinstance(motion, Record):
        return motion
    extra = {"processed": True, "given": True, "trusted_data": motion.user_trusts_data}
    return Record(record_id, motion.north, motion.east, motion.up, motion.sampling_interval, extra=extra)


def largest_pga_pgv_pgd_of_components(
    acceleration_of_horizontal_components: FloatArray, sampling_interval: float
) -> dict[str, float]:
    """Return PGA (m/s²), PGV (m/s) and PGD (m), each from the horizontal component with the larger peak.

    The last axis of the accelerations, m/s², is time; the sampling interval is in s. Velocity and displacement start
    from zero. The values have nine digits; their keys are ``pga``, ``pgv`` and ``pgd``.
    """
    velocity = integrate(acceleration_of_horizontal_components, sampling_interval)
    series = {
        "pga": acceleration_of_horizontal_components,
        "pgv": velocity,
        "pgd": integrate(velocity, sampling_interval),
    }
    # Nine digits suffice for a report and are the same on every processor.
    return {name: float(f"{np.abs(samples).max():.9g}") for name, samples in series.items()}


def processing_entry_text(entry: Mapping[str, Any]) -> str:
    """Return a short text on a processing step of a record, such as ``high-pass 0.1 Hz, order 2``."""
    match entry["step"]:
        case "common_window":
            # An axis such as "chan 1: 90" has a colon of its own.
            names = {axis: axis.replace(": ", " (") + ")" * (": " in axis) for axis in entry["samples"]}
            sizes = ", ".join(f"{names[axis]} = {count}" for axis, count in entry["samples"].items())
            return f"cut to the common {entry['kept']} samples ({sizes}), {entry['left_out_s']:g} s left out"
        case "highpass" | "lowpass" as kind:
            reason = f" ({entry['chosen']})" if "chosen" in entry else ""
            return f"{kind.replace('pass', '-pass')} {entry['corner_hz']:g} Hz, order {entry['order']}{reason}"
        case "remove_mean":
            return "mean removed" if entry["first_s"] is None else f"mean of the first {entry['first_s']:g} s removed"
        case "detrend":
            return f"polynomial of order {entry['order']} removed"
        case "taper":
            return f"taper {entry['length_s']:g} s"
        case "baseline":
            reason = f" ({entry['chosen']})" if "chosen" in entry else ""
            return f"baseline {entry['scheme']}, fit from {entry['fit_from_s']:g} s{reason}"
        case "resample":
            return f"resampled to {entry['sampling_interval_s']:g} s"
        case "cut":
            return f"cut from {entry['start_s']:g} s" + ("" if entry["end_s"] is None else f" to {entry['end_s']:g} s")
        case "site":
            layers = ", ".join(f"{one['thickness_m']:g} m of {one['velocity_m_s']:g} m/s" for one in entry["layers"])
            found = f" ({entry['chosen']})" if "chosen" in entry else ""
            return f"through {layers} over {entry['rock']['velocity_m_s']:g} m/s, record {entry['motion']}{found}"
        case "scale":
            return f"times {entry['factor']:g}"
        case other:
            return str(other)


def processing_state_label(record: Record) -> str:
    """Return a text on the processing of a record: "raw", "processed by AGENCY", "synthetic", "as given" etc."""
    if record.extra.get("given"):
        return "as given"
    if record.extra.get("format") == "synthetic":
        return "synthetic"
    if not record.extra.get("processed"):
        return "raw" + (", response of a velocity sensor removed" if record.extra.get("removed") == "response" else "")
    by = record.extra.get("processed_by")
    if by:
        return f"processed by {by}"
    return "processed, as declared" if "processed" in record.extra.get("declared", ()) else "processed"


def start_offset_from_file_start_s(record: Record) -> float:
    """Return the start time of a record relative to the first sample in its file, s; negative after padding."""
    return float(sum(step.get("shift_s", 0.0) for step in record.processing))


MAX_FINAL_TO_PEAK_VELOCITY_RATIO: Final = 0.02
"""Largest final velocity of a component without drift, as a share of its peak."""


def displacement_drift_evidence(record: Record) -> str:
    """Describe signs that the displacement of a record drifts, so that its PGD is wrong; "" without signs.

    A component drifts if its velocity ends at more than `MAX_FINAL_TO_PEAK_VELOCITY_RATIO` of its peak, or if its
    displacement is largest at the last sample. Synthetic pulses are exempt.
    """
    if record.extra.get("format") == "synthetic":
        return ""
    said = []
    for name, samples in (("north", record.north), ("east", record.east)):
        velocity = integrate(samples, record.sampling_interval)
        speed, way = np.abs(velocity), np.abs(integrate(velocity, record.sampling_interval))
        if speed[-1] > MAX_FINAL_TO_PEAK_VELOCITY_RATIO * speed.max():
            said.append(f"velocity of {name} ends at {100 * speed[-1] / speed.max():.0f} % of its peak")
        if way[-1] == way.max() > 0:
            said.append(f"displacement of {name} is largest at the last sample")
    return "; ".join(said)


def processing_peaks_and_notes_of_record(record: Record) -> dict[str, Any]:
    """Return processing, peaks and notes of a record as a dictionary, which the results of a study store.

    Keys: ``data`` (raw or processed, and by which agency), ``agency`` (the agency's processing), ``steps`` (entries of
    `process_record`), ``peaks`` (largest PGA, PGV and PGD of north and east before and after, SI), ``drift`` (see
    `displacement_drift_evidence`), ``start``, ``duration_s`` (after processing), ``declared`` (properties that
    the user states), ``trusted`` (contradictions that the user accepts), and ``notes`` if there are any.
    """
    effects = [step["effect"] for step in record.processing]
    now = largest_pga_pgv_pgd_of_components(record.horizontal_components, record.sampling_interval)
    return {
        "data": processing_state_label(record),
        "agency": record.extra.get("agency_processing", ""),
        "steps": list(record.processing),
        "peaks": {name: [effects[0][name][0] if effects else peak, peak] for name, peak in now.items()},
        "drift": displacement_drift_evidence(record),
        "start": record.start or "",
        "duration_s": round(record.duration, 6),
        "declared": list(record.extra.get("declared") or ()),
        "trusted": list(record.extra.get("trusted") or ()),
    } | ({"notes": record.notes} if record.notes else {})
