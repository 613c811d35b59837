"""Streams of obspy: which of their traces are the components of a motion, and in which unit."""

import re
import warnings
from typing import Any

import numpy as np

from overturning.errors import ArgumentError
from overturning.units import UNITS


def samples_of(stream: Any, unit: str | None, sensor: str) -> tuple[dict[str, Any], float]:
    """Accelerations of a stream by component, m/s², and its sampling interval, s; errors as of `Motion.from_obspy`."""
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
    return values, float(first.delta)


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
                f"stream: channel {trace.id} is taken towards {name} by its code; {where}: {more}", stacklevel=5
            )
    return name


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
