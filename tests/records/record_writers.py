"""Small files in the formats that the readers know, written from numbers: the fixtures of the tests."""

from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

KNET_SENSORS = {None: ("N-S", "E-W", "U-D"), 1: ("1", "2", "3"), 2: ("4", "5", "6")}
"""Direction codes by the number of the sensor, which KiK-net's files have after NS, EW or UD."""


def knet_text(
    counts, *, direction="N-S", rate="100Hz", station="TST001", scale=(2000, 8388608),
    start=datetime(2001, 2, 3, 4, 5, 6), magnitude="6.1", memo="",
) -> str:  # fmt: skip
    """K-NET ASCII; ``start`` is the first sample's time in UTC, counts carry their offset."""
    counts = np.asarray(counts, dtype=int)
    gain = float(scale[0]) / float(scale[1])
    recorded = start + timedelta(hours=9, seconds=15)
    peak = np.abs(counts - counts.mean()).max() * gain
    duration = counts.size / float(rate.removesuffix("Hz"))
    header = [
        ("Origin Time", f"{recorded - timedelta(seconds=20):%Y/%m/%d %H:%M:%S}"),
        ("Lat.", "35.275"),
        ("Long.", "133.348"),
        ("Depth. (km)", "11"),
        ("Mag.", magnitude),
        ("Station Code", station),
        ("Station Lat.", "35.2289"),
        ("Station Long.", "133.3904"),
        ("Station Height(m)", "420"),
        ("Record Time", f"{recorded:%Y/%m/%d %H:%M:%S}"),
        ("Sampling Freq(Hz)", rate),
        ("Duration Time(s)", f"{duration:g}"),
        ("Dir.", direction),
        ("Scale Factor", f"{scale[0]}(gal)/{scale[1]}"),
        ("Max. Acc. (gal)", f"{peak:.3f}"),
        ("Last Correction", f"{recorded:%Y/%m/%d %H:%M:%S}"),
        ("Memo.", memo),
    ]
    text = "".join(f"{key:<18}{value}\n" for key, value in header)
    for row in range(0, counts.size, 8):
        text += "".join(f"{value:>9d}" for value in counts[row : row + 8]) + "\n"
    return text


def write_knet_set(folder: Path, stem: str, north, east, up=None, *, kik: int | None = None, **header) -> list[Path]:
    """A set of component files of counts; ``kik`` 1 for the borehole sensor, 2 for the surface one."""
    paths = []
    for code, axis, counts in zip(KNET_SENSORS[kik], ("NS", "EW", "UD"), (north, east, up), strict=True):
        if counts is not None:
            path = folder / f"{stem}.{axis}{kik or ''}"
            path.write_text(knet_text(counts, direction=code, **header), encoding="ascii")
            paths.append(path)
    return paths


def fixed(values, width: int, decimals: int, per_line: int, form: str = "f") -> str:
    """FORTRAN columns of fixed width, without the leading zero where it does not fit."""
    words = []
    for value in values:
        word = f"{value:{width}.{decimals}{form}}"
        words.append(word if len(word) <= width else word.replace("0.", ".", 1).strip().rjust(width))
    assert all(len(w) == width for w in words), max(words, key=len)
    return "".join("".join(words[i : i + per_line]) + "\n" for i in range(0, len(words), per_line))


def geonet_text(components: dict, interval: float, *, corrected=True, prepended=0, magnitude=7.82) -> str:
    """GeoNet V2A or V1A; ``components`` maps axis (N28W) to (bearing, samples in mm/s²)."""
    text = ""
    for axis, (bearing, samples) in components.items():
        samples = np.asarray(samples, dtype=float)
        n = samples.size
        peak = samples[np.abs(samples).argmax()]
        kind = "Corrected" if corrected else "Uncorrected"
        unit = "Instrument corrected data" if corrected else "Raw readings in units of 1.00 mm/s/s "
        lines = [
            f"{kind} accelerogram 20161113_110256_TEST_20 GNS Science",
            "Site TEST      42 37 10S  173 03 13E     Cusp file:  20161113_110259_TEST",
            "Test Farm",
            "Instrument Cusp_1",
            "Resolution: 18-bit   Instr Period: 0.0050 s   Damping: 0.700",
            "Accelerogram 20161113_110256_TEST_20                 Processed 2016 December 09",
            "5 km south-west of Nowhere",
            "2016 November 13         11:02:56 UT",
            "Epicentre  42 41 33S 173 01 19E  Bearing S18W  Dist    9km  Depth   15km Mw 7.82",
            f"Number of points  {n}    Duration {n * interval:.2f} sec",
            f"{unit} at {interval:.3f} sec intervals" if corrected else f"{unit} at intervals of {interval:.3f} s",
            "Band-pass filter transition bands are .10-.25 Hz and 24.50-25.50 Hz",
            f"Component {axis}  Longitudinal Accelerometer Axis",
            f"Acceleration:  peak {peak:8.1f} mm/s/s at  44.88 sec     rms    719.0 mm/s/s",
            "Velocity:      peak -1016.55 mm/s   at  46.58 sec     rms    96.10 mm/s",
            "Displacement:  peak  234.852 mm     at  46.36 sec     rms   38.013 mm",
        ]
        whole = [0] * 40
        whole[8:10], whole[18:20] = (2016, 11), (13, 11)
        whole[27] = bearing
        whole[31] = prepended
        whole[33:36] = n, n if corrected else 0, n if corrected else 0
        whole[38:40] = 2, 19_000
        real = [0.0] * 60
        real[14], real[24], real[25] = magnitude, interval, interval
        text += "\n".join(lines) + "\n" + fixed(whole, 8, 0, 10)
        text += "".join(fixed(real[i : i + 10], 8, 4, 10) for i in range(0, 60, 10))
        text += fixed(samples, 8, 1, 10) * (3 if corrected else 1)
    return text


def csmip_text(channels: dict, rate: int, *, volume: int = 1) -> str:
    """CSMIP volume 1 (g) or 2 (cm/s²); ``channels`` maps axis (90 Deg, Up) to (azimuth or 0, samples)."""
    text = ""
    for number, (axis, (azimuth, samples)) in enumerate(channels.items(), 1):
        samples = np.asarray(samples, dtype=float)
        n = samples.size
        peak = np.abs(samples).max()
        lines = ["Corrected Accelerogram Data    Processed: 07/06/19, CGS"] if volume == 2 else []
        lines += [
            "Uncorrected Accelerogram Data             Processed: 07/06/19, CGS  ciclc--f",
            "Rcrd of Fri Jul  5, 2019 20:16:08.0 PDT               (Avol1 v2.0, 4/18 CSMIP)",
            "                                        (Origin:  To be determined)",
            "38457487.CI.CLC.--.HN                Start time:  7/06/19, 03:16: 8.0 UTC (GPS)",
            "Station Id. CLC     35.816N, 117.598W    Q330    s/n 4323  (3 Chns of  3 at Sta)",
            "China Lake, G2 Tower Rd.                 SCSN   Data: Acceleration",
            f"Chan  {number}: {axis}",
            "Rcrd of Fri Jul  5, 2019 20:16:08.0 PDT    Fri Jul  5, 2019 20:16:08.0 PDT",
            "Hypocenter:  To be determined.               ML:  To be determined.",
            "Instr Period =  .0050 sec,  Damping =  .707,  Sensitivity = 4.99 v/g  (Nominal)",
            f"No. of Points = {n:6d}  Record Length ={n / rate:8.3f} sec   at {rate} Samples/sec",
        ]
        if volume == 1:
            lines.append(f"Units of uncor data are sec and g.         Max  = {peak:6.3f} g, at  234.360 sec.")
        else:
            lines.append(f"Peak acceleration = {peak:10.3f} cm/sec/sec at 1.0 sec")
        lines += [""] * ((13 if volume == 1 else 25) - len(lines))
        whole = [-999] * 100
        whole[26], whole[27] = azimuth, n
        text += "\n".join(lines) + "\n" + fixed(whole, 5, 0, 16)
        if volume == 1:
            text += fixed([0.0] * 50, 10, 6, 8)
            text += f" {n:5d} Accelerogram points at {rate} pts/sec in units of g.       Format: (8f9.6)\n"
            text += fixed(samples, 9, 6, 8)
        else:
            text += fixed([0.0] * 100, 10, 4, 8)
            for what, unit in (("accel", "cm/sec2"), ("veloc", "cm/sec"), ("displ", "cm")):
                text += f" {n:5d} points of {what} data equally spaced at {1 / rate:6.4f} sec, in {unit}. (8f10.4)\n"
                text += fixed(samples, 10, 4, 8)
        text += f"/&  ----------  End of Data for Station Channel   {number}  ----------\n"
    return text


def pairs_text(channels: dict, interval: float, lines: Callable[[int, str, int, float], list[str]]) -> str:
    """Channels of volume 1 that hold pairs of time and acceleration, ten columns of seven."""
    text = ""
    for number, (axis, (azimuth, samples)) in enumerate(channels.items(), 1):
        samples = np.asarray(samples, dtype=float)
        head = lines(number, axis, samples.size, np.abs(samples).max() / 10)
        whole = [0] * 100
        whole[26:28] = azimuth, samples.size
        pairs = np.column_stack([np.arange(samples.size) * interval, samples]).ravel()
        text += "\n".join(head + [""] * (13 - len(head))) + "\n" + fixed(whole, 5, 0, 16) + fixed([0.0] * 50, 10, 6, 8)
        text += fixed(pairs, 7, 3, 10) + f"/&  ----------  END OF DATA FOR CHANNEL {number}  ----------\n"
    return text


def csmip_pairs_text(channels: dict, interval: float) -> str:
    """Old volume 1 / RAW, g/10; ``channels`` maps axis to (azimuth, samples)."""

    def lines(number: int, axis: str, size: int, peak: float) -> list[str]:
        return [
            "UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 02/28/94",
            "RECORD OF NORTHRIDGE EARTHQUAKE",
            "STATION NO. 24436   34.160N, 118.534W   SMA-1  S/N 0001",
            f"CHAN  {number}: {axis}",
            f"NO. OF POINTS = {size}  RECORD LENGTH = {(size - 1) * interval:.3f} SEC",
            f"UNITS OF UNCOR ACCEL ARE SEC AND G/10.     MAX  = {peak:.4f} G.",
        ]

    return pairs_text(channels, interval, lines)


def cosmos_text(channels: dict, interval: float, *, unit: int = 4, kind: str = "Corrected") -> str:
    """COSMOS 1.20; ``channels`` maps axis text (340 deg) to (code, samples in the unit)."""
    word = {2: "g", 4: "cm/sec2", 5: "cm/sec", 50: "counts"}[unit]
    text = ""
    for number, (axis, (code, samples)) in enumerate(channels.items(), 1):
        samples = np.asarray(samples, dtype=float)
        n = samples.size
        whole = [-999] * 100
        whole[1], whole[2], whole[53] = 1, unit, code
        whole[39:45] = 2005, 167, 6, 16, 20, 53
        real = [-999.0] * 100
        real[0], real[1], real[12], real[29] = 34.046, -117.035, 4.8, 4.4
        real[61], real[62], real[63] = interval * 1000, n * interval, samples[np.abs(samples).argmax()]
        lines = [
            f"{kind} acceleration    (Format v01.20 with 13 text lines) Src: test",
            "Somewhere            June 16,2005 13:53 PDT",
            "Hypocenter: 34.0580  -117.0110  H= 12km(SCSN) ML=4.9",
            "Origin: 06/16/2005, 20:53:26.1 UTC (SCSN)",
            "Statn No: 01-23075  Code:CE-J2236  CDMG Yucaipa",
            "Coords: 34.0460 -117.0350  Site Geology:  here",
            "Recorder: SSA-2  s/n 1238 ( 1 Chns of 12  at Sta) Sensor:FBA-11  s/n 1889",
            "Rcrd start time:06/16/2005, 20:53:04.400 UTC (Q=2) RcrdId: 23075-L1889-05167.06",
            f"Sta Cha:  {number}: {axis} (Rcrdr Chan  {number}) Location: free field",
            "Raw record length = 70.000  sec, Uncor max =   -.167 g  at   27.850 sec",
            f"Processed: 06/17/2005, 12:01:00 PDT      Max = {samples[np.abs(samples).argmax()]:.3f} {word}  at  "
            "27.850 sec",
            "Record filtered below 0.30  Hz (periods over  14.5 secs), and above 40.0 Hz",
            "Values used when parameter or data value is unknown/unspecified:   -999, -999.0",
            " 100 Integer-header values follow on  10 lines, Format= (10I8)",
        ]
        text += "\n".join(lines) + "\n" + fixed(whole, 8, 0, 10)
        text += " 100 Real-header values follow on  17 lines, Format= (6F13.6)\n" + fixed(real, 13, 6, 6)
        text += '   1 Comment line(s) follow, each starting with a "|":\n| a comment\n'
        text += f"{n:7d}  acceleration pts, approx {n * interval:4.0f} secs, units={word}({unit:02d}),"
        decimals = 1 if unit == 50 else 5
        text += f"Format=(8F10.{decimals})\n" + fixed(samples, 10, decimals, 8)
        text += f"/&  ----------  End of data for channel  {number}  ----------\n"
    return text


def smc_text(samples, rate: float, axis: str, *, kind: str = "2 CORRECTED ACCELEROGRAM", vertical: int = 90) -> str:
    """SMC; samples in cm/s²."""
    samples = np.asarray(samples, dtype=float)
    azimuth = int(axis) if axis.isdigit() else 0
    lines = [
        kind,
        "*",
        "TST01",
        "     1989  10  18    0004 Loma Prieta, CA",
        "Moment Mag=      7.1 Ms=      7.1 Ml=      7.0",
        f"station = Test, 1 Main Street       component={axis:>7}",
        f"epicentral dist =     89.0       pk     = {np.abs(samples).max():8.1f}",
        "inst type=SMA-1      data source = USGS",
        "*",
        "*",
        "*",
    ]
    null = -32768
    whole = [null] * 48
    whole[1:7] = 1989, 291, 0, 4, 12, 500
    whole[12], whole[13], whole[15], whole[16] = vertical, azimuth, 2, samples.size
    real = [1.7e38] * 50
    real[1], real[5], real[10], real[11] = rate, 7.1, 37.728, -122.385
    real[28:32] = 1.0, samples.max(), 2.0, samples.min()
    text = "".join(f"{line:<80}\n" for line in lines) + fixed(whole, 10, 0, 8)
    text += "".join("".join(f"{v:15.7E}" for v in real[i : i + 5]) + "\n" for i in range(0, 50, 5))
    text += "|" + " " * 79 + "\n|a comment\n"
    words = [f"{v:10.4E}".replace("E+0", "E+").replace("E-0", "E-").rjust(10) for v in samples]
    return text + "".join("".join(words[i : i + 8]) + "\n" for i in range(0, len(words), 8))


def peer_text(samples, interval: float, axis: str, *, header: str = "new") -> str:
    """PEER AT2, in g, with the new header, or one of the two old ones."""
    samples = np.asarray(samples, dtype=float)
    n = samples.size
    lines = {
        "new": [
            "PEER NGA STRONG MOTION DATABASE RECORD",
            f"Test-01, 1/17/1994, Test Receiving Sta, {axis}",
            "ACCELERATION TIME SERIES IN UNITS OF G",
            f"NPTS=  {n:5d}, DT=   {interval:.4f} SEC, ",
        ],
        "old": [
            "PEER STRONG MOTION DATABASE RECORD. PROCESSING BY PACIFIC ENGINEERING.",
            f"TEST 01/17/94 12:31, TEST RECEIVING STA, {axis} (USGS STATION 77)",
            "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 Hz LP=30.0 Hz",
            f"NPTS=  {n}, DT= {interval:.5f} SEC".replace("0.0", ".0"),
        ],
        "oldest": [
            "PEER STRONG MOTION DATABASE RECORD",
            f"TEST 01/17/94 12:31, TEST RECEIVING STA, {axis}",
            "ACCELERATION TIME HISTORY IN UNITS OF G",
            f"{n}    {interval:.4f}    NPTS, DT",
        ],
    }[header]
    words = [f"{v:15.7E}" for v in samples]
    return "\n".join(lines) + "\n" + "".join("".join(words[i : i + 5]) + "\n" for i in range(0, n, 5))


def esm_text(samples, interval: float, stream: str) -> str:
    """DYNA 1.2; samples in cm/s²."""
    samples = np.asarray(samples, dtype=float)
    peak = samples[np.abs(samples).argmax()]
    lines = [
        "EVENT_NAME: NORCIA_EARTHQUAKE",
        "EVENT_ID: EMSC-20161030_0000029",
        "EVENT_DATE_YYYYMMDD: 20161030",
        "EVENT_TIME_HHMMSS: 064018",
        "MAGNITUDE_W: 6.5",
        "MAGNITUDE_L:",
        "NETWORK: IT",
        "STATION_CODE: AMT",
        "STATION_NAME: AMATRICE",
        "STATION_LATITUDE_DEGREE: 42.632500",
        "STATION_LONGITUDE_DEGREE: 13.286600",
        "VS30_M/S: 670",
        "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS: 20161030_064010.450",
        f"SAMPLING_INTERVAL_S: {interval:.6f}",
        f"NDATA: {samples.size}",
        f"DURATION_S: {samples.size * interval:.3f}",
        f"STREAM: {stream}",
        "UNITS: cm/s^2",
        f"PGA_CM/S^2: {peak:.6f}",
        "TIME_PGA_S: 1.0",
        "BASELINE_CORRECTION: BASELINE REMOVED",
        "DATA_TYPE: ACCELERATION",
        "HEADER_FORMAT: DYNA 1.2",
    ]
    return "\n".join(lines) + "\n" + "".join(f"{v:.6f}\n" for v in samples)
