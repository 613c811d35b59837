"""The one form in which every ground-motion record enters the project."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError


@dataclass(frozen=True)
class Record:
    """A strong-motion record turned to north, east and up."""

    record_id: str  # its name in the record table
    north: FloatArray  # ground acceleration towards true north, m/s², shape (n,)
    east: FloatArray
    up: FloatArray | None  # None where the record has none
    sampling_interval: float  # s
    start: str | None = None  # time of the first sample, ISO 8601 in UTC, where the file states it
    station: str = ""  # as the record table or the file names it
    event: str = ""
    source: str = ""  # where the data came from, without a path of this machine
    sha256: str = ""  # of the file (or of the samples, where a file holds many records)
    licence: str = ""  # terms under which the data may be used
    fault_strike_deg: float | None = None  # clockwise from north; the fault normal is strike + 90°
    component_azimuths_deg: tuple[float, ...] = ()  # of the two recorded axes, after corrections
    latitude: float | None = None  # of the station, degrees
    longitude: float | None = None
    processing: tuple[dict[str, Any], ...] = ()  # the steps applied, in order, with parameters and effect
    extra: dict[str, Any] = field(default_factory=dict)  # what else is known (magnitude, epicentre, header peaks)

    def __post_init__(self) -> None:
        components = {"north": self.north, "east": self.east} | ({} if self.up is None else {"up": self.up})
        for name, samples in components.items():
            if samples.ndim != 1 or samples.dtype != np.float64:
                raise TypeError(f"{name} must be a one-dimensional float64 array")
            if samples.size != self.north.size:
                raise RecordError(
                    f"record {self.record_id}: component {name} has {samples.size} samples, north has {self.north.size}; "
                    "cut both to their common window"
                )
            if not np.isfinite(samples).all():
                first = int(np.flatnonzero(~np.isfinite(samples))[0])
                raise RecordError(
                    f"record {self.record_id}: component {name} is not a number at sample {first}; repair or leave out the record"
                )
        if self.north.size < 2:
            raise RecordError(f"record {self.record_id}: {self.north.size} samples; a record needs at least 2")
        if not (np.isfinite(self.sampling_interval) and self.sampling_interval > 0):
            raise RecordError(
                f"record {self.record_id}: sampling interval {self.sampling_interval} s; it must be positive"
            )

    def with_each(self, change: Callable[[FloatArray], FloatArray], **more: Any) -> "Record":
        """The record with each component changed in the same way, and other fields as given."""
        up = None if self.up is None else change(self.up)
        return replace(self, north=change(self.north), east=change(self.east), up=up, **more)

    @property
    def trusted(self) -> bool:
        """Whether the user has said to go on where the data contradicts its header or is not the size of a ground motion."""
        return bool(self.extra.get("trusted_data", False))

    @property
    def components(self) -> list[FloatArray]:
        """North, east and, where there is one, up, m/s²."""
        return [self.north, self.east, *([] if self.up is None else [self.up])]

    @property
    def horizontal(self) -> FloatArray:
        """Acceleration towards north and east, m/s², shape (2, n)."""
        return np.stack([self.north, self.east])

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return (self.north.size - 1) * self.sampling_interval
