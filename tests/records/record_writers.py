"""Small files in the formats that the readers know, written from numbers: the fixtures of the tests."""

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

HEADER_TEMPLATE_FOLDER = Path(__file__).parent / "headers"


def format_header_filled_from_template(form: str, samples, interval: float, **more) -> str:
    """Return the header of a format, filled in with the samples, the sampling interval and further values."""
    n, extreme = samples.size, samples[np.abs(samples).argmax()]
    stated = {"n": n, "interval": interval, "seconds": n * interval, "last": (n - 1) * interval, "extreme": extreme}
    return (
        (HEADER_TEMPLATE_FOLDER / f"{form}.txt").read_text(encoding="utf-8").format(**stated, peak=abs(extreme), **more)
    )


def list_of_header_numbers_with_known_values(size: int, unknown: float, known: dict[int, tuple]) -> list:
    """Return `size` numbers: `known` maps a place (from 0) to the values that begin there, the others are `unknown`."""
    found = [unknown] * size
    for place, values in known.items():
        found[place : place + len(values)] = values
    return found


KNET_DIRECTION_CODES_BY_SENSOR = {None: ("N-S", "E-W", "U-D"), 1: ("1", "2", "3"), 2: ("4", "5", "6")}
"""Direction codes by the number of the sensor, which KiK-net's files have after NS, EW or UD."""


def knet_text(
    counts, *, direction="N-S", rate="100Hz", station="TST001", scale=(2000, 8388608),
    start=datetime(2001, 2, 3, 4, 5, 6), magnitude="6.1", memo="",
) -> str:  # fmt: skip
    """Text of a K-NET ASCII file; ``start`` is the time of the first sample in UTC, counts include their offset."""
    counts = np.asarray(counts, dtype=int)
    recorded, interval = start + timedelta(hours=9, seconds=15), 1 / float(rate.removesuffix("Hz"))
    gal = (counts - counts.mean()) * (float(scale[0]) / float(scale[1]))
    stated = {"direction": direction, "rate": rate, "station": station, "scale": scale, "magnitude": magnitude}
    stated |= {"origin": recorded - timedelta(seconds=20), "recorded": recorded, "memo": memo}
    text = format_header_filled_from_template("knet", gal, interval, **stated)
    for row in range(0, counts.size, 8):
        text += "".join(f"{value:>9d}" for value in counts[row : row + 8]) + "\n"
    return text


def write_knet_component_files(
    folder: Path, stem: str, north, east, up=None, *, kik: int | None = None, **header
) -> list[Path]:
    """Write a K-NET file for each component; ``kik`` is 1 for a KiK-net borehole sensor, 2 for a surface sensor."""
    paths = []
    for code, axis, counts in zip(
        KNET_DIRECTION_CODES_BY_SENSOR[kik], ("NS", "EW", "UD"), (north, east, up), strict=True
    ):
        if counts is not None:
            path = folder / f"{stem}.{axis}{kik or ''}"
            path.write_text(knet_text(counts, direction=code, **header), encoding="ascii")
            paths.append(path)
    return paths


def fixed_width_columns(values, width: int, decimals: int, per_line: int, form: str = "f") -> str:
    """Return numbers in FORTRAN columns of fixed width; a number that is too wide loses its leading zero."""
    form = f"{width}.{decimals}{form}"
    words = [format(value, form) for value in (values.tolist() if isinstance(values, np.ndarray) else values)]
    words = [word if len(word) <= width else word.replace("0.", ".", 1).strip().rjust(width) for word in words]
    assert all(len(w) == width for w in words), max(words, key=len)
    return "".join("".join(words[i : i + per_line]) + "\n" for i in range(0, len(words), per_line))


def geonet_text(components: dict, interval: float, *, corrected=True, prepended=0, magnitude=7.82) -> str:
    """Text of a GeoNet V2A or V1A file; ``components`` maps axis (N28W) to (bearing, samples in mm/s²)."""
    text = ""
    for axis, (bearing, samples) in components.items():
        samples = np.asarray(samples, dtype=float)
        n = samples.size
        kind = "Corrected" if corrected else "Uncorrected"
        unit = f"Instrument corrected data at {interval:.3f} sec intervals"
        raw = f"Raw readings in units of 1.00 mm/s/s  at intervals of {interval:.3f} s"
        counts = (n, n, n) if corrected else (n, 0, 0)
        of_start = {8: (2016, 11), 18: (13, 11), 38: (2, 19_000)}
        whole = list_of_header_numbers_with_known_values(
            40, 0, of_start | {27: (bearing,), 31: (prepended,), 33: counts}
        )
        real = list_of_header_numbers_with_known_values(60, 0.0, {14: (magnitude,), 24: (interval, interval)})
        text += format_header_filled_from_template(
            "geonet", samples, interval, axis=axis, kind=kind, unit=unit if corrected else raw
        )
        text += fixed_width_columns(whole, 8, 0, 10)
        text += "".join(fixed_width_columns(real[i : i + 10], 8, 4, 10) for i in range(0, 60, 10))
        text += fixed_width_columns(samples, 8, 1, 10) * (3 if corrected else 1)
    return text


def csmip_text(channels: dict, rate: int, *, volume: int = 1, old_agency: str = "") -> str:
    """Text of a CSMIP volume 1 (g) or 2 (cm/s²); ``channels`` maps axis (90 Deg, Up) to (azimuth or 0, samples).

    Volume 2 has an old header if ``old_agency`` names an agency that processed it.
    """
    form = "csmip2-old" if old_agency else f"csmip{volume}"
    text = ""
    for number, (axis, (azimuth, samples)) in enumerate(channels.items(), 1):
        samples = np.asarray(samples, dtype=float)
        n = samples.size
        text += format_header_filled_from_template(
            form, samples, 1 / rate, number=number, axis=axis, rate=rate, agency=old_agency
        )
        text += fixed_width_columns(list_of_header_numbers_with_known_values(100, -999, {26: (azimuth, n)}), 5, 0, 16)
        if volume == 1:
            text += fixed_width_columns([0.0] * 50, 10, 6, 8)
            text += f" {n:5d} Accelerogram points at {rate} pts/sec in units of g.       Format: (8f9.6)\n"
            text += fixed_width_columns(samples, 9, 6, 8)
        else:
            text += fixed_width_columns([0.0] * 100, 10, 4, 8)
            for what, unit in (("accel", "cm/sec2"), ("veloc", "cm/sec"), ("displ", "cm")):
                text += f" {n:5d} points of {what} data equally spaced at {1 / rate:6.4f} sec, in {unit}. (8f10.4)\n"
                text += fixed_width_columns(samples, 10, 4, 8)
        text += f"/&  ----------  End of Data for Station Channel   {number}  ----------\n"
    return text


def time_acceleration_pairs_text(channels: dict, interval: float, form: str, **more) -> str:
    """Return an accelerogram file (volume 1) of times, s, with accelerations, g/10, in ten columns of 7 characters."""
    text = ""
    for number, (axis, (azimuth, samples)) in enumerate(channels.items(), 1):
        samples = np.asarray(samples, dtype=float)
        text += format_header_filled_from_template(
            form, samples, interval, number=number, axis=axis, g=samples[np.abs(samples).argmax()] / 10, **more
        )
        whole = list_of_header_numbers_with_known_values(100, 0, {26: (azimuth, samples.size)})
        pairs = np.column_stack([np.arange(samples.size) * interval, samples]).ravel()
        text += fixed_width_columns(whole, 5, 0, 16) + fixed_width_columns([0.0] * 50, 10, 6, 8)
        text += fixed_width_columns(pairs, 7, 3, 10) + f"/&  ----------  END OF DATA FOR CHANNEL {number}  ----------\n"
    return text


def csmip_pairs_text(channels: dict, interval: float) -> str:
    """Text of an old CSMIP volume 1 with times; ``channels`` maps axis to (azimuth, samples in g/10)."""
    return time_acceleration_pairs_text(channels, interval, "csmip-pairs")


def cosmos_text(channels: dict, interval: float, *, unit: int = 4, kind: str = "Corrected") -> str:
    """Return a COSMOS 1.20 file; ``channels`` maps axis text (340 deg) to (axis code, samples), ``unit`` is a code."""
    word = {2: "g", 4: "cm/sec2", 5: "cm/sec", 50: "counts"}[unit]
    text = ""
    for number, (axis, (code, samples)) in enumerate(channels.items(), 1):
        samples = np.asarray(samples, dtype=float)
        n = samples.size
        whole = list_of_header_numbers_with_known_values(
            100, -999, {1: (1, unit), 39: (2005, 167, 6, 16, 20, 53), 53: (code,)}
        )
        about = (interval * 1000, n * interval, samples[np.abs(samples).argmax()])
        real = list_of_header_numbers_with_known_values(
            100, -999.0, {0: (34.046, -117.035), 12: (4.8,), 29: (4.4,), 61: about}
        )
        text += format_header_filled_from_template(
            "cosmos", samples, interval, number=number, axis=axis, kind=kind, unit=word
        )
        text += fixed_width_columns(whole, 8, 0, 10)
        text += " 100 Real-header values follow on  17 lines, Format= (6F13.6)\n" + fixed_width_columns(real, 13, 6, 6)
        text += '   1 Comment line(s) follow, each starting with a "|":\n| a comment\n'
        text += f"{n:7d}  acceleration pts, approx {n * interval:4.0f} secs, units={word}({unit:02d}),"
        decimals = 1 if unit == 50 else 5
        text += f"Format=(8F10.{decimals})\n" + fixed_width_columns(samples, 10, decimals, 8)
        text += f"/&  ----------  End of data for channel  {number}  ----------\n"
    return text


def smc_text(
    samples, rate: float, axis: str, *, kind: str = "2 CORRECTED ACCELEROGRAM", vertical: int = 90, more=None,
    longitude=-122.385,
) -> str:  # fmt: skip
    """Text of an SMC file of samples in cm/s²; ``more`` maps places in the header to further integers."""
    samples = np.asarray(samples, dtype=float)
    azimuth = int(axis) if axis.isdigit() else 0
    start = (1989, 291, 0, 4, 12, 500)
    whole = list_of_header_numbers_with_known_values(
        48, -32768, {1: start, 12: (vertical, azimuth), 15: (2, samples.size)} | (more or {})
    )
    known = {1: (rate,), 5: (7.1,), 10: (37.728, longitude), 28: (1.0, samples.max(), 2.0, samples.min())}
    real = list_of_header_numbers_with_known_values(50, 1.7e38, known)
    lines = format_header_filled_from_template("smc", samples, 1 / rate, kind=kind, axis=axis).splitlines()
    text = "".join(f"{line:<80}\n" for line in lines) + fixed_width_columns(whole, 10, 0, 8)
    text += "".join("".join(f"{v:15.7E}" for v in real[i : i + 5]) + "\n" for i in range(0, 50, 5))
    text += "|" + " " * 79 + "\n|a comment\n"
    words = [f"{v:10.4E}".replace("E+0", "E+").replace("E-0", "E-").rjust(10) for v in samples]
    return text + "".join("".join(words[i : i + 8]) + "\n" for i in range(0, len(words), 8))


def peer_text(samples, interval: float, axis: str, *, header: str = "new") -> str:
    """Text of a PEER AT2 file of samples in g, with the new header or one of the two old ones."""
    samples = np.asarray(samples, dtype=float)
    words = [f"{v:15.7E}" for v in samples]
    stated = format_header_filled_from_template(
        f"peer-{header}", samples, interval, axis=axis, short=f"{interval:.5f}".replace("0.0", ".0")
    )
    return stated + "".join("".join(words[i : i + 5]) + "\n" for i in range(0, samples.size, 5))


def esm_text(samples, interval: float, stream: str) -> str:
    """Text of an ESM file (DYNA 1.2) of samples in cm/s²."""
    samples = np.asarray(samples, dtype=float)
    return format_header_filled_from_template("esm", samples, interval, stream=stream) + "".join(
        f"{v:.6f}\n" for v in samples
    )
