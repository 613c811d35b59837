"""Ground motion as the simulation takes it: three accelerations and a sampling interval, nothing else."""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.motion.direction import direction_cosines
from overturning.motion.plausible import implausible


def _component(name: str, values: ArrayLike) -> FloatArray:
    samples = np.array(values, dtype=np.float64)
    if samples.ndim != 1 or samples.size < 2:
        raise ArgumentError(f"{name}: shape {samples.shape}; a component is one row of at least 2 samples")
    if not np.isfinite(samples).all():
        raise ArgumentError(f"{name}: sample {int(np.flatnonzero(~np.isfinite(samples))[0])} is not finite")
    samples.flags.writeable = False
    return samples


class Recorded(Protocol):
    """What a motion is taken from: anything that has its components, as a record does."""

    @property
    def north(self) -> FloatArray: ...  # noqa: D102
    @property
    def east(self) -> FloatArray: ...  # noqa: D102
    @property
    def up(self) -> FloatArray | None: ...  # noqa: D102
    @property
    def sampling_interval(self) -> float: ...  # noqa: D102
    @property
    def trusted(self) -> bool: ...  # noqa: D102


class Motion:
    """Ground acceleration at a point.

    Parameters
    ----------
    north, east : array_like, shape (n,)
        Acceleration towards north and east, m/s².
    up : array_like, shape (n,), optional
        Upward acceleration, m/s².
    sampling_interval : float
        Time between samples, s.
    trust_data : bool
        Take accelerations and velocities of any size.

    Raises
    ------
    ArgumentError
        If a component is empty or not finite, lengths differ, the sampling interval is not positive, or the motion is not
        the size of one: above 5 g or 1000 cm/s, or below 0.0001 g without being rest.
    """

    def __init__(
        self,
        north: ArrayLike,
        east: ArrayLike,
        up: ArrayLike | None = None,
        *,
        sampling_interval: float,
        trust_data: bool = False,
    ) -> None:
        self.north = _component("north", north)
        self.east = _component("east", east)
        self.up = None if up is None else _component("up", up)
        for name, samples in (("east", self.east), ("up", self.up)):
            if samples is not None and samples.size != self.north.size:
                raise ArgumentError(
                    f"{name}: {samples.size} samples, north has {self.north.size}; components must be equally long"
                )
        if not (np.isfinite(sampling_interval) and sampling_interval > 0):
            raise ArgumentError(f"sampling_interval: {sampling_interval}; it must be a positive number of seconds")
        self.sampling_interval = float(sampling_interval)
        components = [self.north, self.east, *([] if self.up is None else [self.up])]
        if not trust_data and (why := implausible(components, self.sampling_interval, unit="m/s2")):
            raise ArgumentError(f"motion: {why}: give m/s², or say trust_data=True")

    @classmethod
    def of(cls, record: Recorded) -> "Motion":
        """The motion of a record."""
        return cls(
            record.north,
            record.east,
            record.up,
            sampling_interval=record.sampling_interval,
            trust_data=record.trusted,
        )

    @property
    def horizontal(self) -> FloatArray:
        """Acceleration towards north and east, m/s², shape (2, n)."""
        return np.stack([self.north, self.east])

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return int(self.north.size)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return (self.samples - 1) * self.sampling_interval

    def along(self, azimuth_deg: float) -> FloatArray:
        """Horizontal acceleration towards an azimuth φ, a_north cos φ + a_east sin φ, m/s², shape (n,)."""
        cosine, sine = direction_cosines(azimuth_deg)
        return self.north * cosine + self.east * sine
