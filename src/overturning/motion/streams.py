"""Components of a motion from the traces of an obspy Stream, with checks of direction, unit and sensor."""

import re
import warnings
from typing import Any

import numpy as np

from overturning.errors import ArgumentError
from overturning.units import ACCELERATION_UNITS_IN_M_S2


def accelerations_interval_and_start_of_stream(
    stream: Any, unit_stated_by_user: str | None, sensor: str
) -> tuple[dict[str, Any], float, str | None]:
    """Return the accelerations of an obspy Stream (m/s², by component), its sampling interval (s) and its start time.

    The components are ``north``, ``east`` and, if present, ``up``. The start time is that of the first sample, ISO 8601
    in UTC; None for obspy's default, 1970. `Motion.from_obspy` describes arguments and errors.
    """
    if unit_stated_by_user is not None and (
        not isinstance(unit_stated_by_user, str) or unit_stated_by_user not in ACCELERATION_UNITS_IN_M_S2
    ):
        raise ArgumentError(f"unit: {unit_stated_by_user!r}; known are {', '.join(ACCELERATION_UNITS_IN_M_S2)}")
    traces: dict[str, Any] = {}
    for trace in stream:
        code = str(trace.stats.channel).upper()
        if why := _reason_trace_is_no_acceleration(
            trace, code, unit_stated_by_user
        ) or _reason_for_other_sensor_than_requested(code, sensor):
            raise ArgumentError(f"stream: channel {trace.id}: {why}")
        name = _channel_direction_with_warning_if_sac_differs(trace, code)
        if name is None or name in traces:
            raise ArgumentError(
                f"stream: channel {trace.stats.channel!r} {'is given twice' if name else 'is neither N, E nor Z'}; "
                "rotate it to ZNE, merge it, and select one sensor first"
            )
        traces[name] = trace
    missing = [name for name in ("north", "east") if name not in traces]
    if missing:
        raise ArgumentError(
            f"stream: no component towards {missing[0]}; give one trace each for N and E, and optionally Z"
        )
    _check_same_sensor_and_window(traces)
    scale = 1.0 if unit_stated_by_user is None else ACCELERATION_UNITS_IN_M_S2[unit_stated_by_user]
    values: dict[str, Any] = {
        name: np.ma.getdata(trace.data) * _calibration_factor(trace) * scale for name, trace in traces.items()
    }
    stats = traces["north"].stats
    return values, float(stats.delta), str(stats.starttime) if stats.starttime.timestamp else None


def _calibration_factor(trace: Any) -> float:
    """Return the factor that converts the samples of an obspy Trace to physical units (its `calib`; 1 for SAC files).

    obspy takes the header field SCALE of a SAC file as a calibration; programs fill this field in different ways, so
    that `overturning.read` does not apply it either.
    """
    return 1.0 if "sac" in trace.stats else float(trace.stats.calib)


def _check_same_sensor_and_window(traces: dict[str, Any]) -> None:
    """Raise an `ArgumentError` unless all traces have the same station, time window, sampling interval and sensor."""
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


def _reason_trace_is_no_acceleration(trace: Any, channel_code: str, unit_stated_by_user: str | None) -> str:
    """Return why an obspy Trace is not an acceleration without gaps, and a remedy; "" if it is one."""
    if np.ma.is_masked(trace.data):
        return (
            f"a gap of {int(np.ma.getmaskarray(trace.data).sum())} masked samples; cut the stream to one side of it "
            "(stream.split, stream.trim)"
        )
    if unit_stated_by_user is not None:
        return ""
    if np.issubdtype(trace.data.dtype, np.integer) and _calibration_factor(trace) == 1.0:
        return "integer samples are counts; remove the response with output='ACC', or give their unit"
    steps = " ".join(trace.stats.get("processing", ()))
    done = re.findall(r"remove_response\([^()]*?output='?(\w+)|\b(integrate|differentiate)\(", steps)
    removed = [output for output, _ in done if output]
    # SEED's instrument codes: H and L seismometers of high and low gain, P geophones; N and G accelerometers.
    why = (
        "a velocity sensor by its code"
        if len(channel_code) == 3 and channel_code[1] in "HLP" and channel_code[2] in "NEZ"
        else ""
    )
    integrals = 0  # number of integrations from acceleration
    for output, step in done:
        integrals = (
            _INTEGRATION_COUNT_BY_RESPONSE_OUTPUT.get(output, 1)
            if output
            else integrals + (1 if step == "integrate" else -1)
        )
    if removed or integrals:
        last = (
            f"its response was removed to {removed[-1]}" if removed and not done[-1][1] else f"{done[-1][1]}d by obspy"
        )
        why = last if integrals else ""
    return f"{why}; remove the response with output='ACC', or say unit='m/s2' if these are accelerations" if why else ""


_INTEGRATION_COUNT_BY_RESPONSE_OUTPUT = {"ACC": 0, "VEL": 1, "DISP": 2}
"""Number of integrations from acceleration to each output of obspy's `remove_response`."""

_CHANNEL_CODE_PATTERN = re.compile(r"(?:[A-Z]{2})?([NEZ])|(NS|EW|UD)[12]?")
"""SEED codes, with or without band and instrument, and NIED's codes; no other code with these endings is accepted."""

_DIRECTION_BY_CODE_ENDING = {"N": "north", "NS": "north", "E": "east", "EW": "east", "Z": "up", "UD": "up"}


def _channel_direction_with_warning_if_sac_differs(trace: Any, channel_code: str) -> str | None:
    """Return the direction (``north``, ``east``, ``up``) in a channel code, or None; warn if the SAC header differs.

    The warning is given if the direction in the SAC header (CMPAZ, CMPINC) is more than 5° from that of the code.
    """
    found = _CHANNEL_CODE_PATTERN.fullmatch(channel_code)
    if found is None:
        return None
    name = _DIRECTION_BY_CODE_ENDING[found[1] or found[2]]
    azimuth, inclination = (trace.stats.get("sac", {}).get(key, _UNDEFINED_SAC_NUMBER) for key in ("cmpaz", "cmpinc"))
    if _UNDEFINED_SAC_NUMBER not in (azimuth, inclination):
        tilt, turn = np.radians(inclination), np.radians(azimuth)
        along = {"north": np.sin(tilt) * np.cos(turn), "east": np.sin(tilt) * np.sin(turn), "up": np.cos(tilt)}[name]
        if along < np.cos(np.radians(5.0)):
            where = f"azimuth {azimuth:g}°, {inclination:g}° from up, by its SAC header"
            more = "overturning.read uses the directions in SAC headers"
            warnings.warn(f"stream: channel {trace.id} points {name} by its code, but {where}: {more}", stacklevel=5)
    return name


_UNDEFINED_SAC_NUMBER = -12345.0
"""Value of undefined numbers in SAC headers."""


def _reason_for_other_sensor_than_requested(channel_code: str, sensor: str) -> str:
    """Return why a channel is not from the requested sensor, and a remedy; "" if it is from that sensor."""
    if sensor not in ("surface", "borehole"):
        return f"sensor {sensor!r}; known are surface and borehole"
    found = {"1": "borehole", "2": "surface"}.get(channel_code[2:]) if channel_code[:2] in ("NS", "EW", "UD") else None
    return (
        f"it belongs to the {found} sensor; select the {sensor} one, or set sensor={found!r}"
        if found not in (None, sensor)
        else ""
    )
