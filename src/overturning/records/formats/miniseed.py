"""MiniSEED with StationXML, through obspy: counts become acceleration by the gain or response that goes with them."""

import io
from collections.abc import Sequence
from datetime import UTC
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import UNKNOWN, Component, Direction, other_than_coded, sensor_at
from overturning.records.source import Declarations, SourceFile
from overturning.units import GAL, STANDARD_GRAVITY, UNITS

_SECONDS: Final = ("/S**2", "/S2", "/S^2", "/(S**2)", "/SEC**2", "/S/S")
_LENGTHS: Final = {"M": 1.0, "CM": GAL, "MM": 1e-3, "NM": 1e-9}
ACCELERATION: Final = {f"{length}{per}": scale for length, scale in _LENGTHS.items() for per in _SECONDS} | {
    "GAL": GAL,
    "G": STANDARD_GRAVITY,
}
"""Names of units of acceleration, in m/s²."""
VELOCITY: Final = {"M/S", "M/SEC"}
LONGEST_TAPER: Final = 5.0
"""Longest taper at each end before a response is removed, s."""
UNLIKE_GAINS: Final = 0.05
"""Largest relative difference of a channel's gain from the product of its stages; evalresp warns from there on."""
BLANK: Final = "--"
"""A location code of blanks as it is written: it tells sensors apart as any other code does."""
FULL_SCALE: Final = 0.01
"""Velocity from which on most velocity sensors are at the end of their range, m/s."""


def read(source: SourceFile, declared: Declarations) -> list[Component]:
    """Read all channels; a RecordError says so where the file is damaged, has gaps, or no StationXML goes with it."""
    size = len(source.data)
    if size % 128:
        why = f"{size} bytes are no whole number of MiniSEED records; it is cut: get it again"
        raise RecordError(f"{source.name}: {why}")
    stream, inventory = read_stream(source, "MSEED"), read_inventory(declared.metadata)
    if inventory is None:
        why = "MiniSEED holds counts without gain or orientation; give the station's StationXML with it"
        raise RecordError(f"{source.name}: {why}")
    return components_of(stream, inventory, source, declared.unit)


def read_stream(source: SourceFile, form: str, **options: Any) -> Any:
    """The traces of a file, by obspy; a RecordError where it is damaged."""
    import obspy

    try:
        return obspy.read(io.BytesIO(source.data), format=form, **options)
    except Exception as problem:  # struct, numpy, libmseed and obspy each raise their own
        raise RecordError(f"{source.name}: damaged {form} ({problem}); get it again") from problem


def read_inventory(files: Sequence[SourceFile]) -> Any:
    """All StationXML files as one inventory, None without files; a RecordError where one is damaged."""
    import obspy

    inventory = None
    for file in files:
        try:
            one = obspy.read_inventory(io.BytesIO(file.data), format="STATIONXML")
        except Exception as problem:  # lxml and obspy raise many kinds; each means that the file is damaged
            raise RecordError(f"{file.name}: damaged StationXML ({problem}); get it again") from problem
        inventory = one if inventory is None else inventory + one
    return inventory


def components_of(stream: Any, inventory: Any, source: SourceFile, unit: str | None) -> list[Component]:
    """Counts to m/s² with the inventory's gain (accelerometers) or response (velocity sensors).

    A RecordError says so where a trace has a gap or is not in the inventory, and where its code is that of a velocity
    sensor but the inventory says acceleration, unless a ``unit`` is declared.
    """
    name = source.name
    try:
        stream.merge(method=-1)
    except Exception as problem:
        raise RecordError(f"{name}: pieces of a channel do not fit together ({problem}); get it again") from problem
    for number, trace in enumerate(stream):
        if trace.id in [other.id for other in stream[:number]]:
            raise RecordError(f"{name}: channel {trace.id} has a gap or an overlap; cut the file to one side of it")
        if trace.stats.npts < 2:
            raise RecordError(f"{name}: channel {trace.id} has {trace.stats.npts} samples; get the file again")
    return [_component(trace, inventory, source, unit) for trace in stream]


def _component(trace: Any, inventory: Any, source: SourceFile, declared: str | None) -> Component:
    channel, moment = f"{source.name}: channel {trace.id}", trace.stats.starttime
    try:
        response = inventory.get_response(trace.id, moment)
        sensitivity = response.instrument_sensitivity
        place = inventory.get_channel_metadata(trace.id, moment)
        unit, gain = (sensitivity.input_units or "").upper(), float(sensitivity.value)
    except Exception as problem:  # obspy raises bare Exception
        why = f"at {moment} is not in the StationXML given ({problem})"
        raise RecordError(f"{channel} {why}; get it with level=response for that channel and time") from problem
    if not np.isfinite(gain) or gain <= 0:
        raise RecordError(f"{channel} has a gain of {gain}; correct the StationXML")
    if unit not in ACCELERATION and unit not in VELOCITY:
        raise RecordError(f"{channel} is in {unit or 'no unit'} in the StationXML; acceleration or velocity is needed")
    if unit in ACCELERATION and trace.stats.channel[1:2] == "H" and declared is None:
        raise RecordError(
            f"{channel} is of a velocity sensor by its code (H), but in {unit} in the StationXML; correct it, or "
            "declare the unit (unit m/s2 in the record table, --unit m/s2) if it is an acceleration"
        )
    if unit in VELOCITY and trace.stats.channel[1:2] == "N" and len(trace.stats.channel) == 3:
        raise RecordError(
            f"{channel} is of an accelerometer by its code (N), but in {unit} in the StationXML; correct its units"
        )
    samples, removed, direction = np.asarray(trace.data, dtype=np.float64) / gain, "gain", _orientation(place)
    notes = [*other_than_coded(trace.stats.channel, direction, "the StationXML")]
    if unit in ACCELERATION:
        samples *= ACCELERATION[unit]
        stages = [float(stage.stage_gain or 0.0) for stage in response.response_stages]
        if stages and all(stages) and abs(float(np.prod(stages)) / gain - 1.0) > UNLIKE_GAINS:
            notes += [f"{channel} has a gain of {gain:g} in the StationXML, whose stages make {np.prod(stages):g}"]
    else:
        if (speed := 0.5 * float(np.ptp(samples))) > FULL_SCALE:
            what = f"channel {trace.stats.channel} of a velocity sensor reaches {100 * speed:.2g} cm/s"
            notes += [f"{what}: most saturate from 1 or 2 cm/s on, and their acceleration is wrong then; look at it"]
        samples, removed = _deconvolved(trace, inventory, source.name), "response"
    return Component.of(
        source,
        trace.stats.channel,
        direction,
        samples,
        float(trace.stats.delta),
        start=moment.datetime.replace(tzinfo=UTC),
        station=trace.stats.station,
        place=(place["latitude"], place["longitude"]),
        sensor=sensor_at(place["local_depth"]),
        location=trace.stats.location or BLANK,
        unit=declared if declared and UNITS.get(declared) == ACCELERATION.get(unit) else "",
        extra={"removed": removed, "network": trace.stats.network},
        notes=tuple(notes),
    )


def _deconvolved(trace: Any, inventory: Any, name: str) -> FloatArray:
    """Acceleration from a velocity sensor: response removed between 0.02 Hz and 0.8 of the Nyquist frequency.

    The band bounds the division. A water level counts from the largest response to acceleration, which a broadband
    sensor has at its corner period: 60 dB below that lies at 12 Hz for 120 s, and what is faster came out low.
    """
    nyquist = 0.5 * trace.stats.sampling_rate
    band = (0.01, 0.02, 0.8 * nyquist, 0.95 * nyquist)
    copy = trace.copy()
    copy.data = np.asarray(copy.data, dtype=np.float64)
    # Of both ends together, as obspy has it; its own 5 % are 90 s at each end of an hour, with a shock in them.
    tapered = min(0.05, 2.0 * LONGEST_TAPER / (copy.stats.npts * copy.stats.delta))
    known = {"pre_filt": band, "water_level": 300, "zero_mean": True, "taper_fraction": tapered}
    try:
        copy.remove_response(inventory, output="ACC", **known)
    except Exception as problem:
        why = f"response of {trace.id} cannot be removed ({problem})"
        raise RecordError(f"{name}: {why}; get level=response") from problem
    return np.asarray(copy.data, dtype=np.float64)


def _orientation(place: dict[str, Any]) -> Direction:
    azimuth, dip = place.get("azimuth"), place.get("dip")
    if dip is not None and abs(abs(dip) - 90.0) < 1.0:
        return None, 1 if dip < 0 else -1
    if azimuth is None or dip is None or abs(dip) > 1.0:
        return UNKNOWN
    return float(azimuth) % 360.0, 0
