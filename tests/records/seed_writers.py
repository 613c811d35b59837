"""MiniSEED, SAC and StationXML made with obspy for the tests."""

from pathlib import Path

import numpy as np
import obspy
from obspy.core.inventory import Channel, Inventory, Network, Station
from obspy.core.inventory.response import InstrumentSensitivity, PolesZerosResponseStage, Response

START = obspy.UTCDateTime(2001, 2, 3, 4, 5, 6, 500000)


def response(gain: float, unit: str) -> Response:
    """A gain and, for velocity, a flat pair of zeros and poles far below and above the band."""
    stage = PolesZerosResponseStage(
        1, gain, 1.0, unit, "COUNTS", "LAPLACE (RADIANS/SECOND)", 1.0, [], [], normalization_factor=1.0
    )
    return Response(instrument_sensitivity=InstrumentSensitivity(gain, 1.0, unit, "COUNTS"), response_stages=[stage])


def write_inventory(
    path: Path, channels: dict, *, station="TST1", gain: float = 400_000.0, unit: str = "M/S**2", depth: float = 0.0
) -> Path:
    """StationXML; ``channels`` maps code to (azimuth, dip)."""
    listed = [
        Channel(
            code,
            "",
            35.2,
            133.4,
            10.0,
            depth,
            azimuth=azimuth,
            dip=dip,
            sample_rate=100.0,
            response=response(gain, unit),
        )
        for code, (azimuth, dip) in channels.items()
    ]
    inventory = Inventory([Network("XX", [Station(station, 35.2, 133.4, 10.0, channels=listed)])], source="tests")
    inventory.write(str(path), format="STATIONXML")
    return path


def trace(samples, channel: str, *, station: str = "TST1", start=START, rate: float = 100.0) -> obspy.Trace:
    """A trace of samples as they are."""
    header = {"network": "XX", "station": station, "channel": channel, "starttime": start, "sampling_rate": rate}
    return obspy.Trace(np.asarray(samples), header=header)


def write_mseed(path: Path, traces: dict, **header) -> Path:
    """MiniSEED; ``traces`` maps channel code to counts."""
    stream = obspy.Stream([trace(np.asarray(c, dtype=np.int32), code, **header) for code, c in traces.items()])
    stream.write(str(path), format="MSEED")
    return path


def write_sac(path: Path, samples, channel: str, azimuth: float | None, inclination: float | None, **header) -> Path:
    """One SAC file."""
    one = trace(np.asarray(samples, dtype=np.float32), channel, **header)
    one.stats.sac = obspy.core.AttribDict({"stla": 35.2, "stlo": 133.4})
    if azimuth is not None:
        one.stats.sac.cmpaz = azimuth
    if inclination is not None:
        one.stats.sac.cmpinc = inclination
    one.write(str(path), format="SAC")
    return path
