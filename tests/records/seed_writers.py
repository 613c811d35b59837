"""MiniSEED, SAC and StationXML made with obspy for the tests."""

from pathlib import Path

import numpy as np
import obspy
from obspy.core.inventory import Channel, Inventory, Network, Station
from obspy.core.inventory.response import InstrumentSensitivity, PolesZerosResponseStage, Response

PI_SQUARED = np.pi**2
POLES = (-0.037 + 0.037j, -0.037 - 0.037j)
START = obspy.UTCDateTime(2001, 2, 3, 4, 5, 6, 500000)


def broadband_velocity_response(frequency):
    """Velocity response of a seismometer: corner period 120 s, damping 0.707 of critical, magnitude 1 at 1 Hz."""
    s, pole = 2j * np.pi * np.asarray(frequency), POLES[0]
    return (
        s**2
        / ((s - pole) * (s - np.conj(pole)))
        * abs((2j * np.pi - pole) * (2j * np.pi - np.conj(pole)))
        / 4
        / PI_SQUARED
    )


def response_metadata_of_sensor(gain: float, unit: str, *, broadband: bool = False) -> Response:
    """Return obspy's response metadata of a sensor of flat response, or of a broadband seismometer."""
    zeros, poles = ([0j, 0j], list(POLES)) if broadband else ([], [])
    norm = float(np.prod([abs(2j * np.pi - pole) for pole in poles])) / (4 * PI_SQUARED) if broadband else 1.0
    stage = PolesZerosResponseStage(
        1, gain, 1.0, unit, "COUNTS", "LAPLACE (RADIANS/SECOND)", 1.0, zeros, poles, normalization_factor=norm
    )
    return Response(instrument_sensitivity=InstrumentSensitivity(gain, 1.0, unit, "COUNTS"), response_stages=[stage])


def write_stationxml_of_channels(
    path: Path, channels: dict, *, station="TST1", gain: float = 400_000.0, unit: str = "M/S**2", depth: float = 0.0,
    broadband: bool = False, rate: float = 100.0, rates: dict[str, float] | None = None,
) -> Path:  # fmt: skip
    """Write a StationXML file; ``channels`` maps channel code (HNN or, with location, 10.HNN) to (azimuth, dip).

    ``rates`` maps band and instrument code (HN) to a sampling rate in Hz; other channels have ``rate``.
    """
    listed = [
        Channel(
            code.rpartition(".")[2],
            code.rpartition(".")[0],
            35.2,
            133.4,
            10.0,
            depth,
            azimuth=azimuth,
            dip=dip,
            sample_rate=(rates or {}).get(code[:2], rate),
            response=response_metadata_of_sensor(gain, unit, broadband=broadband),
        )
        for code, (azimuth, dip) in channels.items()
    ]
    inventory = Inventory([Network("XX", [Station(station, 35.2, 133.4, 10.0, channels=listed)])], source="tests")
    inventory.write(str(path), format="STATIONXML")
    return path


def trace_of_samples(samples, channel: str, *, station: str = "TST1", start=START, rate: float = 100.0) -> obspy.Trace:
    """Return an obspy trace of samples; `channel` may begin with a location code (10.HNN)."""
    location, _, code = channel.rpartition(".")
    header = {"network": "XX", "station": station, "location": location, "channel": code}
    header |= {"starttime": start, "sampling_rate": rate}
    return obspy.Trace(np.asarray(samples), header=header)


def write_mseed(path: Path, traces: dict, **header) -> Path:
    """Write a miniSEED file; ``traces`` maps channel code to counts."""
    stream = obspy.Stream(
        [trace_of_samples(np.asarray(c, dtype=np.int32), code, **header) for code, c in traces.items()]
    )
    stream.write(str(path), format="MSEED")
    return path


def write_sac(path: Path, samples, channel: str, azimuth: float | None, inclination: float | None, **header) -> Path:
    """Write a SAC file of one component."""
    one = trace_of_samples(np.asarray(samples, dtype=np.float32), channel, **header)
    one.stats.sac = obspy.core.AttribDict({"stla": 35.2, "stlo": 133.4})
    if azimuth is not None:
        one.stats.sac.cmpaz = azimuth
    if inclination is not None:
        one.stats.sac.cmpinc = inclination
    one.write(str(path), format="SAC")
    return path
