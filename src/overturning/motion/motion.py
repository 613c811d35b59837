"""Ground motion as the simulation takes it: three accelerations and a sampling interval, nothing else."""

import re
import warnings
from importlib import import_module
from typing import Any

import numpy as np

from overturning.arrays import ArrayLike, FloatArray
from overturning.errors import ArgumentError, OverturningError, keywords
from overturning.motion.direction import direction_cosines
from overturning.motion.integration import integrate
from overturning.motion.plausible import implausible
from overturning.units import UNITS


def _no_acceleration(trace: Any, code: str, unit: str | None) -> str:
    """Why the samples of an obspy Trace are no acceleration without gaps, and what to do; empty where they are one."""
    if np.ma.is_masked(trace.data):
        return (
            f"a gap of {int(np.ma.getmaskarray(trace.data).sum())} masked samples; cut the stream to one side of it "
            "(stream.split, stream.trim)"
        )
    if unit is not None:
        return ""
    if np.issubdtype(trace.data.dtype, np.integer) and float(trace.stats.calib) == 1.0:
        return "counts, as whole numbers are; remove the response with output='ACC', or say their unit"
    steps = " ".join(trace.stats.get("processing", ()))
    done = re.findall(r"remove_response\([^()]*?output='?(\w+)|\b(integrate|differentiate)\(", steps)
    removed = [output for output, _ in done if output]
    # SEED's instrument codes: H and L seismometers of high and low gain, P geophones; N and G accelerometers.
    why = "a velocity sensor by its code" if len(code) == 3 and code[1] in "HLP" and code[2] in "NEZ" else ""
    integrals = 0  # that lead to it from acceleration
    for output, step in done:
        integrals = _INTEGRALS.get(output, 1) if output else integrals + (1 if step == "integrate" else -1)
    if removed or integrals:
        last = (
            f"its response was removed to {removed[-1]}" if removed and not done[-1][1] else f"{done[-1][1]}d by obspy"
        )
        why = last if integrals else ""
    return f"{why}; remove the response with output='ACC', or say unit='m/s2' if these are accelerations" if why else ""


_INTEGRALS = {"ACC": 0, "VEL": 1, "DISP": 2}
"""Of the outputs of obspy's `remove_response`, how often acceleration is integrated to them."""

_CHANNEL = re.compile(r"(?:[A-Z]{2})?([NEZ])|(NS|EW|UD)[12]?")
"""SEED codes, with or without band and instrument, and NIED's; other names that end alike are of other directions."""

_TOWARDS = {"N": "north", "NS": "north", "E": "east", "EW": "east", "Z": "up", "UD": "up"}


def _direction_of(trace: Any, code: str) -> str | None:
    """North, east or up by the code of a channel; None where it says none of them.

    A warning where the direction in a SAC header (CMPAZ, CMPINC), which obspy carries along, is more than 5° from it.
    """
    found = _CHANNEL.fullmatch(code)
    if found is None:
        return None
    name = _TOWARDS[found[1] or found[2]]
    azimuth, inclination = (trace.stats.get("sac", {}).get(key, _UNDEFINED) for key in ("cmpaz", "cmpinc"))
    if _UNDEFINED not in (azimuth, inclination):
        tilt, turn = np.radians(inclination), np.radians(azimuth)
        along = {"north": np.sin(tilt) * np.cos(turn), "east": np.sin(tilt) * np.sin(turn), "up": np.cos(tilt)}[name]
        if along < np.cos(np.radians(5.0)):
            where = f"azimuth {azimuth:g}°, {inclination:g}° from up, by its SAC header"
            more = "overturning.read takes SAC files as their headers say"
            warnings.warn(
                f"stream: channel {trace.id} is taken towards {name} by its code; {where}: {more}", stacklevel=4
            )
    return name


_DRIFTING = 0.5
"""Share of its peak at which the velocity of a motion does not end unless an offset is in its samples."""

_UNDEFINED = -12345.0
"""SAC's word for what is not known."""


def _other_sensor(code: str, sensor: str) -> str:
    """Why a channel is not of the sensor that is wanted, and what to do; empty where it is."""
    if sensor not in ("surface", "borehole"):
        return f"sensor {sensor!r}; known are surface and borehole"
    found = {"1": "borehole", "2": "surface"}.get(code[2:]) if code[:2] in ("NS", "EW", "UD") else None
    return (
        f"of the {found} sensor; select the {sensor} one, or say sensor={found!r}"
        if found not in (None, sensor)
        else ""
    )


class Recorded:
    """What a record and a motion have: acceleration towards north, east and, where known, up, m/s², shape (n,)."""

    north: FloatArray
    east: FloatArray
    up: FloatArray | None
    sampling_interval: float
    trusted = False  # whether the size of the motion is taken as it is
    start: str | None = None  # time of the first sample, ISO 8601 in UTC, where it is known

    def __repr__(self) -> str:
        parts = "north and east" if self.up is None else "north, east and up"
        return (
            f"<{self._named}: {self.samples} samples of {self.sampling_interval:g} s, {parts}, "
            f"horizontal peak {np.hypot(*self.horizontal).max():.3g} m/s²>"
        )

    @property
    def _named(self) -> str:
        return type(self).__name__

    def check(self, error: type[OverturningError], of: str = "") -> None:
        """Refuse components that are empty, unlike long, not finite or masked, and an interval that is not positive."""
        for name, samples in zip(("north", "east", "up"), self.components, strict=False):
            if samples.ndim != 1 or samples.size < 2:
                raise error(f"{of}{name}: shape {samples.shape}; a component is one row of at least 2 samples")
            finite = np.isfinite(np.ma.filled(samples, np.nan))
            if not finite.all():
                first = int(np.flatnonzero(~finite)[0])
                what = "masked, a gap" if np.ma.is_masked(samples) else "not finite"
                raise error(f"{of}{name}: sample {first} is {what}; repair it, or leave the record out")
            if samples.size != self.north.size:
                sizes = f"{samples.size} samples, north has {self.north.size}"
                raise error(f"{of}{name}: {sizes}; components must be equally long: cut all to their common window")
        if not (np.isfinite(self.sampling_interval) and self.sampling_interval > 0):
            interval = self.sampling_interval
            raise error(f"{of}sampling_interval: {interval}; it must be a positive number of seconds")

    @property
    def components(self) -> list[FloatArray]:
        """North, east and, where there is one, up, m/s²."""
        return [self.north, self.east, *([] if self.up is None else [self.up])]

    @property
    def horizontal(self) -> FloatArray:
        """Acceleration towards north and east, m/s², shape (2, n)."""
        return np.stack([self.north, self.east])

    @property
    def velocity(self) -> FloatArray:
        """Velocity towards north, east and, where there is one, up, m/s, shape (2 or 3, n), from rest."""
        return integrate(np.stack(self.components), self.sampling_interval)

    @property
    def displacement(self) -> FloatArray:
        """Displacement towards north, east and, where there is one, up, m, shape (2 or 3, n), from rest at 0."""
        return integrate(self.velocity, self.sampling_interval)

    def along(self, azimuth_deg: float) -> FloatArray:
        """Horizontal acceleration towards an azimuth φ, a_north cos φ + a_east sin φ, m/s², shape (n,)."""
        cosine, sine = direction_cosines(azimuth_deg)
        return self.north * cosine + self.east * sine

    def plot(self) -> Any:
        """Figure of acceleration, velocity, displacement and Fourier amplitudes; as `overturning.plot.history`."""
        # What draws lies above what moves, and is found by its name when it is asked for.
        return import_module("overturning.plot").history(self)

    def to_obspy(self) -> Any:
        """An obspy Stream of channels HNN, HNE and, where there is one, HNZ, in m/s² (``stats.unit``).

        It begins at the record's start, or, where that is not known, at obspy's: 1970. `Motion.from_obspy` makes a
        motion of it again.
        """
        from obspy import Stream, Trace, UTCDateTime

        about: dict[str, Any] = {"delta": self.sampling_interval, "unit": "m/s2"}
        about |= {"starttime": UTCDateTime(self.start)} if self.start else {}
        channels = zip(("HNN", "HNE", "HNZ"), self.components, strict=False)
        return Stream([Trace(samples.copy(), about | {"channel": name}) for name, samples in channels])

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return int(self.north.size)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return (self.samples - 1) * self.sampling_interval


@keywords()
class Motion(Recorded):
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
        If a component is empty, not finite or masked in part, lengths differ, the sampling interval is not positive, or
        the motion is not the size of one: above 5 g or 1000 cm/s, or below 0.0001 g without being rest.
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
        # Masked arrays keep their masks until they are looked at.
        self.north, self.east = (np.array(of, dtype=np.float64, subok=np.ma.is_masked(of)) for of in (north, east))
        self.up = None if up is None else np.array(up, dtype=np.float64, subok=np.ma.is_masked(up))
        self.sampling_interval, self.trusted = float(sampling_interval), trust_data
        self.check(ArgumentError)
        for samples in self.components:
            samples.flags.writeable = False
        if not trust_data and (why := implausible(self.components, self.sampling_interval, unit="m/s2")):
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

    from_record = of

    def times(self, factor: float) -> "Motion":
        """The motion with every sample multiplied by a factor, of any size."""
        up = None if self.up is None else factor * self.up
        interval = self.sampling_interval
        return Motion(factor * self.north, factor * self.east, up, sampling_interval=interval, trust_data=True)

    @classmethod
    @keywords()
    def from_obspy(cls, stream: Any, *, unit: str | None = None, sensor: str = "surface") -> "Motion":
        """The motion of an obspy Stream of three components, or two horizontal ones.

        Traces are told apart by their channels' codes: SEED's that end in N, E, Z, or NS, EW, UD; a SAC header that
        gives another direction is warned of, and so is an offset that drives the velocity. Samples are multiplied by
        ``stats.calib``, where readers of counts leave the m/s² per count.

        Parameters
        ----------
        stream : obspy.Stream
            Accelerations, without gaps.
        unit : str, optional
            That of samples times ``calib``, a key of `overturning.units.UNITS`; not given: m/s², and then a channel
            whose code is that of a velocity sensor (HHN, EHZ) must have had its response removed with ``output="ACC"``.
        sensor : {"surface", "borehole"}
            Which sensor the traces are of: KiK-net's NS1, EW1 and UD1 are of the borehole.

        Raises
        ------
        ArgumentError
            If north or east is missing or doubled, a trace has gaps (is masked), is a velocity, integrated or of the
            other sensor, or the traces differ in station, location, start, length or sampling interval.
        """
        if unit is not None and unit not in UNITS:
            raise ArgumentError(f"unit: {unit!r}; known are {', '.join(UNITS)}")
        traces: dict[str, Any] = {}
        for trace in stream:
            code = str(trace.stats.channel).upper()
            if why := _no_acceleration(trace, code, unit) or _other_sensor(code, sensor):
                raise ArgumentError(f"stream: channel {trace.id}: {why}")
            name = _direction_of(trace, code)
            if name is None or name in traces:
                raise ArgumentError(
                    f"stream: channel {trace.stats.channel!r} {'stands twice' if name else 'is neither N, E nor Z'}; "
                    "rotate it to ZNE, merge it, and select one sensor first"
                )
            traces[name] = trace
        missing = [name for name in ("north", "east") if name not in traces]
        if missing:
            raise ArgumentError(
                f"stream: no component towards {missing[0]}; give one trace each for N and E, and Z where it is"
            )
        first, alike = traces["north"].stats, ("network", "station", "location", "starttime", "npts", "delta")
        for name, trace in traces.items():
            if any(trace.stats[key] != first[key] for key in alike):
                raise ArgumentError(
                    f"stream: {name} and north differ in station, location, start, length or sampling interval; select "
                    "one station and sensor, cut and resample its traces alike first"
                )
        codes = [str(trace.stats.channel).upper() for trace in traces.values()]
        sensors = dict.fromkeys(code[:2] for code in codes if len(code) == 3 and code[2] in "NEZ")
        if len(sensors) > 1:
            raise ArgumentError(f"stream: channels of sensors {' and '.join(sensors)}; select those of one")
        scale = 1.0 if unit is None else UNITS[unit]
        values: dict[str, Any] = {
            name: np.ma.getdata(trace.data) * float(trace.stats.calib) * scale for name, trace in traces.items()
        }
        motion = cls(**values, sampling_interval=float(first.delta))
        for name, speed in zip(("north", "east", "up"), np.abs(motion.velocity), strict=False):
            if speed[-1] > _DRIFTING * speed.max():
                share = f"{100 * speed[-1] / speed.max():.0f} %"
                why = f"stream: the velocity towards {name} ends at {share} of its peak, as of raw data with an offset"
                warnings.warn(f"{why}: take it off first (stream.detrend, filter)", stacklevel=3)
        return motion

    @classmethod
    @keywords()
    def sine(
        cls, amplitude: float, period: float, *, azimuth_deg: float = 0.0, cycles: float = 1.0, rest: float = 1.0,
        sampling_interval: float = 0.005,
    ) -> "Motion":  # fmt: skip
        """A sine of so many cycles towards an azimuth, A sin(2πt/T), with rest before and after.

        Amplitude in m/s², period, rest and sampling interval in s. An `ArgumentError` where one is not positive, the
        rest is below 0, or a period has fewer than four samples.
        """
        given = {"amplitude": amplitude, "period": period, "cycles": cycles, "sampling_interval": sampling_interval}
        for name, value in given.items():
            if not (np.isfinite(value) and value > 0):
                raise ArgumentError(f"{name}: {value}; it must be a positive number")
        if not (np.isfinite(rest) and rest >= 0):
            raise ArgumentError(f"rest: {rest}; it must be a number of seconds, at least 0")
        if period < 4.0 * sampling_interval:
            raise ArgumentError(
                f"period: {period:g} s in samples of {sampling_interval:g} s; it needs at least four of them: "
                f"sampling_interval at most {period / 4.0:g}"
            )
        time = sampling_interval * np.arange(round((2 * rest + cycles * period) / sampling_interval) + 1) - rest
        wave = np.where((time >= 0) & (time <= cycles * period), amplitude * np.sin(2 * np.pi * time / period), 0.0)
        cosine, sine = direction_cosines(azimuth_deg)
        return cls(wave * cosine, wave * sine, sampling_interval=sampling_interval)


def as_motion(given: Any) -> Motion:
    """A motion, or that of a record; an `ArgumentError` says what else to do with anything else."""
    if isinstance(given, Motion):
        return given
    if all(hasattr(given, name) for name in ("north", "east", "up", "sampling_interval")):
        return Motion.of(given)
    kind = type(given).__name__
    if hasattr(given, "traces") or kind == "Trace":
        raise ArgumentError(
            f"motion: an obspy {kind}; make it a motion by Motion.from_obspy(stream), in m/s² and N, E, Z"
        )
    raise ArgumentError(
        f"motion: a {kind}; give a Motion(north, east, sampling_interval=…), or a record of overturning.read"
    )
