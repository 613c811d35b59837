"""Ground motion for the simulation: two or three components of acceleration and a sampling interval."""

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.arrays import ArrayLike, FloatArray, convert_argument_to_float_array
from overturning.errors import ArgumentError, OverturningError, refuse_unknown_keywords
from overturning.motion.direction import cosine_and_sine_of_azimuth
from overturning.motion.integration import integrate
from overturning.motion.plausible import implausible_amplitude_reason, warnings_of_dead_equal_or_clipped_axes
from overturning.motion.streams import accelerations_interval_and_start_of_stream

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MIN_SAMPLING_INTERVAL_S = 1e-6
"""Shortest time between samples, s; with less, the time after a motion until rest has too many samples."""

MAX_SAMPLES_OF_MOTION = 30_000_000
"""Largest number of samples of a motion from a formula, or of a processed record: 240 MB for each component."""

_MAX_FINAL_TO_PEAK_VELOCITY_WITHOUT_DRIFT = 0.5
"""Final velocity, as a share of its peak, above which the samples probably contain an offset."""


class Accelerogram:
    """Base class of records and motions: acceleration towards north, east and optionally up, m/s², n samples each."""

    north: FloatArray
    east: FloatArray
    up: FloatArray | None
    sampling_interval: float
    user_trusts_data = False  # True: amplitudes are not checked for plausibility
    start: str | None = None  # time of the first sample, ISO 8601 in UTC; None if unknown

    def __repr__(self) -> str:
        parts = "north and east" if self.up is None else "north, east and up"
        return (
            f"<{self._label_in_repr}: {self.sample_count} samples of {self.sampling_interval:g} s, {parts}, "
            f"horizontal peak {np.hypot(*self.horizontal_components).max():.3g} m/s²>"
        )

    @property
    def _label_in_repr(self) -> str:
        return type(self).__name__

    def check_samples_and_sampling_interval(self, error_type: type[OverturningError], message_prefix: str = "") -> None:
        """Check samples and sampling interval; raise an exception of type `error_type` at the first fault."""
        for name, samples in zip(("north", "east", "up"), self.components, strict=False):
            if samples.ndim != 1 or samples.size < 2:
                raise error_type(
                    f"{message_prefix}{name}: shape {samples.shape}; a component is one row of at least 2 samples"
                )
            finite = np.isfinite(np.ma.filled(samples, np.nan))
            if not finite.all():
                first = int(np.flatnonzero(~finite)[0])
                what = "masked, a gap" if np.ma.is_masked(samples) else "not finite"
                raise error_type(
                    f"{message_prefix}{name}: sample {first} is {what}; repair it, or leave the record out"
                )
            if samples.size != self.north.size:
                sizes = f"{samples.size} samples, north has {self.north.size}"
                raise error_type(
                    f"{message_prefix}{name}: {sizes}; components must be equally long: cut all to their common window"
                )
        if not (np.isfinite(self.sampling_interval) and self.sampling_interval > 0):
            interval = self.sampling_interval
            raise error_type(f"{message_prefix}sampling_interval: {interval}; it must be a positive number of seconds")
        if self.sampling_interval < MIN_SAMPLING_INTERVAL_S:
            raise error_type(
                f"{message_prefix}sampling_interval: {self.sampling_interval:g} s; give at least "
                f"{MIN_SAMPLING_INTERVAL_S:g} s, or resample the motion"
            )

    @property
    def components(self) -> list[FloatArray]:
        """Accelerations towards north, east and, if present, up, m/s², each of shape (n,)."""
        return [self.north, self.east, *([] if self.up is None else [self.up])]

    @property
    def horizontal_components(self) -> FloatArray:
        """Acceleration towards north and east, m/s², shape (2, n) for n samples."""
        return np.stack([self.north, self.east])

    @property
    def velocity(self) -> FloatArray:
        """Velocity towards north, east and, if present, up, m/s, shape (2 or 3, n), starting from rest."""
        return integrate(np.stack(self.components), self.sampling_interval)

    @property
    def displacement(self) -> FloatArray:
        """Displacement towards north, east and, if present, up, m, shape (2 or 3, n), starting at 0 from rest."""
        return integrate(self.velocity, self.sampling_interval)

    def acceleration_along(self, azimuth_deg: float) -> FloatArray:
        """Return the acceleration along an azimuth φ, a_north cos φ + a_east sin φ, m/s², shape (n,)."""
        cosine, sine = cosine_and_sine_of_azimuth(azimuth_deg)
        return self.north * cosine + self.east * sine

    if TYPE_CHECKING:

        def plot(self) -> "Figure":
            """Draw acceleration, velocity, displacement and Fourier amplitudes."""

    def to_obspy(self) -> Any:
        """Return an obspy Stream with channels HNN, HNE and, if there is a vertical component, HNZ, in m/s².

        The unit is in ``stats.unit``. The start time is that of the record, or obspy's default (1970) if it is unknown.
        `Motion.from_obspy` is the inverse.
        """
        from obspy import Stream, Trace, UTCDateTime

        about: dict[str, Any] = {"delta": self.sampling_interval, "unit": "m/s2"}
        about |= {"starttime": UTCDateTime(self.start)} if self.start else {}
        channels = zip(("HNN", "HNE", "HNZ"), self.components, strict=False)
        return Stream([Trace(samples.copy(), about | {"channel": name}) for name, samples in channels])

    @property
    def sample_count(self) -> int:
        """Number of samples n of each component."""
        return int(self.north.size)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return (self.sample_count - 1) * self.sampling_interval


@refuse_unknown_keywords()
class Motion(Accelerogram):
    """Ground motion at a point: acceleration towards north, east and optionally up, m/s², at equal intervals.

    Parameters
    ----------
    north, east : array_like, shape (n,)
        Acceleration towards north and east, m/s².
    up : array_like, shape (n,), optional
        Upward acceleration, m/s².
    sampling_interval : float
        Time between samples, s.
    trust_data : bool
        Accept accelerations and velocities of any size.

    Raises
    ------
    ArgumentError
        If a component is empty, not finite or partly masked; if lengths differ; if the sampling interval is not
        positive, or below `MIN_SAMPLING_INTERVAL_S`; or if the peak is implausible: above 5 g or 1000 cm/s, or
        below 0.0001 g but not zero.
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
        # Keep masks until `check_samples_and_sampling_interval` has refused masked samples.
        self.north, self.east = (
            convert_argument_to_float_array(name, of, copy=True) for name, of in (("north", north), ("east", east))
        )
        self.up = None if up is None else convert_argument_to_float_array("up", up, copy=True)
        interval = convert_argument_to_float_array("sampling_interval", sampling_interval)
        if interval.ndim:
            raise ArgumentError(f"sampling_interval: shape {interval.shape}; give one number of seconds")
        if not isinstance(trust_data, bool | np.bool_):
            raise ArgumentError(f"trust_data: {trust_data!r}; give True or False")
        self.sampling_interval, self.user_trusts_data = float(interval), trust_data
        self.check_samples_and_sampling_interval(ArgumentError)
        for samples in self.components:
            samples.flags.writeable = False
        if not trust_data and (
            why := implausible_amplitude_reason(
                self.components, self.sampling_interval, declared_unit_if_file_states_none="m/s2"
            )
        ):
            raise ArgumentError(f"motion: {why}: give m/s², or set trust_data=True")

    @classmethod
    def from_record(cls, record: Accelerogram) -> "Motion":
        """Return the ground motion of a record as a `Motion`; raise an `ArgumentError` for any other object."""
        if not all(hasattr(record, name) for name in ("north", "east", "up", "sampling_interval")):
            raise ArgumentError(f"record: a {type(record).__name__}; give a record from overturning.read")
        motion = cls(
            record.north,
            record.east,
            record.up,
            sampling_interval=record.sampling_interval,
            trust_data=bool(getattr(record, "user_trusts_data", False)),
        )
        motion.start = getattr(record, "start", None)
        return motion

    of = from_record

    def scaled_by(self, factor: float) -> "Motion":
        """Return the motion multiplied by a factor, which may be 0 or negative; its amplitude is not checked.

        Raises an `ArgumentError` if the factor is not a finite number.
        """
        number = convert_argument_to_float_array("factor", factor)
        if number.ndim or not np.isfinite(number):
            raise ArgumentError(f"factor: {str(factor)[:60]}; it must be a finite number")
        times, interval = float(number), self.sampling_interval
        up = None if self.up is None else times * self.up
        scaled = Motion(times * self.north, times * self.east, up, sampling_interval=interval, trust_data=True)
        scaled.start = self.start
        return scaled

    @classmethod
    @refuse_unknown_keywords()
    def from_obspy(cls, stream: Any, *, unit: str | None = None, sensor: str = "surface") -> "Motion":
        """Return the motion of an obspy Stream with three components, or two horizontal ones.

        The direction of a trace comes from its channel code: a SEED code that ends in N, E or Z, or NIED's NS, EW or
        UD. A warning is given if a SAC header states another direction, if an axis is dead or clipped, or if an offset
        makes the velocity drift. Samples are multiplied by ``stats.calib``, which readers of raw counts set to m/s²
        per count. For SAC files, obspy sets ``calib`` to the header field SCALE; there it is ignored.

        Parameters
        ----------
        stream : obspy.Stream
            Accelerations, without gaps.
        unit : str, optional
            Unit of samples times ``calib``, a key of `overturning.units.ACCELERATION_UNITS_IN_M_S2`. By default m/s²;
            a channel with the code of a velocity sensor (HHN, EHZ) must then have had its response removed with
            ``output="ACC"``.
        sensor : {"surface", "borehole"}
            Sensor of the traces: KiK-net's NS1, EW1 and UD1 belong to the borehole sensor.

        Raises
        ------
        ArgumentError
            If north or east is missing or given twice; if a trace has gaps (is masked), is not an acceleration or
            belongs to the other sensor; or if traces differ in station, location, start, length or sampling interval.
        """
        if not hasattr(stream, "traces"):
            kind = type(stream).__name__
            raise ArgumentError(f"stream: a {kind}; give an obspy Stream with a trace for each component")
        values, interval, start = accelerations_interval_and_start_of_stream(stream, unit, sensor)
        motion = cls(**values, sampling_interval=interval)
        motion.start = start
        # Not of every motion: one along a single axis, as of a shaking table, is made on purpose, no sensor's.
        for why in warnings_of_dead_equal_or_clipped_axes(motion.components, ("north", "east", "up")):
            warnings.warn(f"stream: {why}", stacklevel=3)
        for name, speed in zip(("north", "east", "up"), np.abs(motion.velocity), strict=False):
            if speed[-1] > _MAX_FINAL_TO_PEAK_VELOCITY_WITHOUT_DRIFT * speed.max():
                share = f"{100 * speed[-1] / speed.max():.0f} %"
                why = f"stream: the velocity towards {name} ends at {share} of its peak, like raw data with an offset"
                warnings.warn(f"{why}: remove the offset first (stream.detrend, filter)", stacklevel=3)
        return motion

    @classmethod
    @refuse_unknown_keywords()
    def sine(
        cls, amplitude: float, period: float, *, azimuth_deg: float = 0.0, cycles: float = 1.0, rest: float = 1.0,
        sampling_interval: float = 0.005, trust_data: bool = False,
    ) -> "Motion":  # fmt: skip
        """Return a motion of sine waves A sin(2πt/T) towards an azimuth, with rest before and after the waves.

        The amplitude is in m/s²; period, rest and sampling interval are in s. Raises an `ArgumentError` if a number is
        not positive (the rest may be 0), if a period or all waves together have fewer than four samples, if there are
        more than `MAX_SAMPLES_OF_MOTION`, or, unless `trust_data` is set, if the amplitude is implausible.
        """
        given = {"amplitude": amplitude, "period": period, "cycles": cycles, "sampling_interval": sampling_interval}
        for name, value in (given | {"rest": rest}).items():
            number = convert_argument_to_float_array(name, value)
            if number.ndim or not np.isfinite(number) or number < 0 or (number == 0 and name != "rest"):
                bound = "a number of seconds, at least 0" if name == "rest" else "a positive number"
                raise ArgumentError(f"{name}: {value}; it must be {bound}")
        amplitude, period, cycles, sampling_interval = (float(value) for value in given.values())
        rest = float(rest)
        length = cycles * period
        for what, value in ((f"period: {period:g} s", period), (f"cycles: {cycles:g}, {length:g} s", length)):
            if value < 4.0 * sampling_interval:
                raise ArgumentError(
                    f"{what} in samples of {sampling_interval:g} s; it needs at least four of them: "
                    f"sampling_interval at most {value / 4.0:g}"
                )
        count = (2 * rest + length) / sampling_interval + 1
        if count > MAX_SAMPLES_OF_MOTION:
            raise ArgumentError(
                f"period, cycles, rest: {count:.3g} samples; at most {MAX_SAMPLES_OF_MOTION:.0e}: give a longer "
                "sampling_interval, or a shorter motion"
            )
        time = sampling_interval * np.arange(round(count)) - rest
        # Include a sample that misses the end of the waves by rounding only.
        inside = (time >= 0) & (time <= length + 1e-9 * sampling_interval)
        wave = np.where(inside, amplitude * np.sin(2 * np.pi * time / period), 0.0)
        cosine, sine = cosine_and_sine_of_azimuth(azimuth_deg)
        return cls(wave * cosine, wave * sine, sampling_interval=sampling_interval, trust_data=trust_data)


def as_motion(motion_or_record: Any) -> Motion:
    """Return a `Motion` unchanged, or a record as a `Motion`; raise an `ArgumentError` for anything else."""
    if isinstance(motion_or_record, Motion):
        return motion_or_record
    if all(hasattr(motion_or_record, name) for name in ("north", "east", "up", "sampling_interval")):
        return Motion.of(motion_or_record)
    kind = type(motion_or_record).__name__
    if hasattr(motion_or_record, "traces") or kind == "Trace":
        raise ArgumentError(f"motion: an obspy {kind}; convert it with Motion.from_obspy(stream), in m/s² and N, E, Z")
    raise ArgumentError(
        f"motion: a {kind}; give a Motion(north, east, sampling_interval=…), or a record from overturning.read"
    )
